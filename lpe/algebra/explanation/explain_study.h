// What explain.cpp works on: one expression as tree and automaton, and the traits of paths as automata beside it.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "lpe/algebra/explanation/features.h"
#include "lpe/algebra/proofs/question.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/automata/languages.h"
#include "lpe/program.h"
#include "lpe/words.h"

namespace raylex::lpe {

struct Study {
    ChannelSource source;  ///< names replaced by what they stand for
    Expression expression;
    Words words;               ///< without straight-through events where they are no letters
    bool user_events = false;  ///< the expression has some; they may stand among the scattering then
    Languages languages;
    Dfa all;    ///< W
    Dfa paths;  ///< what the expression accepts of W
    std::array<Dfa, feature_count> features;

    [[nodiscard]] const Dfa& feature(Feature which) const { return features[static_cast<std::size_t>(which)]; }
    [[nodiscard]] bool accepts_some(Feature which) const;
    [[nodiscard]] bool occurs(Feature which) const;
};

/// Throws Failure.
[[nodiscard]] Study study(const ChannelSource& channel, const Words& words);

/// Further trees over the same W: whether each has a path in common with it. Null trees have none.
[[nodiscard]] std::vector<bool> have_paths(const Study& study, std::vector<NodePtr> trees);

/// "It is the beauty where there is no medium.", and the channels and names that mean the same.
[[nodiscard]] std::vector<std::string> known_equals(const Study& study, bool& is_beauty);

/// What the expression leaves out that people expect in it, and how its letters were taken.
[[nodiscard]] std::vector<std::string> notes_about(const Study& study);

}  // namespace raylex::lpe
