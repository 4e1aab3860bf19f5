#include "display/services/parameters.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace raylex {

const char* type_name(ParameterType type) {
    switch (type) {
        case ParameterType::boolean:
            return "bool";
        case ParameterType::integer:
            return "integer";
        case ParameterType::real:
            return "float";
        case ParameterType::string:
            return "string";
        case ParameterType::rgb:
            return "rgb";
        case ParameterType::blackbody:
            return "blackbody";
        case ParameterType::spectrum:
            return "spectrum";
        case ParameterType::point2:
            return "point2";
        case ParameterType::vector2:
            return "vector2";
        case ParameterType::point3:
            return "point3";
        case ParameterType::vector3:
            return "vector3";
        case ParameterType::normal:
            return "normal";
        case ParameterType::texture:
            return "texture";
    }
    return "value";
}

namespace {

/// Nobody types longer names, and a comparison costs the product of the lengths.
constexpr std::size_t longest_compared = 256;
/// Nobody reads longer quotations to their end; lists of expected names are shorter.
constexpr std::size_t longest_message = 4000;

/// Keeps the beginning and the end of a text that is too long; cuts between UTF-8 characters.
void shorten(std::string& text) {
    if (text.size() <= longest_message) return;
    const auto within = [&](std::size_t i) { return (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80; };
    std::size_t begin = 200, end = text.size() - 400;
    while (begin > 0 && within(begin)) --begin;
    while (end < text.size() && within(end)) ++end;
    text.replace(begin, end - begin, "...[" + std::to_string(end - begin) + " bytes]...");
}

std::size_t value_count(const Parameter& parameter) {
    if (parameter.type == ParameterType::boolean) return parameter.booleans.size();
    return parameter.numbers.size() + parameter.strings.size();
}

/// An Error unless `parameter` has exactly one value, of a type that the caller accepts (`type_fits`).
Status require_single(const Parameter& parameter, const SourceLocation& set_location, ParameterType expected,
                      bool type_fits) {
    const SourceLocation& where = parameter.location.line != 0 ? parameter.location : set_location;
    if (!type_fits)
        return error_at(where, "parameter '" + parameter.name + "' has type " + type_name(parameter.type) +
                                   "; expected one " + type_name(expected));
    if (value_count(parameter) != 1)
        return error_at(where, "parameter '" + parameter.name + "' has " + std::to_string(value_count(parameter)) +
                                   " values; expected one " + type_name(expected));
    return success();
}

char lower(char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

}  // namespace

/// Longer names are equal, or differ in all of their letters.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    if (std::max(a.size(), b.size()) > longest_compared)
        return lower_case(a) == lower_case(b) ? 0 : std::max(a.size(), b.size());
    const std::size_t columns = b.size() + 1;
    std::vector<std::size_t> before(columns), above(columns), row(columns);
    std::iota(above.begin(), above.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const bool same = lower(a[i - 1]) == lower(b[j - 1]);
            row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (same ? 0 : 1)});
            if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]))
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
        before.swap(above);
        above.swap(row);
    }
    return above[b.size()];
}

Error error_at(const SourceLocation& where, std::string message, std::string hint) {
    Error error;
    error.message = std::move(message);
    shorten(error.message);
    error.file = where.file;
    error.line = where.line;
    error.column = where.column;
    error.hint = std::move(hint);
    shorten(error.hint);
    return error;
}

Error named_by(Error error, std::string_view what, const SourceLocation& where) {
    if (!error.hint.empty()) error.hint += "; ";
    error.hint += "named by " + std::string(what);
    if (!where.file.empty()) error.hint += " at " + where.file + ":" + std::to_string(where.line);
    return error;
}

const Parameter* ParameterSet::find(std::string_view name) const {
    for (const Parameter& parameter : parameters) {
        if (parameter.name != name) continue;
        parameter.used = true;
        return &parameter;
    }
    return nullptr;
}

// An integer is accepted as a real: "radius = 2" in TOML means 2.0.
Result<double> ParameterSet::real_or(std::string_view name, double fallback) const {
    const Parameter* parameter = find(name);
    if (parameter == nullptr) return fallback;
    const bool fits = parameter->type == ParameterType::real || parameter->type == ParameterType::integer;
    if (Status status = require_single(*parameter, location, ParameterType::real, fits); !status) return status.error();
    const double value = parameter->numbers.front();
    // Most users of numbers store them as float, where this one would silently become infinite.
    if (std::isfinite(value) && std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
        return error_at(parameter->location.line != 0 ? parameter->location : location,
                        "parameter '" + parameter->name + "' is beyond the range of float; expected less than 3.4e38");
    return value;
}

Result<std::int64_t> ParameterSet::integer_or(std::string_view name, std::int64_t fallback) const {
    const Parameter* parameter = find(name);
    if (parameter == nullptr) return fallback;
    if (Status status =
            require_single(*parameter, location, ParameterType::integer, parameter->type == ParameterType::integer);
        !status)
        return status.error();
    const double value = parameter->numbers.front();
    // 2^53: the largest range in which a double holds every integer.
    if (!(std::abs(value) <= 9007199254740992.0) || value != std::floor(value))
        return error_at(parameter->location.line != 0 ? parameter->location : location,
                        "parameter '" + parameter->name + "' is out of range; expected an integer of at most 2^53");
    return static_cast<std::int64_t>(value);
}

Result<bool> ParameterSet::boolean_or(std::string_view name, bool fallback) const {
    const Parameter* parameter = find(name);
    if (parameter == nullptr) return fallback;
    if (Status status =
            require_single(*parameter, location, ParameterType::boolean, parameter->type == ParameterType::boolean);
        !status)
        return status.error();
    return parameter->booleans.front() != 0;
}

Result<std::string> ParameterSet::string_or(std::string_view name, std::string_view fallback) const {
    const Parameter* parameter = find(name);
    if (parameter == nullptr) return std::string(fallback);
    if (Status status =
            require_single(*parameter, location, ParameterType::string, parameter->type == ParameterType::string);
        !status)
        return status.error();
    return parameter->strings.front();
}

Result<std::string> ParameterSet::choice_or(std::string_view name, std::string_view fallback,
                                            const std::vector<std::string>& choices) const {
    auto chosen = string_or(name, fallback);
    if (!chosen || std::find(choices.begin(), choices.end(), *chosen) != choices.end()) return chosen;
    std::string list;
    for (std::size_t i = 0; i < choices.size(); ++i)
        list += (i == 0 ? "" : i + 1 == choices.size() ? " or " : ", ") + choices[i];
    return error_at(find(name)->location, "'" + std::string(name) + "' is '" + *chosen + "'; expected " + list,
                    near_miss(*chosen, choices));
}

std::vector<const Parameter*> ParameterSet::unused() const {
    std::vector<const Parameter*> result;
    for (const Parameter& parameter : parameters)
        if (!parameter.used) result.push_back(&parameter);
    return result;
}

std::string lower_case(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return result;
}

// A typo changes at most a third of the word's letters, at least one is always allowed, but never all of them. Ties go
// to the candidate listed first.
std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates) {
    std::string best;
    std::size_t best_distance = std::max<std::size_t>(1, word.size() / 3) + 1;
    for (const std::string& candidate : candidates) {
        // The number of inserted or deleted letters is a lower bound of the distance.
        const std::size_t longer = std::max(word.size(), candidate.size()),
                          shorter = std::min(word.size(), candidate.size());
        if (longer - shorter >= best_distance) continue;
        const std::size_t distance = edit_distance(word, candidate);
        if (distance >= best_distance || distance >= longer) continue;
        best_distance = distance;
        best = candidate;
    }
    return best;
}

std::string near_miss(std::string_view word, const std::vector<std::string>& candidates) {
    const std::string near = nearest_name(word, candidates);
    return near.empty() ? std::string() : "did you mean '" + near + "'?";
}

}  // namespace raylex
