// Bump and normal maps: they turn the shading frame of a hit before its material makes a closure.
//
// Any material takes "displacement" (a float texture: heights along the shading normal, by which only normals are
// turned; Blinn 1978, "Simulation of Wrinkled Surfaces") or "normalmap" (an image of tangent-space normals). As in
// pbrt-v4 the height wins where both are given, a mix has none of its own, and the turned normal is put on the
// geometric normal's side (book, 4th edition, 10.5.3).
#pragma once

#include "transport/geometry/surface_point.h"
#include "transport/textures/texture.h"

namespace raylex::transport {

class NormalDetail {
  public:
    /// Reads a material's parameters. The result is empty without a map and with a constant displacement.
    static Result<NormalDetail> read(const SceneEntity& material, TextureTable& textures);

    [[nodiscard]] bool empty() const { return displacement_ < 0 && normal_map_ < 0; }
    /// Turns `point`'s shading normal and dpdu. `beam_width`: of the ray at the hit, in world units; 0: not known.
    /// A slope comes from two heights that are a step apart in u or v. The step is an eighth of the beam, as in pbrt-v4
    /// at 64 samples a pixel and more, but at least 2^-14 and 2^-18 of the coordinate. Without a beam it is 0.0005.
    /// Where no frame can be made (infinite slopes, texels that cancel), the point stays as it is.
    void apply(const TextureTable& textures, const SurfaceTangents& tangents, Real beam_width,
               SurfacePoint& point) const;

  private:
    void apply_displacement(const TextureTable& textures, const SurfaceTangents& tangents, Real beam_width,
                            SurfacePoint& point) const;
    void apply_normal_map(const TextureTable& textures, const SurfaceTangents& tangents, SurfacePoint& point) const;

    TextureId displacement_ = -1, normal_map_ = -1;
};

/// Whether a material of this type has a surface of its own to turn: all but mix and interface.
inline bool takes_normal_detail(std::string_view type) {
    return type != "mix" && type != "interface" && !type.empty();
}
/// "displacement" and "normalmap".
const std::vector<ParameterDescription>& normal_detail_parameters();

}  // namespace raylex::transport
