// What both precisions of transport are asked: the same renders of the same samples.
#pragma once

#include <array>
#include <vector>

namespace raylex::test {

/// Reflectance and longest path of the furnaces.
inline constexpr double long_albedo = 0.9995, short_albedo = 0.5;
inline constexpr int long_depth = 10'000, short_depth = 6;

/// The beauty, plane after plane as FrameBuffer::resolve gives it.
struct Measurements {
    std::vector<double> long_furnace;  ///< `path`: every path has all of its 10^4 scattering events
    std::vector<double> path_furnace, bdpt_furnace;
    std::vector<double> path_room, bdpt_room;  ///< walls, rough metal, glass, fog; no coats: they hash directions

    [[nodiscard]] std::array<std::vector<double>*, 5> all() {
        return {&long_furnace, &path_furnace, &bdpt_furnace, &path_room, &bdpt_room};
    }
};

Measurements measure();

}  // namespace raylex::test
