#include "transport/textures/image_mean.h"

#include <algorithm>

#include "transport/color/color_space.h"
#include "transport/textures/image_sampler.h"
#include "transport/textures/parameter_reader.h"

namespace raylex::transport {

Result<std::array<double, 3>> mean_of_image(const SceneTexture& source, const ColorContext& color) {
    ParameterReader reader(source.parameters);
    const std::string file = reader.string("filename", ""), encoding = reader.string("encoding", "");
    const std::string filter = reader.string("filter", "");
    const bool means = filter.empty() || filter == "bilinear" || filter == "trilinear" || filter == "unfiltered",
               first_channel = !source.spectrum && !means;
    const Real scale = reader.real("scale", 1);
    const bool invert = reader.boolean("invert", false);
    if (reader.error()) return *reader.error();
    const bool by_file_rules = color.file_color && source.spectrum && encoding.empty();
    Result<Image> image = read_image(file, by_file_rules ? "linear" : encoding);
    if (!image) return error_at(source.location, "image texture '" + file + "': " + image.error().message);
    static_cast<void>(clear_invalid_texels(*image, NegativeTexels::kept));
    if (by_file_rules) {
        auto convert = color.file_color(file);
        if (!convert) return error_at(source.location, "image texture '" + file + "': " + convert.error().message);
        convert_colors(*image, *convert);
    }
    const ImageSampler sampler{&*image, WrapMode::clamp, first_channel, alpha_varies(*image)};
    const Real width = static_cast<Real>(image->width), height = static_cast<Real>(image->height);
    const auto value_of = [&](Real texel) {  // as in look-ups: float textures may be negative
        const Real value = invert ? 1 - texel : texel;
        return source.spectrum || invert ? std::max(Real(0), value) : value;
    };
    std::array<double, 3> sum{};
    for (int y = 0; y < image->height; ++y)
        for (int x = 0; x < image->width; ++x) {
            const Vec2 st{(static_cast<Real>(x) + 0.5f) / width, (static_cast<Real>(y) + 0.5f) / height};
            const Rgb texel = (source.spectrum ? sampler.rgb(st) : Rgb(sampler.real(st))) * scale;
            for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += static_cast<double>(value_of(texel[c]));
        }
    const double texels = static_cast<double>(image->width) * static_cast<double>(image->height);
    for (double& each : sum) each /= texels;
    if (!source.spectrum || by_file_rules || image->space == color.scene_space) return sum;
    const double most = std::max({1.0, sum[0], sum[1], sum[2]});  // keeps an albedo at most 1
    sum = multiply(rgb_from_rgb(color.scene_space, image->space, true), sum);
    for (double& each : sum) each = std::clamp(each, 0.0, most);
    return sum;
}

}  // namespace raylex::transport
