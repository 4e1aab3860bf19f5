#include "transport/paths/subpaths/camera_subpaths.h"

#include <algorithm>

#include "transport/math/make_at.h"

namespace raylex::transport {
namespace {

/// A pilot bounds the depth of its paths, and may follow them until they end by themselves.
WalkOptions bounded(WalkOptions options, const PathPlan* plan) {
    if (plan == nullptr) return options;
    options.max_depth = std::min(options.max_depth, plan->most_depth);
    if (plan->follows_whole_paths) options.roulette_below = 0;
    return options;
}

}  // namespace

CameraSubpaths::CameraSubpaths(const PathContext& context, WalkOptions options)
    : Walk(context, bounded(options, context.plan),
           Record(*context.events, static_cast<std::size_t>(context.batch_capacity))),
      planned_((context.directions != nullptr && context.directions->plans_rays()) ||
               (context.plan != nullptr && context.plan->changes_paths())),
      live_lobes_(!options.densities && !context.beauty && context.events->prunes()) {
    if (planned_) {
        branch_samplers_.resize(paths_.size());
        splits_.resize(paths_.size());
    }
    directions_plan_rays_ = context.directions != nullptr && context.directions->plans_rays();
    if (directions_plan_rays_ || (context.plan != nullptr && context.plan->shares.any())) shares_.resize(paths_.size());
    if (scene_.tests_alpha()) travelled_.resize(paths_.size());
}

void CameraSubpaths::begin(const CameraBatch& batch, ThreadServices& services, IntegratorCounters& counters) {
    levels_in_use_ = 0;
    later_ = services.later;
    std::span<const PixelSampler> samplers = batch.samplers;
    if (planned_) {
        std::copy(samplers.begin(), samplers.end(), branch_samplers_.begin());
        samplers = {branch_samplers_.data(), samplers.size()};
    }
    Walk::begin(samplers, counters);
    record_.begin(services.lpe, batch.rays.size());
    // What is learned depends on no layer beside the beauty or the class of the pass (Law 2).
    record_.follow_beauty_alone(later_ != nullptr && (context_.beauty || services.lpe.is_of_class()));
    std::fill(splits_.begin(), splits_.end(), SplitState());
    std::fill(shares_.begin(), shares_.end(), TechniqueShares());
    std::fill(travelled_.begin(), travelled_.end(), Real(0));
    for (std::size_t i = 0; i < batch.rays.size(); ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        Subpath& path = paths_[row];
        make_at(path, [] { return Subpath(); });
        path.from = batch.rays[i].origin;
        path.medium = scene_.media->camera();
        if (!batch.weights.empty()) {
            path.beta = Rgb(batch.weights[i]);
            // A factor of the whole image makes no path weak.
            if (batch.weights[i] > 0) path.roulette_scale = 1 / batch.weights[i];
        }
        if (options_.densities) {
            mis_weights_[row] = PartialMisWeights();
            mis_weights_[row].connects = 1;  // the first vertex with the camera: t = 1
        }
        push(row, batch.rays[i]);
    }
}

bool CameraSubpaths::advance(ThreadServices& services) {
    if (!(going() || (levels_in_use_ > 0 && go_back())) || services.leaving()) return false;
    Walk::advance(services.display);
    if (record_.events().wants_user()) report_surfaces();
    if (live_lobes_) keep_live_lobes();
    write_first_hits(context_, vertices_, first_entries(), first_hits_, services.display);
    if (directions_plan_rays_)
        for (std::size_t j = 0; j < vertices_.count; ++j) choose_rays(j);
    else if (planned_ && (context_.plan->splits.any() || context_.plan->follows_whole_paths))
        for (std::size_t j = 0; j < vertices_.count; ++j) split(j);
    return true;
}

void CameraSubpaths::scatter() {
    if (!planned_) return scatter_vertices<false>(0);
    keep_split_vertices();
    scatter_vertices<true>(0);
}

void CameraSubpaths::report_surfaces() {
    const VertexBatch& v = vertices_;
    for (std::size_t j = 0; j < v.surfaces; ++j) {
        const std::uint32_t row = v.rows[j];
        if (path(row).depth < options_.first_depth) continue;
        const SurfacePoint& point = v.points[j];
        const std::int32_t label = v.sources[j].label;
        record_.report_user(row, label, UserLobe::albedo, throughput(row), [&] { return v.bsdfs[j].albedo(point.wo); });
        record_.report_user(row, label, UserLobe::normal, throughput(row), [&] {
            const Vec3 n = face_forward(point.shading_normal, point.wo);
            Rgb value;
            for (int i = 0; i < 3; ++i) {
                const Real* m = context_.first_hits.world_to_camera[i];
                value[i] = m[0] * n.x + m[1] * n.y + m[2] * n.z;
            }
            return value;
        });
    }
}

void CameraSubpaths::keep_live_lobes() {
    if (record_.counts_alike()) return;
    VertexBatch& v = vertices_;
    for (std::size_t j = 0; j < v.surfaces; ++j) {
        if (record_.events().scatterings(v.sources[j].label, v.points[j].material).size() < 2) continue;
        const std::optional<SideLobes> lobes = v.bsdfs[j].side_lobes();
        if (!lobes || record_.takes_all(v.rows[j])) continue;
        const auto live = [&](LobeId lobe) { return record_.is_live_lobe(v.rows[j], v.sources[j].label, lobe); };
        const bool reflected = live(lobes->reflected), passed = live(lobes->passed[0]) || live(lobes->passed[1]);
        if (reflected == passed) continue;
        counters().count(Pruned::lobes);
        v.bsdfs[j].keep_side(reflected ? Sides::reflection : Sides::transmission);
    }
}

}  // namespace raylex::transport
