// Describes sets of events in English, and in the notation of the expression language.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lpe/algebra/wording/event_space.h"

namespace raylex::lpe {

/// "diffuse reflection off 'floor'" and "diffuse reflections off 'floor'", one entry for each alternative. Terminals
/// include their article: "a light of group 'key'", "emission".
struct EventPhrase {
    std::vector<std::string> one, many;
    [[nodiscard]] bool empty() const { return one.empty(); }
};

/// "a", "a or b", "a, b or c"
[[nodiscard]] std::string joined_by(const std::vector<std::string>& items, const std::string& last_joint = " or ");

/// The first few items, followed by the number of omitted ones.
[[nodiscard]] std::vector<std::string> shortened(std::vector<std::string> items);

[[nodiscard]] bool has_scatter(const std::vector<Scatter>& list, Scatter scatter);

class EventTeller {
  public:
    using Members = std::function<Membership(const Event&)>;

    /// `occurring` gives `in` for events that can occur and `never` for others. `space` and `occurring` must outlive
    /// the object.
    EventTeller(const EventSpace& space, Dialect dialect, const Members& occurring);

    [[nodiscard]] Dialect dialect() const { return dialect_; }
    [[nodiscard]] std::vector<EventBox> boxes(const Members& members) const { return space_.boxes(members); }
    [[nodiscard]] EventPhrase phrase(const EventBox& box) const;
    /// The alternatives of all boxes that have the role.
    [[nodiscard]] EventPhrase phrase(const std::vector<EventBox>& boxes, EventRole role) const;
    /// Returns whether the box contains every event of its role that can occur.
    [[nodiscard]] bool is_all(const EventBox& box) const;

    /// "<RD'floor'>", "V", "<L.'key'>", "L-B": expressions whose union is the set.
    [[nodiscard]] std::vector<std::string> notation(const EventBox& box) const;

  private:
    const EventSpace& space_;
    Dialect dialect_;
    std::vector<CoreKind> scattering_, terminals_;  // that can occur
};

/// Scattering cores of a box, grouped by equal lobe numbers.
struct ScatteringOutline {
    std::vector<std::uint8_t> numbers;  ///< empty: every lobe number
    bool numbers_excluded = false;      ///< every number except these
    std::vector<Scatter> reflection, transmission;
    bool straight = false;
    bool volume = false;
};
[[nodiscard]] std::vector<ScatteringOutline> outline(const std::vector<CoreKind>& cores,
                                                     const std::vector<CoreKind>& possible);

}  // namespace raylex::lpe
