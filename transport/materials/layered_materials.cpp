// coateddiffuse, coatedconductor: a dielectric coat over an opaque base.
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

using Built = Result<std::unique_ptr<Material>>;

struct CoatInput {
    RoughnessInput roughness;
    RealInput thickness, g;
    RgbInput albedo;
    Real eta = 1.5f;
    std::uint16_t max_depth = 10, sample_count = 1;
    bool as_pbrt = true;

    /// pbrt-v4's parameters; those of the interface have the prefix, those of the slab between have not.
    static CoatInput read(MaterialReader& reader, std::string_view prefix) {
        CoatInput coat;
        const std::string p(prefix);
        coat.roughness = reader.roughness(prefix, 0);
        coat.thickness = reader.real_texture("thickness", Real(0.01));
        coat.eta = reader.index_of_refraction(p + "eta", 1.5f);
        coat.g = reader.real_texture("g", 0);
        coat.albedo = reader.rgb("albedo", Rgb(0));
        // Walks of no layers never meet the base: as in pbrt-v4, what the coat reflects is all there is.
        coat.max_depth = static_cast<std::uint16_t>(reader.integer("maxdepth", 10, 0, 10000));
        coat.sample_count = static_cast<std::uint16_t>(reader.integer("nsamples", 1, 1, 10000));
        coat.as_pbrt = !reader.boolean("raylex:unbiased", false);
        return coat;
    }
    [[nodiscard]] CoatLayer at(const TextureTable& textures, const SurfacePoint& p) const {
        CoatLayer layer;
        layer.interface = {roughness.at(textures, p), eta};
        // A slab without thickness would leave a walk nowhere to be (pbrt-v4 keeps it above the least float).
        layer.thickness = std::max(thickness.at(textures, p), Real(1e-30));
        layer.g = std::clamp(g.at(textures, p), -Real(0.999), Real(0.999));
        layer.albedo = clamp_to_unit(albedo.at(textures, p));
        layer.max_depth = max_depth;
        layer.sample_count = sample_count;
        layer.as_pbrt = as_pbrt;
        return layer;
    }
    void append_lobes(std::vector<LobeId>& lobes) const {
        const bool matched = DielectricClosure{{1, 1}, eta}.is_delta();
        if (roughness.may_be_rough() && !matched) lobes.push_back(lobes::coat_glossy);
        if (roughness.may_be_smooth() || matched) lobes.push_back(lobes::coat_singular);
    }
    [[nodiscard]] bool scatters() const { return albedo.varies || !albedo.value.is_black(); }
};

/// Anisotropy of either interface needs the tangent.
Frame layered_frame(const SurfacePoint& p, const Ggx& coat, const Ggx& base) {
    return shading_frame(p, coat.alpha_x == coat.alpha_y ? base : coat);
}

class CoatedDiffuseMaterial final : public Material {
  public:
    CoatedDiffuseMaterial(const CoatInput& coat, const RgbInput& reflectance)
        : coat_(coat), reflectance_(reflectance) {}
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            const SurfacePoint& p = points[i];
            LayeredClosure<LambertClosure> layered;
            layered.coat = coat_.at(textures, p);
            layered.base.reflectance = clamp_to_unit(reflectance_.at(textures, p));
            layered.key = p.random_key;
            closures[i].set(shading_frame(p, layered.coat.interface.facets), layered);
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        coat_.append_lobes(lobes);
        lobes.push_back(lobes::diffuse);
    }

  private:
    CoatInput coat_;
    RgbInput reflectance_;
};

class CoatedConductorMaterial final : public Material {
  public:
    CoatedConductorMaterial(const CoatInput& coat, const ConductorInput& metal) : coat_(coat), metal_(metal) {}
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            const SurfacePoint& p = points[i];
            LayeredClosure<ConductorClosure> layered;
            layered.coat = coat_.at(textures, p);
            layered.base = metal_.at(textures, p, coat_.eta);
            layered.key = p.random_key;
            closures[i].set(layered_frame(p, layered.coat.interface.facets, layered.base.facets), layered);
        }
    }
    /// The base is singular only where coat and base both are and the slab does not scatter.
    void append_lobes(std::vector<LobeId>& lobes) const override {
        coat_.append_lobes(lobes);
        const bool coat_rough = coat_.roughness.may_be_rough() && !DielectricClosure{{1, 1}, coat_.eta}.is_delta();
        const bool coat_smooth = coat_.roughness.may_be_smooth() || DielectricClosure{{1, 1}, coat_.eta}.is_delta();
        if (coat_rough || metal_.roughness.may_be_rough() || coat_.scatters()) lobes.push_back(lobes::conductor_glossy);
        if (coat_smooth && metal_.roughness.may_be_smooth()) lobes.push_back(lobes::conductor_singular);
    }

  private:
    CoatInput coat_;
    ConductorInput metal_;
};

Built make_coated_diffuse(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const CoatInput coat = CoatInput::read(reader, "");
    const RgbInput reflectance = reader.rgb("reflectance", Rgb(0.5f));
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<CoatedDiffuseMaterial>(coat, reflectance));
}

Built make_coated_conductor(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const CoatInput coat = CoatInput::read(reader, "interface.");
    const ConductorInput metal = reader.conductor("conductor.", coat.eta);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<CoatedConductorMaterial>(coat, metal));
}

}  // namespace

void register_layered_materials(Registry<MaterialFactory>& registry) {
    using enum ParameterType;
    const std::vector<ParameterDescription> slab{
        {"thickness", real, "0.01", "optical thickness of the slab between coat and base"},
        {"g", real, "0", "Henyey-Greenstein asymmetry of the slab"},
        {"albedo", rgb, "0", "single-scattering albedo of the slab"},
        {"maxdepth", integer, "10", "layers visited per random walk"},
        {"nsamples", integer, "1", "random walks per evaluation"},
        {"remaproughness", boolean, "true", "alpha = sqrt(roughness) instead of roughness"},
        {"raylex:unbiased", boolean, "false", "under a rough coat: exact instead of agreeing with pbrt-v4's bias"}};
    std::vector<ParameterDescription> diffuse{{"reflectance", rgb, "0.5", "diffuse albedo of the base"},
                                              {"eta", real, "1.5", "index of refraction of the coat"},
                                              {"roughness", real, "0", "of the coat, on both axes"},
                                              {"uroughness", real, "roughness", "of the coat, along dp/du"},
                                              {"vroughness", real, "roughness", "of the coat, across dp/du"}};
    std::vector<ParameterDescription> metal{
        {"interface.eta", real, "1.5", "index of refraction of the coat"},
        {"interface.roughness", real, "0", "of the coat, on both axes"},
        {"interface.uroughness", real, "interface.roughness", "of the coat, along dp/du"},
        {"interface.vroughness", real, "interface.roughness", "of the coat, across dp/du"},
        {"conductor.eta", spectrum, "metal-Cu-eta", "index of refraction of the base"},
        {"conductor.k", spectrum, "metal-Cu-k", "extinction of the base"},
        {"reflectance", rgb, "", "instead of conductor.eta and .k: reflectance at normal incidence"},
        {"conductor.roughness", real, "0", "of the base, on both axes"},
        {"conductor.uroughness", real, "conductor.roughness", "of the base, along dp/du"},
        {"conductor.vroughness", real, "conductor.roughness", "of the base, across dp/du"}};
    diffuse.insert(diffuse.end(), slab.begin(), slab.end());
    metal.insert(metal.end(), slab.begin(), slab.end());
    registry.add({"coateddiffuse", "a dielectric coat over a diffuse base", diffuse, make_coated_diffuse});
    registry.add({"coatedconductor", "a dielectric coat over metal", metal, make_coated_conductor});
}

}  // namespace raylex::transport
