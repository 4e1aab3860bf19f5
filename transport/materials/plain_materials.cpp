// diffuse, diffusetransmission, conductor, dielectric, thindielectric, interface: one closure each.
#include <limits>

#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

using Built = Result<std::unique_ptr<Material>>;

class DiffuseMaterial final : public Material {
  public:
    explicit DiffuseMaterial(const RgbInput& reflectance) : reflectance_(reflectance) {
        if (reflectance_.texture < 0) reflectance_.value = clamp_to_unit(reflectance_.value);
    }
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        if (reflectance_.texture < 0) {
            for (const std::uint32_t i : hits)
                closures[i].set(Frame::from_normal(points[i].shading_normal), LambertClosure{reflectance_.value});
            return;
        }
        for (const std::uint32_t i : hits) {
            const Rgb reflectance = clamp_to_unit(reflectance_.at(textures, points[i]));
            closures[i].set(Frame::from_normal(points[i].shading_normal), LambertClosure{reflectance});
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override { lobes.push_back(lobes::diffuse); }

  private:
    RgbInput reflectance_;
};

class DiffuseTransmissionMaterial final : public Material {
  public:
    DiffuseTransmissionMaterial(const RgbInput& reflectance, const RgbInput& transmittance, Real scale)
        : reflectance_(reflectance), transmittance_(transmittance), scale_(scale) {}
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            const auto at = [&](const RgbInput& input) {
                return clamp_to_unit(input.at(textures, points[i]) * scale_);
            };
            closures[i].set(Frame::from_normal(points[i].shading_normal),
                            DiffuseTransmissionClosure{at(reflectance_), at(transmittance_)});
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        const auto lit = [](const RgbInput& input) { return input.texture >= 0 || !input.value.is_black(); };
        if (lit(reflectance_)) lobes.push_back(lobes::diffuse);
        if (lit(transmittance_)) lobes.push_back(lobes::diffuse_transmit);
    }

  private:
    RgbInput reflectance_, transmittance_;
    Real scale_;
};

class ConductorMaterial final : public Material {
  public:
    ConductorMaterial(const ConductorInput& metal, std::shared_ptr<const FacetAlbedo> compensation)
        : metal_(metal), compensation_(std::move(compensation)) {}
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            const ConductorClosure closure = metal_.at(textures, points[i], 1);
            const Frame frame = shading_frame(points[i], closure.facets);
            if (compensation_ && !closure.is_delta())
                closures[i].set(frame, CompensatedConductor{closure, compensation_.get()});
            else closures[i].set(frame, closure);
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        if (metal_.roughness.may_be_rough()) lobes.push_back(lobes::conductor_glossy);
        if (metal_.roughness.may_be_smooth()) lobes.push_back(lobes::conductor_singular);
    }

  private:
    ConductorInput metal_;
    std::shared_ptr<const FacetAlbedo> compensation_;  ///< null: none
};

class DielectricMaterial final : public Material {
  public:
    DielectricMaterial(const RoughnessInput& roughness, Real eta, std::shared_ptr<const FacetAlbedo> compensation,
                       std::shared_ptr<const IndexSpectrum> index)
        : roughness_(roughness), eta_(eta), compensation_(std::move(compensation)) {
        index_spectrum = std::move(index);
    }
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            const DielectricClosure interface { roughness_.at(textures, points[i]), eta_ };
            const Frame frame = shading_frame(points[i], interface.facets);
            if (compensation_ && !interface.is_delta())
                closures[i].set(frame, CompensatedDielectric{interface, compensation_.get()});
            else closures[i].set(frame, GlassClosure{interface});
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        const bool varies = index_spectrum != nullptr;
        const bool matched = varies ? may_be_matched(*index_spectrum) : DielectricClosure{{1, 1}, eta_}.is_delta();
        if (roughness_.may_be_rough() && (!matched || varies))
            lobes.insert(lobes.end(), {lobes::glass_reflect_glossy, lobes::glass_transmit_glossy});
        if (!roughness_.may_be_smooth() && !matched) return;
        if (eta_ != 1 || varies)
            lobes.push_back(lobes::glass_reflect_singular);  // else there is nothing to reflect, exactly
        lobes.push_back(lobes::glass_transmit_singular);
    }

  private:
    RoughnessInput roughness_;
    Real eta_;
    std::shared_ptr<const FacetAlbedo> compensation_;  ///< null: none
};

class ThinDielectricMaterial final : public Material {
  public:
    explicit ThinDielectricMaterial(Real eta) : eta_(eta) {}
    void shade(const TextureTable&, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits)
            closures[i].set(Frame::from_normal(points[i].shading_normal), ThinDielectricClosure{eta_});
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        lobes.insert(lobes.end(), {lobes::glass_reflect_singular, lobes::glass_transmit_singular});
    }

  private:
    Real eta_;
};

class InterfaceMaterial final : public Material {
  public:
    void shade(const TextureTable&, HitIndices hits, std::span<const SurfacePoint>,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) closures[i].set_pass_through();
    }
    void append_lobes(std::vector<LobeId>&) const override {}
    bool is_interface() const override { return true; }
};

Built make_diffuse(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RgbInput reflectance = reader.rgb("reflectance", Rgb(0.5f));
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<DiffuseMaterial>(reflectance));
}

Built make_diffuse_transmission(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RgbInput reflectance = reader.rgb("reflectance", Rgb(0.25f)),
                   transmittance = reader.rgb("transmittance", Rgb(0.25f));
    const Real scale = reader.real("scale", 1, 0, std::numeric_limits<Real>::infinity());
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<DiffuseTransmissionMaterial>(reflectance, transmittance, scale));
}

Built make_conductor(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const ConductorInput metal = reader.conductor("");
    auto compensation = reader.compensation(metal.roughness, 0);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<ConductorMaterial>(metal, std::move(compensation)));
}

Built make_dielectric(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RoughnessInput roughness = reader.roughness("", 0);
    const Real eta = reader.index_of_refraction("eta", 1.5f);
    auto index = reader.index_spectrum("eta");
    auto compensation = reader.compensation(roughness, index != nullptr && may_be_matched(*index) ? 1 : eta);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(
        std::make_unique<DielectricMaterial>(roughness, eta, std::move(compensation), std::move(index)));
}

Built make_thin_dielectric(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const Real eta = reader.index_of_refraction("eta", 1.5f);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<ThinDielectricMaterial>(eta));
}

Built make_interface(const SceneEntity&, const MaterialContext&) {
    return std::unique_ptr<Material>(std::make_unique<InterfaceMaterial>());
}

}  // namespace

void register_plain_materials(Registry<MaterialFactory>& registry) {
    using enum ParameterType;
    const std::vector<ParameterDescription> rough{
        {"roughness", real, "0", "facets on both axes; 0 is a mirror"},
        {"uroughness", real, "roughness", "along dp/du"},
        {"vroughness", real, "roughness", "across dp/du"},
        {"remaproughness", boolean, "true", "alpha = sqrt(roughness) instead of roughness"},
        {"raylex:compensate", boolean, "false", compensation_help}};
    std::vector<ParameterDescription> metal = rough, glass = rough;
    metal.insert(metal.begin(), {{"eta", spectrum, "metal-Cu-eta", "index of refraction"},
                                 {"k", spectrum, "metal-Cu-k", "extinction"},
                                 {"reflectance", rgb, "", "instead of eta and k: reflectance at normal incidence"}});
    const ParameterDescription index{"eta", real, "1.5", "index of refraction, inside over outside"};
    glass.insert(glass.begin(), index);
    registry.add({"diffuse",
                  "ideal diffuse reflection from both sides",
                  {{"reflectance", rgb, "0.5", "diffuse albedo"}},
                  make_diffuse});
    registry.add({"diffusetransmission",
                  "ideal diffuse reflection and transmission: leaves, paper",
                  {{"reflectance", rgb, "0.25", "albedo on the side that light comes from"},
                   {"transmittance", rgb, "0.25", "albedo on the other side"},
                   {"scale", real, "1", "of both; what is above 1 then counts as 1"}},
                  make_diffuse_transmission});
    registry.add({"conductor", "metal with GGX facets", metal, make_conductor});
    registry.add({"dielectric", "glass with GGX facets", glass, make_dielectric});
    registry.add({"thindielectric", "a thin pane of smooth glass", {index}, make_thin_dielectric});
    registry.add({"interface", "no surface: a border between media", {}, make_interface});
}

}  // namespace raylex::transport
