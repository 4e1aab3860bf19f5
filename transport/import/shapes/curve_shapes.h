// Curves: from parameters to cubic Bezier segments.
#pragma once

#include "transport/import/shapes/shapes.h"

namespace raylex::transport {

/// Makes one curve, as a group of one; SceneBuilder joins curves that differ only in their points (join_curves()).
Result<std::vector<SceneShape>> make_curve(const ParameterSet& parameters, const ShapeContext& context,
                                           std::vector<Error>& warnings);

/// Appends the curves of `next` to `group` if both share type, transform, material, alpha, media, label and all else
/// that a hit can distinguish; returns false otherwise. `same_material` is true if their materials are equal.
bool join_curves(SceneShape& group, const SceneShape& next, bool same_material);

}  // namespace raylex::transport
