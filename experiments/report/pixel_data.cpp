#include "experiments/report/pixel_data.h"

#include <Imath/half.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "experiments/report/html.h"

namespace raylex::experiments {

std::string pack_bytes(std::span<const unsigned char> bytes) {
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    std::vector<unsigned char> packed(size);
    // With a buffer of compressBound's size only a lack of memory can make this fail.
    if (compress2(packed.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), 6) != Z_OK) return {};
    return base64(std::span(packed).first(size));
}

std::string pack_halves(std::span<const float> values) {
    std::vector<unsigned char> bytes(values.size() * 2);
    unsigned previous = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const float value = values[i];
        const Imath::half half(std::isfinite(value) ? std::clamp(value, -65504.0F, 65504.0F) : value);
        const unsigned high = half.bits() >> 8U;
        bytes[i] = static_cast<unsigned char>((high - previous) & 255U);
        bytes[values.size() + i] = static_cast<unsigned char>(half.bits() & 255U);
        previous = high;
    }
    return pack_bytes(bytes);
}

std::string pack_integers(std::span<const float> values) {
    std::vector<unsigned char> bytes(values.size() * 4);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const bool fits = values[i] >= 0 && values[i] < 4294967296.0F;  // false for NaN
        const std::uint32_t whole = fits ? static_cast<std::uint32_t>(values[i]) : 0;
        for (std::size_t byte = 0; byte < 4; ++byte)
            bytes[byte * values.size() + i] = static_cast<unsigned char>(whole >> (24 - 8 * byte) & 255U);
    }
    return pack_bytes(bytes);
}

Result<std::string> pack_view(const display::ColorManager& color, const display::Chromaticities& primaries,
                              const std::string& display, const std::string& view) {
    std::array<float, view_nodes> node{};
    for (std::size_t i = 0; i < view_nodes; ++i)
        node[i] = static_cast<float>(std::exp2(static_cast<double>(i) / 2 - 10) - std::exp2(-10));
    std::vector<float> rgb;
    rgb.reserve(view_nodes * view_nodes * view_nodes * 3);
    for (const float blue : node)
        for (const float green : node)
            for (const float red : node) rgb.insert(rgb.end(), {red, green, blue});
    auto shown = color.to_display(rgb, primaries, display, view);
    if (!shown) return shown.error();
    return pack_bytes(*shown);
}

}  // namespace raylex::experiments
