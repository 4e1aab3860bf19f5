// Finds the settings that are worth their time: the undominated points of (seconds, error).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace raylex::experiments {

struct CostPoint {
    double seconds = 0, error = 0;
};

/// Returns the indices of the undominated points, by seconds. A point is dominated if another is at least as fast and
/// as accurate, and better in one of the two. Points that are not finite are ignored; of equal points the first is
/// kept.
std::vector<std::size_t> pareto_front(std::span<const CostPoint> points);

}  // namespace raylex::experiments
