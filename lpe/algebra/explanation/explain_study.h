// The data behind explain.cpp: one expression as tree and automaton, and automata for traits of paths.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "lpe/algebra/explanation/features.h"
#include "lpe/algebra/proofs/question.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/automata/languages.h"
#include "lpe/path_strings.h"
#include "lpe/program.h"

namespace raylex::lpe {

struct Study {
    ChannelSource source;  ///< names are replaced by their definitions
    Expression expression;
    PathStrings words;         ///< without pass-through events where the expression does not use them as letters
    bool user_events = false;  ///< the expression uses user events, so W contains them among the scattering events
    Languages languages;
    Dfa all;    ///< W
    Dfa paths;  ///< the words of W that the expression accepts
    std::array<Dfa, feature_count> features;

    [[nodiscard]] const Dfa& feature(Feature which) const { return features[static_cast<std::size_t>(which)]; }
    [[nodiscard]] bool accepts_some(Feature which) const;
    [[nodiscard]] bool occurs(Feature which) const;
};

/// Parses and compiles the expression. Throws Failure.
[[nodiscard]] Study study(const ChannelSource& channel, const PathStrings& words);

/// For each further tree over the W of `study`: does the tree share a path with the expression? Null trees share none.
[[nodiscard]] std::vector<bool> have_paths(const Study& study, std::vector<NodePtr> trees);

/// Sentences about equality: "It is the beauty where there is no medium.", and equivalent channels and names.
[[nodiscard]] std::vector<std::string> known_equals(const Study& study, bool& is_beauty);

/// Notes on paths that the expression omits although people expect them, and on how its letters were read.
[[nodiscard]] std::vector<std::string> notes_about(const Study& study);

}  // namespace raylex::lpe
