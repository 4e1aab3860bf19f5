// Maps an event to its class with plain arrays. Compiled programs and their files contain them.
//
// The table is a small automaton over (core, label, label, ...). The core (pattern.h) selects a node. Each label leads
// to the next node: by name if an expression names it, otherwise by the globs of the node that match it. The node after
// the last label holds the class. Trailing empty labels count as absent.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"

namespace raylex::lpe {

struct ClassTable {
    struct Node {
        std::uint32_t end_class = 0;              ///< class of an event whose labels end here
        std::uint32_t leaf = 1;                   ///< 1: further labels change nothing
        std::uint32_t first_name = 0, names = 0;  ///< into `names`, sorted by text
        std::uint32_t first_glob = 0, globs = 0;  ///< into `globs`
        std::uint32_t first_kind = 0, kinds = 0;  ///< into `kinds`, for labels without a name here
    };
    struct Name {
        std::uint32_t text = 0, node = 0;  ///< label -> node
    };
    struct Kind {
        std::uint32_t first_match = 0,
                      node = 0;  ///< matches[first_match ...]: for each glob of the node, 1 if it matches
    };

    std::vector<std::uint32_t> node_of_core;  ///< [core_count]
    std::vector<Node> nodes;
    std::vector<Name> names;
    std::vector<std::uint32_t> globs;  ///< texts
    std::vector<Kind> kinds;
    std::vector<std::uint8_t> matches;
    std::vector<std::uint32_t> text_begin{0};  ///< [text + 1] into `characters`
    std::string characters;

    [[nodiscard]] std::string_view text(std::uint32_t index) const {
        return std::string_view(characters).substr(text_begin[index], text_begin[index + 1] - text_begin[index]);
    }
    std::uint32_t add_text(std::string_view added) {
        characters += added;
        text_begin.push_back(static_cast<std::uint32_t>(characters.size()));
        return static_cast<std::uint32_t>(text_begin.size() - 2);
    }
    /// The class of the event. Labels that are not valid UTF-8, where globs are compared, give class 0, which nothing
    /// matches.
    [[nodiscard]] std::uint32_t classify(const Event& event) const;
};

}  // namespace raylex::lpe
