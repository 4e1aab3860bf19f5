// Formats tables for people in columns.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace raylex::experiments {

/// Pads `text` with blanks up to `width` characters. A longer text stays unchanged.
inline std::string padded(std::string text, std::size_t width) {
    text.resize(std::max(text.size(), width), ' ');
    return text;
}

}  // namespace raylex::experiments
