#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace raylex::transport {

/// The causes for which work is left out, because no channel takes its light, or too little of it (Law 4). A guide also
/// leaves out light samples of renders with beauty.
enum class Pruned : std::uint8_t {
    paths,                       ///< paths that ended early: no channel accepts any continuation
    light_samples,               ///< light samples that were not drawn: no channel accepts a light there
    shadow_rays,                 ///< shadow rays of light samples and connections that no channel accepts
    rays_left_to_light_samples,  ///< scattering rays of last vertices that were not traced, because light samples find
                                 ///< the same light at less cost
    light_samples_left_to_rays,  ///< light samples that were not drawn, because scattering rays of last vertices find
                                 ///< the same light at less cost, or a guide has learned that they find little
    lobes,        ///< sides of an interface that were not sampled: no channel accepts a path on that side
    light_paths,  ///< light subpaths that were not begun, or ended early: no channel accepts a path through them
    connections,  ///< connections of light subpath vertices with camera subpaths or the camera that no channel accepts
    weak_paths,   ///< paths that ended at random, because channels are expected to receive little from them
    closures      ///< closures of first hits that were not made, because AOVs need only the geometry there
};
inline constexpr std::size_t pruned_causes = 10;
using PrunedCounts = std::array<std::uint64_t, pruned_causes>;

/// Counts of work done, for statistics. The render adds the counters of all threads at its end.
struct IntegratorCounters {
    std::uint64_t camera_rays = 0, scattering_rays = 0, shadow_rays = 0;
    std::uint64_t branches = 0;               ///< number of branches of split paths, without the first branch of each
    PrunedCounts pruned{};                    ///< [Pruned]
    std::vector<std::uint64_t> path_lengths;  ///< [scattering events]
    void count(Pruned cause, std::uint64_t times = 1) { pruned[static_cast<std::size_t>(cause)] += times; }
    /// Counts paths that were not begun, because no channel takes their light.
    void leave_out_paths(std::uint64_t paths) { count(Pruned::paths, paths); }
    void add(const IntegratorCounters& other);
    /// Adds the counts of `part` to these counts, and sets `part` to zero.
    void take(IntegratorCounters& part);
    /// Counts a path that ended after this number of scattering events. The last slot also counts all longer paths.
    void count_length(std::uint32_t events) { ++path_lengths[std::min<std::size_t>(events, path_lengths.size() - 1)]; }
};

inline void IntegratorCounters::add(const IntegratorCounters& other) {
    camera_rays += other.camera_rays;
    scattering_rays += other.scattering_rays;
    shadow_rays += other.shadow_rays;
    branches += other.branches;
    for (std::size_t i = 0; i < pruned_causes; ++i) pruned[i] += other.pruned[i];
    if (path_lengths.size() < other.path_lengths.size()) path_lengths.resize(other.path_lengths.size());
    for (std::size_t i = 0; i < other.path_lengths.size(); ++i) path_lengths[i] += other.path_lengths[i];
}

inline void IntegratorCounters::take(IntegratorCounters& part) {
    add(part);
    const std::size_t slots = part.path_lengths.size();
    part = IntegratorCounters();
    part.path_lengths.assign(slots, 0);
}

}  // namespace raylex::transport
