// Tables for people, in columns.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace raylex::experiments {

/// With spaces behind it up to `width`; texts that are wider stay as they are.
inline std::string padded(std::string text, std::size_t width) {
    text.resize(std::max(text.size(), width), ' ');
    return text;
}

}  // namespace raylex::experiments
