// Helpers of the tests of the display services and the frame buffer.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/channel.h"
#include "display/services/samples/sample_table.h"

namespace raylex::test {

/// A generator with the same numbers on every machine: the standard library's distributions are not portable, its
/// engines are.
class Random {
  public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    std::uint64_t bits() { return engine_(); }
    double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    float uniform_float() { return static_cast<float>(engine_() >> 40) * 0x1p-24f; }
    int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
    double normal() {  // Box and Muller
        return std::sqrt(-2 * std::log(1 - uniform())) * std::cos(2 * std::numbers::pi * uniform());
    }

  private:
    std::mt19937_64 engine_;
};

/// Concatenates the parts. (`"text" + string` makes g++ 12 warn of an impossible overlap: its bug 105651.)
inline std::string join(std::initializer_list<std::string_view> parts) {
    std::string result;
    for (const std::string_view part : parts) result += part;
    return result;
}

inline display::ChannelDefinition plain_channel(std::string name, display::ChannelType type,
                                                display::FilterRule rule = display::FilterRule::filter,
                                                float miss = 0) {
    display::ChannelDefinition channel;
    channel.name = std::move(name);
    channel.type = type;
    channel.rule = rule;
    channel.miss_value = miss;
    return channel;
}

inline display::ChannelDefinition expression_channel(std::string name, std::string expression) {
    display::ChannelDefinition channel;
    channel.name = std::move(name);
    channel.style = display::ChannelStyle::expression;
    channel.expression = std::move(expression);
    return channel;
}

/// Camera rows of one pixel: `count` of them, with the samples first, first + 1, ...
inline std::vector<display::CameraRow> pixel_rows(int x, int y, std::uint64_t first, int count) {
    std::vector<display::CameraRow> rows(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        rows[static_cast<std::size_t>(i)].pixel_x = x;
        rows[static_cast<std::size_t>(i)].pixel_y = y;
        rows[static_cast<std::size_t>(i)].sample = first + static_cast<std::uint64_t>(i);
    }
    return rows;
}

/// Upper quantile of the chi-square distribution (Wilson and Hilferty 1931); `z` is the normal quantile.
inline double chi_square_quantile(double degrees, double z) {
    const double t = 2 / (9 * degrees), root = 1 - t + z * std::sqrt(t);
    return degrees * root * root * root;
}

}  // namespace raylex::test
