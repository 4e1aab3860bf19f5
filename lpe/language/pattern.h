// Predicates on single events: the meaning of a letter, a '.', a quoted label or a <...> in an expression.
//
// An event is its core (type, scatter, lobe number: 328 combinations) followed by its labels without trailing empty
// ones. A pattern is a set of cores and one test per label slot. The dialects differ in the treatment of missing slots,
// and of labels beyond the tests.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"

namespace raylex::lpe {

inline constexpr int scene_types = 7;  ///< EventType values before `user`
inline constexpr int scatter_kinds = 5;
inline constexpr int lobe_numbers = 9;   ///< 0 (unnumbered) and 1..8
inline constexpr int user_numbers = 13;  ///< 0 (never matched) and 1..12
inline constexpr std::size_t core_count = scene_types * scatter_kinds * lobe_numbers + user_numbers;
using CoreSet = std::bitset<core_count>;

/// The index of an event's core. Numbers out of range count as unnumbered.
[[nodiscard]] std::size_t core_index(const Event& event);
/// The event with that core, without labels.
[[nodiscard]] Event core_event(std::size_t core);

/// The number of an event's labels without trailing empty ones.
[[nodiscard]] std::size_t label_count(const Event& event);

/// The letter of an event type: C R T V L B O, and '-' for user events. scatter_letter(): x D G S s.
[[nodiscard]] char type_letter(EventType type);
[[nodiscard]] char scatter_letter(Scatter scatter);

/// A set of labels: those that are named or match a glob, or all others when negated.
struct LabelTest {
    bool negated = false;
    std::vector<std::string> names;  // sorted, no duplicates
    std::vector<std::string> globs;  // '*': any text, '?': one character, '\': the next byte literally

    [[nodiscard]] static LabelTest any() { return {true, {}, {}}; }
    [[nodiscard]] bool is_any() const { return negated && names.empty() && globs.empty(); }
    [[nodiscard]] bool matches(std::string_view label) const;
    void add_name(std::string name);
    /// Makes this test the union of both sets. Neither can contain globs.
    void unite(const LabelTest& other);
    bool operator==(const LabelTest&) const = default;
};

/// Treatment of a missing label slot: as the empty label (renderman), or as a mismatch (osl).
enum class Missing : std::uint8_t { is_empty, refuses };
/// Treatment of labels beyond the tests: ignored (renderman), refused if equal to an OSL symbol (osl), or refused.
enum class Extra : std::uint8_t { ignored, unreserved, refused };

struct EventPattern {
    CoreSet cores;
    std::vector<LabelTest> labels;
    Missing missing = Missing::is_empty;
    Extra extra = Extra::ignored;
    bool operator==(const EventPattern&) const = default;
};

/// The events that match a pattern of `any_of` and no pattern of `none_of`.
struct EventSet {
    std::vector<EventPattern> any_of;
    std::vector<EventPattern> none_of;
    /// A text that is equal for two sets exactly when their patterns are equal.
    [[nodiscard]] std::string key() const;
};

[[nodiscard]] bool matches(const EventPattern& pattern, const Event& event);
[[nodiscard]] bool matches(const EventSet& set, const Event& event);

/// Labels that OSL's trailing wildcard does not match: the texts of its basic symbols.
[[nodiscard]] const std::vector<std::string>& reserved_names();

/// Pass-through transmission, Ts: the event that `renderman` words do not contain.
[[nodiscard]] const CoreSet& straight_cores();
/// The events that '.' matches: all except user events and, in renderman, Ts.
[[nodiscard]] const CoreSet& wildcard_cores(Dialect dialect);

}  // namespace raylex::lpe
