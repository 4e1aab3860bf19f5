// Parameters of materials: read once by a factory, then constants or texture look-ups at every hit.
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
    bool varies = false;     ///< false with a texture: the look-up of a constant, forced by Effect::image_textures

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
    /// Whether the facets can be smooth, or rough, somewhere.
    [[nodiscard]] bool may_be_smooth() const;
    [[nodiscard]] bool may_be_rough() const;
    /// The facets, unless a texture varies them.
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

/// Whether an interface is index-matched, and so ideal whatever its facets, at some wavelength.
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
    /// The table for "raylex:compensate" (compensated.h), or null where that is not true. `eta` is 0 for metal.
    std::shared_ptr<const FacetAlbedo> compensation(const RoughnessInput& roughness, Real eta);
    /// A real index of refraction: a number, or the mean of a spectrum over the RGB channels.
    Real index_of_refraction(std::string_view name, Real fallback);
    /// Material::index_spectrum from the parameter that index_of_refraction() has read; null where it is one number.
    std::shared_ptr<const IndexSpectrum> index_spectrum(std::string_view name);

  private:
    /// eta or k of a metal; copper's when the scene gives none.
    RgbInput metal_parameter(std::string_view name, std::string_view fallback);
    /// The spectrum of eta or k of a metal; nothing where it is a texture or three numbers.
    std::optional<VisibleSpectrum> metal_spectrum(std::string_view name, std::string_view fallback,
                                                  const RgbInput& read);
    /// -1, so that a constant is not looked up again, unless Effect::image_textures forces look-ups.
    [[nodiscard]] TextureId looked_up(TextureId constant) const;

    const SceneEntity& entity_;
    const MaterialContext& context_;
};

/// Isotropic facets need no particular tangent.
inline Frame shading_frame(const SurfacePoint& p, const Ggx& facets) {
    return facets.alpha_x == facets.alpha_y ? Frame::from_normal(p.shading_normal)
                                            : Frame::from_normal_and_tangent(p.shading_normal, p.dpdu);
}

/// The help text of "raylex:compensate".
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
