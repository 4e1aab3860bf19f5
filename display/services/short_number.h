// Formats numbers of any size for messages.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace raylex {

/// The leading `digits` digits of the number.
inline std::string short_number(double value, int digits = 3) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    return text.data();
}

}  // namespace raylex
