#include "transport/materials/parameter_reader.h"

namespace raylex::transport {

int ParameterReader::integer(std::string_view name, int fallback, int least, int most) {
    const std::int64_t value = take(set_.integer_or(name, fallback), static_cast<std::int64_t>(fallback));
    if (value >= least && value <= most) return static_cast<int>(value);
    const Parameter* parameter = set_.find(name);
    fail(error_at(parameter != nullptr ? where(*parameter) : set_.location,
                  "parameter '" + std::string(name) + "' is " + std::to_string(value) + "; expected " +
                      std::to_string(least) + " to " + std::to_string(most)));
    return fallback;
}

std::size_t ParameterReader::choice(std::string_view name, const std::vector<std::string>& known, std::size_t fallback) {
    const std::string found = string(name, known[fallback]);
    for (std::size_t i = 0; i < known.size(); ++i)
        if (known[i] == found) return i;
    std::string list;
    for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
    const std::string near = nearest_name(found, known);
    const Parameter* parameter = set_.find(name);
    fail(error_at(parameter != nullptr ? where(*parameter) : set_.location,
                  "parameter '" + std::string(name) + "' is '" + found + "'; expected one of: " + list,
                  near.empty() ? std::string() : "did you mean '" + near + "'?"));
    return fallback;
}

}  // namespace raylex::transport
