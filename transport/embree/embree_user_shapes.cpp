// Quadrics and bilinear patches for Embree: Embree finds their boxes, and raylex solves the equations in double.
#include <algorithm>
#include <limits>

#include "transport/embree/embree_device.h"

namespace raylex::transport {
namespace {

RTCBounds outward(const DVec3& lower, const DVec3& upper) {
    const auto down = [](double v) { return next_down(static_cast<float>(v)); };
    const auto up = [](double v) { return next_up(static_cast<float>(v)); };
    RTCBounds b{};
    b.lower_x = down(lower.x);
    b.lower_y = down(lower.y);
    b.lower_z = down(lower.z);
    b.upper_x = up(upper.x);
    b.upper_y = up(upper.y);
    b.upper_z = up(upper.z);
    return b;
}

void bound_user_shape(const RTCBoundsFunctionArguments* args) {
    const ShapeGeometry& shape = *static_cast<const ShapeGeometry*>(args->geometryUserPtr);
    DVec3 lower, upper;
    if (shape.kind == ShapeKind::bilinear_mesh) {
        const BilinearPatch patch = shape.patch(args->primID);
        lower = upper = patch.p00;
        for (const DVec3& p : {patch.p10, patch.p01, patch.p11}) {
            lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
            upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
        }
    } else {
        shape.quadric.bounds(lower, upper);
    }
    *args->bounds_o = outward(lower, upper);
}

template <class Arguments>
bool intersect_shape(const Arguments* args, const RTCRay& ray, double& t, double& u, double& v) {
    const auto& shape = *static_cast<const ShapeGeometry*>(args->geometryUserPtr);
    return shape.intersect(args->primID, {ray.org_x, ray.org_y, ray.org_z}, {ray.dir_x, ray.dir_y, ray.dir_z},
                           {ray.tnear, ray.tfar}, t, u, v);
}

/// Callbacks set `valid` to 0 for a ray that misses: Embree 4 reads it as the result.
void intersect_user(const RTCIntersectFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* rayhit = reinterpret_cast<RTCRayHit*>(args->rayhit);  // N is 1: closest hits are traced one by one
    double t, u, v;
    args->valid[0] = intersect_shape(args, rayhit->ray, t, u, v) ? -1 : 0;
    if (!args->valid[0]) return;
    rayhit->ray.tfar = static_cast<float>(t);
    rayhit->hit.u = static_cast<float>(u);
    rayhit->hit.v = static_cast<float>(v);
    rayhit->hit.primID = args->primID;
    rayhit->hit.geomID = args->geomID;
    rayhit->hit.instID[0] = args->context->instID[0];
}

/// Streams of Embree 3 deliver several shadow rays at a time.
void occlude_user(const RTCOccludedFunctionNArguments* args) {
    for (unsigned i = 0; i < args->N; ++i) {
        if (!args->valid[i]) continue;
        double t, u, v;
        args->valid[i] = intersect_shape(args, rtcGetRayFromRayN(args->ray, args->N, i), t, u, v) ? -1 : 0;
        if (args->valid[i]) RTCRayN_tfar(args->ray, args->N, i) = -infinity;
    }
}

}  // namespace

RTCGeometry new_user_geometry(RTCDevice device, unsigned primitives) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, primitives);
    rtcSetGeometryBoundsFunction(geometry, bound_user_shape, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect_user);
    rtcSetGeometryOccludedFunction(geometry, occlude_user);
    return geometry;
}

}  // namespace raylex::transport
