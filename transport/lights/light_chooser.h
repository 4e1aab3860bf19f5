// Which light a sample goes to.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "transport/lights/alias_table.h"
#include "transport/lights/light.h"

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

    [[nodiscard]] bool empty() const { return table_.empty(); }
    /// Above this many lights the choice takes a number of its own; below, it shares another and costs few of its bits.
    static constexpr std::size_t shared_choice_limit = 64;
    [[nodiscard]] bool needs_number() const { return table_.size() > shared_choice_limit; }
    /// Numbers in [0, 1); u_choice is read only if needs_number(), and `u` stays one that is uniform.
    [[nodiscard]] std::uint32_t choose(Real u_choice, Real& u) const {
        return needs_number() ? table_.choose(u_choice) : table_.choose_and_remap(u);
    }
    [[nodiscard]] Real probability(std::uint32_t light) const { return table_.probability(light); }

  private:
    AliasTable table_;
};

}  // namespace raylex::transport
