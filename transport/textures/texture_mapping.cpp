#include "transport/textures/texture_mapping.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "display/services/elementary.h"
#include "transport/geometry/ray.h"

namespace raylex::transport {

namespace {

/// The names in the order of TextureMapping::Kind.
const std::vector<std::string>& mapping_names() {
    static const std::vector<std::string> names{"uv", "spherical", "cylindrical", "planar"};
    return names;
}

}  // namespace

Vec2 TextureMapping::map(const TexturePoint& at) const {
    if (kind == Kind::uv) return {scale_u * at.u + offset_u, scale_v * at.v + offset_v};
    const Vec3 p = texture_from_world.point(at.position);
    if (kind == Kind::planar) return {offset_u + dot(p, axis_u), offset_v + dot(p, axis_v)};
    if (kind == Kind::cylindrical) return {(pi + elementary::atan2(p.y, p.x)) * (0.5f * inv_pi), p.z};
    const Real l = length(p), phi = elementary::atan2(p.y, p.x);
    const Real theta = l > 0 ? elementary::acos(std::clamp(p.z / l, Real(-1), Real(1))) : 0.0f;
    return {theta * inv_pi, (phi < 0 ? phi + 2 * pi : phi) * (0.5f * inv_pi)};
}

/// The derivatives of map() along a vector of the world.
Vec2 TextureMapping::change(const TexturePoint& at, const Vec3& along, const Vec2& along_uv) const {
    if (kind == Kind::uv) return {scale_u * along_uv.x, scale_v * along_uv.y};
    const Vec3 d = texture_from_world.vector(along);
    if (kind == Kind::planar) return {dot(d, axis_u), dot(d, axis_v)};
    const Vec3 p = texture_from_world.point(at.position);
    const Real across = p.x * p.x + p.y * p.y;
    const Real turn = across > 0 ? (p.x * d.y - p.y * d.x) / across * (0.5f * inv_pi) : infinity;
    if (kind == Kind::cylindrical) return {turn, d.z};
    const Real radius2 = across + p.z * p.z;
    const Real tilt = (p.z * (p.x * d.x + p.y * d.y) - across * d.z) / (radius2 * std::sqrt(across));
    return {across > 0 ? tilt * inv_pi : infinity, turn};
}

TexelFootprint TextureMapping::footprint(const TexturePoint& at) const {
    const SurfaceFootprint& seen = *at.footprint;
    return {change(at, seen.first, seen.first_uv), change(at, seen.second, seen.second_uv)};
}

Vec3 read_vector(ParameterReader& reader, std::string_view name, const Vec3& fallback) {
    const Parameter* parameter = reader.set().find(name);
    if (parameter == nullptr) return fallback;
    if (parameter->type != ParameterType::vector3 || parameter->numbers.size() != 3) {
        reader.fail(error_at(reader.where(*parameter), "parameter '" + std::string(name) + "' must be one vector3"));
        return fallback;
    }
    const auto& n = parameter->numbers;
    return {static_cast<Real>(n[0]), static_cast<Real>(n[1]), static_cast<Real>(n[2])};
}

std::vector<ParameterDescription> with_mapping(std::vector<ParameterDescription> parameters) {
    using enum ParameterType;
    parameters.insert(parameters.end(), {{"mapping", string, "uv", "uv, spherical, cylindrical or planar"},
                                         {"uscale", real, "1", "factor on u, for uv"},
                                         {"vscale", real, "1", "factor on v, for uv"},
                                         {"udelta", real, "0", "added to u, for uv and planar"},
                                         {"vdelta", real, "0", "added to v, for uv and planar"},
                                         {"v1", vector3, "1 0 0", "direction of u, for planar"},
                                         {"v2", vector3, "0 1 0", "direction of v, for planar"}});
    return parameters;
}

std::optional<Error> mend_mapping(ParameterSet& parameters) {
    const std::vector<std::string>& known = mapping_names();
    for (Parameter& p : parameters.parameters) {
        if (p.name != "mapping" || p.type != ParameterType::string || p.strings.size() != 1) continue;
        std::string& name = p.strings.front();
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        Error warning = error_at(p.location.line != 0 ? p.location : parameters.location,
                                 "parameter 'mapping' is '" + name +
                                     "'; expected uv, spherical, cylindrical or planar. It is read as uv, as in "
                                     "pbrt-v4",
                                 near_miss(name, known));
        name = known.front();
        return warning;
    }
    return std::nullopt;
}

TextureMapping read_mapping(ParameterReader& reader, const Transform& world_from_texture) {
    TextureMapping mapping;
    mapping.kind = static_cast<TextureMapping::Kind>(reader.choice("mapping", mapping_names(), 0));
    mapping.texture_from_world = world_from_texture.inverse();
    if (mapping.kind == TextureMapping::Kind::uv) {
        mapping.scale_u = reader.real("uscale", 1);
        mapping.scale_v = reader.real("vscale", 1);
    }
    if (mapping.kind == TextureMapping::Kind::planar) {
        mapping.axis_u = read_vector(reader, "v1", mapping.axis_u);
        mapping.axis_v = read_vector(reader, "v2", mapping.axis_v);
    }
    if (mapping.kind == TextureMapping::Kind::uv || mapping.kind == TextureMapping::Kind::planar) {
        mapping.offset_u = reader.real("udelta", 0);
        mapping.offset_v = reader.real("vdelta", 0);
    }
    return mapping;
}

}  // namespace raylex::transport
