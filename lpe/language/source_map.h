// The origin of every byte of an expression. An expression often differs from the bytes of a file: strings have
// escapes, lines are continued, names are replaced by expressions. Errors still give the exact position in the file.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace raylex::lpe {

/// A text in memory, for the excerpts of errors.
struct TextFile {
    std::string name;  ///< path, or a description such as "built-in name 'diffuse'"
    std::string text;
    bool numbered = true;  ///< false: errors give no line number if the text has only one line (an argument of the
                           ///< command line)
};

struct TextPlace {
    int line = 1, column = 1;  ///< from 1; column in bytes; line 0 if lines are not numbered
    std::string line_text;     ///< empty when the line is too long to show
};

/// Line and column of byte `position` (at most the size of the text), and the text of that line.
[[nodiscard]] TextPlace place_of(const TextFile& file, std::size_t position);

struct SourceMap {
    /// The bytes of the expression from `offset` to the next span are those of `file` from `position`.
    struct Span {
        std::size_t offset = 0;
        std::shared_ptr<const TextFile> file;
        std::size_t position = 0;
        std::string via;  ///< e.g. "in the macro 'direct'"; empty in the expression itself
    };
    std::vector<Span> spans;  ///< ascending offsets, the first at 0

    /// The span that contains byte `offset`, which can be the end of the expression.
    [[nodiscard]] const Span& span_at(std::size_t offset) const;
};

}  // namespace raylex::lpe
