#include "transport/import/builder/settled_transform.h"

#include <cmath>

namespace raylex::transport {

bool is_affine(const Matrix4& m) {
    return m[3][0] == 0 && m[3][1] == 0 && m[3][2] == 0 && m[3][3] == 1;
}

Status check_finite(const Transform& transform, const SourceLocation& where) {
    for (const auto& row : transform.matrix())
        for (const double value : row)
            if (!std::isfinite(value))
                return error_at(where, "its transformation has an element that is not finite; expected finite numbers");
    return success();
}

Result<Transform> settled(const Transform& transform, const SourceLocation& where) {
    if (Status s = check_finite(transform, where); !s) return s.error();
    if (transform.is_identity()) return Transform();
    Transform result(transform.matrix());
    if (!transform.invertible() || !result.invertible())
        return error_at(where, "its transformation cannot be inverted");
    return result;
}

Result<Transform> settled_camera(const Transform& world_to_camera, const SourceLocation& where) {
    if (Status s = check_finite(world_to_camera, where); !s) return s.error();
    const Matrix4 camera_to_world = world_to_camera.inverse().matrix();
    if (!world_to_camera.invertible() || !is_affine(world_to_camera.matrix()) || !is_affine(camera_to_world))
        return settled(world_to_camera, where);
    Matrix4 linear = world_to_camera.matrix();
    for (std::size_t i = 0; i < 3; ++i) linear[i][3] = 0;
    const Result<Transform> turned = settled(Transform(linear), where);
    if (!turned) return turned.error();
    return *turned * Transform::translate(-camera_to_world[0][3], -camera_to_world[1][3], -camera_to_world[2][3]);
}

}  // namespace raylex::transport
