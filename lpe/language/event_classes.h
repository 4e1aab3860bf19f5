// Reduces infinitely many events to a few classes. Two events are in the same class if every predicate of the channels
// gives the same answer for both, so an automaton needs one column per class.
//
// The predicates are evaluated slot by slot. First the 328 cores are grouped by the patterns that admit them. Then each
// group branches on the labels that a live pattern names; all other labels are merged, with one branch per combination
// of globs that a label can match. The result is a small automaton over (core, label, label, ...). Its states are the
// sets of patterns that can still match; its ends are the event classes, which classify() finds.
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
    /// Throws Failure when the predicates distinguish too many kinds of events.
    explicit EventClasses(std::vector<EventSet> sets);

    [[nodiscard]] std::size_t count() const { return examples_.size(); }
    /// The classes whose events are in the set with index `set` in the constructor's list.
    [[nodiscard]] const ClassSet& members(std::size_t set) const { return members_[set]; }
    [[nodiscard]] EventClass classify(const Event& event) const {
        return static_cast<EventClass>(table_.classify(event));
    }
    [[nodiscard]] const ClassTable& table() const { return table_; }
    /// The simplest event of the class.
    [[nodiscard]] const Event& example(EventClass event_class) const { return examples_[event_class]; }

  private:
    using Alive = std::vector<std::uint32_t>;  // patterns that can still match, ascending
    struct Reached;                            // a node under construction
    class Builder;

    ClassTable table_;
    std::vector<Event> examples_;
    std::vector<ClassSet> members_;
};

}  // namespace raylex::lpe
