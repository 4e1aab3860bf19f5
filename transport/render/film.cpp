#include "transport/render/film.h"

namespace raylex::transport {

Result<FilmSettings> read_film(const SceneEntity& film, const std::optional<std::array<int, 2>>& resolution,
                               std::vector<Error>& warnings) {
    FilmSettings settings;
    const ParameterSet& set = film.parameters;
    auto width = set.integer_or("xresolution", settings.width), height = set.integer_or("yresolution", settings.height);
    if (!width) return width.error();
    if (!height) return height.error();
    if (resolution) {
        *width = (*resolution)[0];
        *height = (*resolution)[1];
    }
    if (*width < 1 || *height < 1 || *width > 65536 || *height > 65536)
        return error_at(film.location, "the resolution is " + std::to_string(*width) + " x " + std::to_string(*height) +
                                           "; expected 1 to 65536 pixels each way");
    settings.width = static_cast<int>(*width);
    settings.height = static_cast<int>(*height);
    for (const char* name : {"cropwindow", "pixelbounds"})
        if (const Parameter* p = set.find(name))
            return error_at(p->location, std::string("'") + name + "' is not supported yet; expected the whole image");
    if (!film.type.empty() && film.type != "rgb")
        warnings.push_back(
            error_at(film.location, "film '" + film.type + "' is written as plain radiance, as film 'rgb'"));
    // Where the image goes is said beside the scene, and a pinhole or thin lens does not ask for the film's size.
    for (const char* name : {"filename", "diagonal"}) static_cast<void>(set.find(name));
    for (const Parameter* p : set.unused())
        warnings.push_back(error_at(p->location, "the film has no parameter '" + p->name + "'; it is ignored"));
    return settings;
}

}  // namespace raylex::transport
