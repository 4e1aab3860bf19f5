// Display channels: what can be written to during a render, and how it becomes pixels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lpe/event.h"

namespace raylex::display {

/// Handle of a channel for every display-services call. Negative ids are invalid and refused.
using ChannelId = std::int32_t;
inline constexpr ChannelId invalid_channel = -1;

enum class ChannelStyle : std::uint8_t { name, expression };  ///< a plain AOV by name, or a light path expression
enum class ChannelType : std::uint8_t { real, rgb, point, normal, vector, integer };

/// Numbers per sample: 1 for real and integer, 3 for the others.
[[nodiscard]] constexpr int component_count(ChannelType type) {
    return type == ChannelType::real || type == ChannelType::integer ? 1 : 3;
}

/// How a contribution was found: with `s` vertices made from the light and `t` from the camera, the light's and the
/// camera's own among them (E. Veach 1997, section 10.2). Path tracing finds lights with s = 0 and samples them with s
/// = 1; t = 1 is a splat. Never part of the word: an emitter is L by what it is, not by how it was hit.
struct Technique {
    std::uint32_t s = 0, t = 0;
    bool operator==(const Technique&) const = default;
};

/// How the samples of a pixel become its value: the render's pixel filter, or a rule that ignores it.
/// zmin and zmax copy the value of the sample nearest to / farthest from the camera.
enum class FilterRule : std::uint8_t { filter, zmin, zmax, min, max, average, sum };

/// What a layer of statistics says of the samples of another channel, component by component. With n samples v of
/// weight w and the pixel's value m:
///   variance   sum((v - m)^2) / (n - 1)
///   mse        variance of m: variance x sum(w^2) / sum(w)^2, which is variance / n for equal weights
///   even, odd  the pixel made of the samples with an even (odd) index alone: two images of half the samples each
enum class Statistic : std::uint8_t { none, variance, mse, even, odd };

/// What GetDisplayChannels shows to patterns, bxdfs and integrators.
struct DisplayChannel {
    ChannelId id = invalid_channel;
    ChannelStyle style = ChannelStyle::name;
    ChannelType type = ChannelType::rgb;
    std::string name;
};

/// A channel as the job declares it. The index in the render's list is its ChannelId.
/// Beyond the range of float either way.
inline constexpr int largest_scale_exponent = 256;

struct ChannelDefinition {
    std::string name;
    ChannelStyle style = ChannelStyle::name;
    ChannelType type = ChannelType::rgb;
    /// Style name: a job or a plugin declares the channel, and whoever finds it by its name writes to it. False: the
    /// name is a geometric AOV's, or one that a pattern of the scene or a plugin declares.
    bool declared = false;
    std::string expression;  ///< style expression: the text as the user wrote it
    lpe::Dialect dialect = lpe::Dialect::renderman;
    /// Not empty: accepts what none of these channels (by index) accepts. `expression` may then say so for people.
    std::vector<std::size_t> rest_of;
    FilterRule rule = FilterRule::filter;
    std::string space;        ///< "camera", "world", "raster", "rendering colour space", ...
    bool statistics = false;  ///< also keep the per-pixel second moment
    /// Not invalid: a further output of channel `source`, which has samples and the same type. Nothing can be sent to
    /// it: what is sent to its source reaches every output. With a statistic it is made of what the frame buffer keeps
    /// of its source, whose rule is then `filter`; without one the source's samples become pixels once more, by this
    /// layer's own rule.
    ChannelId source = invalid_channel;
    Statistic statistic = Statistic::none;
    float miss_value = 0.0f;  ///< value of a sample to which nothing was written
    /// Values are of the order of 2^scale_exponent: where the frame buffer's exact sums begin and end (frame_buffer.h).
    /// From -largest_scale_exponent to that; the same for all channels of style expression, and for a layer as for its
    /// source.
    int scale_exponent = 0;
    std::string origin;                      ///< for errors: the file or option the expression stands in
    int origin_line = 0, origin_column = 0;  ///< of the expression's first character, 0 = not known
};

/// Whether samples can be sent to the channel: whether it is no mere output of another.
[[nodiscard]] inline bool takes_samples(const ChannelDefinition& channel) {
    return channel.source == invalid_channel;
}
/// Whether samples become pixels by the channel's own rule: whether it is no layer of statistics.
[[nodiscard]] inline bool keeps_pixels(const ChannelDefinition& channel) {
    return channel.statistic == Statistic::none;
}

}  // namespace raylex::display
