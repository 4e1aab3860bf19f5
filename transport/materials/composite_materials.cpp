// mix: one of two materials at every hit, chosen by a hash, so that no closure ever holds both.
#include <algorithm>
#include <vector>

#include "lpe/budgets.h"
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

using Built = Result<std::unique_ptr<Material>>;

class MixMaterial final : public Material {
  public:
    MixMaterial(const Material& first, const Material& second, const RealInput& amount, std::uint32_t salt)
        : first_(first),
          second_(second),
          amount_(amount),
          salt_(salt),
          depth_(1 + std::max(depth_of(first), depth_of(second))) {
        // Once and each once: mixes of mixes that share their parts would list them as often as there are ways down.
        first.append_lobes(lobes_);
        second.append_lobes(lobes_);
        std::sort(lobes_.begin(), lobes_.end());
        lobes_.erase(std::unique(lobes_.begin(), lobes_.end()), lobes_.end());
    }
    /// Mixes inside one another, this one included; 0 for other materials. Shading goes down by recursion.
    static std::uint64_t depth_of(const Material& material) {
        const auto* mix = dynamic_cast<const MixMaterial*>(&material);
        return mix != nullptr ? mix->depth_ : 0;
    }

    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t& i : hits) chosen(textures, points[i]).shade(textures, {&i, 1}, points, closures);
    }
    const Material& chosen(const TextureTable& textures, const SurfacePoint& point) const override {
        const Real amount = amount_.at(textures, point);
        return (draw(point.random_key) < amount ? second_ : first_).chosen(textures, point);
    }
    const Medium* interior() const override {
        return first_.interior() != nullptr ? first_.interior() : second_.interior();
    }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        lobes.insert(lobes.end(), lobes_.begin(), lobes_.end());
    }

  private:
    /// In [0, 1): amount 0 never takes the second, amount 1 always. A mix inside a mix has another salt.
    [[nodiscard]] Real draw(std::uint32_t key) const {
        return unit_float(mix_bits(std::uint64_t{salt_} << 32 ^ mix_bits(key + 0x6d6978ull)));
    }
    const Material& first_;
    const Material& second_;
    RealInput amount_;
    std::uint32_t salt_;
    std::uint64_t depth_;
    std::vector<LobeId> lobes_;
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
    for (std::size_t i : {0u, 1u})
        if ((i == 0 ? *first : *second)->is_interface())
            return error_at(reader.where(*names),
                            "a mix with the interface '" + names->strings[i] +
                                "' is not supported: hits on it would absorb; expected two surfaces",
                            "give the shape an \"alpha\" for the share that is to pass");
    if (std::max(MixMaterial::depth_of(**first), MixMaterial::depth_of(**second)) >= budget(Budget::material_depth))
        return over_budget(Budget::material_depth, "mix materials inside one another too deep", entity.location.file,
                           entity.location.line, entity.location.column);
    return std::unique_ptr<Material>(std::make_unique<MixMaterial>(**first, **second, amount, context.salt));
}

}  // namespace

void register_composite_materials(Registry<MaterialFactory>& registry) {
    registry.add({"mix",
                  "one of two named materials at every hit",
                  {{"materials", ParameterType::string, "", "names of the two materials"},
                   {"amount", ParameterType::real, "0.5", "share of the second"}},
                  make_mix});
}

}  // namespace raylex::transport
