// Normalises transforms for a SceneDescription, so that a scene that is written to a file and read again has the same
// bits.
#pragma once

#include "display/services/parameters.h"
#include "lpe/result.h"
#include "transport/math/transform.h"

namespace raylex::transport {

/// Reports an error if the matrix contains NaN or infinity.
Status check_finite(const Transform& transform, const SourceLocation& where);
/// Whether the last row is 0 0 0 1.
bool is_affine(const Matrix4& matrix);

/// Recomputes the transform from its matrix alone, so that the inverse follows from the matrix. Error: it has no
/// inverse.
Result<Transform> settled(const Transform& transform, const SourceLocation& where);

/// Recomputes a camera transform as a linear map after a translation, which keeps the camera's place exact at any
/// distance.
Result<Transform> settled_camera(const Transform& world_to_camera, const SourceLocation& where);

}  // namespace raylex::transport
