#include "transport/materials/normal_detail.h"

#include <algorithm>
#include <cmath>

#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

constexpr Real step_without_beam = Real(0.0005);

/// How far to move in a texture coordinate that now is `at` and changes by `slope` a unit of length on the surface.
Real height_step(Real beam_width, Real slope, Real at) {
    const Real wanted = beam_width > 0 ? beam_width * slope * Real(0.125) : step_without_beam;
    const Real least = std::max(Real(0x1p-14), Real(0x1p-18) * std::abs(at));
    return std::isfinite(wanted) ? std::max(wanted, least) : std::max(step_without_beam, least);
}

void turn(const Vec3& normal, const Vec3& dpdu, SurfacePoint& point) {
    const Real l2 = length_squared(normal);
    if (!(l2 > 0) || !std::isfinite(l2) || !is_finite(dpdu)) return;
    point.shading_normal = face_forward(normal / std::sqrt(l2), point.geometric_normal);
    point.dpdu = dpdu;
}

}  // namespace

const std::vector<ParameterDescription>& normal_detail_parameters() {
    static const std::vector<ParameterDescription> list{
        {"displacement", ParameterType::texture, "", "heights, by which normals are turned (bump mapping)"},
        {"normalmap", ParameterType::string, "", "image of tangent-space normals"}};
    return list;
}

Result<NormalDetail> NormalDetail::read(const SceneEntity& material, TextureTable& textures) {
    NormalDetail detail;
    const ParameterSet& set = material.parameters;
    if (set.find("displacement") != nullptr) {
        const auto id = textures.real_parameter(set, "displacement", 0);
        if (!id) return id.error();
        if (!textures.is_constant(*id)) detail.displacement_ = *id;
    }
    const Parameter* map = set.find("normalmap");
    if (map == nullptr) return detail;
    const SourceLocation& where = map->location.line != 0 ? map->location : set.location;
    const auto file = set.string_or("normalmap", "");
    if (!file) return file.error();
    const auto id = textures.normal_map(*file, where);
    if (!id) return id.error();
    detail.normal_map_ = *id;
    detail.displacement_ = -1;  // the map alone turns normals, as in pbrt
    return detail;
}

void NormalDetail::apply(const TextureTable& textures, const SurfaceTangents& tangents, Real beam_width,
                         SurfacePoint& point) const {
    if (displacement_ >= 0) apply_displacement(textures, tangents, beam_width, point);
    else if (normal_map_ >= 0) apply_normal_map(textures, tangents, point);
}

void NormalDetail::apply_displacement(const TextureTable& textures, const SurfaceTangents& tangents, Real beam_width,
                                      SurfacePoint& point) const {
    const Vec3& n = point.shading_normal;
    const TexturePoint here = texture_point(point);
    const Real area = length(cross(tangents.dpdu, tangents.dpdv));
    const Real height = textures.real(displacement_, here);
    const auto slope = [&](Real TexturePoint::*coordinate, const Vec3& along, const Vec3& across) {
        TexturePoint there = here;
        there.services = {};  // values are written at the hit alone
        there.*coordinate += height_step(beam_width, length(across) / area, here.*coordinate);
        const Real step = there.*coordinate - here.*coordinate;  // as it was rounded
        there.position += along * step;
        return (textures.real(displacement_, there) - height) / step;
    };
    const Vec3 dpdu =
        tangents.dpdu + n * slope(&TexturePoint::u, tangents.dpdu, tangents.dpdv) + tangents.dndu * height;
    const Vec3 dpdv =
        tangents.dpdv + n * slope(&TexturePoint::v, tangents.dpdv, tangents.dpdu) + tangents.dndv * height;
    // Tangents are normalised first: the cross product of small ones would vanish in float.
    turn(cross(normalize(dpdu), normalize(dpdv)), dpdu, point);
}

void NormalDetail::apply_normal_map(const TextureTable& textures, const SurfaceTangents& tangents,
                                    SurfacePoint& point) const {
    const Rgb texel = textures.rgb(normal_map_, texture_point(point));
    const Vec3 local{2 * texel.r - 1, 2 * texel.g - 1, 2 * texel.b - 1};
    const Real l = length(local);
    if (!(l > Real(0x1p-10))) return;  // texels cancelled: what is left is rounding
    const Frame frame = Frame::from_normal_and_tangent(point.shading_normal, tangents.dpdu);
    const Vec3 n = frame.to_world(local / l);
    turn(n, tangents.dpdu - n * dot(n, tangents.dpdu), point);
}

}  // namespace raylex::transport
