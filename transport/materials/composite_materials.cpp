// mix: one of two materials at every hit, chosen by a hash, so that no closure ever holds both.
#include <algorithm>
#include <vector>

#include "display/services/split_mix.h"
#include "lpe/input/budgets.h"
#include "transport/materials/material_inputs.h"

namespace raylex::transport {

namespace {

/// The share of either part that is surface, for mixes with interfaces. EmbreeScene already passes rays by the whole
/// share of interfaces, so the mix chooses among surfaces alone.
struct SurfaceShares {
    TextureId first = -1, second = -1, whole = -1;  ///< -1: all of it
};

class MixMaterial final : public Material {
  public:
    MixMaterial(const Material& first, const Material& second, const RealInput& amount, const SurfaceShares& shares,
                std::uint32_t salt)
        : first_(first),
          second_(second),
          amount_(amount),
          shares_(shares),
          salt_(salt),
          depth_(1 + std::max(depth_of(first), depth_of(second))),
          interior_(first.interior() != nullptr ? first.interior() : second.interior()) {
        // Lobes and interior are found once, here. Nested mixes that share parts have exponentially many ways down to
        // them, and each lobe counts once.
        first.append_lobes(lobes_);
        second.append_lobes(lobes_);
        std::sort(lobes_.begin(), lobes_.end());
        lobes_.erase(std::unique(lobes_.begin(), lobes_.end()), lobes_.end());
    }
    /// The depth of nested mixes, this one included; 0 for other materials. Shading recurses as deep.
    static std::uint64_t depth_of(const Material& material) {
        const auto* mix = dynamic_cast<const MixMaterial*>(&material);
        return mix != nullptr ? mix->depth_ : 0;
    }

    void shade(const TextureTable& textures, HitIndices hits, std::span<const SurfacePoint> points,
               std::span<Bsdf> closures) const override {
        for (const std::uint32_t& i : hits) chosen(textures, points[i]).shade(textures, {&i, 1}, points, closures);
    }
    const Material& chosen(const TextureTable& textures, const SurfacePoint& point) const override {
        Real amount = amount_.at(textures, point);
        if (shares_.whole >= 0) amount = among_surfaces(textures, point, amount);
        return (draw(point.random_key) < amount ? second_ : first_).chosen(textures, point);
    }
    const Medium* interior() const override { return interior_; }
    TextureId surface_share() const override { return shares_.whole; }
    void append_lobes(std::vector<LobeId>& lobes) const override {
        lobes.insert(lobes.end(), lobes_.begin(), lobes_.end());
    }

  private:
    /// In [0, 1): amount 0 never chooses the second part, amount 1 always. A mix inside a mix has another salt.
    [[nodiscard]] Real draw(std::uint32_t key) const {
        return unit_float(mix_bits(std::uint64_t{salt_} << 32 ^ mix_bits(key + 0x6d6978ull)));
    }
    /// The second part's share of the surface at this point.
    [[nodiscard]] Real among_surfaces(const TextureTable& textures, const SurfacePoint& point, Real amount) const {
        const auto share = [&](TextureId id) {
            return id < 0 ? Real(1) : std::clamp(textures.real(id, texture_point(point)), Real(0), Real(1));
        };
        amount = std::clamp(amount, Real(0), Real(1));
        const Real first = (1 - amount) * share(shares_.first), second = amount * share(shares_.second);
        return first + second > 0 ? second / (first + second) : amount;
    }
    const Material& first_;
    const Material& second_;
    RealInput amount_;
    SurfaceShares shares_;
    std::uint32_t salt_;
    std::uint64_t depth_;
    const Medium* interior_;
    std::vector<LobeId> lobes_;
};

Result<SurfaceShares> shares_of(const Material& first, const Material& second, const RealInput& amount,
                                TextureTable& textures) {
    const auto share = [&](const Material& material) {
        return material.is_interface() ? textures.add_constant(Rgb(0)) : material.surface_share();
    };
    SurfaceShares shares{share(first), share(second), -1};
    if (shares.first < 0 && shares.second < 0) return shares;
    const auto or_all = [&](TextureId id) { return id < 0 ? textures.add_constant(Rgb(1)) : id; };
    const TextureId by = amount.texture < 0 ? textures.add_constant(Rgb(amount.value)) : amount.texture;
    auto whole = textures.add_mix(or_all(shares.first), or_all(shares.second), by);
    if (!whole) return whole.error();
    shares.whole = *whole;
    return shares;
}

MadeMaterial make_mix(const SceneEntity& entity, const MaterialContext& context) {
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
    if (std::max(MixMaterial::depth_of(**first), MixMaterial::depth_of(**second)) >= budget(Budget::material_depth))
        return over_budget(Budget::material_depth, "mix materials inside one another too deep", entity.location.file,
                           entity.location.line, entity.location.column);
    const auto shares = shares_of(**first, **second, amount, context.textures);
    if (!shares) return error_at(entity.location, "mix material with an interface: " + shares.error().message);
    return std::unique_ptr<Material>(std::make_unique<MixMaterial>(**first, **second, amount, *shares, context.salt));
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
