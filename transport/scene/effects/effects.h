// Decides which effects a scene uses and why, and how one is left out.
//
//     const EffectFindings found = analyse_effects(scene);  // before anything is built
//     if (Status s = apply_effects(scene, choices); !s) return s.error();  // import/apply_effects.h
//
// An effect that a scene does not use costs nothing but a test: its loops do not run. A choice overrides that, to
// measure the cost of an effect. Off: the scene is changed so that it does not use the effect (EffectInfo::without),
// and rendering code needs no special case. On, in a scene that does not use it: the code for scenes with the effect
// runs, without anything to process, and the image has the same bits, for the beauty, every channel and every AOV.
// Effects that only add materials, lights or shapes have no general code: forcing them on runs nothing
// (EffectInfo::general_code).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "display/services/parameters.h"
#include "lpe/result.h"
#include "transport/scene/effect_set.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct EffectInfo {
    Effect effect;
    const char* name;          ///< "depth-of-field"
    const char* meaning;       ///< what makes a scene use it
    const char* without;       ///< what replaces it when it is left out
    const char* general_code;  ///< the code that runs if it is forced on in a scene without it; empty: none
};
/// All effects in the order of Effect.
std::span<const EffectInfo> effect_catalogue();
[[nodiscard]] const EffectInfo& effect_info(Effect effect);

/// A feature of other renderers that raylex does not simulate, and the consequence for scenes with it.
struct AbsentEffect {
    const char* name;
    const char* consequence;
};
std::span<const AbsentEffect> effects_not_simulated();

/// The effect with this name. Errors at `where`: an effect that raylex does not simulate, with the consequence; an
/// unknown one, with the closest match and all names.
Result<Effect> effect_named(const std::string& name, const SourceLocation& where);

/// A user's choices about effects; unset: as the scene requires.
struct EffectChoices {
    std::array<std::optional<bool>, effect_count> forced{};

    [[nodiscard]] std::optional<bool>& operator[](Effect effect) { return forced[static_cast<std::size_t>(effect)]; }
    [[nodiscard]] const std::optional<bool>& operator[](Effect effect) const {
        return forced[static_cast<std::size_t>(effect)];
    }
    [[nodiscard]] bool any() const;
    /// The choices as text, such as "alpha on, media off"; empty without choices. Equal choices have equal texts.
    [[nodiscard]] std::string text() const;
};

struct EffectFinding {
    bool called_for = false;
    std::string why;  ///< the reason, such as "2 of 5 materials", or that nothing uses the effect
};
using EffectFindings = std::array<EffectFinding, effect_count>;  // [Effect]

/// Analyses the whole scene once. Undefined names are left to the build, which reports them.
EffectFindings analyse_effects(const SceneDescription& scene);

}  // namespace raylex::transport
