// Trees to automata: Thompson's construction, then subset construction. Operators on whole languages (&, -, !) are
// worked out on minimal automata and embedded, so they may stand anywhere in an expression.
#pragma once

#include <cstddef>
#include <unordered_map>

#include "lpe/automata/dfa.h"
#include "lpe/language/ast.h"

namespace raylex::lpe {

/// Counts elementary steps, so that no expression keeps the compiler busy for more than seconds.
class WorkMeter {
  public:
    /// Throws Failure when the steps of this compilation are used up.
    void spend(std::size_t steps);

  private:
    std::size_t spent_ = 0;
};

/// What the construction needs to know about the world of events.
struct ClassLookup {
    const EventClasses* classes = nullptr;
    /// Classes of the words that '!' complements within: all events but user events (and straight ones in renderman).
    const ClassSet* universe = nullptr;
    WorkMeter* work = nullptr;
};

/// The minimal automaton of the tree's language, output 1 where it accepts. At most `state_cap` states before
/// minimisation. Throws Failure when a bound is passed.
[[nodiscard]] Dfa build_dfa(const Node& root, const ClassLookup& lookup, std::size_t state_cap);

}  // namespace raylex::lpe
