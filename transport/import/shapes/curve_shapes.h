// Curves: from parameters to cubic Bezier segments.
#pragma once

#include "transport/import/shapes/shapes.h"

namespace raylex::transport {

/// One curve, as a group of one; SceneBuilder puts those together that share all but their points (join_curves()).
Result<std::vector<SceneShape>> make_curve(const ParameterSet& parameters, const ShapeContext& context,
                                           std::vector<Error>& warnings);

/// Adds the curves of `next` to `group` where they share type, transform, material, alpha, media, label and what else a
/// hit can tell; false where they do not. `same_material` says whether their materials are one.
bool join_curves(SceneShape& group, const SceneShape& next, bool same_material);

}  // namespace raylex::transport
