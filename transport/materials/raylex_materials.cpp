// raylex:additive, raylex:mirror, raylex:diffuse-mirror, raylex:sheet: surfaces with known answers, for analytic scenes
// (furnaces with a closed form per light path expression) and for tests of lobe attribution.
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

/// A null name leaves its lobe out.
MadeMaterial make_ideal(const SceneEntity& entity, const MaterialContext& context, const char* diffuse_name,
                        const char* mirror_name, const char* sheet_name) {
    MaterialReader reader(entity, context);
    std::vector<LobeId> lobes;
    const auto input = [&](const char* name, LobeId lobe) {
        const RgbInput read = name != nullptr ? reader.rgb(name, Rgb(0.5f)) : RgbInput{};
        if (read.varies || !read.value.is_black()) lobes.push_back(lobe);
        return read;
    };
    const RgbInput diffuse = input(diffuse_name, lobes::diffuse), mirror = input(mirror_name, lobes::mirror),
                   sheet = input(sheet_name, lobes::sheet);
    return reader.material(lobes, [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
        const auto at = [&](const RgbInput& each) { return clamp_to_unit(each.at(textures, p)); };
        closure.set(Frame::from_normal(p.shading_normal), IdealClosure{at(diffuse), at(mirror), at(sheet)});
    });
}

MadeMaterial make_additive(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RgbInput diffuse = reader.rgb("diffuse", Rgb(0.5f)), specular = reader.rgb("specular", Rgb(0.5f));
    const RoughnessInput roughness = reader.roughness("", Real(0.3));
    const bool constant = reader.boolean("constantreflectance", false);
    const auto shade = [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
        const LambertClosure lambert{clamp_to_unit(diffuse.at(textures, p))};
        const Rgb reflectance = clamp_to_unit(specular.at(textures, p));
        Ggx facets = roughness.at(textures, p);
        if (facets.smooth()) facets = {Ggx::smooth_below, Ggx::smooth_below};
        const ConductorClosure metal{facets, constant ? reflectance : Rgb(1),
                                     constant ? Rgb(0) : conductor_k_from_reflectance(reflectance), constant};
        closure.set(shading_frame(p, facets), AdditiveClosure{lambert, metal});
    };
    return reader.material({lobes::diffuse, lobes::specular_glossy}, shade);
}

}  // namespace

void register_raylex_materials(Registry<MaterialFactory>& registry) {
    using enum ParameterType;
    registry.add({"raylex:additive",
                  "the sum of a Lambert and a GGX lobe",
                  {{"diffuse", rgb, "0.5", "albedo of the Lambert lobe"},
                   {"specular", rgb, "0.5", "reflectance of the GGX lobe at normal incidence"},
                   {"roughness", real, "0.3", "of the GGX lobe; alpha is kept at 0.001 or more"},
                   {"uroughness", real, "roughness", "along dp/du"},
                   {"vroughness", real, "roughness", "across dp/du"},
                   {"remaproughness", boolean, "true", "alpha = sqrt(roughness) instead of roughness"},
                   {"constantreflectance", boolean, "false", "`specular` at every angle instead of Fresnel's law"}},
                  make_additive});
    registry.add({"raylex:mirror",
                  "ideal reflection of constant reflectance",
                  {{"reflectance", rgb, "0.5", "at every angle"}},
                  [](const SceneEntity& e, const MaterialContext& c) {
                      return make_ideal(e, c, nullptr, "reflectance", nullptr);
                  }});
    registry.add(
        {"raylex:diffuse-mirror",
         "Lambert and ideal reflection on one surface",
         {{"diffuse", rgb, "0.5", "albedo of the Lambert lobe"}, {"specular", rgb, "0.5", "reflectance of the mirror"}},
         [](const SceneEntity& e, const MaterialContext& c) {
             return make_ideal(e, c, "diffuse", "specular", nullptr);
         }});
    registry.add({"raylex:sheet",
                  "index-matched sheet: straight on, as a transmission event",
                  {{"transmittance", rgb, "0.5", "at every angle"}},
                  [](const SceneEntity& e, const MaterialContext& c) {
                      return make_ideal(e, c, nullptr, nullptr, "transmittance");
                  }});
}

}  // namespace raylex::transport
