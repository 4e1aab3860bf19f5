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

    /// For bdpt, whose weights need the same choice of lights at every vertex: the lights that are live for connections
    /// by `language`; all lights if it is null.
    static LiveLights alike_everywhere(const SceneView& scene, const EventTable& events, const LightLanguage* language);
    /// Whether the object was constructed with these arguments.
    [[nodiscard]] bool is_of(LightChoice choice, bool by_receiver) const {
        return choice_ == choice && by_receiver_ == by_receiver;
    }
    /// Whether alike_everywhere() chooses no light because none is live.
    [[nodiscard]] bool none_is_live() const { return none_is_live_; }

    /// The number of the smallest set of lights that contains all live ones.
    [[nodiscard]] std::uint8_t of(const display::Liveness::LiveSet& live) const {
        for (const Set& set : sets_)
            if ((live.terminals & ~set.terminals) == 0) return set.chooser;
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

/// One chooser for all vertices, among the lights whose suffix has `wanted` in its live set: `joins` for light samples,
/// `goes_on` for the start of light subpaths. A null `language` means all lights.
LightChooser choose_live_lights(const SceneView& scene, const EventTable& events, const LightLanguage* language,
                                LightChoice choice, bool display::SuffixLiveness::LiveSet::*wanted);

}  // namespace raylex::transport
