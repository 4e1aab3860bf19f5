#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace raylex::transport {

/// Work that was left out because no channel takes its light, or too little of it (Law 4), by cause.
enum class Pruned : std::uint8_t {
    paths,                       ///< ended: no word can be completed any more
    light_samples,               ///< not drawn: no light ends a word there
    shadow_rays,                 ///< of light samples and connections that no channel accepts
    rays_left_to_light_samples,  ///< last vertices where light samples find more for less,
    light_samples_left_to_rays,  ///< and the other way round
    lobes,                       ///< not drawn: no channel takes that side of an interface
    light_paths,                 ///< not begun or ended: no word leads on to where one is seen or joined
    connections,                 ///< of light subpath vertices with others or the camera: no channel takes any
    weak_paths,                  ///< ended at random: channels are expected to receive little of them
    closures                     ///< of first hits of which AOVs ask for the geometry alone: no texture is looked up
};
inline constexpr std::size_t pruned_causes = 10;
using PrunedCounts = std::array<std::uint64_t, pruned_causes>;

/// Work done, for statistics. Added up over threads at the end.
struct IntegratorCounters {
    std::uint64_t camera_rays = 0, scattering_rays = 0, shadow_rays = 0;
    std::uint64_t branches = 0;               ///< beside the first, of split paths
    PrunedCounts pruned{};                    ///< [Pruned]
    std::vector<std::uint64_t> path_lengths;  ///< [scattering events]
    void count(Pruned cause, std::uint64_t times = 1) { pruned[static_cast<std::size_t>(cause)] += times; }
    /// No channel takes any light of so many paths: none was begun.
    void leave_out_paths(std::uint64_t paths) { count(Pruned::paths, paths); }
    void add(const IntegratorCounters& other);
    /// Adds the counts of a part of an integrator, and sets them to zero there.
    void take(IntegratorCounters& part);
    /// A path of so many scattering events has ended; the longest share the last slot.
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
