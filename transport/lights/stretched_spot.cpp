#include "transport/lights/stretched_spot.h"

#include <cmath>

#include "transport/lights/light.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

StretchedSpot::StretchedSpot(const DVec3& axis, Real versine_full, Real versine_zero, const Placement& placement)
    : axis_(axis.to_real()), versine_full_(versine_full), versine_zero_(versine_zero), placement_(placement) {}

Vec3 StretchedSpot::to_light(const Vec3& direction) const {
    return normalize(placement_.to_object.vector(DVec3(direction))).to_real();
}

/// The solid angle in the light's space over that in the world; see solid_angle_ratio().
Real StretchedSpot::per_steradian(const Vec3& local) const {
    return uniform_cone_pdf(versine_zero_) * static_cast<Real>(solid_angle_ratio(placement_.to_world, DVec3(local)));
}

Real StretchedSpot::falloff(const Vec3& direction) const {
    return spot_falloff(axis_, versine_full_, versine_zero_, to_light(direction));
}

bool StretchedSpot::sample(const Vec2& u, Vec3& direction, Real& falloff, Real& pdf) const {
    if (!(versine_zero_ > 0)) return false;
    const Vec3 local = normalize(Frame::from_normal(axis_).to_world(sample_uniform_cone(u, versine_zero_)));
    direction = normalize(placement_.to_world.vector(DVec3(local))).to_real();
    falloff = spot_falloff(axis_, versine_full_, versine_zero_, local);
    pdf = per_steradian(local);
    return falloff > 0;
}

Real StretchedSpot::pdf(const Vec3& direction) const {
    const Vec3 local = to_light(direction);
    return versine_between(axis_, local) < versine_zero_ ? per_steradian(local) : Real(0);
}

}  // namespace raylex::transport
