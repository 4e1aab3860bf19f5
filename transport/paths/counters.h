#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace raylex::transport {

/// Work done, for statistics. Added up over threads at the end.
struct IntegratorCounters {
    std::uint64_t camera_rays = 0, scattering_rays = 0, shadow_rays = 0;
    std::vector<std::uint64_t> path_lengths;  ///< [scattering events]
    void add(const IntegratorCounters& other);
    /// A path of so many scattering events has ended; the longest share the last slot.
    void count_length(std::uint32_t events) { ++path_lengths[std::min<std::size_t>(events, path_lengths.size() - 1)]; }
};

inline void IntegratorCounters::add(const IntegratorCounters& other) {
    camera_rays += other.camera_rays;
    scattering_rays += other.scattering_rays;
    shadow_rays += other.shadow_rays;
    if (path_lengths.size() < other.path_lengths.size()) path_lengths.resize(other.path_lengths.size());
    for (std::size_t i = 0; i < other.path_lengths.size(); ++i) path_lengths[i] += other.path_lengths[i];
}

}  // namespace raylex::transport
