// Maps a surface point to texture coordinates, as pbrt-v4 does (book, 4th edition, 10.2).
#pragma once

#include <optional>

#include "transport/math/transform.h"
#include "transport/math/vec.h"
#include "transport/textures/parameter_reader.h"
#include "transport/textures/texture.h"

namespace raylex::transport {

/// The sides of a footprint in (s, t).
struct TexelFootprint {
    Vec2 first, second;
};

struct TextureMapping {
    enum class Kind : std::uint8_t { uv, spherical, cylindrical, planar };

    Kind kind = Kind::uv;
    Real scale_u = 1, scale_v = 1, offset_u = 0, offset_v = 0;
    Vec3 axis_u{1, 0, 0}, axis_v{0, 1, 0};  ///< planar
    Transform texture_from_world;           ///< all but uv

    [[nodiscard]] Vec2 map(const TexturePoint& at) const;
    /// The footprint in (s, t) at a point with a footprint.
    [[nodiscard]] TexelFootprint footprint(const TexturePoint& at) const;

  private:
    [[nodiscard]] Vec2 change(const TexturePoint& at, const Vec3& along, const Vec2& along_uv) const;
};

/// Reads one vector3, or returns `fallback` if it is absent; errors are stored in `reader`.
Vec3 read_vector(ParameterReader& reader, std::string_view name, const Vec3& fallback);
/// Returns `parameters` and those that read_mapping() reads, for catalogues.
std::vector<ParameterDescription> with_mapping(std::vector<ParameterDescription> parameters);
/// Reads "mapping", "uscale", "vscale", "udelta", "vdelta", "v1", "v2"; errors are stored in `reader`.
TextureMapping read_mapping(ParameterReader& reader, const Transform& world_from_texture);
/// Replaces an unknown "mapping" by uv, as pbrt-v4 does, and returns a warning if it did. Separate from read_mapping(),
/// which runs for every role of a texture.
std::optional<Error> mend_mapping(ParameterSet& parameters);

}  // namespace raylex::transport
