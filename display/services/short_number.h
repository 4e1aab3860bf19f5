// Numbers of any size in messages.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace raylex {

/// The first digits of it.
inline std::string short_number(double value, int digits = 3) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    return text.data();
}

}  // namespace raylex
