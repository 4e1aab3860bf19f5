// The walk: subpaths of one direction, one a row, side by side, from vertex to vertex.
//
//     walk.begin(samplers, counters);
//     walk.push(row, ray);                     // for every subpath, after filling in path(row)
//     while (walk.going()) {
//         walk.advance(display, visitor);      // vertices() are the next of all subpaths that go on
//         ...                                  // what an integrator does with them
//         walk.scatter(visitor);
//     }
//
// advance: rays -> free flight through media -> hits -> cutouts pass straight on -> arrivals -> closures. scatter:
// closures or phase functions -> throughput -> roulette -> rays. Every stage is one loop over plain arrays; what a
// scene does not have (media, cutouts) costs a test a batch, what nobody asks for (densities) one a vertex.
#pragma once

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "transport/math/make_at.h"
#include "transport/media/medium.h"
#include "transport/paths/counters.h"
#include "transport/paths/event_table.h"
#include "transport/paths/footprints.h"
#include "transport/paths/path_depth.h"
#include "transport/paths/path_wavelengths.h"
#include "transport/paths/scattering.h"
#include "transport/paths/splits.h"
#include "transport/paths/strategies.h"
#include "transport/paths/subpath.h"
#include "transport/paths/vertex.h"
#include "transport/paths/walk_visitor.h"
#include "transport/samplers/sampler_batch.h"

namespace raylex::transport {

struct WalkOptions {
    std::uint32_t max_depth = 5;  ///< scattering events of a whole path; of a light subpath its connection's among them
    Real roulette_below = default_roulette_below;  ///< 0: paths do not end at random
    bool densities = false;                        ///< keep sums()
    bool regularize = false;                       ///< closures are, behind a scattering that is not specular
    /// False: of a camera subpath specular events do not count before any other, as long as they alone stay below
    /// `max_depth`.
    bool counts_first_specular = true;
};

template <TransportMode mode>
class Walk {
  public:
    static constexpr const SubpathDimensions& dimensions = subpath_dimensions<mode>;

    Walk(const SceneView& scene, const EventTable& events, const WalkOptions& options, std::size_t capacity)
        : scene_(scene),
          events_(events),
          options_(options),
          depth_limit_(*scene.media, options.max_depth),
          in_media_(scene.asks_for_media()),
          has_footprints_(mode == TransportMode::radiance && scene.materials->filters_images()),
          paths_(capacity),
          pairs_(capacity),
          wavelengths_(scene, capacity) {
        if (options.densities) sums_.resize(capacity);
        queue_.reserve(capacity);
        vertices_.reserve(capacity);
        if (has_footprints_) vertices_.footprints.resize(capacity);
        first_entries_.resize(capacity);
        needs_closure_.resize(capacity);
        if (in_media_) collisions_.resize(capacity);
    }

    /// Both must last as long as the walk goes on.
    void begin(std::span<const PixelSampler> samplers, IntegratorCounters& counters) {
        samplers_ = samplers;
        counters_ = &counters;
        queue_.count = 0;
        if (wavelengths_.any()) wavelengths_.draw(samplers);
    }
    void push(std::uint32_t row, const Ray& ray) {
        queue_.push(row, ray);
        ++(is_camera_ray(paths_[row]) ? counters_->camera_rays : counters_->scattering_rays);
    }
    [[nodiscard]] bool going() const { return queue_.count > 0; }
    /// Draws a pair of numbers for every vertex (`which` of SubpathDimensions), together where that is faster.
    void draw_pairs(std::uint32_t which);
    /// Of vertex j, as drawn last: until the vertex is left.
    [[nodiscard]] Vec2 pair(std::size_t j) const {
        if (pairs_are_drawn_) return pairs_[j];
        const std::uint32_t row = vertices_.rows[j];
        return samplers_[row].get_2d(dimensions.of(paths_[row].depth, pair_));
    }
    template <class Visitor>
    void advance(display::DisplayServices& display, Visitor& visitor);
    template <class Visitor>
    void scatter(Visitor& visitor);

    [[nodiscard]] const VertexBatch& vertices() const { return vertices_; }
    /// The closure of vertex j, to be narrowed down.
    [[nodiscard]] Bsdf& closure(std::size_t j) { return vertices_.bsdfs[j]; }
    /// Puts other vertices in the place of the current ones, whose subpaths go on from there.
    void exchange_vertices(VertexBatch& other) { std::swap(vertices_, other); }
    /// Entries of vertices() that are the first of their subpaths, surfaces only.
    [[nodiscard]] std::span<const std::uint32_t> first_entries() const { return {first_entries_.data(), first_count_}; }
    [[nodiscard]] Subpath& path(std::uint32_t row) { return paths_[row]; }
    [[nodiscard]] const Subpath& path(std::uint32_t row) const { return paths_[row]; }
    /// By what light counts that meets the subpath of a row: beta, and the weight of its wavelength if it is of one.
    [[nodiscard]] Rgb throughput(std::uint32_t row) const { return wavelengths_.throughput(row, paths_[row]); }
    [[nodiscard]] const PathWavelengths& wavelengths() const { return wavelengths_; }
    /// At the current vertex; options.densities only.
    [[nodiscard]] StrategySums& sums(std::uint32_t row) { return sums_[row]; }
    [[nodiscard]] const StrategySums& sums(std::uint32_t row) const { return sums_[row]; }
    [[nodiscard]] const PixelSampler& sampler(std::uint32_t row) const { return samplers_[row]; }
    [[nodiscard]] const WalkOptions& options() const { return options_; }
    [[nodiscard]] IntegratorCounters& counters() { return *counters_; }
    /// The medium that a ray leaving vertex j flies through.
    [[nodiscard]] std::int32_t medium_towards(std::size_t j, const Vec3& direction) const {
        const std::int32_t current = paths_[vertices_.rows[j]].medium;
        if (!in_media_ || j >= vertices_.surfaces) return current;
        return scene_.geometry->shapes()[vertices_.hits[j].shape].medium_towards(vertices_.points[j].geometric_normal,
                                                                                 direction, current);
    }
    [[nodiscard]] const DepthLimit& depth_limit() const { return depth_limit_; }
    /// Whether a path is short enough for an event at vertex j, in some direction at least.
    [[nodiscard]] bool may_scatter(std::size_t j) const { return may_scatter(j, j < vertices_.surfaces); }
    /// The same while vertices are still gathered: of a surface, or a collision of the ray that a row's path left.
    [[nodiscard]] bool may_scatter(std::size_t j, bool surface) const {
        const std::int32_t length = paths_[vertices_.rows[j]].length;
        return depth_limit_.allows(depth_limit_.has_bodies() ? vertex_depth(j, surface).least : length + whole_event);
    }
    [[nodiscard]] bool may_collide(std::uint32_t row) const {
        return depth_limit_.allows(depth_limit_.at_collision(paths_[row].length, paths_[row].medium).least);
    }
    [[nodiscard]] VertexDepth vertex_depth(std::size_t j) const { return vertex_depth(j, j < vertices_.surfaces); }
    void finish(std::uint32_t row) { counters_->count_length(paths_[row].depth); }

  private:
    struct Collision {
        std::uint32_t row;
        Vec3 position, forward;  // forward: unit, the way the path came along
        Real time;
        RayCone cone;
    };
    [[nodiscard]] VertexDepth vertex_depth(std::size_t j, bool surface) const {
        const std::int32_t length = paths_[vertices_.rows[j]].length;
        return depth_limit_.has_bodies() ? depth_by_bodies(j, surface) : VertexDepth{length, length + whole_event};
    }
    /// Apart, so that scenes without bodies pay nothing for it.
    [[nodiscard, gnu::noinline]] VertexDepth depth_by_bodies(std::size_t j, bool surface) const {
        const Subpath& path = paths_[vertices_.rows[j]];
        if (!surface) return depth_limit_.at_collision(path.length, path.medium);
        return depth_limit_.at_surface(path.length, scene_.geometry->shapes()[vertices_.hits[j].shape],
                                       vertices_.points[j]);
    }
    bool stays_short(std::size_t j, const Vec3& direction);
    static bool is_camera_ray(const Subpath& path) { return mode == TransportMode::radiance && path.depth == 0; }
    template <class Visitor>
    void trace(Visitor& visitor);
    template <class Visitor>
    bool crosses_medium(std::uint32_t row, const Ray& ray, Real distance, Visitor& visitor);
    template <class Visitor>
    bool crosses_grid(std::uint32_t row, const Ray& ray, Real distance, Visitor& visitor);
    bool lets_pass(std::uint32_t row, const Rgb& passed);
    template <class Visitor>
    bool flies(std::uint32_t row, const Ray& ray, const FreeFlight& flight, Visitor& visitor);
    template <class Visitor>
    void arrive(std::uint32_t row, const SurfacePoint& point, Real time, Visitor& visitor);
    template <class Visitor>
    void append_collisions(Visitor& visitor);
    bool fails_alpha_test(std::size_t j) const;
    void lay_footprints();
    template <class Visitor>
    bool survives_roulette(std::uint32_t row, std::uint32_t dimension, const Visitor& visitor);
    static std::uint32_t take_branch(Subpath& path, const BsdfSample& s);

    const SceneView scene_;
    const EventTable& events_;
    const WalkOptions options_;
    const DepthLimit depth_limit_;
    const bool in_media_, has_footprints_;
    std::span<const PixelSampler> samplers_;  // by row
    IntegratorCounters* counters_ = nullptr;
    std::vector<Subpath> paths_;  // by row
    SamplerBatch pairs_;          // [vertex]
    std::uint32_t pair_ = 0;
    bool pairs_are_drawn_ = false;
    PathWavelengths wavelengths_;
    std::vector<StrategySums> sums_;  // by row
    RayQueue queue_;                  // of the next vertices
    VertexBatch vertices_;
    std::vector<std::uint32_t> first_entries_;
    std::vector<std::uint8_t> needs_closure_;  // [vertex]
    std::vector<Collision> collisions_;
    std::size_t first_count_ = 0, collision_count_ = 0;
};

/// Bump and normal maps. What stands in points from here on is what everyone sees: closures, lights, AOVs. The points
/// need their random_key.
inline void turn_normals(const SceneView& scene, std::span<const Hit> hits, std::span<SurfacePoint> points) {
    for (std::size_t j = 0; j < hits.size(); ++j) {
        const NormalDetail& detail = scene.materials->normal_detail(*scene.textures, points[j]);
        if (detail.empty()) continue;
        detail.apply(*scene.textures, scene.geometry->tangents(hits[j], points[j]), hits[j].cone.width, points[j]);
    }
}

/// Closest hits become vertices, all but their closures.
template <TransportMode mode>
template <class Visitor>
void Walk<mode>::trace(Visitor& visitor) {
    const EmbreeScene& geometry = *scene_.geometry;
    VertexBatch& v = vertices_;
    const std::size_t count = queue_.count;
    queue_.count = 0;
    collision_count_ = 0;
    geometry.intersect({queue_.rays.data(), count}, {v.hits.data(), count});
    v.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t row = queue_.rows[i];
        if (in_media_ && paths_[row].medium >= 0 && !crosses_medium(row, queue_.rays[i], v.hits[i].t, visitor))
            continue;
        if (!v.hits[i].valid()) {
            visitor.escapes(row, queue_.rays[i]);
            finish(row);
            continue;
        }
        v.rows[v.count] = row;
        v.rays[v.count] = queue_.rays[i];
        v.hits[v.count] = v.hits[i];
        ++v.count;
    }
    geometry.surfaces({v.rays.data(), v.count}, {v.hits.data(), v.count}, {v.points.data(), v.count},
                      {v.sources.data(), v.count});
}

/// The densities of a vertex follow from the one that its subpath left. Those of free flights are left out: a path of
/// given vertices has them in every strategy, but for the transmittance along the segment that is joined
/// (strategies.h).
template <TransportMode mode>
template <class Visitor>
void Walk<mode>::arrive(std::uint32_t row, const SurfacePoint& point, Real time, Visitor& visitor) {
    if (!options_.densities) return;
    const Subpath& path = paths_[row];
    const double near = path.from_infinity ? 1 : 1 / static_cast<double>(length_squared(point.position - path.from));
    const double pdf = path.specular ? 1 : static_cast<double>(path.pdf);
    sums_[row].arrive(pdf * static_cast<double>(point.cosine(point.wo)) * near,
                      path.from_infinity ? 1 : static_cast<double>(path.cosine) * near);
    if (path.depth == 0) visitor.first_vertex(row, point, time, sums_[row]);
}

/// Closest hit first, then one counter-based choice: in expectation what alpha blending gives, and what pbrt does.
template <TransportMode mode>
bool Walk<mode>::fails_alpha_test(std::size_t j) const {
    const std::uint32_t row = vertices_.rows[j];
    const SurfacePoint& point = vertices_.points[j];
    const ShapeGeometry& shape = scene_.geometry->shapes()[vertices_.hits[j].shape];
    const Real u = samplers_[row].get_random(dimensions.cutouts + paths_[row].segment);
    return !(u < scene_.opacity(shape, point));
}

/// What images are filtered over, where there are any.
template <TransportMode mode>
void Walk<mode>::lay_footprints() {
    for (std::size_t j = 0; j < vertices_.surfaces; ++j) {
        SurfacePoint& point = vertices_.points[j];
        point.footprint = nullptr;
        if (!scene_.materials->filters_images(point.material)) continue;
        const Hit& hit = vertices_.hits[j];
        vertices_.footprints[j] = footprint_of(scene_.geometry->tangents(hit, point), point, hit.cone.width);
        point.footprint = &vertices_.footprints[j];
    }
}

template <TransportMode mode>
template <class Visitor>
void Walk<mode>::advance([[maybe_unused]] display::DisplayServices& display, Visitor& visitor) {
    trace(visitor);
    VertexBatch& v = vertices_;
    const bool cutouts = scene_.tests_alpha(), skips_closures = visitor.may_skip_closures();
    const std::span<const ShapeGeometry> shapes = scene_.geometry->shapes();
    std::size_t kept = 0;
    first_count_ = 0;
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        Subpath& path = paths_[row];
        SurfacePoint& point = v.points[j];
        arrive(row, point, v.hits[j].time, visitor);
        // Strategies that come there from the light would find another point: they leave it alone (LightSubpaths), and
        // count for nothing here.
        if (options_.densities && mode == TransportMode::radiance && shapes[v.hits[j].shape].faces_rays)
            sums_[row].forward = std::numeric_limits<double>::infinity();
        if (cutouts && shapes[v.hits[j].shape].alpha >= 0) {
            const ShapeGeometry& shape = shapes[v.hits[j].shape];
            if (shape.interface && shape.first_light != Hit::none) visitor.interface_emits(j);
            if (fails_alpha_test(j)) {
                visitor.passes_cutout(j);
                // What a cutout takes away of a surface is no border between media either.
                const Vec3& direction = v.rays[j].direction;
                if (in_media_ && shape.border)
                    path.medium = shape.medium_towards(point.geometric_normal, direction, path.medium);
                ++path.segment;
                Ray onward = ray_from(v, j, direction);
                onward.origin = straight_ray_origin(v.rays[j], v.hits[j].t, point.position, point.geometric_normal,
                                                    v.sources[j].offset.here);
                push(row, onward);
                continue;
            }
        }
        if (!visitor.arrives(j)) {
            finish(row);
            continue;
        }
        if (skips_closures) needs_closure_[kept] = visitor.needs_closure(j) ? 1 : 0;
        point.random_key = samplers_[row].key(dimensions.of(path.depth, dimensions.key));
        if constexpr (mode == TransportMode::radiance)
            point.services = {&display, static_cast<std::int32_t>(row), path.depth};
        if (is_camera_ray(path)) first_entries_[first_count_++] = static_cast<std::uint32_t>(kept);
        v.keep(j, kept++);
    }
    v.surfaces = v.count = kept;
    if (has_footprints_) lay_footprints();
    if (scene_.materials->turns_normals()) turn_normals(scene_, {v.hits.data(), v.surfaces}, v.points);
    if (kept > 0)
        scene_.materials->shade(*scene_.textures, {v.points.data(), kept}, {v.bsdfs.data(), kept},
                                {needs_closure_.data(), skips_closures ? kept : 0});
    if (options_.regularize)
        for (std::size_t j = 0; j < kept; ++j)
            if (paths_[v.rows[j]].any_non_specular) v.bsdfs[j].regularize();
    if (wavelengths_.any()) wavelengths_.meet(v, paths_);
    if (in_media_) append_collisions(visitor);
}

template <TransportMode mode>
template <class Visitor>
bool Walk<mode>::survives_roulette(std::uint32_t row, std::uint32_t dimension,
                                   [[maybe_unused]] const Visitor& visitor) {
    Subpath& path = paths_[row];
    Real keep = 1, chance = 0;
    if constexpr (Visitor::expects) chance = visitor.chance(row);
    if (chance > 0) {
        keep = chance;
    } else if (path.depth >= 2) {
        const Real throughput = mode == TransportMode::radiance ? path.beta.max() * path.roulette_scale
                                                                : path.beta.max() / path.roulette_scale;
        if (throughput < options_.roulette_below) keep = throughput / options_.roulette_below;
    }
    if (!path.specular) {  // a specular direction no other technique finds
        keep *= path.ray_share;
        path.pdf *= path.ray_share;
    }
    if (!(keep < 1)) return true;
    if (samplers_[row].get_random(dimension) >= keep) {
        if (!path.specular && path.ray_share < 1) counters_->count(Pruned::rays_left_to_light_samples);
        else if (chance > 0) counters_->count(Pruned::weak_paths);
        return false;
    }
    path.beta *= 1 / keep;
    return true;
}

/// What a branch carries on; roulette is to take it for as strong as the path was. Returns how many there are that
/// may find the same.
template <TransportMode mode>
std::uint32_t Walk<mode>::take_branch(Subpath& path, const BsdfSample& s) {
    const std::uint32_t rays = path.rays;
    if (path.all_lobes) {  // none is left out, so none counts for others
        path.beta *= s.pdf;
        path.roulette_scale /= s.pdf;
    } else if (rays > 1) {
        path.beta *= 1 / static_cast<Real>(rays);
        path.roulette_scale *= static_cast<Real>(rays);
    }
    path.rays = 1;
    path.all_lobes = false;
    return rays;
}

/// Takes off what does not count of the event at vertex j, which the path has left. False: it is too long for it.
template <TransportMode mode>
[[gnu::noinline]] bool Walk<mode>::stays_short(std::size_t j, const Vec3& direction) {
    Subpath& path = paths_[vertices_.rows[j]];
    const bool first_specular = mode == TransportMode::radiance && !options_.counts_first_specular &&
                                !path.any_non_specular && path.depth < options_.max_depth;
    const std::int32_t event = first_specular ? 0 : depth_limit_.event(vertex_depth(j), vertices_.points[j], direction);
    path.length -= whole_event - event;
    return depth_limit_.allows(path.length);
}

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
template <class Visitor>
void Walk<mode>::scatter(Visitor& visitor) {
    const VertexBatch& v = vertices_;
    draw_pairs(dimensions.scatter);
    const std::size_t passed_on = queue_.count;  // through cutouts: counted already
    // A path's last scattering may be its connection to the camera, and a light subpath's always is; where it may be
    // less than an event, it is counted when it comes.
    constexpr std::int32_t to_camera = mode == TransportMode::importance ? 1 : 0;
    const std::int32_t next = whole_event * (to_camera + 1);
    const bool counts_whole = !depth_limit_.has_bodies() && options_.counts_first_specular;
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        Subpath& path = paths_[row];
        const bool short_enough = depth_limit_.has_bodies() ? may_scatter(j) && depth_limit_.allows_walk(path.depth)
                                                            : depth_limit_.allows(path.length + next);
        if (!short_enough || !visitor.worth_scattering(j)) {
            counters_->count_length(path.depth + static_cast<std::uint32_t>(to_camera));
            continue;
        }
        if constexpr (Visitor::splits)
            if (path.rays == 0) {
                finish(row);
                continue;
            }
        const PixelSampler& sampler = samplers_[row];
        const Bsdf& bsdf = v.bsdfs[j];
        const SurfacePoint& point = v.points[j];
        const std::uint32_t depth = path.depth;
        Real u_lobe = bsdf.chooses_lobes() ? sampler.get_1d(dimensions.of(depth, dimensions.lobe)) : 0.0f;
        if constexpr (Visitor::splits)
            if (path.all_lobes) u_lobe = lobe_number(visitor.branch);
        BsdfSample s = sample_scattering<mode>(bsdf, point, u_lobe, pair(j));
        if (wavelengths_.any()) wavelengths_.leave<mode>(v, j, path, s);
        if (!(s.pdf > 0) || s.weight.is_black()) {
            finish(row);
            continue;
        }
        path.beta *= s.weight;
        std::uint32_t rays = 1;
        if constexpr (Visitor::splits) rays = take_branch(path, s);
        leave_vertex<mode>(path, point, s);
        if (!counts_whole && !stays_short(j, s.wi)) {
            finish(row);
            continue;
        }
        visitor.scatters(j, s.lobes);
        if (!is_finite(path.beta)) {
            visitor.invalid(row);
            finish(row);
            continue;
        }
        if (path.beta.is_black() || !survives_roulette(row, dimensions.of(depth, dimensions.roulette), visitor) ||
            !visitor.goes_on(row)) {
            finish(row);
            continue;
        }
        if (rays > 1 && !path.specular) path.pdf *= static_cast<Real>(rays);
        if (options_.densities) {
            sums_[row].leave(s.delta, s.delta ? 1.0 : static_cast<double>(bsdf.pdf(s.wi, point.wo)));
            path.cosine = point.cosine(s.wi);
        }
        if (in_media_) path.medium = medium_towards(j, s.wi);
        Ray& onward = queue_.next(row);
        make_at(onward, [&] { return ray_from(v, j, s.wi); });
        if (has_footprints_) onward.cone = scattered_cone(*scene_.geometry, v.hits[j], point, s);
    }
    counters_->scattering_rays += queue_.count - passed_on;
}

}  // namespace raylex::transport

#include "transport/paths/walk_flights.h"
