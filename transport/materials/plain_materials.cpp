// diffuse, diffusetransmission, conductor, dielectric, thindielectric, interface: one closure each.
#include <limits>

#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

class InterfaceMaterial final : public Material {
  public:
    void shade(const TextureTable&, HitIndices hits, std::span<const SurfacePoint>,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) closures[i].set_pass_through();
    }
    void append_lobes(std::vector<LobeId>&) const override {}
    bool is_interface() const override { return true; }
};

MadeMaterial make_interface(const SceneEntity&, const MaterialContext&) {
    return std::unique_ptr<Material>(std::make_unique<InterfaceMaterial>());
}

MadeMaterial make_diffuse(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RgbInput reflectance = reader.rgb("reflectance", Rgb(0.5f));
    if (reflectance.texture < 0)
        return reader.material({lobes::diffuse}, [lambert = LambertClosure{clamp_to_unit(reflectance.value)}](
                                                     const TextureTable&, const SurfacePoint& p, Bsdf& closure) {
            closure.set(Frame::from_normal(p.shading_normal), lambert);
        });
    return reader.material({lobes::diffuse}, [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
        const LambertClosure lambert{clamp_to_unit(reflectance.at(textures, p))};
        closure.set(Frame::from_normal(p.shading_normal), lambert);
    });
}

MadeMaterial make_diffuse_transmission(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RgbInput reflectance = reader.rgb("reflectance", Rgb(0.25f)),
                   transmittance = reader.rgb("transmittance", Rgb(0.25f));
    const Real scale = reader.real("scale", 1, 0, std::numeric_limits<Real>::infinity());
    std::vector<LobeId> lobes;
    const auto lit = [](const RgbInput& input) { return input.texture >= 0 || !input.value.is_black(); };
    if (lit(reflectance)) lobes.push_back(lobes::diffuse);
    if (lit(transmittance)) lobes.push_back(lobes::diffuse_transmit);
    return reader.material(lobes, [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
        const auto at = [&](const RgbInput& input) { return clamp_to_unit(input.at(textures, p) * scale); };
        closure.set(Frame::from_normal(p.shading_normal),
                    DiffuseTransmissionClosure{at(reflectance), at(transmittance)});
    });
}

MadeMaterial make_conductor(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const ConductorInput input = reader.conductor("");
    const auto compensation = reader.compensation(input.roughness, 0);
    std::vector<LobeId> lobes;
    if (input.roughness.may_be_rough()) lobes.push_back(lobes::conductor_glossy);
    if (input.roughness.may_be_smooth()) lobes.push_back(lobes::conductor_singular);
    return reader.material(lobes, [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
        const ConductorClosure metal = input.at(textures, p, 1);
        const Frame frame = shading_frame(p, metal.facets);
        if (compensation && !metal.is_delta()) closure.set(frame, CompensatedConductor{metal, compensation.get()});
        else closure.set(frame, metal);
    });
}

MadeMaterial make_dielectric(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RoughnessInput roughness = reader.roughness("", 0);
    const Real eta = reader.index_of_refraction("eta", 1.5f);
    const auto index = reader.index_spectrum("eta");
    const auto compensation = reader.compensation(roughness, index != nullptr && may_be_matched(*index) ? 1 : eta);
    const InterfaceLobes may_give(roughness, eta, index.get());
    std::vector<LobeId> lobes;
    if (may_give.rough) lobes = {lobes::glass_reflect_glossy, lobes::glass_transmit_glossy};
    if (may_give.smooth_reflection) lobes.push_back(lobes::glass_reflect_singular);
    if (may_give.smooth) lobes.push_back(lobes::glass_transmit_singular);
    const auto shade = [=](const TextureTable& textures, const SurfacePoint& p, Bsdf& closure) {
        const DielectricClosure glass{roughness.at(textures, p), eta};
        const Frame frame = shading_frame(p, glass.facets);
        if (compensation && !glass.is_delta()) closure.set(frame, CompensatedDielectric{glass, compensation.get()});
        else closure.set(frame, GlassClosure{glass});
    };
    return reader.material(lobes, shade, index);
}

MadeMaterial make_thin_dielectric(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const Real eta = reader.index_of_refraction("eta", 1.5f);
    return reader.material({lobes::glass_reflect_singular, lobes::glass_transmit_singular},
                           [=](const TextureTable&, const SurfacePoint& p, Bsdf& closure) {
                               closure.set(Frame::from_normal(p.shading_normal), ThinDielectricClosure{eta});
                           });
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
