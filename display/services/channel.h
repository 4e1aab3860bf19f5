// Display channels: the values that a render produces, and how they become pixels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lpe/event.h"

namespace raylex::display {

/// Handle of a channel in every display-services call. Negative ids are invalid and are refused.
using ChannelId = std::int32_t;
inline constexpr ChannelId invalid_channel = -1;

enum class ChannelStyle : std::uint8_t { name, expression };  ///< a plain AOV by name, or a light path expression
enum class ChannelType : std::uint8_t { real, rgb, point, normal, vector, integer };

/// Number of values per sample: 1 for real and integer, 3 for the others.
[[nodiscard]] constexpr int component_count(ChannelType type) {
    return type == ChannelType::real || type == ChannelType::integer ? 1 : 3;
}

/// The technique that found a contribution: `s` vertices of the light subpath and `t` of the camera subpath, including
/// the light's and the camera's (E. Veach 1997, section 10.2). Path tracing hits lights with s = 0 and samples them
/// with s = 1; t = 1 is a splat. The technique is not part of the path string: an emitter is L because of its kind, not
/// because of the technique that found it.
struct Technique {
    std::uint32_t s = 0, t = 0;
    bool operator==(const Technique&) const = default;
};

/// How the samples of a pixel become its value: by the render's pixel filter, or by a rule that ignores it. zmin and
/// zmax copy the value of the sample nearest to / farthest from the camera.
enum class FilterRule : std::uint8_t { filter, zmin, zmax, min, max, average, sum };

/// The statistics in a layer about the samples of another channel, component by component. With n samples v of weight w
/// and the pixel's value m:
///   variance   sum((v - m)^2) / (n - 1)
///   mse        variance of m: variance x sum(w^2) / sum(w)^2, which is variance / n for equal weights
///   even, odd  the pixel from the samples with an even (odd) index only: two images of half the samples each
enum class Statistic : std::uint8_t { none, variance, mse, even, odd };

/// The channel information that GetDisplayChannels gives to patterns, bxdfs and integrators.
struct DisplayChannel {
    ChannelId id = invalid_channel;
    ChannelStyle style = ChannelStyle::name;
    ChannelType type = ChannelType::rgb;
    std::string name;
};

/// The limit of scale exponents, beyond the range of float in both directions.
inline constexpr int largest_scale_exponent = 256;

struct ChannelDefinition {
    std::string name;
    ChannelStyle style = ChannelStyle::name;
    ChannelType type = ChannelType::rgb;
    /// For style `name`: a job or a plugin declares the channel, and code that finds it by name writes to it. False:
    /// the name belongs to a geometric AOV, or to a channel of a pattern of the scene or of a plugin.
    bool declared = false;
    std::string expression;  ///< style `expression`: the text of the user
    lpe::Dialect dialect = lpe::Dialect::renderman;
    /// If not empty, the channel accepts what none of these channels (by index) accepts. `expression` can describe
    /// this.
    std::vector<std::size_t> rest_of;
    FilterRule rule = FilterRule::filter;
    std::string space;        ///< "camera", "world", "raster", "rendering colour space", ...
    bool statistics = false;  ///< keep the second moment per pixel, too
    /// If not invalid, the channel is a further output of channel `source`, which has samples and the same type. Values
    /// cannot be sent to it: values for the source reach every output. With a statistic it is computed from the frame
    /// buffer's sums of its source, whose rule is `filter`. Without one it combines the samples of the source with its
    /// own rule.
    ChannelId source = invalid_channel;
    Statistic statistic = Statistic::none;
    float miss_value = 0.0f;  ///< value of a sample to which no value was written
    /// Values are of the order of 2^scale_exponent, which sets the range of the frame buffer's exact sums
    /// (frame_buffer.h). Within +-largest_scale_exponent; equal for all channels of style `expression`, and for a layer
    /// and its source.
    int scale_exponent = 0;
    std::string origin;                      ///< for errors: the file or option that contains the expression
    int origin_line = 0, origin_column = 0;  ///< position of the first character of the expression, 0 = unknown
};

/// Returns whether samples can be sent to the channel, that is, whether it is not an output of another one.
[[nodiscard]] inline bool takes_samples(const ChannelDefinition& channel) {
    return channel.source == invalid_channel;
}
/// Returns whether the channel's rule combines samples, that is, whether it is not a layer of statistics.
[[nodiscard]] inline bool keeps_pixels(const ChannelDefinition& channel) {
    return channel.statistic == Statistic::none;
}

}  // namespace raylex::display
