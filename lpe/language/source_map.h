// Where every byte of an expression came from. Expressions are rarely the bytes that stand in a file: strings have
// escapes, lines are continued, names stand for whole expressions. An error inside one still points at the very byte.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace raylex::lpe {

/// A text as it was read, kept for the excerpts of errors.
struct TextFile {
    std::string name;  ///< path, or a description such as "built-in name 'diffuse'"
    std::string text;
    bool numbered = true;  ///< false: errors name no line where the text has only one (an argument of the command line)
};

struct TextPlace {
    int line = 1, column = 1;  ///< from 1; the column counts bytes; line 0 where lines are not numbered
    std::string line_text;     ///< empty when the line is too long to show
};

/// The line and column of byte `position` (at most the size of the text), and the text of that line.
[[nodiscard]] TextPlace place_of(const TextFile& file, std::size_t position);

struct SourceMap {
    /// The bytes of the expression from `offset` to the next span stand in `file` from `position` on.
    struct Span {
        std::size_t offset = 0;
        std::shared_ptr<const TextFile> file;
        std::size_t position = 0;
        std::string via;  ///< e.g. "in the macro 'direct'"; empty in the expression itself
    };
    std::vector<Span> spans;  ///< ascending offsets, the first at 0

    /// The span that byte `offset` is in; `offset` may be the end of the expression.
    [[nodiscard]] const Span& span_at(std::size_t offset) const;
};

}  // namespace raylex::lpe
