// What the readers of channel files share: positions that become lines and columns, strings that know where each of
// their bytes stood.
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

/// A string of a file after its escapes are resolved.
class MappedText {
  public:
    /// Appends a byte that stands at `position` of the file.
    void append(char c, std::size_t position);
    [[nodiscard]] const std::string& text() const { return text_; }
    /// Where byte `offset` stands in the file; the end of the text counts.
    [[nodiscard]] std::size_t position(std::size_t offset) const;
    void start(std::size_t position) { start_ = position; }

  private:
    friend class FileText;
    struct Run {
        std::size_t offset, position;
    };
    std::string text_;
    std::vector<Run> runs_;  // bytes that stand side by side in the file
    std::size_t start_ = 0;  // where the first byte would stand
};

/// A file's text under a cursor.
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
    /// The rest of the line, without its end; the cursor moves behind the line's end.
    std::string_view take_line();

    [[nodiscard]] int line_of(std::size_t position) const;
    [[nodiscard]] int column_of(std::size_t position) const;
    [[noreturn]] void fail_at(std::size_t position, std::string message, std::string hint = {}) const;
    /// An error of a single channel: the reader goes on, and return_or_throw() has it.
    void note(std::size_t position, std::string message, std::string hint = {});
    /// Notes a word that is none of the known ones; `what` is what it stands for.
    void note_unless_known(std::size_t position, const std::string& what, std::string_view word,
                           std::span<const std::string_view> known);
    /// The file where no error was noted. Throws ChannelErrors.
    ChannelFile return_or_throw(ChannelFile file);
    /// What stands at `position`, for a message.
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

/// "color lpe:CD<L.>" and "lpe:CD<L.>": the offset of what follows "lpe:", or npos when it is not there.
[[nodiscard]] std::size_t expression_offset(std::string_view source);

/// In double quotes with escapes, as RIB, USD and TOML write strings.
[[nodiscard]] std::string quoted(std::string_view text);
/// Lines of comment behind their mark, each with its end.
[[nodiscard]] std::string commented(const std::string& comment, const std::string& mark);

}  // namespace raylex::lpe
