// W, the path strings that a scene can produce: C scatter* (L | O | B). Every proof of the algebra is relative to W,
// restricted to what can occur, so a split is checked on existing paths and not on impossible sequences of events.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lpe/event.h"

namespace raylex::lpe {

/// The events that can occur, if they are known (for example from a scene). Labels are compared exactly. Thousands of
/// labels cost little, because one event represents all that no expression of a question distinguishes.
struct Alphabet {
    std::vector<Event> scattering;  ///< R, T and V events
    std::vector<Event> terminals;   ///< L, O and B events
};

/// The restrictions of W. By default there are none: every lobe, any label in either slot, every terminal.
struct PathStrings {
    bool volume = true;             ///< V events occur
    bool straight = true;           ///< Ts events occur (words of `renderman` channels never contain them)
    bool background = true;         ///< B terminals occur
    bool emission = true;           ///< O terminals occur
    bool unlabelled_lights = true;  ///< L and B terminals without a light group occur
    /// The existing light groups, and the existing labels of objects and media; none: any text. Emission without a
    /// group and objects without a label always exist. Ignored if there is an alphabet, which lists its own labels.
    std::optional<std::vector<std::string>> light_groups, object_labels;
    /// Largest number of scattering events of a path string, pass-through events excluded. If it is absent or above
    /// limits::path_string_depth, there is no limit: a proof must never cover fewer path strings than exist.
    std::optional<int> max_depth;
    std::optional<Alphabet> alphabet;  ///< only these scattering and terminal events, further restricted by the flags
                                       ///< above
};

}  // namespace raylex::lpe
