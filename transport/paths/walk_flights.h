// How a walk (walk.h, which includes this) goes through media: flights, and the vertices where they end.
#pragma once

#include "transport/paths/walk.h"

namespace raylex::transport {

/// A flight towards a hit or miss at `distance`. False if the subpath ends or collides before.
template <TransportMode mode>
template <class Visitor>
bool Walk<mode>::crosses_medium(std::uint32_t row, const Ray& ray, Real distance, Visitor& visitor) {
    Subpath& path = paths_[row];
    const Medium& medium = (*scene_.media)[path.medium];
    if (medium.grid != nullptr) return crosses_grid(row, ray, distance, visitor);
    if (mode == TransportMode::radiance && medium.emits) visitor.volume_emits(row, emission_along(medium, distance));
    const Vec2 u = samplers_[row].get_2d(dimensions.flights + path.segment);
    if (!medium.scatters || !visitor.worth_colliding(row)) {
        const Rgb passed = transmittance(medium, distance);
        visitor.absorbs(row, distance, passed, u);
        return lets_pass(row, passed);
    }
    return flies(row, ray, sample_free_flight(medium, path.beta, distance, u), visitor);
}

/// The same through a grid. Apart, so that homogeneous media pay one test for it.
template <TransportMode mode>
template <class Visitor>
[[gnu::noinline]] bool Walk<mode>::crosses_grid(std::uint32_t row, const Ray& ray, Real distance, Visitor& visitor) {
    const Subpath& path = paths_[row];
    const Medium& medium = (*scene_.media)[path.medium];
    const MediumSegment segment{ray.origin, ray.direction, distance};
    const std::uint32_t key = samplers_[row].key(dimensions.null_collisions + path.segment);
    if (mode == TransportMode::radiance && medium.emits)
        visitor.volume_emits(row, medium.grid->emission(segment, FlightNumbers(key, 1)));
    if (medium.scatters && visitor.worth_colliding(row)) {
        const Vec2 u = samplers_[row].get_2d(dimensions.flights + path.segment);
        return flies(row, ray, medium.grid->sample_free_flight(segment, path.beta, u, FlightNumbers(key)), visitor);
    }
    if (!is_camera_ray(path)) return lets_pass(row, medium.grid->transmittance(segment, FlightNumbers(key)));
    // Deep images want to know where light is lost, which what is known in closed form does not say: another estimate.
    Real lost_at = 0;
    const Rgb passed = medium.grid->transmittance(segment, FlightNumbers(key, 2), lost_at);
    visitor.absorbs_at(row, lost_at, passed);
    return lets_pass(row, medium.grid->transmittance(segment, FlightNumbers(key)));
}

/// What a medium has left of the path, which is not black. False: it ends.
template <TransportMode mode>
bool Walk<mode>::lets_pass(std::uint32_t row, const Rgb& passed) {
    Subpath& path = paths_[row];
    path.beta *= passed;
    if (is_camera_ray(path) || !path.beta.is_black()) return true;  // what a camera ray hits is asked for all the same
    finish(row);
    return false;
}

template <TransportMode mode>
template <class Visitor>
bool Walk<mode>::flies(std::uint32_t row, const Ray& ray, const FreeFlight& flight, Visitor& visitor) {
    Subpath& path = paths_[row];
    path.beta *= flight.weight;
    if (!flight.collided) return true;
    const bool goes_on = visitor.collides(row, flight.distance, ray);
    if (!goes_on || !may_collide(row) || path.beta.is_black()) finish(row);
    else
        collisions_[collision_count_++] = {row, ray.origin + ray.direction * flight.distance, ray.direction, ray.time,
                                           ray.cone.after(flight.distance)};
    return false;
}

template <TransportMode mode>
template <class Visitor>
void Walk<mode>::append_collisions(Visitor& visitor) {
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
        v.sources[j] = {{}, events_.medium_label(medium), 0};
        v.hits[j].time = collision.time;
        v.hits[j].cone = collision.cone;
        v.bsdfs[j].set_phase((*scene_.media)[medium].g);
        arrive(collision.row, point, collision.time, visitor);
    }
}

}  // namespace raylex::transport
