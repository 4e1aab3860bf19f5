#include "transport/paths/subpaths/camera_subpaths.h"

#include <algorithm>

#include "transport/math/make_at.h"

namespace raylex::transport {

void CameraSubpaths::begin(std::span<const Ray> rays, std::span<const PixelSampler> samplers, display::LpeServices& lpe,
                           IntegratorCounters& counters) {
    levels_in_use_ = 0;
    if (by_channels_) {
        std::copy(samplers.begin(), samplers.end(), branch_samplers_.begin());
        samplers = {branch_samplers_.data(), samplers.size()};
    }
    walk_.begin(samplers, counters);
    record_.begin(lpe, rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        Subpath& path = walk_.path(row);
        make_at(path, [] { return Subpath(); });
        path.from = rays[i].origin;
        path.medium = scene_.media->camera();
        if (options_.walk.densities) {
            walk_.sums(row) = StrategySums();
            walk_.sums(row).join = 1;  // of the first vertex with the camera: t = 1
        }
        walk_.push(row, rays[i]);
    }
}

void CameraSubpaths::weigh(std::span<const Real> weights) {
    for (std::size_t i = 0; i < weights.size(); ++i) {
        Subpath& path = walk_.path(static_cast<std::uint32_t>(i));
        path.beta = Rgb(weights[i]);
        if (weights[i] > 0) path.roulette_scale = 1 / weights[i];  // a factor of the whole image makes no path weak
    }
}

void CameraSubpaths::pass(std::size_t j) {
    const VertexBatch& v = vertices();
    const std::uint32_t row = v.rows[j];
    Subpath& path = walk_.path(row);
    record_.pass_straight(row, v.sources[j].label);
    // This ray went through, so its own opacity at the cutout is 0: over many rays the mean is the cutout's alpha.
    path.travelled += v.hits[j].t;
}

void CameraSubpaths::record_first_hit(display::DisplayServices& display, std::size_t j) {
    const VertexBatch& v = vertices();
    const EmbreeScene& geometry = *scene_.geometry;
    const auto row = static_cast<int>(v.rows[j]);
    display.write_distance(row, to_float(path(v.rows[j]).travelled + v.hits[j].t));
    const bool holdout = geometry.has_holdouts() && geometry.is_holdout(v.hits[j]);
    display.write_opacity(row, holdout ? 0.0f : 1.0f);
    display.write_surface(row, geometry.surface_number(v.hits[j]));
    if (holdout) record_.hold_out(v.rows[j]);
}

void CameraSubpaths::report_surfaces() {
    const VertexBatch& v = vertices();
    for (std::size_t j = 0; j < v.surfaces; ++j) {
        const std::uint32_t row = v.rows[j];
        if (path(row).depth < options_.first_depth) continue;
        const SurfacePoint& point = v.points[j];
        const std::int32_t label = v.sources[j].label;
        record_.say(row, label, UserLobe::albedo, throughput(row), [&] { return v.bsdfs[j].albedo(point.wo); });
        record_.say(row, label, UserLobe::normal, throughput(row), [&] {
            const Vec3 n = face_forward(point.shading_normal, point.wo);
            Rgb value;
            for (int i = 0; i < 3; ++i) {
                const Real* m = options_.world_to_camera[i];
                value[i] = m[0] * n.x + m[1] * n.y + m[2] * n.z;
            }
            return value;
        });
    }
}

void CameraSubpaths::keep_live_lobes() {
    if (record_.wants_blocked_light()) return;  // values without throughput count paths as they are drawn
    const VertexBatch& v = vertices();
    for (std::size_t j = 0; j < v.surfaces; ++j) {
        const std::optional<SideLobes> lobes = v.bsdfs[j].side_lobes();
        if (!lobes || record_.takes_all(v.rows[j])) continue;
        const auto live = [&](LobeId lobe) { return record_.worth_scattering(v.rows[j], v.sources[j].label, lobe); };
        const bool reflected = live(lobes->reflected), passed = live(lobes->passed[0]) || live(lobes->passed[1]);
        if (reflected == passed) continue;
        walk_.counters().count(Pruned::lobes);
        walk_.closure(j).keep_side(reflected ? Sides::reflection : Sides::transmission);
    }
}

void CameraSubpaths::report_hidden_environments(const LightChooser& sampled, std::size_t j) const {
    const std::uint32_t row = vertices().rows[j];
    const Subpath& subpath = path(row);
    if (subpath.specular) return;
    const LightTable& lights = *scene_.lights;
    const Vec3& direction = vertices().rays[j].direction;
    for (const std::uint32_t light : lights.environments()) {
        if (lights.environment_density(sampled, light, subpath.from, direction) > 0) continue;
        const Rgb emitted = lights.environment_radiance(light, subpath.from, direction);
        record_.arrive(row, record_.events().terminal(light), {0, subpath.depth + 2},
                       {Rgb(), emitted, throughput(row) * emitted, 0});
    }
}

struct CameraSubpaths::Scatterer : WalkVisitor {
    CameraSubpaths& self;

    void scatters(std::size_t j, const LobeList& lobes) {
        self.record_.scatter(self.vertices().rows[j], self.vertices().sources[j].label, lobes);
    }
    void invalid(std::uint32_t row) { self.record_.reject(row, self.path(row).beta); }
    bool goes_on(std::uint32_t row) {
        const DepthLimit& limit = self.depth_limit();
        const bool last = !limit.has_bodies() && !limit.allows(self.path(row).length + whole_event);
        if (last && !self.options_.light_can_be_hit) return false;
        const bool worth = self.record_.worth(row);
        if (!worth) self.walk_.counters().count(Pruned::paths);
        return worth;
    }
};

/// Where channels alone decide which rays go on.
struct CameraSubpaths::ChannelScatterer : Scatterer {
    static constexpr bool splits = true, expects = true;
    std::uint32_t branch;

    /// Paths that have come in a direction which light samples could not find still bring all of the light there.
    [[nodiscard]] std::uint64_t state(std::uint32_t row) const {
        const std::uint64_t state = self.record_.events().foresight().state_of(self.record_.tracker(row));
        return self.walk_.path(row).specular ? state ^ (std::uint64_t{state != 0} << 63) : state;
    }
    [[nodiscard]] static Real throughput(const Subpath& path) { return path.beta.max() * path.roulette_scale; }
    [[nodiscard]] Real chance(std::uint32_t row) const {
        if (self.options_.roulette == nullptr) return 0;
        const Subpath& path = self.walk_.path(row);
        Real strength = throughput(path);
        if (path.split) strength /= static_cast<Real>(self.options_.splits.rays);
        if (!path.specular) strength /= path.ray_share;  // as it will be
        return self.options_.roulette->chance(state(row), strength);
    }
    bool goes_on(std::uint32_t row) {
        if (!Scatterer::goes_on(row)) return false;
        const Subpath& path = self.walk_.path(row);
        if (self.options_.watch != nullptr) self.options_.watch->leaves(row, state(row), throughput(path), path.split);
        return true;
    }
};

void CameraSubpaths::scatter_branch(std::uint32_t branch) {
    ChannelScatterer scatterer{{{}, *this}, branch};
    walk_.scatter(scatterer);
}

void CameraSubpaths::scatter() {
    if (by_channels_) {
        keep_split_vertices();
        return scatter_branch(0);
    }
    Scatterer scatterer{{}, *this};
    walk_.scatter(scatterer);
}

}  // namespace raylex::transport
