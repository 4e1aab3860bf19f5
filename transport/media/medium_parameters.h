// Reads the parameters that media of all types share.
#pragma once

#include "transport/math/matrix34.h"
#include "transport/media/medium.h"

namespace raylex::transport {

/// Coefficients at density 1, per unit of world length.
struct MediumCoefficients {
    Rgb sigma_a{1}, sigma_s{1};
};
/// Reads "sigma_a" and "sigma_s", or a measured "preset", times "scale". As in pbrt, a preset overrides coefficients
/// beside it, which stay unused and add a warning. With an unknown preset the coefficients are used, with a warning.
Result<MediumCoefficients> read_coefficients(const SceneEntity& entity, const MediumContext& context);
/// The coefficients of the measured medium `name`, or an Error that lists the names.
Result<MediumCoefficients> measured_coefficients(const std::string& name, const SourceLocation& where);
/// Reads "g", above -1 and below 1. Other values are set to pbrt-v4's bounds, with a warning.
Result<Real> read_asymmetry(const SceneEntity& entity, const MediumContext& context);
/// Checks that scaled coefficients are at least 0 and finite. Errors name the parameter `name`.
Status check_coefficients(const Rgb& value, const char* name, const SceneEntity& entity);
/// Reads a parameter as one point3.
Result<DVec3> point_or(const ParameterSet& set, const char* name, const DVec3& fallback);

}  // namespace raylex::transport
