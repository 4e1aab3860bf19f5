// mix: one of two materials at every hit, chosen by a hash, so that no closure ever holds both.
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

using Built = Result<std::unique_ptr<Material>>;

class MixMaterial final : public Material {
  public:
    MixMaterial(const Material& first, const Material& second, const RealInput& amount, std::uint32_t salt)
        : first_(first), second_(second), amount_(amount), salt_(salt) {}

    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t& i : hits) {
            const float amount = amount_.at(textures, points[i]);
            const Material& chosen = draw(points[i].random_key) < amount ? second_ : first_;
            chosen.shade(textures, {&i, 1}, points, closures);
        }
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        first_.append_lobes(lobes);
        second_.append_lobes(lobes);
    }

  private:
    /// In [0, 1): amount 0 never takes the second, amount 1 always. A mix inside a mix has another salt.
    [[nodiscard]] float draw(std::uint32_t key) const {
        return unit_float(mix_bits(std::uint64_t{salt_} << 32 ^ mix_bits(key + 0x6d6978ull)));
    }
    const Material& first_;
    const Material& second_;
    RealInput amount_;
    std::uint32_t salt_;
};

Built make_mix(const SceneEntity& entity, const MaterialContext& context) {
    MaterialReader reader(entity, context);
    const RealInput amount = reader.real_texture("amount", 0.5f);
    const Parameter* names = entity.parameters.find("materials");
    if (names == nullptr || names->strings.size() != 2)
        return error_at(names != nullptr ? reader.where(*names) : entity.location,
                        "mix material needs \"string materials\" with the names of two materials");
    const Result<const Material*> first = context.materials.find(names->strings[0], reader.where(*names));
    if (!first) return first.error();
    const Result<const Material*> second = context.materials.find(names->strings[1], reader.where(*names));
    if (!second) return second.error();
    if (reader.error()) return *reader.error();
    return std::unique_ptr<Material>(std::make_unique<MixMaterial>(**first, **second, amount, context.salt));
}

}  // namespace

void register_composite_materials(Registry<MaterialFactory>& registry) {
    registry.add({"mix", "one of two named materials at every hit",
                  {{"materials", ParameterType::string, "", "names of the two materials"},
                   {"amount", ParameterType::real, "0.5", "share of the second"}}, make_mix});
}

}  // namespace raylex::transport
