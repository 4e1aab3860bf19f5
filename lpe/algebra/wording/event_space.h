// Sets of events told by their outlines: which types and scatterings, which lobe numbers, which labels. An automaton
// knows a set only as answers to "is this event in it?"; people want "<R[DS]'floor'>" and "a reflection off 'floor'".
//
// The space holds one event for every combination of core and labels that the expressions at hand can tell apart. A set
// is asked about each of them and cut into boxes, core set x first label x second label, that are as few as is easy.
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

/// What an event does in a word of W.
enum class EventRole : std::uint8_t { camera, scattering, user, terminal };

[[nodiscard]] EventRole role_of(EventType type);

/// A core, or several that differ in lobe number only and that no expression tells apart.
struct CoreKind {
    EventType type = EventType::camera;
    Scatter scatter = Scatter::none;
    std::vector<std::uint8_t> numbers{0};  ///< ascending
};

/// The labels that one slot may carry.
struct LabelChoice {
    enum class Kind : std::uint8_t { any, only, except };
    Kind kind = Kind::any;
    std::vector<std::string> names;  ///< labels; the empty one is left out
    std::vector<std::string> globs;  ///< as expressions write them
    bool empty_allowed = true;       ///< an event without this label is in the set
    bool operator==(const LabelChoice&) const = default;
};

struct EventBox {
    EventRole role = EventRole::scattering;
    std::vector<CoreKind> cores;
    LabelChoice first;   ///< object, or light group
    LabelChoice second;  ///< lobe
};

/// An answer about one event; `never`: it cannot occur, so nothing depends on it.
enum class Membership : std::uint8_t { out, in, never };

class EventSpace {
  public:
    /// The space for the events that these trees tell apart. Throws Failure when they are too many.
    explicit EventSpace(const std::vector<const Node*>& trees);

    /// The set as boxes: camera, scattering, users, terminals in this order; within each, by type and scattering.
    [[nodiscard]] std::vector<EventBox> boxes(const std::function<Membership(const Event&)>& member) const;

    /// The kinds of cores of that role that can occur, i.e. are not `never` whatever their labels.
    [[nodiscard]] std::vector<CoreKind> possible(EventRole role,
                                                 const std::function<Membership(const Event&)>& member) const;

  private:
    struct Value {
        std::string example;      // a label of this kind
        bool named = false;       // only this very label
        std::vector<bool> globs;  // which of the slot's globs match it
    };
    struct Slot {
        std::vector<std::string> globs;
        std::vector<Value> values;
    };
    /// Answers of one core: [first][second].
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
