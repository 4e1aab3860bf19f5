// What a material factory reads once and its shade() looks up at every hit: constants at once, textures by index.
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "transport/materials/bsdf/conductor.h"
#include "transport/materials/bsdf/dielectric.h"
#include "transport/materials/bsdf/facet_albedo.h"
#include "transport/materials/material.h"
#include "transport/textures/parameter_reader.h"

namespace raylex::transport {

inline TexturePoint texture_point(const SurfacePoint& p) {
    return {p.u, p.v, p.position, p.geometric_normal, p.footprint, p.services};
}

inline Rgb clamp_to_unit(const Rgb& c) {
    return {std::clamp(c.r, Real(0), Real(1)), std::clamp(c.g, Real(0), Real(1)), std::clamp(c.b, Real(0), Real(1))};
}

struct RgbInput {
    Rgb value;
    TextureId texture = -1;  ///< -1: `value` everywhere
    bool varies = false;     ///< else the texture, if there is one, is looked up for nothing (Effect::image_textures)

    [[nodiscard]] Rgb at(const TextureTable& textures, const SurfacePoint& p) const {
        return texture < 0 ? value : textures.rgb(texture, texture_point(p));
    }
};

struct RealInput {
    Real value = 0;
    TextureId texture = -1;
    bool varies = false;

    [[nodiscard]] Real at(const TextureTable& textures, const SurfacePoint& p) const {
        return texture < 0 ? value : textures.real(texture, texture_point(p));
    }
};

struct RoughnessInput {
    RealInput u, v;
    bool remap = true;  ///< alpha = sqrt(roughness), as pbrt-v4

    [[nodiscard]] Ggx at(const TextureTable& textures, const SurfacePoint& p) const {
        const Real x = u.at(textures, p), y = v.at(textures, p);
        return remap ? Ggx::from_alpha(Ggx::alpha_from_roughness(x), Ggx::alpha_from_roughness(y))
                     : Ggx::from_alpha(x, y);
    }
    /// Whether the facets can be smooth, or rough, somewhere: what lobes the material must announce.
    [[nodiscard]] bool may_be_smooth() const;
    [[nodiscard]] bool may_be_rough() const;
    /// The facets, where no texture decides.
    [[nodiscard]] std::optional<Ggx> constant() const;
    /// Whether both axes always have one roughness.
    [[nodiscard]] bool isotropic() const { return u.texture == v.texture && u.value == v.value; }
};

/// A metal: from "reflectance", or from eta and k.
struct ConductorInput {
    RoughnessInput roughness;
    RgbInput eta, k, reflectance;
    bool by_reflectance = false;

    /// Seen from inside a medium of index `outside_eta`.
    [[nodiscard]] ConductorClosure at(const TextureTable& textures, const SurfacePoint& p, Real outside_eta) const;
};

/// Whether an interface is index-matched at some wavelength, and ideal there whatever its facets.
inline bool may_be_matched(const IndexSpectrum& index) {
    return index.least() < 1 + DielectricClosure::matched_within &&
           index.most() > 1 - DielectricClosure::matched_within;
}

/// The kinds of lobes that a dielectric interface can have somewhere: what lobes its material must announce.
struct InterfaceLobes {
    bool rough, smooth;
    bool smooth_reflection;  ///< false where an index of exactly 1 leaves nothing to reflect

    /// `index`: null where the index of refraction does not depend on the wavelength.
    InterfaceLobes(const RoughnessInput& roughness, Real eta, const IndexSpectrum* index = nullptr);
};

using MadeMaterial = Result<std::unique_ptr<Material>>;

/// A material whose closure follows from one hit alone: `shade(textures, point, closure)` sets it.
template <class Shade>
class HitMaterial final : public Material {
  public:
    HitMaterial(std::vector<LobeId> lobes, Shade shade) : lobes_(std::move(lobes)), shade_(std::move(shade)) {}
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) shade_(textures, points[i], closures[i]);
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        lobes.insert(lobes.end(), lobes_.begin(), lobes_.end());
    }

  private:
    std::vector<LobeId> lobes_;
    Shade shade_;
};

/// A ParameterReader for materials. Every factory begins with one and ends with material() or error().
class MaterialReader : public ParameterReader {
  public:
    MaterialReader(const SceneEntity& entity, const MaterialContext& context);

    /// A HitMaterial, or the first error of the parameters that were read.
    template <class Shade>
    [[nodiscard]] MadeMaterial material(std::vector<LobeId> lobes, Shade shade,
                                        std::shared_ptr<const IndexSpectrum> index = nullptr) const {
        if (error()) return *error();
        std::unique_ptr<Material> made = std::make_unique<HitMaterial<Shade>>(std::move(lobes), std::move(shade));
        made->index_spectrum = std::move(index);
        return made;
    }

    RgbInput rgb(std::string_view name, const Rgb& fallback, SpectrumRole role = SpectrumRole::albedo);
    RealInput real_texture(std::string_view name, Real fallback);
    /// `prefix` + "roughness", "uroughness", "vroughness", and "remaproughness".
    RoughnessInput roughness(std::string_view prefix, Real fallback);
    /// "eta", "k" and roughness under `prefix`, or "reflectance" instead of both; copper when nothing is given.
    /// `outside`: index of what lies over it.
    ConductorInput conductor(std::string_view prefix, Real outside = 1);
    /// "raylex:compensate": the table that makes up for what facets lose (compensated.h), or nothing when it is not
    /// asked for. `eta` 0: metal.
    std::shared_ptr<const FacetAlbedo> compensation(const RoughnessInput& roughness, Real eta);
    /// A real index of refraction: a number, or a spectrum, of which the mean over the RGB channels counts.
    Real index_of_refraction(std::string_view name, Real fallback);
    /// The same parameter after it, where it is a spectrum that varies: Material::index_spectrum. Null: one number.
    std::shared_ptr<const IndexSpectrum> index_spectrum(std::string_view name);

  private:
    /// Of eta or k of a metal, which is copper where nothing is said.
    RgbInput metal_parameter(std::string_view name, std::string_view fallback);
    /// The same as a spectrum; nothing where it is a texture or three numbers.
    std::optional<VisibleSpectrum> metal_spectrum(std::string_view name, std::string_view fallback,
                                                  const RgbInput& read);
    /// A constant is read once, unless the code of textures is forced on.
    [[nodiscard]] TextureId looked_up(TextureId constant) const;

    const SceneEntity& entity_;
    const MaterialContext& context_;
};

/// Isotropic facets need no particular tangent.
inline Frame shading_frame(const SurfacePoint& p, const Ggx& facets) {
    return facets.alpha_x == facets.alpha_y ? Frame::from_normal(p.shading_normal)
                                            : Frame::from_normal_and_tangent(p.shading_normal, p.dpdu);
}

/// How the catalogue of materials describes it.
inline constexpr const char* compensation_help =
    "give back the light that facets scatter more than once (Turquin 2019)";

// The in-tree factories, one file per family.
void register_plain_materials(Registry<MaterialFactory>& registry);
void register_layered_materials(Registry<MaterialFactory>& registry);
void register_hair_materials(Registry<MaterialFactory>& registry);
void register_subsurface_materials(Registry<MaterialFactory>& registry);
void register_measured_materials(Registry<MaterialFactory>& registry);
void register_composite_materials(Registry<MaterialFactory>& registry);
void register_raylex_materials(Registry<MaterialFactory>& registry);

}  // namespace raylex::transport
