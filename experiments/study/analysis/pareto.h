// Which settings are worth their time: the undominated points of (seconds, error).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace raylex::experiments {

struct CostPoint {
    double seconds = 0, error = 0;
};

/// Indices of the points than which no other is both as fast and as accurate and better in one of the two, by seconds.
/// Points that are not finite are left out; of equal points the first is kept.
std::vector<std::size_t> pareto_front(std::span<const CostPoint> points);

}  // namespace raylex::experiments
