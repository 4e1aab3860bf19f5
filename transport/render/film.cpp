#include "transport/render/film.h"

#include <algorithm>
#include <cmath>

namespace raylex::transport {
namespace {

/// Reads "cropwindow" (shares of the image) or "pixelbounds", each x0 x1 y0 y1; "pixelbounds" refers to an image of
/// `given` size. A share that falls inside a pixel excludes it at the lower end. "pixelbounds" is ignored if both are
/// given. Both rules are pbrt-v4's.
Status read_crop(const ParameterSet& set, FilmSettings& settings, const std::array<double, 2>& given,
                 std::vector<Error>& warnings) {
    const Parameter* window = set.find("cropwindow");
    const Parameter* bounds = set.find("pixelbounds");
    const Parameter* p = window != nullptr ? window : bounds;
    if (p == nullptr) return success();
    if (bounds != nullptr && window != nullptr)
        warnings.push_back(error_at(
            bounds->location,
            "'pixelbounds' and 'cropwindow' exclude each other; expected one of them, and 'pixelbounds' is ignored"));
    if (p->numbers.size() != 4)
        return error_at(p->location, "'" + p->name + "' must be four numbers: x min, x max, y min, y max");
    const std::array<int, 2> size{settings.width, settings.height};
    std::array<int, 4> ends{};
    for (std::size_t i = 0; i < 4; ++i) {
        const double share = p == bounds ? p->numbers[i] / given[i / 2] : p->numbers[i];
        // A share such as 0.3 of 10 pixels is 3 pixels, despite rounding.
        ends[i] = static_cast<int>(std::ceil(std::clamp(share, 0.0, 1.0) * size[i / 2] - 1e-9 * size[i / 2]));
    }
    const display::PixelRegion crop{std::min(ends[0], ends[1]), std::min(ends[2], ends[3]), std::max(ends[0], ends[1]),
                                    std::max(ends[2], ends[3])};
    if (crop.x0 >= crop.x1 || crop.y0 >= crop.y1)
        return error_at(p->location, "'" + p->name + "' leaves no pixel of an image of " +
                                         std::to_string(settings.width) + " x " + std::to_string(settings.height) +
                                         "; expected x min, x max, y min, y max within it");
    if (crop.width() < settings.width || crop.height() < settings.height) settings.crop = crop;
    return success();
}

}  // namespace

Result<FilmSettings> read_film(const SceneEntity& film, const std::optional<std::array<int, 2>>& resolution,
                               std::vector<Error>& warnings) {
    FilmSettings settings;
    const ParameterSet& set = film.parameters;
    auto width = set.integer_or("xresolution", settings.width), height = set.integer_or("yresolution", settings.height);
    if (!width) return width.error();
    if (!height) return height.error();
    const std::array<double, 2> given{static_cast<double>(*width), static_cast<double>(*height)};
    if (resolution) {
        *width = (*resolution)[0];
        *height = (*resolution)[1];
    }
    if (*width < 1 || *height < 1 || *width > 65536 || *height > 65536)
        return error_at(film.location, "the resolution is " + std::to_string(*width) + " x " + std::to_string(*height) +
                                           "; expected 1 to 65536 pixels each way");
    settings.width = static_cast<int>(*width);
    settings.height = static_cast<int>(*height);
    auto diagonal = set.real_or("diagonal", settings.diagonal);
    if (!diagonal) return diagonal.error();
    if (!(*diagonal > 0)) return error_at(film.location, "'diagonal' must be positive, in millimetres");
    settings.diagonal = *diagonal;
    if (Status s = read_crop(set, settings, given, warnings); !s) return s.error();
    static const std::vector<std::string> films{"rgb", "gbuffer", "spectral"};
    if (!film.type.empty() && std::find(films.begin(), films.end(), film.type) == films.end())
        return error_at(film.location, "unknown film '" + film.type + "'; expected rgb, gbuffer or spectral",
                        film.type == "image" ? "pbrt-v3's 'image' is 'rgb' in pbrt-v4" : near_miss(film.type, films));
    if (film.type == "spectral")
        warnings.push_back(error_at(film.location,
                                    "film 'spectral' is written as film 'rgb': light is transported in RGB, so there "
                                    "are no wavelength buckets to write"));
    if (auto space = set.choice_or("coordinatesystem", "camera", {"camera", "world"}); !space) return space.error();
    if (film.type == "gbuffer")
        warnings.push_back(
            error_at(film.location,
                     "film 'gbuffer' stands for the layers albedo, P, Ngn (N), Nn (Ns) and st (uv), or Pw and "
                     "__Nworld; there is none of dzdx and dzdy, and variances are statistics of a job"));
    // The output is set outside of the scene file; the sensor's effect is in the colours of the lights.
    for (const char* name : {"filename", "sensor", "iso", "exposuretime", "whitebalance", "coordinatesystem"})
        static_cast<void>(set.find(name));
    for (const Parameter* p : set.unused())
        warnings.push_back(error_at(p->location, "the film has no parameter '" + p->name + "'; it is ignored"));
    return settings;
}

std::vector<std::string> gbuffer_layers(const SceneEntity& film) {
    if (film.type != "gbuffer") return {};
    const auto space = film.parameters.string_or("coordinatesystem", "camera");
    if (space && *space == "world") return {"albedo", "Pw", "__Nworld", "st"};
    return {"albedo", "P", "Ngn", "Nn", "st"};
}

}  // namespace raylex::transport
