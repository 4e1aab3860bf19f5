// Chooses the light of a sample.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "transport/lights/alias_table.h"
#include "transport/lights/light.h"
#include "transport/lights/light_tree.h"

namespace raylex::transport {

/// The lights that can be chosen. Scattering rays find uniform environments at least as well as light samples, so `mis`
/// leaves them to scattering (as pbrt-v4 does); `light_sampling` cannot. Both choose by power; the other two give every
/// light that emits the same probability.
enum class LightChoice : std::uint8_t { mis, light_sampling, mis_uniform, light_sampling_uniform };
inline constexpr std::size_t light_choices = 4;

class LightChooser {
  public:
    /// A chooser without lights.
    LightChooser() = default;
    /// A chooser among the lights that `wanted` [light] marks; empty: all.
    LightChooser(std::span<const Light> lights, LightChoice choice, std::span<const std::uint8_t> wanted = {});
    /// A chooser that uses what each light sends to the receiver, if more than `most_by_power` of them have a position.
    /// The n lights without a position (distant, infinite) then share n / (n + 1) of the choices, as in pbrt-v4.
    static LightChooser by_receiver(std::span<const Light> lights, const EmbreeScene& geometry, LightChoice choice,
                                    std::span<const std::uint8_t> wanted = {});
    static constexpr std::size_t most_by_power = 32;

    [[nodiscard]] bool empty() const { return table_.empty() && tree_.empty(); }
    /// Whether skies are sampled by the excess over their mean, since scattering finds the rest: true for by_receiver()
    /// with `mis`.
    [[nodiscard]] bool compensates() const { return compensates_; }
    /// With more lights than this, the choice takes a random number of its own; with fewer, it shares one and uses few
    /// of its bits.
    static constexpr std::size_t shared_choice_limit = 64;
    [[nodiscard]] bool needs_number() const { return !tree_.empty() || table_.size() > shared_choice_limit; }
    /// Chooses a light with numbers in [0, 1). u_choice is read only if needs_number(); `u` stays uniform. Returns
    /// LightTree::none if no light can arrive.
    [[nodiscard]] LightTree::Chosen choose(const LightReceiver& receiver, Real u_choice, Vec2& u) const {
        if (!tree_.empty()) return choose_by_receiver(receiver, u_choice, u);
        const std::uint32_t light = needs_number() ? table_.choose(u_choice) : table_.choose_and_remap(u.x);
        return {light, table_.probability(light)};
    }
    [[nodiscard]] Real probability(const LightReceiver& receiver, std::uint32_t light) const {
        if (tree_.empty()) return table_.probability(light);
        return table_share_ * table_.probability(light) + (1 - table_share_) * tree_.probability(receiver, light);
    }

  private:
    [[nodiscard]] LightTree::Chosen choose_by_receiver(const LightReceiver& receiver, Real u_choice,
                                                       const Vec2& u) const;
    AliasTable table_;  // of all lights; beside a tree: of the lights without a position
    LightTree tree_;
    Real table_share_ = 1;
    bool compensates_ = false;
};

}  // namespace raylex::transport
