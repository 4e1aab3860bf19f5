// Numbers of any size in messages.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace raylex {

/// Three digits of it.
inline std::string short_number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return text.data();
}

}  // namespace raylex
