#include "display/output/writer/exr_pixels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include <half.h>

#include "display/output/splits/stored_precision.h"

namespace raylex::display {

namespace {

const ChannelDefinition& definition_of(const PixelImage& frame_buffer, const PlannedPart& part) {
    return frame_buffer.channels()[static_cast<std::size_t>(part.channel)];
}

constexpr int most_cached = 4096;  // pixels: 96 KiB of doubles

// The common case, without calls: float, everything in range.
bool float_plane(const double* values, std::size_t count, std::size_t stride, char* bytes) {
    bool fits = true;
    for (std::size_t i = 0; i < count; ++i) {
        const double value = values[i * stride];
        fits &= std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
        const auto stored = static_cast<float>(value);
        std::memcpy(bytes + 4 * i, &stored, 4);
    }
    return fits;
}

// Stores one plane of `stride`-interleaved doubles as the bytes of a file, and in `judged` unless it is null.
void store_plane(const double* values, std::size_t count, std::size_t stride, float miss, StoredType type, char* bytes,
                 float* checked) {
    if (type == StoredType::single_float && float_plane(values, count, stride, bytes)) {
        if (checked != nullptr) std::memcpy(checked, bytes, 4 * count);
        return;
    }
    Repairs repairs;
    for (std::size_t i = 0; i < count; ++i) {
        const double value = values[i * stride];
        if (type == StoredType::unsigned_int) {
            const auto integer =
                static_cast<std::uint32_t>(std::isfinite(value) ? static_cast<std::int64_t>(value) : 0);
            std::memcpy(bytes + 4 * i, &integer, 4);
            continue;
        }
        const float stored = repairs.to_stored(value, miss, type);
        if (type == StoredType::half_float) {
            const std::uint16_t bits = half(stored).bits();
            std::memcpy(bytes + 2 * i, &bits, 2);
        } else {
            std::memcpy(bytes + 4 * i, &stored, 4);
        }
        if (checked != nullptr) checked[i] = stored;
    }
}

PartPixels data_pixels(const DataPart& data, const PixelRegion& rows) {
    const std::vector<float> values = data.values(rows);
    const std::size_t count = values.size() / data.planes.size();
    PartPixels result;
    for (std::size_t plane = 0; plane < data.planes.size(); ++plane) {
        std::vector<char>& bytes = result.planes.emplace_back(4 * count);
        std::memcpy(bytes.data(), values.data() + plane * count, bytes.size());
    }
    return result;
}

}  // namespace

float Repairs::to_stored(double value, float miss, StoredType type) {
    const bool is_half = type == StoredType::half_float;
    const auto largest = static_cast<double>(largest_of(type));
    if (std::abs(value) <= largest) {
        const auto rounded = static_cast<float>(value);
        return is_half ? static_cast<float>(half(rounded)) : rounded;
    }
    if (std::isnan(value)) {
        ++not_a_number;
        return 0.0f;
    }
    if (std::isinf(miss) && value == static_cast<double>(miss)) return miss;
    ++out_of_range;
    return static_cast<float>(std::copysign(largest, value));
}

PartPixels part_pixels(const PixelImage& frame_buffer, const PlannedPart& part, const PixelRegion& rows, bool checked) {
    if (part.data != nullptr) return data_pixels(*part.data, rows);
    const ChannelDefinition& channel = definition_of(frame_buffer, part);
    const auto components = static_cast<std::size_t>(component_count(channel.type));
    const std::size_t width = static_cast<std::size_t>(rows.width()),
                      count = width * static_cast<std::size_t>(rows.height()),
                      size = part.storage.type == StoredType::half_float ? 2 : 4;
    PartPixels result;
    result.planes.assign(components + (part.alpha ? 1 : 0), std::vector<char>(count * size));
    if (checked) result.checked.assign(components, std::vector<float>(count));
    // Line by line, because the doubles of all rows would not fit in the processor's cache.
    const int together = std::max(1, most_cached / rows.width());
    for (PixelRegion lines = rows; lines.y0 < rows.y1; lines.y0 = lines.y1) {
        lines.y1 = std::min(lines.y0 + together, rows.y1);
        const std::size_t first = width * static_cast<std::size_t>(lines.y0 - rows.y0),
                          here = width * static_cast<std::size_t>(lines.height());
        const std::vector<double> pixels = frame_buffer.resolve(part.channel, lines);
        for (std::size_t c = 0; c < components; ++c)
            store_plane(pixels.data() + c, here, components, channel.miss_value, part.storage.type,
                        result.planes[c].data() + first * size, checked ? result.checked[c].data() + first : nullptr);
        if (part.alpha)
            store_plane(frame_buffer.resolve_alpha(lines).data(), here, 1, 0, part.storage.type,
                        result.planes.back().data() + first * size, nullptr);
    }
    return result;
}

// Light is summed in fixed point, so it is finite, and within float unless its scale is large. Picked values (depth,
// normals) are what was written, and halves end at 65504.
bool may_need_repair(const PixelImage& frame_buffer, const PlannedPart& part) {
    if (part.data != nullptr) return false;
    const ChannelDefinition& channel = definition_of(frame_buffer, part);
    if (channel.type == ChannelType::integer) return false;
    constexpr int largest_in_float = 127 - 47;  // sums end at 2^(47 + scale): see frame_buffer.h
    return part.storage.type == StoredType::half_float || channel.scale_exponent > largest_in_float ||
           (channel.rule != FilterRule::filter && channel.rule != FilterRule::average &&
            channel.rule != FilterRule::sum);
}

void note_repairs(const PixelImage& frame_buffer, const PlannedPart& part, const PixelRegion& rows, Repairs& repairs) {
    const float miss = definition_of(frame_buffer, part).miss_value;
    for (const double value : frame_buffer.resolve(part.channel, rows))
        repairs.to_stored(value, miss, part.storage.type);
}

std::string repairs_text(const Repairs& repairs, StoredType type) {
    if (repairs.not_a_number + repairs.out_of_range == 0) return {};
    return std::to_string(repairs.not_a_number) + " values not a number, set to 0; " +
           std::to_string(repairs.out_of_range) + " beyond " + (type == StoredType::half_float ? "half" : "float") +
           ", set to the largest";
}

}  // namespace raylex::display
