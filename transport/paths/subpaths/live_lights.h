// The lights among which a vertex draws its light sample: those whose light a channel can still take (Law 4).
#pragma once

#include <cstdint>
#include <vector>

#include "transport/paths/record.h"

namespace raylex::transport {

class LiveLights {
  public:
    /// Numbers of two choosers: among all lights, and among none.
    static constexpr std::uint8_t all = 0, none = 1;

    LiveLights() = default;
    /// `by_receiver`: LightChooser::by_receiver().
    LiveLights(const SceneView& scene, const EventTable& events, LightChoice choice, bool by_receiver);

    /// For bdpt, whose weights need the same choice of lights at every vertex: among the lights that connections may
    /// meet by `language` (null: all).
    static LiveLights alike_everywhere(const SceneView& scene, const EventTable& events, const LightLanguage* language);
    /// Whether this was built with these arguments.
    [[nodiscard]] bool is_of(LightChoice choice, bool by_receiver) const {
        return choice_ == choice && by_receiver_ == by_receiver;
    }
    /// Whether no light is chosen because no channel takes any of their light.
    [[nodiscard]] bool none_is_live() const { return none_is_live_; }

    /// The number of the smallest set of lights that contains every light still live behind a vertex.
    [[nodiscard]] std::uint8_t of(const display::Foresight::Ahead& ahead) const {
        for (const Set& set : sets_)
            if ((ahead.terminals & ~set.terminals) == 0) return set.chooser;
        return all;
    }
    [[nodiscard]] const LightChooser& operator[](std::uint8_t number) const { return choosers_[number]; }

  private:
    static constexpr std::size_t most_choosers = 32;
    struct Set {
        std::uint64_t terminals;
        std::size_t lights;
        std::uint8_t chooser;
    };
    std::vector<Set> sets_;  // ascending by lights
    std::vector<LightChooser> choosers_{2};
    bool none_is_live_ = false;
    LightChoice choice_ = LightChoice::mis;
    bool by_receiver_ = false;
};

/// One chooser for all vertices, among the lights for which `language` has `wanted`: `joins` where light is sampled,
/// `goes_on` where light subpaths begin. Null: all lights.
LightChooser choose_live_lights(const SceneView& scene, const EventTable& events, const LightLanguage* language,
                                LightChoice choice, bool display::LightForesight::Ahead::*wanted);

}  // namespace raylex::transport
