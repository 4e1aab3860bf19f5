// How a walk leaves its vertices: directions, roulette, branches, the next rays. Only walk.cpp includes this file.
#pragma once

#include "transport/math/make_at.h"
#include "transport/paths/plan/splits.h"
#include "transport/paths/walk.h"

namespace raylex::transport {

template <TransportMode mode>
void Walk<mode>::draw_pairs(std::uint32_t which) {
    pair_ = which;
    pairs_are_drawn_ = vertices_.count > 0 && SamplerBatch::takes(samplers_[vertices_.rows[0]]);
    if (!pairs_are_drawn_) return;
    pairs_.clear();
    for (std::size_t j = 0; j < vertices_.count; ++j) {
        const std::uint32_t row = vertices_.rows[j];
        pairs_.add(samplers_[row], dimensions.of(paths_[row].depth, which));
    }
    pairs_.draw();
}

template <TransportMode mode>
void Walk<mode>::pass_cutouts() {
    for (const CutoutPass& pass : passes_) {
        Subpath& path = paths_[pass.row];
        record_.pass_through(pass.row, pass.label);
        if constexpr (mode == TransportMode::radiance) travelled_[pass.row] += pass.t;
        path.medium = pass.medium;
        ++path.segment;
        push(pass.row, pass.onward);
    }
    passes_.clear();
}

/// The probability with which a planned roulette continues the path of a row. 0: the throughput decides.
template <TransportMode mode>
Real Walk<mode>::planned_survival(std::uint32_t row) const {
    const Subpath& path = paths_[row];
    Real strength = path.beta.max() * path.roulette_scale;
    if (splits_[row].split) strength /= static_cast<Real>(context_.plan->splits.rays);
    if (!path.specular) strength /= technique_shares(row).ray;  // the throughput behind the choice between techniques
    return context_.plan->roulette.chance(planned_state(row), strength);
}

/// The state by which a plan distinguishes paths. Specular directions have states of their own: no light sample finds
/// their light, so more depends on these paths.
template <TransportMode mode>
std::uint64_t Walk<mode>::planned_state(std::uint32_t row) const {
    if constexpr (mode == TransportMode::importance) return 0;
    else {
        const std::uint64_t state = record_.events().liveness().state_of(record_.tracker(row));
        return paths_[row].specular ? state ^ (std::uint64_t{state != 0} << 63) : state;
    }
}

template <TransportMode mode>
template <bool planned>
bool Walk<mode>::survives_roulette(std::size_t j, std::uint32_t dimension) {
    const std::uint32_t row = vertices_.rows[j];
    Subpath& path = paths_[row];
    Real keep = 1, chance = 0;
    if constexpr (planned) {
        // 1: CameraSubpaths::choose_rays() decided before the direction was drawn, by the number of this dimension
        if (directions_plan_rays_) chance = vertices_.bsdfs[j].has_density() ? 1 : 0;
        else if (!context_.plan->roulette.empty()) chance = planned_survival(row);
    }
    if (chance > 0) {
        keep = chance;
    } else if (path.depth >= 2) {
        const Real throughput = mode == TransportMode::radiance ? path.beta.max() * path.roulette_scale
                                                                : path.beta.max() / path.roulette_scale;
        if (throughput < options_.roulette_below) keep = throughput / options_.roulette_below;
    }
    const bool shared = !shares_.empty() && !path.specular;  // no other technique finds a specular direction
    if (shared) {
        keep *= shares_[row].ray;
        path.pdf *= shares_[row].ray;
    }
    if (!(keep < 1)) return true;
    if (samplers_[row].get_random(dimension) >= keep) {
        if (shared && shares_[row].ray < 1) counters_->count(Pruned::rays_left_to_light_samples);
        else if (chance > 0) counters_->count(Pruned::weak_paths);
        return false;
    }
    path.beta *= 1 / keep;
    return true;
}

/// Multiplies the throughput by the share of a branch. Roulette treats the branch like the unsplit path. Returns the
/// expected number of rays that compete for the same light in multiple importance sampling, which is 1 if each ray
/// follows another lobe.
template <TransportMode mode>
Real Walk<mode>::take_branch(Subpath& path, SplitState& split, const BsdfSample& s) {
    const Real rays = split.expected;
    if (split.all_lobes) {  // every lobe is followed, so none counts for others
        path.beta *= s.pdf;
        path.roulette_scale /= s.pdf;
    } else if (rays != 1) {
        path.beta *= 1 / rays;
        path.roulette_scale *= std::max(rays, Real(1));
    }
    split.rays = 1;
    split.expected = 1;
    split.all_lobes = false;
    return rays;
}

/// Corrects the path's length for the event at vertex j, which the path has left. Returns false if the path is too
/// long.
template <TransportMode mode>
[[gnu::noinline]] bool Walk<mode>::stays_short(std::size_t j, const Vec3& direction) {
    Subpath& path = paths_[vertices_.rows[j]];
    const bool first_specular = mode == TransportMode::radiance && !options_.counts_first_specular &&
                                !path.any_non_specular && path.depth < options_.max_depth;
    const std::int32_t event = first_specular ? 0 : depth_limit_.event(vertex_depth(j), vertices_.points[j], direction);
    path.length -= whole_event - event;
    return depth_limit_.allows(path.length);
}

/// Whether a light subpath goes on from vertex j. If not, vertex j itself may still be connected.
template <TransportMode mode>
bool Walk<mode>::may_be_scattered(std::size_t j) {
    if constexpr (mode == TransportMode::importance) {
        const std::uint32_t row = vertices_.rows[j];
        if (!record_.live_set(row, vertices_.sources[j].label, vertices_.points[j].material).goes_on) {
            counters_->count(pruned_paths);
            return false;
        }
        if (paths_[row].depth >= options_.most_scatterings) {
            ++cut_;
            return false;
        }
    }
    return true;
}

/// Whether a channel takes anything that the next ray may meet.
template <TransportMode mode>
bool Walk<mode>::goes_on(std::uint32_t row) {
    const Subpath& path = paths_[row];
    if constexpr (mode == TransportMode::radiance) {
        const bool last = !depth_limit_.has_bodies() && !depth_limit_.allows(path.length + whole_event);
        if (last && !light_can_be_hit_) return false;
    }
    if (!record_.is_live(row)) {
        counters_->count(pruned_paths);
        return false;
    }
    return true;
}

template <TransportMode mode>
[[gnu::noinline]] void Walk<mode>::pass_vertex(std::size_t j, const BsdfSample& s, Real reached, Real factor,
                                               Real rays) {
    const VertexBatch& v = vertices_;
    const std::uint32_t row = v.rows[j];
    const Subpath& path = paths_[row];
    const Bsdf& bsdf = v.bsdfs[j];
    const bool emits = j < v.surfaces && scene_.geometry->shapes()[v.hits[j].shape].first_light != Hit::none;
    later_->pass({.row = row,
                  .depth = path.depth,
                  .state = planned_state(row),
                  .throughput = throughput(row),
                  .reached = reached,
                  .arrived = reached * factor,
                  .strength = path.beta.max() * path.roulette_scale,
                  .split = !splits_.empty() && splits_[row].split,
                  .emits = emits,
                  .guidable = bsdf.has_density() && bsdf.can_be_guided(),
                  .specular = s.delta,
                  .position = path.from,
                  .direction = s.wi,
                  .normal = path.from_normal,
                  .chance = s.pdf * s.drawn_over_pdf,
                  .pdf = path.pdf * s.drawn_over_pdf * (s.delta ? Real(1) : rays)});
}

/// Counts and logs a throughput that is NaN or infinite (Law 6).
template <TransportMode mode>
void Walk<mode>::reject(std::uint32_t row) {
    if constexpr (mode == TransportMode::radiance) record_.reject(row, paths_[row].beta);
    else invalid_powers_.push_back({row, paths_[row].beta});
}

/// Whether the path is short enough, and live, to draw a direction at vertex j.
template <TransportMode mode>
bool Walk<mode>::draws_direction(std::size_t j) {
    const Subpath& path = paths_[vertices_.rows[j]];
    // In bodies an event may count less than a whole one: stays_short() checks the length behind the drawn direction.
    const bool short_enough = depth_limit_.has_bodies()
                                  ? may_scatter(j) && depth_limit_.allows_walk(path.depth)
                                  : depth_limit_.allows(path.length + whole_event * (to_camera + 1));
    return short_enough && may_be_scattered(j);
}

template <TransportMode mode>
template <bool planned>
void Walk<mode>::scatter_vertices(std::uint32_t branch) {
    draw_pairs(dimensions.scatter);
    pass_cutouts();
    const std::size_t passed_on = queue_.count;  // counted already
    for (std::size_t j = 0; j < vertices_.count; ++j) {
        const std::uint32_t row = vertices_.rows[j];
        if (!draws_direction(j)) counters_->count_length(paths_[row].depth + static_cast<std::uint32_t>(to_camera));
        else if (!scatter_vertex<planned>(j, branch)) finish(row);
    }
    counters_->scattering_rays += queue_.count - passed_on;
}

/// Returns false if the path ends.
template <TransportMode mode>
template <bool planned>
bool Walk<mode>::scatter_vertex(std::size_t j, [[maybe_unused]] std::uint32_t branch) {
    const VertexBatch& v = vertices_;
    const std::uint32_t row = v.rows[j];
    Subpath& path = paths_[row];
    if (planned && splits_[row].rays == 0) return false;
    const PixelSampler& sampler = samplers_[row];
    const Bsdf& bsdf = v.bsdfs[j];
    const SurfacePoint& point = v.points[j];
    const std::uint32_t depth = path.depth;
    const DirectionSampler* directions = bsdf.has_density() ? context_.directions : nullptr;
    const bool draws_lobe = bsdf.chooses_lobes() || directions != nullptr;
    Real u_lobe = draws_lobe ? sampler.get_1d(dimensions.of(depth, dimensions.lobe)) : 0.0f;
    if (planned && splits_[row].all_lobes) u_lobe = lobe_number(branch);
    BsdfSample s = directions == nullptr ? sample_scattering<mode>(bsdf, point, u_lobe, pair(j))
                                         : sample_direction<mode>(*directions, bsdf, point, u_lobe, pair(j));
    if (wavelengths_.any()) wavelengths_.leave<mode>(v, j, path, s);
    if (!(s.pdf > 0) || s.weight.is_black()) return false;
    const Real reached = path.beta.average();
    path.beta *= s.weight;
    const Real weighed = mode == TransportMode::radiance && later_ != nullptr ? path.beta.average() : Real(1);
    const Real rays = planned ? take_branch(path, splits_[row], s) : 1;
    leave_vertex<mode>(path, point, s);
    if (mode == TransportMode::radiance && directions != nullptr) path.roulette_scale *= s.favoured;
    const bool counts_whole = !depth_limit_.has_bodies() && options_.counts_first_specular;
    if (!counts_whole && !stays_short(j, s.wi)) return false;
    if constexpr (mode == TransportMode::radiance) record_.scatter(row, v.sources[j].label, s.lobes);
    else record_.scatter(row, v.sources[j].label, s.lobes, sampler.key(dimensions.of(path.depth, dimensions.key)));
    if (!is_finite(path.beta)) {
        reject(row);
        return false;
    }
    if (path.beta.is_black() || !survives_roulette<planned>(j, dimensions.of(depth, dimensions.roulette)) ||
        !goes_on(row))
        return false;
    const bool weighs_rays =
        planned && !path.specular && !bsdf.depends_on_weights();  // CameraSubpaths::expected_rays()
    if (weighs_rays) path.pdf *= rays;
    if (mode == TransportMode::radiance && later_ != nullptr)
        pass_vertex(j, s, reached, path.beta.average() / weighed, weighs_rays ? 1 : rays);
    if (options_.densities) {
        const Real reverse = s.delta ? 1 : direction_density<reverse_mode>(directions, bsdf, point, s.wi, point.wo);
        mis_weights_[row].leave(s.delta, static_cast<double>(reverse), static_cast<double>(point.cosine(s.wi)));
    }
    if (in_media_) path.medium = medium_towards(j, s.wi);
    Ray& onward = queue_.next(row);
    make_at(onward, [&] { return ray_from(v, j, s.wi); });
    if (has_footprints_) onward.cone = scattered_cone(*scene_.geometry, v.hits[j], point, s);
    return true;
}

}  // namespace raylex::transport
