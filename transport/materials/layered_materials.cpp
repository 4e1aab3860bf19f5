// coateddiffuse, coatedconductor: a dielectric coat over an opaque base.
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

struct CoatInput {
    RoughnessInput roughness;
    RealInput thickness, g;
    RgbInput albedo;
    Real eta = 1.5f;
    std::uint16_t max_depth = 10, sample_count = 1;
    bool as_pbrt = true;

    /// Reads pbrt-v4's parameters. Those of the interface have the prefix, those of the slab below it do not.
    static CoatInput read(MaterialReader& reader, std::string_view prefix) {
        CoatInput coat;
        const std::string p(prefix);
        coat.roughness = reader.roughness(prefix, 0);
        coat.thickness = reader.real_texture("thickness", Real(0.01));
        coat.eta = reader.index_of_refraction(p + "eta", 1.5f);
        coat.g = reader.real_texture("g", 0);
        coat.albedo = reader.rgb("albedo", Rgb(0));
        // Walks of 0 layers never reach the base: as in pbrt-v4, the surface is then the coat's reflection alone.
        coat.max_depth = static_cast<std::uint16_t>(reader.integer("maxdepth", 10, 0, 10000));
        coat.sample_count = static_cast<std::uint16_t>(reader.integer("nsamples", 1, 1, 10000));
        coat.as_pbrt = !reader.boolean("raylex:unbiased", false);
        return coat;
    }
    [[nodiscard]] CoatLayer at(const TextureTable& textures, const SurfacePoint& p) const {
        CoatLayer layer;
        layer.interface = {roughness.at(textures, p), eta};
        // Walks need a thickness above 0 (pbrt-v4 keeps it above the least float).
        layer.thickness = std::max(thickness.at(textures, p), Real(1e-30));
        layer.g = std::clamp(g.at(textures, p), -Real(0.999), Real(0.999));
        layer.albedo = clamp_to_unit(albedo.at(textures, p));
        layer.max_depth = max_depth;
        layer.sample_count = sample_count;
        layer.as_pbrt = as_pbrt;
        return layer;
    }
    [[nodiscard]] std::vector<LobeId> lobes() const {
        std::vector<LobeId> result;
        const InterfaceLobes may_give(roughness, eta);
        if (may_give.rough) result.push_back(lobes::coat_glossy);
        if (may_give.smooth) result.push_back(lobes::coat_singular);
        return result;
    }
    [[nodiscard]] bool scatters() const { return albedo.varies || !albedo.value.is_black(); }
};

MadeMaterial make_coated_diffuse(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const CoatInput coat = CoatInput::read(reader, "");
    const RgbInput reflectance = reader.rgb("reflectance", Rgb(0.5f));
    std::vector<LobeId> lobes = coat.lobes();
    lobes.push_back(lobes::diffuse);
    return reader.material(lobes, [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
        const LayeredClosure<LambertClosure> layered{
            coat.at(textures, p), {clamp_to_unit(reflectance.at(textures, p))}, p.random_key};
        closure.set(shading_frame(p, layered.coat.interface.facets), layered);
    });
}

MadeMaterial make_coated_conductor(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const CoatInput coat = CoatInput::read(reader, "interface.");
    const ConductorInput metal = reader.conductor("conductor.", coat.eta);
    std::vector<LobeId> lobes = coat.lobes();
    // The base is singular only where coat and base are singular and the slab does not scatter.
    const InterfaceLobes over_it(coat.roughness, coat.eta);
    if (over_it.rough || metal.roughness.may_be_rough() || coat.scatters()) lobes.push_back(lobes::conductor_glossy);
    if (over_it.smooth && metal.roughness.may_be_smooth()) lobes.push_back(lobes::conductor_singular);
    return reader.material(lobes, [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
        const LayeredClosure<ConductorClosure> layered{coat.at(textures, p), metal.at(textures, p, coat.eta),
                                                       p.random_key};
        // Anisotropy of either interface needs the tangent.
        const Ggx &outer = layered.coat.interface.facets, &inner = layered.base.facets;
        closure.set(shading_frame(p, outer.alpha_x == outer.alpha_y ? inner : outer), layered);
    });
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
