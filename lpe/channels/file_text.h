// Helpers of the readers of channel files: conversion of positions to lines and columns, and strings that keep the file
// position of each byte.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/channels/channel_file.h"
#include "lpe/language/source_map.h"
#include "lpe/program.h"

namespace raylex::lpe {

inline constexpr std::array<std::string_view, 4> statistics_names{"variance", "mse", "even", "odd"};

/// A string of a file with its escapes resolved.
class MappedText {
  public:
    /// Appends a byte whose position in the file is `position`.
    void append(char c, std::size_t position);
    [[nodiscard]] const std::string& text() const { return text_; }
    /// The position in the file of byte `offset`; `offset` can be the length of the text.
    [[nodiscard]] std::size_t position(std::size_t offset) const;
    void start(std::size_t position) { start_ = position; }

  private:
    friend class FileText;
    struct Run {
        std::size_t offset, position;
    };
    std::string text_;
    std::vector<Run> runs_;  // runs of bytes that are adjacent in the file
    std::size_t start_ = 0;  // position of the first byte
};

/// The text of a file with a cursor.
class FileText {
  public:
    FileText(std::string_view text, const std::string& origin);

    [[nodiscard]] std::string_view text() const { return file_->text; }
    [[nodiscard]] const std::string& origin() const { return file_->name; }
    [[nodiscard]] bool at_end() const { return position_ >= file_->text.size(); }
    [[nodiscard]] std::size_t position() const { return position_; }
    void move_to(std::size_t position) { position_ = position; }
    [[nodiscard]] char peek(std::size_t ahead = 0) const {
        return position_ + ahead < file_->text.size() ? file_->text[position_ + ahead] : '\0';
    }
    [[nodiscard]] bool starts_with(std::string_view mark) const { return text().substr(position_).starts_with(mark); }
    /// Returns the rest of the line without its line end, and moves the cursor after the line end.
    std::string_view take_line();

    [[nodiscard]] int line_of(std::size_t position) const;
    [[nodiscard]] int column_of(std::size_t position) const;
    [[noreturn]] void fail_at(std::size_t position, std::string message, std::string hint = {}) const;
    /// Records an error of a single channel. The reader continues; return_or_throw() throws the recorded errors.
    void note(std::size_t position, std::string message, std::string hint = {});
    /// Records an error if the word is none of the known ones; `what` names the kind of word.
    void note_unless_known(std::size_t position, const std::string& what, std::string_view word,
                           std::span<const std::string_view> known);
    /// Returns the file if no error was recorded. Throws ChannelErrors otherwise.
    ChannelFile return_or_throw(ChannelFile file);
    /// A description of the byte at `position` for a message.
    [[nodiscard]] std::string describe(std::size_t position) const;

    /// The channel or macro whose expression is `text` from byte `offset` on.
    [[nodiscard]] ChannelSource source(std::string name, const MappedText& text, std::size_t offset = 0) const;

  private:
    [[nodiscard]] Error error_at(std::size_t position, std::string message, std::string hint) const;

    std::shared_ptr<const TextFile> file_;
    std::vector<Error> errors_;
    std::size_t position_ = 0;
    std::vector<std::size_t> line_begins_;
};

/// The offset of the expression after "lpe:" in "color lpe:CD<L.>" or "lpe:CD<L.>"; npos when there is no "lpe:".
[[nodiscard]] std::size_t expression_offset(std::string_view source);

/// The text in double quotes with escapes, in the notation of RIB, USD and TOML.
[[nodiscard]] std::string quoted(std::string_view text);
/// Comment lines, each with the comment mark before it and a line end after it.
[[nodiscard]] std::string commented(const std::string& comment, const std::string& mark);

}  // namespace raylex::lpe
