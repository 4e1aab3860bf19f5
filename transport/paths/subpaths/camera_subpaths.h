// Subpaths from the camera, one a row, side by side, with what each camera ray leaves behind: distance, opacity,
// surface, holdouts, words, what surfaces say of themselves. An integrator adds what the light is that they meet.
//
//     subpaths.begin(batch.rays, batch.samplers, services.lpe, counters);
//     while (subpaths.going()) {
//         subpaths.advance(services.display, ends);    // vertices() are the next of all subpaths that go on
//         ...
//         subpaths.scatter();
//     }
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "display/services/samples/display_services.h"
#include "transport/paths/record.h"
#include "transport/paths/roulette.h"
#include "transport/paths/subpaths/camera_connections.h"
#include "transport/paths/walk.h"

namespace raylex::transport {

/// The time of a sample's rays, its camera subpath's and its light subpath's; 0 where nothing moves.
inline Real sample_time(const SceneView& scene, const PixelSampler& sampler) {
    if (!scene.asks_for_times()) return 0;
    return static_cast<Real>(scene.geometry->shutter().time_of(static_cast<double>(sampler.get_1d(time_dimension))));
}

struct CameraSubpathOptions {
    WalkOptions walk;
    bool keep_first_hits = false;             ///< somebody reads AOVs or patterns there, whatever the light
    bool shade_first_hits = false;            ///< for more than their geometry
    bool light_can_be_hit = true;             ///< by a ray: if not, a path's last scattering need not be traced
    bool live_lobes = false;                  ///< closures draw no side that no channel takes; not for `densities`
    std::uint32_t first_depth = 0;            ///< surfaces before say nothing of themselves
    SplitPlan splits;                         ///< none for samplers of chains
    const RouletteTable* roulette = nullptr;  ///< null: by throughput alone
    PathWatch* watch = nullptr;               ///< a pilot's
    CameraView view;                          ///< for densities
    Real world_to_camera[3][4] = {};          ///< rigid part, for surfaces that say their normal
};

/// What an integrator makes of the light that camera subpaths meet. Derive and hide.
struct CameraEnds {
    /// Vertex j, whose closure is not known yet, lies on a light.
    void emits(std::size_t /*j*/) {}
    /// Vertex j is a surface, with what it emits reported.
    void arrives(std::size_t /*j*/) {}
    /// The ray meets what is infinitely far away.
    void escapes(std::uint32_t /*row*/, const Ray& /*ray*/) {}
    /// A medium sends `emitted` back along the ray.
    void volume_emits(std::uint32_t /*row*/, const Rgb& /*emitted*/) {}
};

class CameraSubpaths {
  public:
    CameraSubpaths(const SceneView& scene, const EventTable& events, const CameraSubpathOptions& options,
                   std::size_t capacity)
        : scene_(scene),
          options_(options),
          by_channels_(options.splits.any() || options.roulette != nullptr || options.watch != nullptr),
          walk_(scene, events, options.walk, capacity),
          record_(events, capacity) {
        if (by_channels_) branch_samplers_.resize(capacity);
    }

    void begin(std::span<const Ray> rays, std::span<const PixelSampler> samplers, display::LpeServices& lpe,
               IntegratorCounters& counters);
    /// After begin(): rays that count differently.
    void weigh(std::span<const Real> weights);
    [[nodiscard]] bool going() { return walk_.going() || (levels_in_use_ > 0 && go_back()); }
    template <class Ends>
    void advance(display::DisplayServices& display, Ends& ends) {
        Visitor<Ends> visitor{{}, *this, display, ends};
        walk_.advance(display, visitor);
        if (record_.events().wants_user()) report_surfaces();
        if (options_.live_lobes) keep_live_lobes();
    }
    void scatter();

    [[nodiscard]] const VertexBatch& vertices() const { return walk_.vertices(); }
    [[nodiscard]] std::span<const std::uint32_t> first_entries() const { return walk_.first_entries(); }
    [[nodiscard]] const Subpath& path(std::uint32_t row) const { return walk_.path(row); }
    /// Walk's.
    [[nodiscard]] Rgb throughput(std::uint32_t row) const { return walk_.throughput(row); }
    /// How a row looks for light from its vertex; see Subpath.
    void choose_techniques(std::uint32_t row, std::uint8_t lights, Real light_share, Real ray_share) {
        Subpath& path = walk_.path(row);
        path.lights = lights;
        path.light_share = light_share;
        path.ray_share = ray_share;
    }
    /// Numbers of light samples from the vertices.
    void draw_light_pairs() { walk_.draw_pairs(light_sample_dimension); }
    [[nodiscard]] Vec2 light_pair(std::size_t j) const { return walk_.pair(j); }
    /// Says at how many rays subpaths leave vertex j, before light is sampled there.
    void split(std::size_t j);
    [[nodiscard]] const StrategySums& sums(std::uint32_t row) const { return walk_.sums(row); }
    [[nodiscard]] StrategySums& sums(std::uint32_t row) { return walk_.sums(row); }
    [[nodiscard]] const PixelSampler& sampler(std::uint32_t row) const { return walk_.sampler(row); }
    [[nodiscard]] std::int32_t medium_towards(std::size_t j, const Vec3& direction) const {
        return walk_.medium_towards(j, direction);
    }
    [[nodiscard]] const Record& record() const { return record_; }
    /// Whether vertex j can be connected with light: something scatters there, and a path one event longer is not too
    /// long; which in bodies depends on where to.
    [[nodiscard]] bool can_connect(std::size_t j) const {
        return vertices().bsdfs[j].has_density() && walk_.may_scatter(j);
    }
    [[nodiscard]] bool can_connect(std::size_t j, const Vec3& direction) const {
        if (!depth_limit().has_bodies()) return true;
        const VertexDepth vertex = walk_.vertex_depth(j);
        return depth_limit().allows(vertex.before + depth_limit().event(vertex, vertices().points[j], direction));
    }
    [[nodiscard]] const DepthLimit& depth_limit() const { return walk_.depth_limit(); }
    [[nodiscard]] VertexDepth vertex_depth(std::size_t j) const { return walk_.vertex_depth(j); }

    /// Infinite lights that light sampling leaves to scattering, reported as blocked: vertex j hides them.
    void report_hidden_environments(const LightChooser& sampled, std::size_t j) const;

  private:
    template <class Ends>
    struct Visitor;
    struct Scatterer;
    struct ChannelScatterer;
    void keep_split_vertices();
    void follow_only(std::uint32_t row);
    void scatter_branch(std::uint32_t branch);
    /// From vertices that were kept, when nothing goes on. False: all is done.
    bool go_back();
    void report_surfaces();
    void keep_live_lobes();
    void pass(std::size_t j);
    /// Distance, opacity and surface of a camera ray.
    void record_first_hit(display::DisplayServices& display, std::size_t j);
    [[nodiscard]] bool is_wanted_first_hit(std::size_t j) const {
        return options_.keep_first_hits && path(vertices().rows[j]).depth == 0;
    }
    /// For light that may come there.
    [[nodiscard]] bool worth_shading(std::size_t j) {
        const std::uint32_t row = vertices().rows[j];
        if (record_.events().wants_user() && record_.channels_follow(row)) return true;
        if (!walk_.may_scatter(j, true)) return false;
        const bool worth = record_.ahead(row, vertices().sources[j].label, vertices().points[j].material).anything;
        if (!worth) walk_.counters().count(Pruned::paths);
        return worth;
    }

    const SceneView scene_;
    const CameraSubpathOptions options_;
    const bool by_channels_;  // alone it is decided which rays go on
    Walk<TransportMode::radiance> walk_;
    Record record_;
    // Where paths may be split.
    std::vector<PixelSampler> branch_samplers_;           // by row
    std::vector<std::unique_ptr<SplitVertices>> levels_;  // the last one kept is gone back to first
    std::size_t levels_in_use_ = 0;
};

template <class Ends>
struct CameraSubpaths::Visitor : WalkVisitor {
    CameraSubpaths& self;
    display::DisplayServices& display;
    Ends& ends;

    void escapes(std::uint32_t row, const Ray& ray) { ends.escapes(row, ray); }
    void interface_emits(std::size_t j) { ends.emits(j); }
    void passes_cutout(std::size_t j) { self.pass(j); }
    bool arrives(std::size_t j) {
        const VertexBatch& v = self.vertices();
        const std::uint32_t row = v.rows[j];
        if (self.path(row).depth == 0) self.record_first_hit(display, j);
        if (self.scene_.geometry->shapes()[v.hits[j].shape].first_light != Hit::none) ends.emits(j);
        ends.arrives(j);
        return self.is_wanted_first_hit(j) || self.worth_shading(j);
    }
    [[nodiscard]] bool may_skip_closures() const {
        return self.options_.keep_first_hits && !self.options_.shade_first_hits;
    }
    bool needs_closure(std::size_t j) {
        // What is no first hit was asked on arrival.
        if (!self.is_wanted_first_hit(j) || self.worth_shading(j)) return true;
        self.walk_.counters().count(Pruned::closures);
        return false;
    }
    void first_vertex(std::uint32_t row, const SurfacePoint& point, Real time, StrategySums& sums) {
        const CameraView& view = self.options_.view;
        sums.forward =
            view.density(view.camera->importance(point.position, self.path(row).from, time), point.cosine(point.wo));
    }
    void volume_emits(std::uint32_t row, const Rgb& emitted) { ends.volume_emits(row, emitted); }
    bool worth_colliding(std::uint32_t row) {
        const Subpath& path = self.path(row);
        if (path.depth == 0) return true;  // the camera ray's depth and opacity are to be found
        return self.walk_.may_collide(row) && self.record_.worth_colliding(row, path.medium);
    }
    void absorbs(std::uint32_t row, Real distance, const Rgb& passed, const Vec2& u) {
        const Subpath& path = self.path(row);
        if (path.depth > 0 || !(passed.average() < 1)) return;
        absorbs_at(row, sample_absorption((*self.scene_.media)[path.medium], distance, u), passed);
    }
    void absorbs_at(std::uint32_t row, Real lost_at, const Rgb& passed) {
        const Subpath& path = self.path(row);
        if (path.depth > 0 || !(passed.average() < 1)) return;
        display.add_sample(static_cast<int>(row), {to_float(path.travelled + lost_at), RgbD(Rgb(1) - passed), true});
    }
    bool collides(std::uint32_t row, Real distance, const Ray& /*ray*/) {
        const Subpath& path = self.path(row);
        if (path.depth > 0) return true;
        display.write_distance(static_cast<int>(row), to_float(path.travelled + distance), true);
        display.write_opacity(static_cast<int>(row), raylex::Rgb(1));
        return true;
    }
};

}  // namespace raylex::transport
