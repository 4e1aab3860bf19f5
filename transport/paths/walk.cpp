#include "transport/paths/walk.h"

#include <limits>

#include "transport/media/medium.h"
#include "transport/paths/walk_media.h"
#include "transport/paths/walk_scatter.h"

namespace raylex::transport {

template <TransportMode mode>
Walk<mode>::Walk(const PathContext& context, const WalkOptions& options, PathRecord record)
    : context_(context),
      scene_(context.scene),
      options_(options),
      record_(std::move(record)),
      paths_(static_cast<std::size_t>(context.batch_capacity)),
      depth_limit_(*scene_.media, options.max_depth),
      in_media_(scene_.asks_for_media()),
      has_footprints_(mode == TransportMode::radiance && scene_.materials->filters_images()),
      pairs_(paths_.size()),
      wavelengths_(scene_, paths_.size()) {
    const std::size_t capacity = paths_.size();
    if (options.densities) mis_weights_.resize(capacity);
    queue_.reserve(capacity);
    vertices_.reserve(capacity);
    if (has_footprints_) vertices_.footprints.resize(capacity);
    first_entries_.resize(capacity);
    needs_closure_.resize(capacity);
    if (in_media_) collisions_.resize(capacity);
    if constexpr (mode == TransportMode::radiance) {
        namespace in = geoaovs::inputs;
        const geoaovs::Inputs inputs = context.first_hits.aovs->inputs();
        wants_first_hits_ = inputs != 0 || context.first_hits.pattern_channels;
        // With beauty all first hits are shaded for their light, and no test of each is needed.
        skips_first_closures_ = wants_first_hits_ && !context.beauty && !context.first_hits.pattern_channels &&
                                (inputs & (in::albedo | in::outside_ior)) == 0;
        light_can_be_hit_ = scene_.lights->any_to_hit() || scene_.media->any_emits();
    }
}

template <TransportMode mode>
void Walk<mode>::begin(std::span<const PixelSampler> samplers, IntegratorCounters& counters) {
    samplers_ = samplers;
    counters_ = &counters;
    queue_.count = 0;
    passes_.clear();
    invalid_powers_.clear();
    cut_ = 0;
    if (wavelengths_.any()) wavelengths_.draw(samplers);
}

template <TransportMode mode>
void Walk<mode>::advance(display::DisplayServices& display) {
    trace(display);
    keep_live_vertices(display);
    shade();
    if (in_media_) append_collisions();
    if (context_.directions != nullptr) context_.directions->locate({vertices_.points.data(), vertices_.count});
}

/// Closest hits become vertices, without closures.
template <TransportMode mode>
void Walk<mode>::trace(display::DisplayServices& display) {
    const EmbreeScene& geometry = *scene_.geometry;
    VertexBatch& v = vertices_;
    const std::size_t count = queue_.count;
    queue_.count = 0;
    collision_count_ = 0;
    escaped_.clear();
    emitters_.clear();
    arrivals_.clear();
    geometry.intersect({queue_.rays.data(), count}, {v.hits.data(), count});
    v.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t row = queue_.rows[i];
        const Ray& ray = queue_.rays[i];
        if (in_media_ && paths_[row].medium >= 0 && !traverse_medium(row, ray, v.hits[i].t, display)) continue;
        if (!v.hits[i].valid()) {
            if (mode == TransportMode::radiance && paths_[row].depth >= options_.first_depth)
                escaped_.push_back({row, ray.direction});
            finish(row);
            continue;
        }
        v.rows[v.count] = row;
        v.rays[v.count] = ray;
        v.hits[v.count] = v.hits[i];
        ++v.count;
    }
    geometry.surfaces({v.rays.data(), v.count}, {v.hits.data(), v.count}, {v.points.data(), v.count},
                      {v.sources.data(), v.count});
}

/// Densities of the vertex (Georgiev 2012, equations 31 to 33). Densities of sampled distances in media are left out: a
/// path of given vertices has the same in every strategy, except for the transmittance of the segment that is
/// connected.
template <TransportMode mode>
void Walk<mode>::arrive(std::uint32_t row, const SurfacePoint& point, Real time) {
    if (!options_.densities) return;
    const Subpath& path = paths_[row];
    PartialMisWeights& mis_weights = mis_weights_[row];
    const bool from_infinity = mode == TransportMode::importance && path.depth == 0 && origins_[row].infinite;
    const double near = from_infinity ? 1 : 1 / static_cast<double>(length_squared(point.position - path.from));
    const double pdf = path.specular ? 1 : static_cast<double>(path.pdf);
    mis_weights.arrive(pdf * static_cast<double>(point.cosine(point.wo)) * near, near);
    if (path.depth > 0) return;
    if constexpr (mode == TransportMode::radiance)
        mis_weights.forward = context_.view.density(context_.view.camera->importance(point.position, path.from, time),
                                                    point.cosine(point.wo));
    else mis_weights.connects = light_sample_ratio(row, point);
}

/// The strategy that connects at the light has the density of a light sample and not of an emission: the square of
/// their ratio.
template <TransportMode mode>
double Walk<mode>::light_sample_ratio(std::uint32_t row, const SurfacePoint& point) const {
    const LightSample& origin = origins_[row];
    const LightTable& lights = *scene_.lights;
    const auto sampled =
        static_cast<double>(lights.density(*options_.sampled, *scene_.geometry, point.position, origin));
    const bool area = lights.lights()[origin.light].is_area();
    return PartialMisWeights::squared(sampled * (area ? mis_weights_[row].to_previous : 1) /
                                      mis_weights_[row].previous);
}

/// Alpha test and liveness: the vertices that stay need a closure.
template <TransportMode mode>
void Walk<mode>::keep_live_vertices(display::DisplayServices& display) {
    VertexBatch& v = vertices_;
    const bool cutouts = scene_.tests_alpha();
    const std::span<const ShapeGeometry> shapes = scene_.geometry->shapes();
    std::size_t kept = 0;
    first_count_ = 0;
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        const Subpath& path = paths_[row];
        SurfacePoint& point = v.points[j];
        const ShapeGeometry& shape = shapes[v.hits[j].shape];
        arrive(row, point, v.hits[j].time);
        // Strategies that come there from the light find another point. They skip it, and have no weight here.
        if (mode == TransportMode::radiance && options_.densities && shape.faces_rays)
            mis_weights_[row].forward = std::numeric_limits<double>::infinity();
        if (cutouts && shape.alpha >= 0 && passes_cutout(j, shape)) continue;
        bool live = true;
        if constexpr (mode == TransportMode::radiance) {
            if (path.depth == 0) record_first_hit(display, j);
            meet_emitter(j, shape);
            if (record_.wants_blocked_light()) arrivals_.push_back({row, v.rays[j].direction, throughput(row)});
            const bool first_hit = wants_first_hits_ && path.depth == 0;
            if (!first_hit || skips_first_closures_) live = is_live_vertex(j);
            if (!live && !first_hit) {
                finish(row);
                continue;
            }
            if (!live) counters_->count(Pruned::closures);
            point.services = {&display, static_cast<std::int32_t>(row), path.depth};
        } else if (!is_through_portal(row, point.position, v.rays[j].direction) ||
                   (options_.densities && shape.faces_rays) || !is_live_vertex(j)) {
            finish(row);
            continue;
        }
        needs_closure_[kept] = live ? 1 : 0;
        point.random_key = samplers_[row].key(dimensions.of(path.depth, dimensions.key));
        if (is_camera_ray(path)) first_entries_[first_count_++] = static_cast<std::uint32_t>(kept);
        v.keep(j, kept++);
    }
    v.surfaces = v.count = kept;
}

/// Alpha test: closest hit first, then one counter-based choice. In expectation this is alpha blending, as in pbrt.
template <TransportMode mode>
bool Walk<mode>::passes_cutout(std::size_t j, const ShapeGeometry& shape) {
    const std::uint32_t row = vertices_.rows[j];
    const SurfacePoint& point = vertices_.points[j];
    if (shape.interface) meet_emitter(j, shape);  // no ray stops at an interface
    const Real u = samplers_[row].get_random(dimensions.cutouts + paths_[row].segment);
    if (u < scene_.opacity(shape, point)) return false;
    const Vec3& direction = vertices_.rays[j].direction;
    CutoutPass pass{.row = row,
                    .label = vertices_.sources[j].label,
                    .medium = paths_[row].medium,
                    .t = vertices_.hits[j].t,
                    .onward = ray_from(vertices_, j, direction)};
    // What a cutout takes away of a surface is no border between media either.
    if (in_media_ && shape.border) pass.medium = shape.medium_towards(point.geometric_normal, direction, pass.medium);
    pass.onward.origin = straight_ray_origin(vertices_.rays[j], pass.t, point.position, point.geometric_normal,
                                             vertices_.sources[j].offset.here);
    passes_.push_back(pass);
    return true;
}

/// Distance, opacity and surface of a camera ray.
template <TransportMode mode>
void Walk<mode>::record_first_hit(display::DisplayServices& display, std::size_t j) {
    const EmbreeScene& geometry = *scene_.geometry;
    const VertexBatch& v = vertices_;
    const auto row = static_cast<int>(v.rows[j]);
    display.write_distance(row, to_float(travelled(v.rows[j]) + v.hits[j].t));
    const bool holdout = geometry.has_holdouts() && geometry.is_holdout(v.hits[j]);
    display.write_opacity(row, holdout ? 0.0f : 1.0f);
    display.write_surface(row, geometry.surface_number(v.hits[j]));
    if constexpr (mode == TransportMode::radiance)
        if (holdout) record_.hold_out(v.rows[j]);
}

template <TransportMode mode>
void Walk<mode>::meet_emitter(std::size_t j, const ShapeGeometry& shape) {
    const VertexBatch& v = vertices_;
    const std::uint32_t row = v.rows[j];
    if (mode == TransportMode::importance || shape.first_light == Hit::none || paths_[row].depth < options_.first_depth)
        return;
    const std::uint32_t light = shape.first_light + v.hits[j].primitive;
    const Rgb emitted = scene_.lights->emitted(light, v.points[j], v.points[j].wo);
    if (!emitted.is_black()) emitters_.push_back({row, light, emitted, throughput(row), v.points[j], v.hits[j]});
}

/// For surfaces. Counts a path that ends because no channel takes anything that it may still meet.
template <TransportMode mode>
bool Walk<mode>::is_live_vertex(std::size_t j) {
    const std::uint32_t row = vertices_.rows[j];
    if constexpr (mode == TransportMode::radiance) {
        if (record_.events().wants_user() && record_.channels_follow(row)) return true;
        if (!may_scatter(j, true)) return false;
    }
    if (record_.is_live(row, vertices_.sources[j].label, vertices_.points[j].material)) return true;
    counters_->count(pruned_paths);
    return false;
}

/// Whether a light subpath that began in the sky behind a portal has come through the portal. Before that its light
/// does not exist.
template <TransportMode mode>
bool Walk<mode>::is_through_portal(std::uint32_t row, const Vec3& point, const Vec3& forward) const {
    const Subpath& path = paths_[row];
    return mode == TransportMode::radiance || path.depth > 0 ||
           scene_.lights->lights()[origins_[row].light].kind != LightKind::portal_environment ||
           !scene_.lights->environment_radiance(origins_[row].light, point, -forward).is_black();
}

/// Ray differentials at the vertices, where images are filtered.
template <TransportMode mode>
void Walk<mode>::trace_footprints() {
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
void Walk<mode>::shade() {
    VertexBatch& v = vertices_;
    const std::size_t count = v.surfaces;
    if (has_footprints_) trace_footprints();
    if (scene_.materials->turns_normals()) apply_bump(scene_, {v.hits.data(), count}, v.points);
    if (count > 0)
        scene_.materials->shade(*scene_.textures, {v.points.data(), count}, {v.bsdfs.data(), count},
                                {needs_closure_.data(), skips_first_closures_ ? count : 0});
    if (options_.regularize)
        for (std::size_t j = 0; j < count; ++j)
            if (paths_[v.rows[j]].any_non_specular) v.bsdfs[j].regularize();
    if (wavelengths_.any()) wavelengths_.meet(v, paths_);
}

template <TransportMode mode>
[[gnu::noinline]] VertexDepth Walk<mode>::depth_by_bodies(std::size_t j, bool surface) const {
    const Subpath& path = paths_[vertices_.rows[j]];
    if (!surface) return depth_limit_.at_collision(path.length, path.medium);
    return depth_limit_.at_surface(path.length, scene_.geometry->shapes()[vertices_.hits[j].shape],
                                   vertices_.points[j]);
}

template class Walk<TransportMode::radiance>;
template class Walk<TransportMode::importance>;
template void Walk<TransportMode::radiance>::scatter_vertices<true>(std::uint32_t);
template void Walk<TransportMode::radiance>::scatter_vertices<false>(std::uint32_t);
template void Walk<TransportMode::importance>::scatter_vertices<false>(std::uint32_t);

}  // namespace raylex::transport
