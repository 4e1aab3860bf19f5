// The text of an expression with its origin, for errors that give the position of a byte.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "lpe/adopt/vocabulary.h"
#include "lpe/program.h"

namespace raylex::lpe {

class SourceText {
  public:
    explicit SourceText(const ChannelSource& source) : source_(&source) {}

    [[nodiscard]] std::string_view text() const { return source_->expression; }
    [[nodiscard]] std::size_t size() const { return source_->expression.size(); }

    /// Throws a Failure at byte `offset`, which can be the end of the text.
    [[noreturn]] void fail_at(std::size_t offset, std::string message, std::string hint = {}) const;

    /// An Error about the expression as a whole.
    [[nodiscard]] static Error whole_error(const ChannelSource& source, Error error);

    /// The registered names; null when there are none.
    [[nodiscard]] const Vocabulary* vocabulary() const { return source_->vocabulary.get(); }

    /// A description of the character at `offset` for a message: "'x'", "'С' (U+0421)", "the end of the expression".
    [[nodiscard]] std::string describe(std::size_t offset) const;
    /// A hint if the character at `offset` looks like a letter or mark of the language; otherwise empty.
    [[nodiscard]] std::string look_alike_hint(std::size_t offset) const;

  private:
    const ChannelSource* source_;
};

/// The candidate closest to `word` within two edits (one for short words); empty if there is none.
[[nodiscard]] std::string nearest(std::string_view word, const std::string_view* candidates, std::size_t count);

}  // namespace raylex::lpe
