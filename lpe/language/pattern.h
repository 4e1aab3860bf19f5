// Predicates on single events: what a letter, a '.', a quoted label or a <...> of an expression stands for.
//
// An event is read as its core (type, scatter, lobe number: 328 combinations) followed by its labels, trailing empty
// labels left out. A pattern is a set of cores and one test per label slot; what happens to slots that the event lacks,
// and to labels beyond the tests, is where the dialects differ.
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

/// Index of an event's core. Numbers out of range count as unnumbered.
[[nodiscard]] std::size_t core_index(const Event& event);
/// The event of that core, without labels.
[[nodiscard]] Event core_event(std::size_t core);

/// The letters of the symbol alphabet: C R T V L B O and '-' for user events; x D G S s.
[[nodiscard]] char type_letter(EventType type);
[[nodiscard]] char scatter_letter(Scatter scatter);

/// A set of label strings: those named or matched by a glob, or all others when negated.
struct LabelTest {
    bool negated = false;
    std::vector<std::string> names;  // sorted, no duplicates
    std::vector<std::string> globs;  // '*': any text, '?': one character, '\': the next byte as it is

    [[nodiscard]] static LabelTest any() { return {true, {}, {}}; }
    [[nodiscard]] bool is_any() const { return negated && names.empty() && globs.empty(); }
    [[nodiscard]] bool matches(std::string_view label) const;
    void add_name(std::string name);
    /// Makes this the union of both sets. Neither may have globs.
    void unite(const LabelTest& other);
    bool operator==(const LabelTest&) const = default;
};

/// What a missing label slot is: the empty label (renderman) or no match (osl).
enum class Missing : std::uint8_t { is_empty, refuses };
/// What labels beyond the tests do: nothing (renderman), refuse when they are named like an OSL symbol (osl), refuse.
enum class Extra : std::uint8_t { ignored, unreserved, refused };

struct EventPattern {
    CoreSet cores;
    std::vector<LabelTest> labels;
    Missing missing = Missing::is_empty;
    Extra extra = Extra::ignored;
    bool operator==(const EventPattern&) const = default;
};

/// The events that some pattern of `any_of` matches and none of `none_of` does.
struct EventSet {
    std::vector<EventPattern> any_of;
    std::vector<EventPattern> none_of;
    /// A text that is equal exactly when the sets are written alike.
    [[nodiscard]] std::string key() const;
};

[[nodiscard]] bool matches(const EventPattern& pattern, const Event& event);
[[nodiscard]] bool matches(const EventSet& set, const Event& event);

/// The names that OSL's trailing wildcard does not eat: its basic symbols.
[[nodiscard]] const std::vector<std::string>& reserved_names();

/// Straight-through transmission, Ts: the event that leaves no trace in `renderman` words.
[[nodiscard]] const CoreSet& straight_cores();
/// What '.' matches: every event but user events (and, in renderman, but Ts).
[[nodiscard]] const CoreSet& wildcard_cores(Dialect dialect);

}  // namespace raylex::lpe
