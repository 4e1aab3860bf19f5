// Transforms as a SceneDescription keeps them: a scene written to a file and read again has the same bits.
#pragma once

#include "display/services/parameters.h"
#include "lpe/result.h"
#include "transport/math/transform.h"

namespace raylex::transport {

/// Errors: a matrix with something that is no number, or infinite.
Status check_finite(const Transform& transform, const SourceLocation& where);
/// Whether the last row is 0 0 0 1.
bool is_affine(const Matrix4& matrix);

/// As its matrix says: the inverse follows from it and from nothing else. Errors: there is none.
Result<Transform> settled(const Transform& transform, const SourceLocation& where);

/// The same for cameras, whose place is exact however far away it is: a linear map after a translation.
Result<Transform> settled_camera(const Transform& world_to_camera, const SourceLocation& where);

}  // namespace raylex::transport
