// @NAME@: a material with its own lobe: Minnaert's law of the moon's surface ("The reciprocity principle in lunar
// photometry", Astrophysical Journal 93, 1941), f = reflectance (k + 2) / (2 pi) (cos_i cos_o)^k. It is reciprocal. Its
// albedo is reflectance cos_o^k.
#include <cmath>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;

LobeId own_lobe = 0;  // set during the registration of the plugin

/// The parameters at a point: plain data in the shading frame. Sampled with density proportional to cos_i^(k+1).
struct MoonClosure {
    Rgb reflectance;
    float k = 0;

    [[nodiscard]] float pdf(const Vec3& wo, const Vec3& wi) const {
        return wo.z * wi.z > 0 ? (k + 2) * (0.5f * inv_pi) * std::pow(std::abs(wi.z), k + 1) : 0.0f;
    }
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        BsdfEvaluation result;
        result.pdf = pdf(wo, wi);
        result.value = albedo(std::abs(wo.z)) * result.pdf;
        if (result.pdf > 0) result.lobes.add(own_lobe, result.value);
        return result;
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, float, const Vec2& u) const {
        const float cos_i = std::pow(1 - u.x, 1 / (k + 2)), sin_i = safe_sqrt(1 - cos_i * cos_i), phi = 2 * pi * u.y;
        BsdfSample result;
        result.wi = {sin_i * std::cos(phi), sin_i * std::sin(phi), std::copysign(cos_i, wo.z)};
        const BsdfEvaluation f = evaluate(wo, result.wi);
        result.pdf = f.pdf;
        result.lobes = f.lobes;
        result.weight = albedo(std::abs(wo.z));
        return result;
    }
    [[nodiscard]] Rgb albedo(float cos_o) const { return reflectance * std::pow(cos_o, k); }
    [[nodiscard]] bool has_density() const { return !reflectance.is_black(); }
};

class MoonMaterial final : public Material {
  public:
    MoonMaterial(RgbInput reflectance, float k) : reflectance_(reflectance), k_(k) {}
    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t i : hits)
            closures[i].set_custom(Frame::from_normal(points[i].shading_normal),
                                   MoonClosure{clamp_to_unit(reflectance_.at(textures, points[i])), k_});
    }
    void append_lobes(std::vector<LobeId>& lobes) const override { lobes.push_back(own_lobe); }

  private:
    RgbInput reflectance_;
    float k_;
};

Result<std::unique_ptr<Material>> make(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RgbInput reflectance = reader.rgb("reflectance", Rgb(0.5f));
    const float k = reader.real("k", 0.5f, 0, 100);
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<MoonMaterial>(reflectance, k));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    own_lobe = host.add_lobe({lpe::EventType::reflection, lpe::Scatter::diffuse, "@NAME@"});
    host.add_material({"@NAME@",
                       "the moon's surface",
                       {{"reflectance", ParameterType::rgb, "0.5", "albedo seen from straight above"},
                        {"k", ParameterType::real, "0.5",
                         "exponent: 0 is a Lambert surface, larger values darken the rim; 0 to 100"}},
                       make});
}
