// Which effects a scene calls for, why, and how one is left out.
//
//     const EffectFindings found = analyse_effects(scene);  // before anything is built
//     if (Status s = apply_effects(scene, choices); !s) return s.error();  // import/apply_effects.h
//
// What a scene does not call for costs nothing beyond a test: its loops do not run. A choice overrules that, to see
// what an effect costs. Off: the scene is changed so that it does not call for the effect (EffectInfo::without), and
// nothing that renders knows of it. On, where the scene does not call for it: the code of scenes that do runs all the
// same, with nothing to find, and the image has the same bits; the beauty, every channel and every AOV. What only
// materials, lights or shapes of their own bring is nowhere in the way of others: forcing that on runs nothing
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
    const char* meaning;       ///< what calls for it
    const char* without;       ///< what stands for it when it is left out
    const char* general_code;  ///< what forcing it on runs where nothing calls for it; empty: nothing
};
/// In the order of Effect.
std::span<const EffectInfo> effect_catalogue();
[[nodiscard]] const EffectInfo& effect_info(Effect effect);

/// What other renderers have and raylex does not simulate, and what becomes of scenes with it.
struct AbsentEffect {
    const char* name;
    const char* consequence;
};
std::span<const AbsentEffect> effects_not_simulated();

/// By its name. Errors at `where`: one that raylex does not simulate, with what becomes of it; an unknown one, with the
/// near miss and all names.
Result<Effect> effect_named(const std::string& name, const SourceLocation& where);

/// What a user says about effects; unset: as the scene calls for it.
struct EffectChoices {
    std::array<std::optional<bool>, effect_count> forced{};

    [[nodiscard]] std::optional<bool>& operator[](Effect effect) { return forced[static_cast<std::size_t>(effect)]; }
    [[nodiscard]] const std::optional<bool>& operator[](Effect effect) const {
        return forced[static_cast<std::size_t>(effect)];
    }
    [[nodiscard]] bool any() const;
    /// "alpha on, media off"; empty without choices. Alike choices have one text.
    [[nodiscard]] std::string text() const;
};

struct EffectFinding {
    bool called_for = false;
    std::string why;  ///< "2 of 5 materials": what calls for it, or that nothing does
};
using EffectFindings = std::array<EffectFinding, effect_count>;  // [Effect]

/// Looks at the whole scene once. Names that nothing has are left to the build to refuse.
EffectFindings analyse_effects(const SceneDescription& scene);

}  // namespace raylex::transport
