// Names that a renderer has for its own events and lobes, so that expressions and events can use them.
//
// Own events become user events (U1 to U12), which no wildcard matches; own lobes become numbered lobes, so that `D`
// and `S` still match them. In an expression a registered name, quoted, stands where the letter would stand:
//
//     renderman   C'hair_entry'L    C<.'hair_entry''wig'>L    C<R'coat''car'>L     (as U1, <.U1'wig'>, <RS4'car'>)
//     osl         C'hair_entry'L    C<'hair_entry'.'wig'>L    C<R'coat''car'>L     (as OSL's registered types do)
//
// In a label slot a quoted text is a label, registered or not.
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
    /// Registers an event of its own; the next free user event is taken, and returned. Errors: a name that is taken,
    /// empty or holds quotes, backslashes or the marks of globs; no user event left.
    Result<int> add_event(const std::string& name);
    /// The same as U`number`, for expressions that are kept.
    Status add_event(const std::string& name, int number);
    /// Registers a lobe: Scatter::diffuse with D1 to D4; Scatter::glossy or Scatter::singular with S1 to S8, which
    /// stand for both. Errors as above, and numbers that do not exist.
    Status add_lobe(const std::string& name, Scatter scatter, int number);

    /// The events that a name stands for, labels aside; nothing for names that are not registered.
    [[nodiscard]] std::optional<CoreSet> cores(std::string_view name) const;
    [[nodiscard]] bool is_event(std::string_view name) const;

    /// An event of a registered kind, with its labels. Errors: the name is not registered as such (near misses are
    /// named).
    Result<Event> event(std::string_view name, std::vector<std::string> labels = {}) const;
    /// A scattering at a registered lobe: `type` is reflection or transmission; a lobe of S is glossy or singular as
    /// it was registered.
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
