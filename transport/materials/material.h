// Materials: registered by name, compiled once per scene, run on batches of hits of one material at a time.
//
// Parameters are pbrt-v4's, by name and default. Every material has "displacement" and "normalmap" (normal_detail.h).
// Materials that pbrt-v4 does not have are called "raylex:..."; they serve analytic scenes and tests, from files and
// from the API alike.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "display/services/registry.h"
#include "display/services/samples/display_services.h"
#include "transport/color/wavelengths.h"
#include "transport/geometry/surface_point.h"
#include "transport/materials/bsdf/bsdf.h"
#include "transport/materials/closures/closure.h"
#include "transport/materials/normal_detail.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/texture.h"

namespace raylex::transport {

/// Positions in a batch of hits.
using HitIndices = std::span<const std::uint32_t>;

struct Medium;

/// A compiled material. One virtual call serves all hits of this material in a batch.
class Material {
  public:
    virtual ~Material() = default;
    /// Fills `closures[i]` from `points[i]` for every i of `hits`. No allocation; texture look-ups only. A material may
    /// write to display channels through `points[i].services`, at every vertex of a camera path.
    virtual void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
                       std::span<Bsdf> closures) const = 0;
    /// Appends the lobes that this material can give: they become part of the scene's alphabet.
    virtual void append_lobes(std::vector<LobeId>& lobes) const = 0;
    /// The material of a hit: this one, or the part that a mix chooses.
    [[nodiscard]] virtual const Material& chosen(const TextureTable&, const SurfacePoint&) const { return *this; }
    /// Whether it is pbrt's "interface", which is no surface.
    [[nodiscard]] virtual bool is_interface() const { return false; }
    /// For a mix with interfaces: a float texture, the share that is surface. -1: no such mix.
    [[nodiscard]] virtual TextureId surface_share() const { return -1; }
    /// The medium that fills shapes of this material; null if the material brings none. A mix returns the medium of its
    /// first part that brings one.
    [[nodiscard]] virtual const Medium* interior() const { return nullptr; }
    /// The bump or normal map. MaterialTable sets it.
    NormalDetail normal_detail;
    /// The interface's index by wavelength; null where it is one number. Closures have the mean index until
    /// Bsdf::set_index().
    std::shared_ptr<const IndexSpectrum> index_spectrum;
};

class MaterialTable;

/// What a material's factory may use.
struct MaterialContext {
    const SceneDescription& scene;
    TextureTable& textures;          ///< the factory resolves texture parameters here, once
    const MaterialTable& materials;  ///< named ones before this one; for one without a name all of them (for mix)
    std::uint32_t salt;              ///< this material's own number, for choices that must not correlate
};

using MaterialFactory = std::function<Result<std::unique_ptr<Material>>(const SceneEntity&, const MaterialContext&)>;

/// pbrt-v4's by their names, and raylex:additive, raylex:mirror, raylex:diffuse-mirror, raylex:sheet; plugins add
/// theirs.
Registry<MaterialFactory>& material_registry();

/// All materials of a scene, in the order of SceneDescription::materials.
class MaterialTable {
  public:
    static Result<MaterialTable> build(const SceneDescription& scene, TextureTable& textures);

    /// Turns hits, in any order, into closures. `points.size() == closures.size()`. `wanted`, if not empty: [point]
    /// whether its closure is used; the others become black.
    void shade(const TextureTable& textures, std::span<const SurfacePoint> points, std::span<Bsdf> closures,
               std::span<const std::uint8_t> wanted = {}) const;
    /// Whether any material turns normals; only then are tangents needed.
    [[nodiscard]] bool turns_normals() const { return turns_normals_; }
    /// Whether any material looks up images over footprints (SurfacePoint::footprint), and whether this one does.
    [[nodiscard]] bool filters_images() const { return filters_images_; }
    [[nodiscard]] bool filters_images(std::int32_t material) const {
        return filtered_[static_cast<std::size_t>(material)] != 0;
    }
    /// The bump or normal map of a hit; empty where there is none. `point` needs its random_key.
    [[nodiscard]] const NormalDetail& normal_detail(const TextureTable& textures, const SurfacePoint& point) const {
        return materials_[static_cast<std::size_t>(point.material)]->chosen(textures, point).normal_detail;
    }
    /// Whether the index of any interface in use depends on the wavelength.
    [[nodiscard]] bool disperses() const { return disperses_; }
    /// The index of the interface at a hit by wavelength; null where it is one number. `point` needs its random_key.
    [[nodiscard]] const IndexSpectrum* index_spectrum(const TextureTable& textures, const SurfacePoint& point) const {
        return materials_[static_cast<std::size_t>(point.material)]->chosen(textures, point).index_spectrum.get();
    }
    [[nodiscard]] const Material* material(std::size_t index) const { return materials_[index].get(); }
    /// Material::surface_share() of every material.
    [[nodiscard]] std::vector<TextureId> surface_shares() const;
    [[nodiscard]] std::size_t size() const { return materials_.size(); }
    /// The last material so far that is called `name`, or an Error at `where` with the near miss.
    [[nodiscard]] Result<const Material*> find(std::string_view name, const SourceLocation& where) const;

  private:
    Status add(std::size_t index, const SceneDescription& scene, TextureTable& textures);

    std::vector<std::unique_ptr<Material>> materials_;
    std::vector<std::string> names_;  ///< of the materials so far that have one
    std::vector<const Material*> named_;
    std::vector<std::uint8_t> filtered_;
    bool turns_normals_ = false, filters_images_ = false, disperses_ = false;
};

}  // namespace raylex::transport
