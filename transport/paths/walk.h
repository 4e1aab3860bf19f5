// The walk: subpaths of one direction, one a row, side by side, from vertex to vertex.
//
//     walk.begin(samplers, counters);
//     walk.push(row, ray);                     // for every subpath, after filling in path(row)
//     while (walk.going()) {
//         walk.advance(display);               // fills the columns below for one ray of each subpath
//         ...                                  // what an integrator does with them
//         walk.scatter();
//     }
//
// advance(): rays -> hits -> sampled distances in media -> alpha tests -> liveness -> closures. scatter(): closures or
// phase functions -> throughput -> roulette -> rays. Every stage is one loop over plain arrays. What a scene does not
// have (media, cutouts) costs a test a batch; densities that no method reads cost a test a vertex.
//
// The walk moves its record along each path. Before each further ray it checks that the record is live (Law 4).
#pragma once

#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "transport/paths/counters.h"
#include "transport/paths/footprints.h"
#include "transport/paths/partial_mis_weights.h"
#include "transport/paths/path_context.h"
#include "transport/paths/path_depth.h"
#include "transport/paths/path_wavelengths.h"
#include "transport/paths/record.h"
#include "transport/paths/scattering.h"
#include "transport/paths/vertex.h"
#include "transport/samplers/sampler_batch.h"

namespace raylex::transport {

struct WalkOptions {
    std::uint32_t max_depth = 5;  ///< scattering events of a whole path; a light subpath's connection is one of them
    Real roulette_below = default_roulette_below;  ///< 0: paths do not end at random
    bool densities = false;                        ///< keep mis_weights()
    bool regularize = false;                       ///< closures behind a scattering that is not specular
    /// False: specular scatterings at the beginning of a camera subpath do not count; at most `max_depth` of them.
    bool counts_first_specular = true;
    /// The walk does not report light and user events that a camera subpath meets before this number of scatterings:
    /// another part of the integrator finds them.
    std::uint32_t first_depth = 0;
    /// Light subpaths longer than this are cut, and counted.
    std::uint32_t most_scatterings = ~0u;
    /// For light subpaths with densities: the chooser from which camera subpaths draw light samples, for the weights.
    const LightChooser* sampled = nullptr;
};

/// A ray of a camera subpath that hit nothing.
struct EscapedRay {
    std::uint32_t row;
    Vec3 direction;  ///< world space, unit
};

/// A light that a camera subpath met.
struct EmitterHit {
    std::uint32_t row, light;
    Rgb emitted;     ///< radiance towards the subpath; never black
    Rgb throughput;  ///< up to the light
    SurfacePoint point;
    Hit hit;
};

/// A camera subpath that arrived at a surface, kept to report light that the surface blocks.
struct SurfaceArrival {
    std::uint32_t row;
    Vec3 direction;  ///< of the ray, world space, unit
    Rgb throughput;
};

/// A light subpath whose power is NaN or infinite.
struct InvalidPower {
    std::uint32_t row;
    Rgb power;
};

template <TransportMode mode>
class Walk {
  public:
    using PathRecord = std::conditional_t<mode == TransportMode::radiance, Record, LightRecord>;
    static constexpr TransportMode reverse_mode =
        mode == TransportMode::radiance ? TransportMode::importance : TransportMode::radiance;
    static constexpr const SubpathDimensions& dimensions = subpath_dimensions<mode>;

    /// `context` must outlive the walk.
    Walk(const PathContext& context, const WalkOptions& options, PathRecord record);

    /// `samplers` [row] and `counters` must last as long as the walk goes on.
    void begin(std::span<const PixelSampler> samplers, IntegratorCounters& counters);
    void push(std::uint32_t row, const Ray& ray) {
        queue_.push(row, ray);
        ++(is_camera_ray(paths_[row]) ? counters_->camera_rays : counters_->scattering_rays);
    }
    [[nodiscard]] bool going() const { return queue_.count > 0; }
    void advance(display::DisplayServices& display);
    void scatter() { scatter_vertices<false>(0); }

    // Results of the last advance().
    [[nodiscard]] const VertexBatch& vertices() const { return vertices_; }
    /// Indices into vertices(): surfaces that camera rays hit first.
    [[nodiscard]] std::span<const std::uint32_t> first_entries() const { return {first_entries_.data(), first_count_}; }
    [[nodiscard]] std::span<const EscapedRay> escaped() const { return escaped_; }
    [[nodiscard]] std::span<const EmitterHit> emitters() const { return emitters_; }
    /// Arrivals of the last advance(). Empty unless channels take blocked light.
    [[nodiscard]] std::span<const SurfaceArrival> arrivals() const { return arrivals_; }
    /// Light subpaths with an invalid power, since begin().
    [[nodiscard]] std::span<const InvalidPower> invalid_powers() const { return invalid_powers_; }

    /// Number of light subpaths that were cut for their length since begin() (WalkOptions::most_scatterings).
    [[nodiscard]] std::uint64_t cut() const { return cut_; }

    [[nodiscard]] const Subpath& path(std::uint32_t row) const { return paths_[row]; }
    /// The factor of light that the subpath of a row meets: beta, times the weight of its wavelength if it has one. For
    /// light subpaths it is the power.
    [[nodiscard]] Rgb throughput(std::uint32_t row) const { return wavelengths_.throughput(row, paths_[row]); }
    /// The weight of a row's wavelength, for paths of one wavelength.
    [[nodiscard]] const Rgb& wavelength_weight(std::uint32_t row) const { return wavelengths_.weight(row); }
    /// The partial MIS weights at a row's current vertex. Only with options.densities.
    [[nodiscard]] PartialMisWeights& mis_weights(std::uint32_t row) { return mis_weights_[row]; }
    [[nodiscard]] const PartialMisWeights& mis_weights(std::uint32_t row) const { return mis_weights_[row]; }
    /// Distance along the camera ray to the start of a row's current ray, which is behind the cutouts that it passed.
    [[nodiscard]] Real travelled(std::uint32_t row) const { return travelled_.empty() ? 0 : travelled_[row]; }
    /// The shares with which a row's subpath uses its techniques at the vertex that its ray leaves.
    [[nodiscard]] TechniqueShares technique_shares(std::uint32_t row) const {
        return shares_.empty() ? TechniqueShares() : shares_[row];
    }
    [[nodiscard]] const PixelSampler& sampler(std::uint32_t row) const { return samplers_[row]; }
    [[nodiscard]] const PathRecord& record() const { return record_; }
    [[nodiscard]] IntegratorCounters& counters() { return *counters_; }
    /// The medium of a ray that leaves vertex j; -1: none.
    [[nodiscard]] std::int32_t medium_towards(std::size_t j, const Vec3& direction) const {
        const std::int32_t current = paths_[vertices_.rows[j]].medium;
        if (!in_media_ || j >= vertices_.surfaces) return current;
        return scene_.geometry->shapes()[vertices_.hits[j].shape].medium_towards(vertices_.points[j].geometric_normal,
                                                                                 direction, current);
    }
    [[nodiscard]] const DepthLimit& depth_limit() const { return depth_limit_; }
    /// Whether a path is short enough for an event at vertex j in at least one direction.
    [[nodiscard]] bool may_scatter(std::size_t j) const { return may_scatter(j, j < vertices_.surfaces); }
    [[nodiscard]] VertexDepth vertex_depth(std::size_t j) const { return vertex_depth(j, j < vertices_.surfaces); }
    /// The pair of numbers of vertex j that draw_pairs() drew last. Valid until the vertex is left.
    [[nodiscard]] Vec2 pair(std::size_t j) const {
        if (pairs_are_drawn_) return pairs_[j];
        const std::uint32_t row = vertices_.rows[j];
        return samplers_[row].get_2d(dimensions.of(paths_[row].depth, pair_));
    }

  protected:
    /// Draws a pair of numbers for every vertex (`which` of SubpathDimensions), together where that is faster.
    void draw_pairs(std::uint32_t which);
    /// Counts a subpath that has ended.
    void finish(std::uint32_t row) { counters_->count_length(paths_[row].depth); }
    /// `planned`: follows context.plan. `branch`: number of the ray that leaves each vertex (splits.h).
    template <bool planned>
    void scatter_vertices(std::uint32_t branch);

    const PathContext& context_;
    const SceneView scene_;
    const WalkOptions options_;
    PathRecord record_;
    // By row. Of these all but paths_ exist only where they are used (subpath.h).
    std::vector<Subpath> paths_;
    std::vector<PartialMisWeights> mis_weights_;
    std::vector<SplitState> splits_;
    std::vector<TechniqueShares> shares_;
    std::vector<Real> travelled_;
    LaterRadiance* later_ = nullptr;     // of camera subpaths; null: the vertices that they leave are not recorded
    bool directions_plan_rays_ = false;  // DirectionSampler::plans_rays(), for camera subpaths
    std::vector<LightSample> origins_;   // where light subpaths left their lights
    VertexBatch vertices_;

  private:
    struct Collision {
        std::uint32_t row;
        Vec3 position, forward;  // forward: unit, the direction in which the path came
        Real time;
        RayCone cone;
    };
    /// A ray that passed a cutout. The next scatter() pushes `onward`.
    struct CutoutPass {
        std::uint32_t row;
        std::int32_t label, medium;  // medium: behind the cutout
        Real t;
        Ray onward;
    };
    static constexpr Pruned pruned_paths = mode == TransportMode::radiance ? Pruned::paths : Pruned::light_paths;
    /// The last scattering of a light subpath is its connection to the camera.
    static constexpr std::int32_t to_camera = mode == TransportMode::importance ? 1 : 0;
    static bool is_camera_ray(const Subpath& path) { return mode == TransportMode::radiance && path.depth == 0; }
    [[nodiscard]] bool may_scatter(std::size_t j, bool surface) const {
        const std::int32_t length = paths_[vertices_.rows[j]].length;
        return depth_limit_.allows(depth_limit_.has_bodies() ? vertex_depth(j, surface).least : length + whole_event);
    }
    [[nodiscard]] VertexDepth vertex_depth(std::size_t j, bool surface) const {
        const std::int32_t length = paths_[vertices_.rows[j]].length;
        return depth_limit_.has_bodies() ? depth_by_bodies(j, surface) : VertexDepth{length, length + whole_event};
    }
    [[nodiscard]] VertexDepth depth_by_bodies(std::size_t j, bool surface) const;

    // advance()
    void trace(display::DisplayServices& display);
    void arrive(std::uint32_t row, const SurfacePoint& point, Real time);
    [[nodiscard]] double light_sample_ratio(std::uint32_t row, const SurfacePoint& point) const;
    void keep_live_vertices(display::DisplayServices& display);
    bool passes_cutout(std::size_t j, const ShapeGeometry& shape);
    void record_first_hit(display::DisplayServices& display, std::size_t j);
    void meet_emitter(std::size_t j, const ShapeGeometry& shape);
    [[nodiscard]] bool is_live_vertex(std::size_t j);
    [[nodiscard]] bool is_through_portal(std::uint32_t row, const Vec3& point, const Vec3& forward) const;
    void shade();
    void trace_footprints();
    // Media; see walk_media.h.
    bool traverse_medium(std::uint32_t row, const Ray& ray, Real distance, display::DisplayServices& display);
    bool traverse_grid(std::uint32_t row, const Ray& ray, Real distance, display::DisplayServices& display);
    [[nodiscard]] bool may_collide(std::uint32_t row) const;
    [[nodiscard]] bool allows_collision(std::uint32_t row) const;
    bool attenuate(std::uint32_t row, const Rgb& transmittance);
    bool collide(std::uint32_t row, const Ray& ray, const FreeFlight& flight, display::DisplayServices& display);
    void report_emission(std::uint32_t row, const Rgb& emitted) const;
    void append_collisions();
    // scatter(); see walk_scatter.h.
    void pass_cutouts();
    [[nodiscard]] bool draws_direction(std::size_t j);
    template <bool planned>
    bool scatter_vertex(std::size_t j, std::uint32_t branch);
    bool stays_short(std::size_t j, const Vec3& direction);
    [[nodiscard]] bool may_be_scattered(std::size_t j);
    template <bool planned>
    bool survives_roulette(std::size_t j, std::uint32_t dimension);
    [[nodiscard]] Real planned_survival(std::uint32_t row) const;
    [[nodiscard]] std::uint64_t planned_state(std::uint32_t row) const;
    static Real take_branch(Subpath& path, SplitState& split, const BsdfSample& s);
    [[gnu::always_inline]] inline bool goes_on(std::uint32_t row);
    /// `reached`: mean colour of the throughput at the vertex. `factor`: of roulette and splits there. `rays`: expected
    /// number, where path.pdf does not include it.
    void pass_vertex(std::size_t j, const BsdfSample& s, Real reached, Real factor, Real rays);
    void reject(std::uint32_t row);

    const DepthLimit depth_limit_;
    const bool in_media_, has_footprints_;
    bool wants_first_hits_ = false;           // AOVs or patterns read first hits, whatever light they bring
    bool skips_first_closures_ = false;       // AOVs need only the geometry of first hits
    bool light_can_be_hit_ = true;            // else the ray behind the last scattering is not traced
    std::span<const PixelSampler> samplers_;  // by row
    IntegratorCounters* counters_ = nullptr;
    SamplerBatch pairs_;  // [vertex]
    std::uint32_t pair_ = 0;
    bool pairs_are_drawn_ = false;
    PathWavelengths wavelengths_;
    RayQueue queue_;  // rays to the next vertices
    std::vector<std::uint32_t> first_entries_;
    std::vector<std::uint8_t> needs_closure_;  // [vertex]
    std::vector<Collision> collisions_;
    std::size_t first_count_ = 0, collision_count_ = 0;
    std::vector<EscapedRay> escaped_;
    std::vector<EmitterHit> emitters_;
    std::vector<SurfaceArrival> arrivals_;
    std::vector<CutoutPass> passes_;
    std::vector<InvalidPower> invalid_powers_;
    std::uint64_t cut_ = 0;
};

extern template class Walk<TransportMode::radiance>;
extern template class Walk<TransportMode::importance>;

}  // namespace raylex::transport
