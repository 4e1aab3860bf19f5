// Converts trees to automata: Thompson's construction, then subset construction. Operators on whole languages (&, -, !)
// are evaluated on minimal automata that are then embedded, so they can occur anywhere in an expression.
#pragma once

#include <cstddef>
#include <unordered_map>

#include "lpe/automata/dfa.h"
#include "lpe/language/ast.h"

namespace raylex::lpe {

/// Counts elementary steps, so that no expression occupies the compiler for more than seconds.
class WorkMeter {
  public:
    /// Adds steps. Throws Failure when this compilation exceeds its limit.
    void spend(std::size_t steps);

  private:
    std::size_t spent_ = 0;
};

/// The event classes and limits that the construction uses.
struct ClassLookup {
    const EventClasses* classes = nullptr;
    /// Classes of the words over which '!' complements: all events except user events and, in renderman, pass-through
    /// events.
    const ClassSet* universe = nullptr;
    WorkMeter* work = nullptr;
};

/// The minimal automaton of the tree's language, with output 1 where it accepts. At most `state_cap` states before
/// minimisation. Throws Failure when a limit is exceeded.
[[nodiscard]] Dfa build_dfa(const Node& root, const ClassLookup& lookup, std::size_t state_cap);

}  // namespace raylex::lpe
