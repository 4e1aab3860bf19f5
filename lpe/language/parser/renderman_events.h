// Events of the `renderman` dialect: characters, letters, labels and <...>. parser_renderman.cpp parses the languages
// over them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "lpe/language/pattern.h"
#include "lpe/language/source_text.h"

namespace raylex::lpe {

class RendermanEvents {
  public:
    explicit RendermanEvents(const SourceText& source) : source_(source), text_(source.text()) {}

  protected:
    /// Skips blanks and comments, then returns whether the text is at its end.
    bool at_end();
    bool at(char c) { return !at_end() && text_[position_] == c; }
    bool take(char c);
    [[noreturn]] void fail_unexpected(const std::string& expected);
    void expect_closing(char closer, char opener, std::size_t opening);

    /// Parses a letter, a quoted label or a <...>; returns the events that it matches.
    EventSet parse_event();

    const SourceText& source_;
    std::string_view text_;
    std::size_t position_ = 0;

  private:
    enum class Slot { type, scatter };

    bool take_type(CoreSet& cores);
    bool take_scatter(CoreSet& cores);
    /// The events of the quoted text at the position; nothing if there is no text, or if it is not a registered name.
    std::optional<CoreSet> find_registered(std::size_t& after);
    bool take_registered(CoreSet& cores);
    int parse_lobe_number(const std::string& letter, int highest);
    EventSet parse_group();
    CoreSet parse_slot(Slot slot);
    CoreSet parse_slot_letter(Slot slot);
    LabelTest parse_labels();
    void add_label(LabelTest& test);
};

}  // namespace raylex::lpe
