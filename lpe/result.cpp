#include "lpe/result.h"

#include <algorithm>
#include <cstddef>

namespace raylex {

namespace {

/// Blanks up to byte `column`: tabs are kept, and each UTF-8 character gives one blank, so that the caret lines up.
std::string caret_indent(const std::string& excerpt, int column) {
    std::string indent;
    const std::size_t bytes = std::min(excerpt.size(), static_cast<std::size_t>(column - 1));
    for (std::size_t i = 0; i < bytes; ++i) {
        const auto byte = static_cast<unsigned char>(excerpt[i]);
        if ((byte & 0xC0U) != 0x80U) { indent += byte == '\t' ? '\t' : ' '; }
    }
    indent.append(static_cast<std::size_t>(column - 1) - bytes, ' ');
    return indent;
}

}  // namespace

std::string Error::to_string() const {
    std::string text = file;
    if (line > 0) {
        text += (text.empty() ? "line " : ":") + std::to_string(line);
        if (column > 0) {
            text += ':';
            text += std::to_string(column);
        }
    } else if (column > 0) {
        text += (text.empty() ? "column " : ": column ") + std::to_string(column);
    }
    if (!text.empty()) { text += ": "; }
    text += message;
    if (!excerpt.empty()) {
        text += "\n  " + excerpt;
        // A caret far beyond the excerpt would only disturb the terminal.
        if (column > 0 && static_cast<std::size_t>(column) <= excerpt.size() + 1) {
            text += "\n  " + caret_indent(excerpt, column) + "^";
        }
    }
    if (!hint.empty()) { text += "\n" + hint; }
    return text;
}

}  // namespace raylex
