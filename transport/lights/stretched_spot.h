// A spot light under a transform that does not keep angles: its cone is round in the light's own space, as in pbrt-v4
// (SpotLight::I takes a direction in the light's space), and an ellipse across its axis in the world.
#pragma once

#include "transport/math/matrix34.h"
#include "transport/math/vec.h"

namespace raylex::transport {

class StretchedSpot {
  public:
    /// `axis` is a unit vector in the light's space; the versines are those of Light in that space.
    StretchedSpot(const DVec3& axis, Real versine_full, Real versine_zero, const Placement& placement);

    /// The share of the axis intensity that is emitted in `direction`, a unit vector in the world.
    [[nodiscard]] Real falloff(const Vec3& direction) const;
    /// Draws a direction in the world in which light is emitted, uniform in the light's own cone, and its density per
    /// steradian. Returns false if the cone has no width or no light is emitted in the direction.
    bool sample(const Vec2& u, Vec3& direction, Real& falloff, Real& pdf) const;
    [[nodiscard]] Real pdf(const Vec3& direction) const;

  private:
    [[nodiscard]] Vec3 to_light(const Vec3& direction) const;
    [[nodiscard]] Real per_steradian(const Vec3& local) const;

    Vec3 axis_;
    Real versine_full_, versine_zero_;
    Placement placement_;
};

}  // namespace raylex::transport
