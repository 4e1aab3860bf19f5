// What media of all types read from their parameters.
#pragma once

#include "transport/math/matrix34.h"
#include "transport/media/medium.h"

namespace raylex::transport {

/// Coefficients where the density is 1, per unit of world length.
struct MediumCoefficients {
    Rgb sigma_a{1}, sigma_s{1};
};
/// "sigma_a" and "sigma_s", or a measured "preset", times "scale". As in pbrt a preset goes before coefficients that
/// stand beside it; these stay unread and get a warning. For one that nobody measured they count, with a warning, too.
Result<MediumCoefficients> read_coefficients(const SceneEntity& entity, const MediumContext& context);
/// The coefficients measured under that name, or an Error that says what there is.
Result<MediumCoefficients> measured_coefficients(const std::string& name, const SourceLocation& where);
/// "g", above -1 and below 1; from there on pbrt-v4's bounds, with a warning.
Result<Real> read_asymmetry(const SceneEntity& entity, const MediumContext& context);
/// Numbers from 0 up, and finite: what is left of `name` when it has been scaled.
Status check_coefficients(const Rgb& value, const char* name, const SceneEntity& entity);
/// The parameter as one point3.
Result<DVec3> point_or(const ParameterSet& set, const char* name, const DVec3& fallback);

}  // namespace raylex::transport
