// Splitting of camera subpaths: which vertices are kept, and how subpaths go back to them.
#include "transport/paths/subpaths/camera_subpaths.h"

namespace raylex::transport {
namespace {

/// Whether the closure reflects or transmits, each in one direction.
bool has_two_lobes(const Bsdf& bsdf, const Vec3& wo) {
    if (!bsdf.side_lobes()) return false;
    const BsdfSample first = bsdf.sample(wo, lobe_number(0), {}), last = bsdf.sample(wo, lobe_number(1), {});
    return first.delta && last.delta && first.pdf > 0 && last.pdf > 0 && first.transmitted != last.transmitted;
}

}  // namespace

/// Sets the number of rays that leave vertex j. Called before light is sampled there.
void CameraSubpaths::split(std::size_t j) {
    const VertexBatch& v = vertices_;
    const std::uint32_t row = v.rows[j];
    SplitState& split = splits_[row];
    const SplitPlan& splits = context_.plan->splits;
    if (!may_scatter(j) || record_.takes_all(row)) return;
    if (v.bsdfs[j].has_density()) {
        if (split.split || !record_.live_set(row, v.sources[j].label, v.points[j].material).scatters) return;
        split.split = true;
        split.rays = splits.rays;
        split.expected = static_cast<Real>(splits.rays);
    } else if (split.split && split.followed < splits.both_lobes && has_two_lobes(v.bsdfs[j], v.points[j].wo)) {
        ++split.followed;
        split.all_lobes = true;
    }
}

/// Draws the number of rays that leave vertex j, where the sampler of directions determines it. It depends on no
/// channel (Law 2).
void CameraSubpaths::choose_rays(std::size_t j) {
    if (!may_scatter(j)) return;
    const std::uint32_t row = vertices_.rows[j];
    SplitState& split = splits_[row];
    split.expected = context_.directions->rays(vertices_.bsdfs[j], vertices_.points[j], paths_[row].beta.average());
    split.rays = static_cast<std::uint8_t>(split.expected);
    const Real rest = split.expected - static_cast<Real>(split.rays);
    if (rest > 0 && branch_samplers_[row].get_random(dimensions.of(paths_[row].depth, dimensions.roulette)) < rest)
        ++split.rays;
}

void SplitVertices::drop_finished() {
    std::size_t kept = 0, surfaces = 0;
    for (std::size_t k = 0; k < vertices.count; ++k) {
        if (splits[k].branches() <= next) continue;
        if (k < vertices.surfaces) ++surfaces;
        if (kept != k) {
            vertices.keep(k, kept);
            vertices.bsdfs[kept] = vertices.bsdfs[k];
            paths[kept] = paths[k];
            splits[kept] = splits[k];
            shares[kept] = shares[k];
            trackers[kept] = trackers[k];
            samplers[kept] = samplers[k];
        }
        ++kept;
    }
    vertices.count = kept;
    vertices.surfaces = surfaces;
}

void CameraSubpaths::keep_split_vertices() {
    const VertexBatch& v = vertices_;
    SplitVertices* level = nullptr;
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        SplitState& split = splits_[row];
        if (split.branches() <= 1) continue;
        const SplitPlan::Only only = context_.plan == nullptr ? SplitPlan::Only::all : context_.plan->splits.only;
        if (only != SplitPlan::Only::all && !split.all_lobes) {
            if (only == SplitPlan::Only::none) split.rays = 0;
            else branch_samplers_[row] = branch_samplers_[row].branch(0, split.rays);
            continue;
        }
        if (level == nullptr) {
            if (levels_in_use_ == levels_.size())
                levels_.push_back(std::make_unique<SplitVertices>(branch_samplers_.size()));
            level = levels_[levels_in_use_++].get();
            level->next = 1;
            level->vertices.count = level->vertices.surfaces = 0;
        }
        const std::size_t k = level->vertices.count++;
        if (j < v.surfaces) ++level->vertices.surfaces;
        level->vertices.rows[k] = row;
        level->vertices.rays[k] = v.rays[j];
        level->vertices.hits[k] = v.hits[j];
        level->vertices.points[k] = v.points[j];
        level->vertices.sources[k] = v.sources[j];
        level->vertices.bsdfs[k] = v.bsdfs[j];
        level->paths[k] = paths_[row];
        level->splits[k] = split;
        level->shares[k] = technique_shares(row);
        level->trackers[k] = record_.tracker(row);
        level->samplers[k] = branch_samplers_[row];
        if (!split.all_lobes) branch_samplers_[row] = branch_samplers_[row].branch(0, split.rays);
    }
}

bool CameraSubpaths::go_back() {
    while (!going() && levels_in_use_ > 0) {
        SplitVertices& level = *levels_[levels_in_use_ - 1];
        level.drop_finished();
        if (level.vertices.count == 0) {
            --levels_in_use_;
            continue;
        }
        const std::uint32_t branch = level.next++;
        for (std::size_t k = 0; k < level.vertices.count; ++k) {
            const std::uint32_t row = level.vertices.rows[k];
            paths_[row] = level.paths[k];
            splits_[row] = level.splits[k];
            if (!shares_.empty()) shares_[row] = level.shares[k];
            record_.go_back(row, level.trackers[k]);
            branch_samplers_[row] = level.samplers[k].branch(branch, level.splits[k].branches());
        }
        counters().branches += level.vertices.count;
        std::swap(vertices_, level.vertices);
        scatter_vertices<true>(branch);
        std::swap(vertices_, level.vertices);
    }
    return going();
}

}  // namespace raylex::transport
