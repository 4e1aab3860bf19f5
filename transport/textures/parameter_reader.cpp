#include "transport/textures/parameter_reader.h"

#include <array>
#include <charconv>
#include <cmath>

namespace raylex::transport {

/// The position of the parameter if it is known, else that of the set.
const SourceLocation& ParameterReader::place_of(std::string_view name) const {
    const Parameter* parameter = set_.find(name);
    return parameter != nullptr ? where(*parameter) : set_.location;
}

int ParameterReader::integer(std::string_view name, int fallback, int least, int most) {
    const std::int64_t value = take(set_.integer_or(name, fallback), static_cast<std::int64_t>(fallback));
    if (value >= least && value <= most) return static_cast<int>(value);
    fail(error_at(place_of(name), "parameter '" + std::string(name) + "' is " + std::to_string(value) + "; expected " +
                                      std::to_string(least) + " to " + std::to_string(most)));
    return fallback;
}

Real ParameterReader::real(std::string_view name, Real fallback, Real least, Real most) {
    const Real value = real(name, fallback);
    if (value >= least && value <= most) return value;
    const auto shown = [](Real number) {
        std::array<char, 32> text{};
        return std::string(text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr);
    };
    fail(error_at(place_of(name),
                  "parameter '" + std::string(name) + "' is " + shown(value) + "; expected " +
                      (std::isinf(most) ? shown(least) + " or more" : shown(least) + " to " + shown(most))));
    return fallback;
}

std::size_t ParameterReader::choice(std::string_view name, const std::vector<std::string>& known,
                                    std::size_t fallback) {
    const std::string found = string(name, known[fallback]);
    for (std::size_t i = 0; i < known.size(); ++i)
        if (known[i] == found) return i;
    std::string list;
    for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
    fail(error_at(place_of(name), "parameter '" + std::string(name) + "' is '" + found + "'; expected one of: " + list,
                  near_miss(found, known)));
    return fallback;
}

}  // namespace raylex::transport
