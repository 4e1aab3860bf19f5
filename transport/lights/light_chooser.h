// Which light a sample goes to.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "transport/lights/alias_table.h"
#include "transport/lights/light.h"
#include "transport/lights/light_tree.h"

namespace raylex::transport {

/// Which lights are chosen from. Uniform environments have nothing to aim at: a scattering ray finds them at least as
/// well as a light sample would, so `mis` leaves them to scattering (pbrt-v4 does too); `light_sampling` cannot. Both
/// go by power, the other two give every light that sends anything the same probability.
enum class LightChoice : std::uint8_t { mis, light_sampling, mis_uniform, light_sampling_uniform };
inline constexpr std::size_t light_choices = 4;

class LightChooser {
  public:
    /// Chooses none.
    LightChooser() = default;
    /// Among the lights that `wanted` [light] marks; empty: all.
    LightChooser(std::span<const Light> lights, LightChoice choice, std::span<const std::uint8_t> wanted = {});
    /// The same, but where more than `most_by_power` of them stand somewhere, these are chosen by what each can send to
    /// the receiver. The n that stand nowhere (distant, infinite) then share n / (n + 1) of the choices, as in pbrt-v4.
    static LightChooser by_receiver(std::span<const Light> lights, const EmbreeScene& geometry, LightChoice choice,
                                    std::span<const std::uint8_t> wanted = {});
    static constexpr std::size_t most_by_power = 32;

    [[nodiscard]] bool empty() const { return table_.empty() && tree_.empty(); }
    /// Whether skies are sampled by what stands out of them, for scattering finds the rest: of by_receiver() with
    /// `mis`.
    [[nodiscard]] bool compensates() const { return compensates_; }
    /// Above this many lights the choice takes a number of its own; below, it shares another and costs few of its bits.
    static constexpr std::size_t shared_choice_limit = 64;
    [[nodiscard]] bool needs_number() const { return !tree_.empty() || table_.size() > shared_choice_limit; }
    /// Numbers in [0, 1); u_choice is read only if needs_number(), and `u` stay uniform. LightTree::none where nothing
    /// can arrive.
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
    AliasTable table_;  // of all; beside a tree, of the lights that stand nowhere
    LightTree tree_;
    Real table_share_ = 1;
    bool compensates_ = false;
};

}  // namespace raylex::transport
