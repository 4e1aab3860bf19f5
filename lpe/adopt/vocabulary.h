// A renderer's own names for events and lobes, for use in expressions and in events.
//
// A renderer's events become user events (U1 to U12), which no wildcard matches. Its lobes become numbered lobes, so
// `D` and `S` match them too. In an expression a registered name in quotes replaces the letter:
//
//     renderman   C'hair_entry'L    C<.'hair_entry''wig'>L    C<R'coat''car'>L     (as U1, <.U1'wig'>, <RS4'car'>)
//     osl         C'hair_entry'L    C<'hair_entry'.'wig'>L    C<R'coat''car'>L     (as OSL's registered types do)
//
// In a label slot a quoted text is always a label, even if the name is registered.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"
#include "lpe/language/pattern.h"
#include "lpe/result.h"

namespace raylex::lpe {

class Vocabulary {
  public:
    /// Registers an event and returns the number of its user event, the lowest that is free. Errors: the name is taken,
    /// is empty, or contains quotes, backslashes or the wildcards of globs; no user event is left.
    Result<int> add_event(const std::string& name);
    /// Registers an event as user event U`number`, for expressions that are stored and must keep their meaning.
    Status add_event(const std::string& name, int number);
    /// Registers a lobe: Scatter::diffuse has D1 to D4; Scatter::glossy and Scatter::singular share S1 to S8. Errors:
    /// the name is taken, empty or contains a forbidden character; the number does not exist.
    Status add_lobe(const std::string& name, Scatter scatter, int number);

    /// The events that a name denotes, whatever their labels; nothing if the name is not registered.
    [[nodiscard]] std::optional<CoreSet> cores(std::string_view name) const;
    [[nodiscard]] bool is_event(std::string_view name) const;

    /// Makes an event of a registered kind, with its labels. Errors: no event has that name; the error suggests similar
    /// names.
    Result<Event> event(std::string_view name, std::vector<std::string> labels = {}) const;
    /// Makes a scattering at a registered lobe. `type` is reflection or transmission. A lobe of S is glossy or
    /// singular, as it was registered. Errors: no lobe has that name; the error suggests similar names.
    Result<Event> scattering(EventType type, std::string_view lobe, std::vector<std::string> labels = {}) const;

  private:
    struct Entry {
        Scatter scatter = Scatter::none;  ///< none: a user event
        int number = 0;
    };
    Status check_name(const std::string& name) const;
    [[nodiscard]] Error unknown(std::string_view name, bool event) const;
    std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace raylex::lpe
