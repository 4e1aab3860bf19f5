// How a walk (walk.cpp, which alone includes this) goes through media: sampled distances, and vertices at collisions.
#pragma once

#include "transport/media/medium.h"
#include "transport/paths/walk.h"

namespace raylex::transport {

/// Follows a ray of a subpath, which hits a surface or nothing at `distance`, through its medium. Returns false if the
/// subpath ends or collides before.
template <TransportMode mode>
bool Walk<mode>::traverse_medium(std::uint32_t row, const Ray& ray, Real distance, display::DisplayServices& display) {
    const Subpath& path = paths_[row];
    const Medium& medium = (*scene_.media)[path.medium];
    if (medium.grid != nullptr) return traverse_grid(row, ray, distance, display);
    if (mode == TransportMode::radiance && medium.emits) report_emission(row, emission_along(medium, distance));
    const Vec2 u = samplers_[row].get_2d(dimensions.flights + path.segment);
    if (medium.scatters && may_collide(row))
        return collide(row, ray, sample_free_flight(medium, path.beta, distance, u), display);
    const Rgb passed = transmittance(medium, distance);
    if (is_camera_ray(path) && passed.average() < 1)
        display.add_sample(static_cast<int>(row), {to_float(travelled(row) + sample_absorption(medium, distance, u)),
                                                   RgbD(Rgb(1) - passed), true});
    return attenuate(row, passed);
}

/// Follows a ray through a grid. It is a separate function, so that homogeneous media pay one test for grids.
template <TransportMode mode>
[[gnu::noinline]] bool Walk<mode>::traverse_grid(std::uint32_t row, const Ray& ray, Real distance,
                                                 display::DisplayServices& display) {
    const Subpath& path = paths_[row];
    const Medium& medium = (*scene_.media)[path.medium];
    const MediumSegment segment{ray.origin, ray.direction, distance};
    const std::uint32_t key = samplers_[row].key(dimensions.null_collisions + path.segment);
    if (mode == TransportMode::radiance && medium.emits)
        report_emission(row, medium.grid->emission(segment, FlightNumbers(key, 1)));
    if (medium.scatters && may_collide(row)) {
        const Vec2 u = samplers_[row].get_2d(dimensions.flights + path.segment);
        return collide(row, ray, medium.grid->sample_free_flight(segment, path.beta, u, FlightNumbers(key)), display);
    }
    if (!is_camera_ray(path)) return attenuate(row, medium.grid->transmittance(segment, FlightNumbers(key)));
    // Deep images need the distance at which light is lost, which the closed form does not give: another estimate.
    Real lost_at = 0;
    const Rgb passed = medium.grid->transmittance(segment, FlightNumbers(key, 2), lost_at);
    if (passed.average() < 1)
        display.add_sample(static_cast<int>(row), {to_float(travelled(row) + lost_at), RgbD(Rgb(1) - passed), true});
    return attenuate(row, medium.grid->transmittance(segment, FlightNumbers(key)));
}

/// Whether a channel takes light that the medium scatters along this ray. If not, the medium only attenuates light.
template <TransportMode mode>
bool Walk<mode>::may_collide(std::uint32_t row) const {
    const Subpath& path = paths_[row];
    if constexpr (mode == TransportMode::radiance) {
        if (path.depth == 0) return true;  // depth and opacity of a camera ray are always found
        if (!allows_collision(row)) return false;
    }
    return record_.is_live_in_medium(row, path.medium);
}

template <TransportMode mode>
bool Walk<mode>::allows_collision(std::uint32_t row) const {
    return depth_limit_.allows(depth_limit_.at_collision(paths_[row].length, paths_[row].medium).least);
}

/// Returns false if the path ends because no light is left.
template <TransportMode mode>
bool Walk<mode>::attenuate(std::uint32_t row, const Rgb& transmittance) {
    Subpath& path = paths_[row];
    path.beta *= transmittance;
    if (is_camera_ray(path) || !path.beta.is_black()) return true;  // AOVs read the hit of a camera ray all the same
    finish(row);
    return false;
}

/// Returns false if the subpath ends or collides.
template <TransportMode mode>
bool Walk<mode>::collide(std::uint32_t row, const Ray& ray, const FreeFlight& flight,
                         display::DisplayServices& display) {
    Subpath& path = paths_[row];
    path.beta *= flight.weight;
    if (!flight.collided) return true;
    if (is_camera_ray(path)) {
        display.write_distance(static_cast<int>(row), to_float(travelled(row) + flight.distance), true);
        display.write_opacity(static_cast<int>(row), raylex::Rgb(1));
    }
    const Vec3 position = ray.origin + ray.direction * flight.distance;
    if (!is_through_portal(row, position, ray.direction) || !allows_collision(row) || path.beta.is_black()) finish(row);
    else
        collisions_[collision_count_++] = {.row = row,
                                           .position = position,
                                           .forward = ray.direction,
                                           .time = ray.time,
                                           .cone = ray.cone.after(flight.distance)};
    return false;
}

/// `emitted`: the radiance that the medium sends back along the ray of a camera subpath. No other strategy finds it.
template <TransportMode mode>
void Walk<mode>::report_emission(std::uint32_t row, const Rgb& emitted) const {
    const Subpath& path = paths_[row];
    if (path.depth < options_.first_depth) return;
    const Rgb value = throughput(row) * emitted;
    if constexpr (mode == TransportMode::radiance)
        record_.arrive(row, record_.events().emission(), {0, path.depth + 2},
                       {.value = value, .emitted = emitted, .unweighted = value});
}

template <TransportMode mode>
void Walk<mode>::append_collisions() {
    VertexBatch& v = vertices_;
    for (std::size_t k = 0; k < collision_count_; ++k) {
        const Collision& collision = collisions_[k];
        const std::int32_t medium = paths_[collision.row].medium;
        const std::size_t j = v.count++;
        v.rows[j] = collision.row;
        SurfacePoint& point = v.points[j];
        point = SurfacePoint();
        point.position = collision.position;
        point.wo = -collision.forward;
        point.material = SurfacePoint::no_material;
        v.sources[j] = {{}, record_.events().medium_label(medium), 0};
        v.hits[j].time = collision.time;
        v.hits[j].cone = collision.cone;
        v.bsdfs[j].set_phase((*scene_.media)[medium].g);
        arrive(collision.row, point, collision.time);
    }
}

}  // namespace raylex::transport
