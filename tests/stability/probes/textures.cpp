// Image look-ups at any coordinates, and images with invalid values.
#include <limits>

#include "tests/stability/probes/draws.h"
#include "tests/stability/probes/probes.h"
#include "transport/textures/image_sampler.h"

namespace raylex::experiments {
namespace {

using namespace transport;

Image ramp(int width, int height, int channels) {
    Image image{width, height, channels, {}};
    for (int i = 0; i < width * height * channels; ++i) image.pixels.push_back(static_cast<float>(1 + i % 7));
    return image;
}

/// Counts look-ups whose result is not a mixture of texels. Word "wrap": repeat, black, clamp, octahedralsphere.
/// Numbers: width, height, nearest (0 or 1).
Result<ProbeResult> lookups(const ProbeInput& input) {
    const std::string wrap = input.word("wrap");
    if (Status given = input.status(); !given) return given.error();
    const Image image =
        ramp(static_cast<int>(input.number("width", 4)), static_cast<int>(input.number("height", 4)), 3);
    const ImageSampler sampler{&image,
                               wrap == "repeat"  ? WrapMode::repeat
                               : wrap == "black" ? WrapMode::black
                               : wrap == "clamp" ? WrapMode::clamp
                                                 : WrapMode::octahedral_sphere,
                               input.number("nearest", 0) != 0, false};
    const Real inf = std::numeric_limits<Real>::infinity(), nan = std::numeric_limits<Real>::quiet_NaN();
    const Real least = wrap == "black" ? 0 : 1;
    ProbeResult result;
    int asked = 0;
    for (const Real s :
         {Real(0), -Real(0), Real(1), one_minus_epsilon, Real(0.5), Real(-1e-30), Real(-3.7), Real(1e9), Real(-1e30),
          std::numeric_limits<Real>::max(), std::numeric_limits<Real>::denorm_min(), inf, -inf, nan})
        for (const Real t : {Real(0), Real(1), Real(0.3), Real(-1e30), inf, -inf, nan})
            for (const Vec2 st : {Vec2{s, t}, Vec2{t, s}}) {
                const transport::Rgb c = sampler.rgb(st);
                const Real mean = sampler.real(st);
                ++asked;
                // Four weights sum to 1 up to rounding.
                for (const Real v : {c.r, c.g, c.b, mean})
                    result.measured += !(v >= least * (1 - Real(4e-7)) && v <= 7 * (1 + Real(4e-7)));
            }
    result.expected = 0;
    result.note = "of " + std::to_string(4 * asked) + " values";
    return result;
}

/// Returns the mean of bilinear look-ups at even points of the unit square, relative to the mean of the texels. Every
/// texel must have the same weight.
Result<ProbeResult> texel_weights(const ProbeInput& input) {
    const Image image =
        ramp(static_cast<int>(input.number("width", 5)), static_cast<int>(input.number("height", 3)), 1);
    const ImageSampler sampler{&image, WrapMode::repeat, input.number("nearest", 0) != 0, false};
    const int n = 32;  // points per texel and axis
    double sum = 0, texels = 0;
    for (const float v : image.pixels) texels += double(v);
    const int columns = n * image.width, rows = n * image.height;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x)
            sum += double(sampler.real({static_cast<Real>((x + 0.5) / columns), static_cast<Real>((y + 0.5) / rows)}));
    ProbeResult result;
    result.measured = sum / (double(columns) * rows) / (texels / double(image.pixels.size()));
    result.expected = 1;
    return result;
}

/// Counts values of a light's image that were replaced by 0 (textures keep negative ones). `invalid` values are NaN,
/// infinite or negative in turn.
Result<ProbeResult> invalid_texels(const ProbeInput& input) {
    const auto invalid = static_cast<std::size_t>(input.number("invalid"));
    if (Status given = input.status(); !given) return given.error();
    Image image = ramp(16, 16, static_cast<int>(input.number("channels", 3)));
    const float bad[] = {std::numeric_limits<float>::quiet_NaN(), -1, std::numeric_limits<float>::infinity(), -1e-30f,
                         -std::numeric_limits<float>::infinity()};
    if (invalid > image.pixels.size()) return error_at(input.where(), "more invalid values than the image has");
    const std::size_t stride = invalid > 0 ? image.pixels.size() / invalid : 1;
    for (std::size_t i = 0; i < invalid; ++i) image.pixels[i * stride] = bad[i % std::size(bad)];
    const auto said = clear_invalid_texels(image, NegativeTexels::cleared);
    ProbeResult result;
    result.measured = said ? std::stod(*said) : 0;
    result.expected = double(invalid);
    result.note = said.value_or("no warning");
    for (const float v : image.pixels) result.measured += !(v >= 0 && std::isfinite(v)) ? 1e9 : 0;
    return result;
}

}  // namespace

std::span<const NamedProbe> texture_probes() {
    static constexpr NamedProbe table[] = {
        {"texture_lookups",
         "number of look-ups at extreme coordinates with a value that no texel has; wrap, width, height, nearest",
         lookups},
        {"texel_weights", "mean of look-ups relative to the mean of texels; width, height, nearest", texel_weights},
        {"invalid_texels", "number of values of a light's image reported as negative or not finite; invalid, channels",
         invalid_texels}};
    return table;
}

}  // namespace raylex::experiments
