// raylex:additive, raylex:mirror, raylex:diffuse-mirror, raylex:sheet: surfaces with known answers, for analytic scenes
// (furnaces with a closed form per light path expression) and for tests of lobe attribution.
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

using Built = Result<std::unique_ptr<Material>>;

class IdealMaterial final : public Material {
  public:
    IdealMaterial(const RgbInput& diffuse, const RgbInput& mirror, const RgbInput& sheet)
        : diffuse_(diffuse), mirror_(mirror), sheet_(sheet) {}
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            const SurfacePoint& p = points[i];
            const IdealClosure closure{clamp_to_unit(diffuse_.at(textures, p)), clamp_to_unit(mirror_.at(textures, p)),
                                       clamp_to_unit(sheet_.at(textures, p))};
            closures[i].set(Frame::from_normal(p.shading_normal), closure);
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        const auto lit = [](const RgbInput& input) { return input.varies || !input.value.is_black(); };
        if (lit(diffuse_)) lobes.push_back(lobes::diffuse);
        if (lit(mirror_)) lobes.push_back(lobes::mirror);
        if (lit(sheet_)) lobes.push_back(lobes::sheet);
    }

  private:
    RgbInput diffuse_, mirror_, sheet_;
};

class AdditiveMaterial final : public Material {
  public:
    AdditiveMaterial(const RgbInput& diffuse, const RgbInput& specular, const RoughnessInput& roughness, bool constant)
        : diffuse_(diffuse), specular_(specular), roughness_(roughness), constant_(constant) {}
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits) {
            const SurfacePoint& p = points[i];
            AdditiveClosure closure;
            closure.diffuse.reflectance = clamp_to_unit(diffuse_.at(textures, p));
            const Rgb specular = clamp_to_unit(specular_.at(textures, p));
            Ggx facets = roughness_.at(textures, p);
            if (facets.smooth()) facets = {Ggx::smooth_below, Ggx::smooth_below};
            closure.specular = {facets, constant_ ? specular : Rgb(1),
                                constant_ ? Rgb(0) : conductor_k_from_reflectance(specular), constant_};
            closures[i].set(shading_frame(p, facets), closure);
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        lobes.insert(lobes.end(), {lobes::diffuse, lobes::specular_glossy});
    }

  private:
    RgbInput diffuse_, specular_;
    RoughnessInput roughness_;
    bool constant_;
};

Built make_ideal(const SceneEntity& entity, const MaterialContext& context, const char* diffuse, const char* mirror,
                 const char* sheet) {
    MaterialReader reader(entity, context);
    const auto input = [&](const char* name) { return name != nullptr ? reader.rgb(name, Rgb(0.5f)) : RgbInput{}; };
    const RgbInput d = input(diffuse), m = input(mirror), s = input(sheet);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<IdealMaterial>(d, m, s));
}

Built make_additive(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RgbInput diffuse = reader.rgb("diffuse", Rgb(0.5f)), specular = reader.rgb("specular", Rgb(0.5f));
    const RoughnessInput roughness = reader.roughness("", Real(0.3));
    const bool constant = reader.boolean("constantreflectance", false);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<AdditiveMaterial>(diffuse, specular, roughness, constant));
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
