// Describes sets of events by type and scattering, lobe numbers and labels. An automaton only answers "is this event in
// the set?"; people read "<R[DS]'floor'>" or "a reflection off 'floor'".
//
// The space holds one event for every combination of core and labels that the given expressions distinguish. It tests
// each event for membership and divides the set into few boxes: core set x first label x second label.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lpe/event.h"
#include "lpe/language/ast.h"
#include "lpe/language/pattern.h"

namespace raylex::lpe {

/// The role of an event in a word of W.
enum class EventRole : std::uint8_t { camera, scattering, user, terminal };

[[nodiscard]] EventRole role_of(EventType type);

/// One core, or several cores that differ only in lobe numbers that no expression distinguishes.
struct CoreKind {
    EventType type = EventType::camera;
    Scatter scatter = Scatter::none;
    std::vector<std::uint8_t> numbers{0};  ///< ascending
};

/// The labels that one slot can have.
struct LabelChoice {
    enum class Kind : std::uint8_t { any, only, except };
    Kind kind = Kind::any;
    std::vector<std::string> names;  ///< labels, without the empty one
    std::vector<std::string> globs;  ///< as expressions write them
    bool empty_allowed = true;       ///< the set contains events without this label
    bool operator==(const LabelChoice&) const = default;
};

struct EventBox {
    EventRole role = EventRole::scattering;
    std::vector<CoreKind> cores;
    LabelChoice first;   ///< object, or light group
    LabelChoice second;  ///< lobe
};

/// Membership of one event; `never`: the event cannot occur, so its membership is arbitrary.
enum class Membership : std::uint8_t { out, in, never };

class EventSpace {
  public:
    /// The space of the events that these trees distinguish. Throws Failure when there are too many.
    explicit EventSpace(const std::vector<const Node*>& trees);

    /// Divides the set into boxes in the order camera, scattering, user, terminal; within a role, by type and
    /// scattering.
    [[nodiscard]] std::vector<EventBox> boxes(const std::function<Membership(const Event&)>& member) const;

    /// The kinds of cores of that role that can occur, that is, not `never` for all labels.
    [[nodiscard]] std::vector<CoreKind> possible(EventRole role,
                                                 const std::function<Membership(const Event&)>& member) const;

  private:
    struct Value {
        std::string example;      // a label of this kind
        bool named = false;       // the kind contains only this label
        std::vector<bool> globs;  // [glob of the slot]: it matches the label
    };
    struct Slot {
        std::vector<std::string> globs;
        std::vector<Value> values;
    };
    /// The membership of one core by labels: [first][second].
    using Matrix = std::vector<Membership>;

    [[nodiscard]] const Slot& first_slot(EventRole role) const {
        return role == EventRole::terminal ? groups_ : objects_;
    }
    [[nodiscard]] const Slot& second_slot(EventRole role) const { return role == EventRole::terminal ? none_ : lobes_; }
    [[nodiscard]] Matrix ask(const CoreKind& core, const std::function<Membership(const Event&)>& member) const;
    void cut(EventRole role, const std::vector<CoreKind>& cores, const Matrix& matrix,
             std::vector<EventBox>& boxes) const;
    static LabelChoice choice(const Slot& slot, const std::vector<bool>& in, const std::vector<bool>& possible);

    std::vector<CoreKind> cores_;
    Slot objects_, lobes_, groups_, none_;
};

}  // namespace raylex::lpe
