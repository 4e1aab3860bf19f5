// From infinitely many events to a few classes: two events are in the same class when every predicate of the channels
// answers alike on both, so an automaton needs one column per class.
//
// The predicates are resolved slot by slot: first the 328 cores are grouped by the patterns that admit them, then each
// group branches on the labels that some live pattern names (all other labels fall together, one branch per combination
// of globs that a label can realise). The result is a small automaton over (core, label, label, ...) whose states are
// sets of patterns that may still match; its ends are the event classes. classify() walks it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lpe/language/class_table.h"
#include "lpe/language/pattern.h"
#include "lpe/program.h"

namespace raylex::lpe {

/// A subset of the event classes.
using ClassSet = std::vector<bool>;

class EventClasses {
  public:
    /// Throws Failure when the predicates tell too many kinds of events apart.
    explicit EventClasses(std::vector<EventSet> sets);

    [[nodiscard]] std::size_t count() const { return examples_.size(); }
    /// The classes whose events are in set `set` (an index into the constructor's list).
    [[nodiscard]] const ClassSet& members(std::size_t set) const { return members_[set]; }
    [[nodiscard]] EventClass classify(const Event& event) const {
        return static_cast<EventClass>(table_.classify(event));
    }
    [[nodiscard]] const ClassTable& table() const { return table_; }
    /// The plainest event of the class.
    [[nodiscard]] const Event& example(EventClass event_class) const { return examples_[event_class]; }

  private:
    using Alive = std::vector<std::uint32_t>;  // patterns that may still match, ascending
    struct Reached;                            // a node while it is being built
    class Builder;

    ClassTable table_;
    std::vector<Event> examples_;
    std::vector<ClassSet> members_;
};

}  // namespace raylex::lpe
