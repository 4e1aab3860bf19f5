#include "experiments/report/preview.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "display/output/color/primaries.h"

namespace raylex::experiments {
namespace {

using display::ImagePlane;

// Below the largest float, because the colour library shows infinities black.
constexpr double brightest = 1e30;

/// Side of the block of source pixels that one pixel of the picture stands for.
int reduction(const display::ExrImage& image, int largest_side) {
    const int side = std::max(image.width, image.height);
    return largest_side > 0 && side > largest_side ? (side + largest_side - 1) / largest_side : 1;
}

unsigned char to_byte(double value) {
    if (!(value > 0)) return 0;  // NaN too
    return static_cast<unsigned char>(std::lround(std::min(value, 1.0) * 255));
}

/// A value of a plane; 0 if there is no such plane.
double value_at(const ImagePlane* plane, std::size_t i) {
    return plane != nullptr ? static_cast<double>(plane->values[i]) : 0.0;
}

/// Larger depths mean that nothing was hit: renderers write infinity, and Blender writes 1e10.
constexpr double farthest_depth = 1e9;

bool is_depth(double value) {
    return std::isfinite(value) && value < farthest_depth;
}

struct Range {
    double least = std::numeric_limits<double>::infinity(), most = -std::numeric_limits<double>::infinity();

    Range(const ImagePlane* plane, bool depth) {
        if (plane == nullptr) return;
        for (const float value : plane->values) {
            if (!std::isfinite(value) || (depth && !is_depth(value))) continue;
            least = std::min(least, static_cast<double>(value));
            most = std::max(most, static_cast<double>(value));
        }
    }
    [[nodiscard]] double share(double value) const {
        if (!std::isfinite(value)) return 0;
        return most > least ? (value - least) / (most - least) : 0.5;
    }
};

/// A fixed colour for each integer. The finaliser of MurmurHash3 mixes the bits, so close integers look different.
std::array<unsigned char, 3> colour_of_id(std::uint32_t id) {
    if (id == 0) return {0, 0, 0};
    std::uint32_t h = id;
    h ^= h >> 16;
    h *= 0x85ebca6bU;
    h ^= h >> 13;
    h *= 0xc2b2ae35U;
    h ^= h >> 16;
    const auto channel = [h](int shift) { return static_cast<unsigned char>(70 + (h >> shift & 0xffU) * 170 / 255); };
    return {channel(0), channel(8), channel(16)};
}

/// Means of scene-linear values over blocks, without values that are not finite.
std::vector<float> averaged(const display::ExrImage& image, const std::array<const ImagePlane*, 3>& planes, int block,
                            double scale, int width, int height) {
    std::vector<float> rgb(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                double sum = 0;
                int count = 0;
                for (int v = y * block; v < std::min((y + 1) * block, image.height); ++v)
                    for (int u = x * block; u < std::min((x + 1) * block, image.width); ++u) {
                        const float value =
                            planes[c]->values[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                                              static_cast<std::size_t>(u)];
                        if (!std::isfinite(value)) continue;
                        sum += value;
                        ++count;
                    }
                rgb[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 3 +
                    c] = count > 0 ? static_cast<float>(std::clamp(sum / count * scale, -brightest, brightest)) : 0.0f;
            }
    return rgb;
}

std::array<unsigned char, 3> geometry_pixel(LayerLook look, const std::array<double, 3>& v,
                                            const std::array<Range, 3>& ranges) {
    switch (look) {
        case LayerLook::normal:
            if (v[0] == 0 && v[1] == 0 && v[2] == 0) return {0, 0, 0};  // nothing was hit
            return {to_byte(v[0] * 0.5 + 0.5), to_byte(v[1] * 0.5 + 0.5), to_byte(v[2] * 0.5 + 0.5)};
        case LayerLook::position:
            return {to_byte(ranges[0].share(v[0])), to_byte(ranges[1].share(v[1])), to_byte(ranges[2].share(v[2]))};
        case LayerLook::parameter:
            return {to_byte(v[0] - std::floor(v[0])), to_byte(v[1] - std::floor(v[1])), 0};
        case LayerLook::depth: {
            const unsigned char grey =
                is_depth(v[0]) ? to_byte(1 - 0.9 * ranges[0].share(v[0])) : static_cast<unsigned char>(0);
            return {grey, grey, grey};
        }
        case LayerLook::identity:
            return colour_of_id(v[0] > 0 && v[0] < 4294967296.0 ? static_cast<std::uint32_t>(v[0]) : 0U);
        case LayerLook::value:
        case LayerLook::mattes:
        case LayerLook::light:
            break;
    }
    const unsigned char grey = to_byte(ranges[0].share(v[0]));
    return {grey, grey, grey};
}

/// Two ranks of a cryptomatte: means over blocks of the colours of ids, weighted by coverage.
std::vector<unsigned char> matte_picture(const display::ExrImage& image, const display::ImageLayer& layer, int block,
                                         int width, int height) {
    const std::array<const ImagePlane*, 4> planes{layer.plane("R"), layer.plane("G"), layer.plane("B"),
                                                  layer.plane("A")};
    std::vector<unsigned char> rgb;
    rgb.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::array<double, 3> sum{};
            int count = 0;
            for (int v = y * block; v < std::min((y + 1) * block, image.height); ++v)
                for (int u = x * block; u < std::min((x + 1) * block, image.width); ++u, ++count) {
                    const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                                          static_cast<std::size_t>(u);
                    for (std::size_t rank = 0; rank < 4; rank += 2) {
                        const auto color = colour_of_id(std::bit_cast<std::uint32_t>(planes[rank]->values[i]));
                        const double coverage = planes[rank + 1]->values[i];
                        for (std::size_t c = 0; c < 3; ++c) sum[c] += coverage * color[c] / 255;
                    }
                }
            for (const double each : sum) rgb.push_back(to_byte(each / count));
        }
    return rgb;
}

bool has_chroma(const display::ImageLayer& layer) {
    return layer.plane("Y") != nullptr && layer.plane("RY") != nullptr && layer.plane("BY") != nullptr;
}

/// R, G and B of a layer with luminance and chroma. OpenEXR defines RY = (R - Y) / Y and BY = (B - Y) / Y.
std::array<ImagePlane, 3> from_chroma(const display::ImageLayer& layer, const display::Chromaticities& primaries) {
    const std::array<double, 3> weights = display::luminance_weights(primaries);
    const std::vector<float>&luminance = layer.plane("Y")->values, &ry = layer.plane("RY")->values,
          &by = layer.plane("BY")->values;
    std::array<ImagePlane, 3> planes{ImagePlane{"R", {}, {}}, ImagePlane{"G", {}, {}}, ImagePlane{"B", {}, {}}};
    for (std::size_t i = 0; i < luminance.size(); ++i) {
        const double y = luminance[i], red = (ry[i] + 1.0) * y, blue = (by[i] + 1.0) * y;
        planes[0].values.push_back(static_cast<float>(red));
        planes[1].values.push_back(static_cast<float>((y - weights[0] * red - weights[2] * blue) / weights[1]));
        planes[2].values.push_back(static_cast<float>(blue));
    }
    return planes;
}

/// The planes that are shown as red, green and blue. The last ones are null if the layer has fewer planes.
std::array<const ImagePlane*, 3> shown_planes(const display::ImageLayer& layer) {
    if (const auto triple = layer.triple(); triple[0] != nullptr) return triple;
    std::array<const ImagePlane*, 3> planes{};
    std::size_t count = 0;
    for (const ImagePlane& plane : layer.planes)
        if (count < 3 && plane.name != "A" && plane.name != "a") planes[count++] = &plane;
    return planes;
}

std::vector<unsigned char> geometry_picture(const display::ExrImage& image, LayerLook look,
                                            const std::array<const ImagePlane*, 3>& planes, int block, int width,
                                            int height) {
    const bool depth = look == LayerLook::depth;
    const std::array<Range, 3> ranges{Range(planes[0], depth), Range(planes[1], depth), Range(planes[2], depth)};
    std::vector<unsigned char> rgb;
    rgb.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            // A mean would invent ids, normals and depths, so the middle of the block is shown.
            const auto v = static_cast<std::size_t>(std::min(y * block + block / 2, image.height - 1));
            const auto u = static_cast<std::size_t>(std::min(x * block + block / 2, image.width - 1));
            const std::size_t i = v * static_cast<std::size_t>(image.width) + u;
            auto pixel =
                geometry_pixel(look, {value_at(planes[0], i), value_at(planes[1], i), value_at(planes[2], i)}, ranges);
            for (std::size_t c = 0; c < 3; ++c) rgb.push_back(planes[c] != nullptr ? pixel[c] : 0);
        }
    return rgb;
}

}  // namespace

LayerLook look_of(const display::ImageLayer& layer) {
    // The name without the groups that a part name can put before it.
    const std::string name =
        layer.name.substr(layer.name.find_last_of('.') == std::string::npos ? 0 : layer.name.find_last_of('.') + 1);
    if (layer.planes.size() == 1) {
        const ImagePlane& plane = layer.planes.front();
        if (plane.stored == display::StoredType::unsigned_int || name == "id") return LayerLook::identity;
        if (plane.name == "Z" || name == "z" || name == "zback" || name == "VLen" || name == "depth" || name == "Depth")
            return LayerLook::depth;
        return plane.name == "Y" || plane.name == "y" ? LayerLook::light : LayerLook::value;
    }
    if (name.starts_with("Crypto") && layer.planes.size() == 4 && layer.is_color()) return LayerLook::mattes;
    if (name == "st" || name == "__st" || name == "uv" || name == "UV") return LayerLook::parameter;
    const bool vector = layer.plane("X") != nullptr && layer.plane("Y") != nullptr;
    if (name == "Nn" || name == "Ngn" || name == "Non" || name == "Tn" || name == "Vn" || name == "__Nworld" ||
        name == "__Vworld" || name == "N" || name == "normal" || name == "Normal")
        return LayerLook::normal;
    if (vector || name == "P" || name == "Pw" || name == "position") return LayerLook::position;
    const bool light = layer.triple()[0] != nullptr || has_chroma(layer);
    return light ? LayerLook::light : LayerLook::position;
}

Result<const display::ImageLayer*> shown_layer(const display::ExrImage& image, const std::string& name) {
    if (!name.empty()) return image.require_layer(name == "beauty" ? "" : name);
    auto beauty = image.require_layer("");
    if (beauty || image.layers.empty()) return beauty;
    for (const display::ImageLayer& each : image.layers)
        if (look_of(each) == LayerLook::light) return &each;
    return &image.layers.front();
}

const char* describe(LayerLook look) {
    switch (look) {
        case LayerLook::light:
            return "";
        case LayerLook::normal:
            return "unit vectors: -1 to 1 shown as 0 to 1";
        case LayerLook::position:
            return "each axis shown from its least to its largest value";
        case LayerLook::parameter:
            return "fractional parts of s (red) and t (green)";
        case LayerLook::depth:
            return "near is bright, nothing hit is black";
        case LayerLook::identity:
            return "one colour per object";
        case LayerLook::mattes:
            return "one colour per id, as bright as it covers the pixel";
        case LayerLook::value:
            return "shown from the least to the largest value";
    }
    return "";
}

Result<Picture> picture_of(const display::ExrImage& image, const display::ImageLayer& layer,
                           const display::ColorManager& color, const PictureOptions& options) {
    const int block = reduction(image, options.largest_side);
    Picture picture;
    picture.width = (image.width + block - 1) / block;
    picture.height = (image.height + block - 1) / block;
    std::array<const ImagePlane*, 3> planes = shown_planes(layer);
    if (planes[0] == nullptr)
        return Error{
            "layer '" + layer.name + "' has only alpha; expected a plane that can be shown", image.path, 0, 0, {}, {}};
    const LayerLook look = look_of(layer);
    if (look == LayerLook::light) {
        const display::Chromaticities primaries = image.chromaticities.value_or(display::Chromaticities{});
        std::array<ImagePlane, 3> colors;
        if (has_chroma(layer)) {
            colors = from_chroma(layer, primaries);
            for (std::size_t c = 0; c < 3; ++c) planes[c] = &colors[c];
        }
        const std::vector<float> rgb =
            averaged(image, planes, block, std::exp2(options.exposure), picture.width, picture.height);
        auto shown = color.to_display(rgb, primaries, options.display, options.view);
        if (!shown) return shown.error();
        picture.rgb = std::move(*shown);
        return picture;
    }
    picture.rgb = look == LayerLook::mattes
                      ? matte_picture(image, layer, block, picture.width, picture.height)
                      : geometry_picture(image, look, planes, block, picture.width, picture.height);
    return picture;
}

}  // namespace raylex::experiments
