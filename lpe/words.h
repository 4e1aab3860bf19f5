// W, the words a scene can produce: C scatter* (L | O | B). Every proof of the algebra is relative to W, cut to what
// can occur, so that a split is judged by the paths that exist and not by sequences of events no renderer makes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lpe/event.h"

namespace raylex::lpe {

/// The events that can occur, when they are known (from a scene, say). Labels are compared exactly. Thousands of labels
/// cost little: of events that no expression of a question tells apart, the first listed stands for all.
struct Alphabet {
    std::vector<Event> scattering;  ///< R, T and V events
    std::vector<Event> terminals;   ///< L, O and B events
};

/// What W is cut to. The default is everything: every lobe, any label in either slot, every terminal.
struct Words {
    bool volume = true;             ///< V events occur
    bool straight = true;           ///< Ts events occur (to `renderman` channels they never leave an event)
    bool background = true;         ///< B terminals occur
    bool emission = true;           ///< O terminals occur
    bool unlabelled_lights = true;  ///< L and B terminals without a light group occur
    /// The light groups, and the labels of objects and media, that exist; none given: any text. Emission without a
    /// group and objects without a label always exist. No part beside an alphabet, which lists its own.
    std::optional<std::vector<std::string>> light_groups, object_labels;
    /// Scattering events of a word at most, straight-through ones not counted; none or more than limits::word_depth:
    /// any number, so that a proof is never relative to fewer words than there are.
    std::optional<int> max_depth;
    std::optional<Alphabet> alphabet;  ///< exactly these scattering and terminal events, further cut by the flags above
};

}  // namespace raylex::lpe
