#include "display/output/writer/exr_pixels.h"

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

// The common case, free of calls: float, everything in range.
bool float_plane(const double* values, std::size_t count, std::size_t stride, char* bytes) {
    bool fits = true;
    for (std::size_t i = 0; i < count; ++i) {
        const double value = values[i * stride];
        fits = fits && std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
        const auto stored = static_cast<float>(value);
        std::memcpy(bytes + 4 * i, &stored, 4);
    }
    return fits;
}

// One plane of `stride`-interleaved doubles to the bytes of a file.
std::vector<char> stored_plane(const double* values, std::size_t count, std::size_t stride, float miss, StoredType type,
                               std::vector<float>* judged) {
    std::vector<char> bytes(count * (type == StoredType::half_float ? 2 : 4));
    if (judged != nullptr) judged->resize(count);
    if (type == StoredType::single_float && float_plane(values, count, stride, bytes.data())) {
        if (judged != nullptr) std::memcpy(judged->data(), bytes.data(), bytes.size());
        return bytes;
    }
    Repairs repairs;
    for (std::size_t i = 0; i < count; ++i) {
        const double value = values[i * stride];
        if (type == StoredType::unsigned_int) {
            const auto integer =
                static_cast<std::uint32_t>(std::isfinite(value) ? static_cast<std::int64_t>(value) : 0);
            std::memcpy(bytes.data() + 4 * i, &integer, 4);
            continue;
        }
        const float stored = repairs.to_stored(value, miss, type);
        if (type == StoredType::half_float) {
            const std::uint16_t bits = half(stored).bits();
            std::memcpy(bytes.data() + 2 * i, &bits, 2);
        } else {
            std::memcpy(bytes.data() + 4 * i, &stored, 4);
        }
        if (judged != nullptr) (*judged)[i] = stored;
    }
    return bytes;
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

PartPixels part_pixels(const PixelImage& frame_buffer, const PlannedPart& part, const PixelRegion& rows, bool judged) {
    if (part.data != nullptr) return data_pixels(*part.data, rows);
    const ChannelDefinition& channel = definition_of(frame_buffer, part);
    const auto components = static_cast<std::size_t>(component_count(channel.type));
    const std::vector<double> pixels = frame_buffer.resolve(part.channel, rows);
    const std::size_t count = pixels.size() / components;
    PartPixels result;
    for (std::size_t c = 0; c < components; ++c) {
        std::vector<float>* copy = judged ? &result.judged.emplace_back() : nullptr;
        result.planes.push_back(
            stored_plane(pixels.data() + c, count, components, channel.miss_value, part.storage.type, copy));
    }
    if (part.alpha)
        result.planes.push_back(
            stored_plane(frame_buffer.resolve_alpha(rows).data(), count, 1, 0, part.storage.type, nullptr));
    return result;
}

// Light is summed in fixed point, so it is finite, and within float but where its scale is large; what is picked
// (depth, normals) is whatever was written, and halves end at 65504.
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

std::string repairs_text(const Repairs& repairs, const PlannedPart& part) {
    if (repairs.not_a_number + repairs.out_of_range == 0) return {};
    return std::to_string(repairs.not_a_number) + " values not a number, set to 0; " +
           std::to_string(repairs.out_of_range) + " beyond " +
           (part.storage.type == StoredType::half_float ? "half" : "float") + ", set to the largest";
}

}  // namespace raylex::display
