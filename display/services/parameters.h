// Typed, located parameters: how scene files, TOML jobs and command lines hand settings to anything in a Registry.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/rgb.h"
#include "lpe/result.h"

namespace raylex {

/// Where a user wrote something; `line` and `column` count from 1, 0 = not known.
struct SourceLocation {
    std::string file;
    int line = 0;
    int column = 0;
};

/// An Error at `where`.
Error error_at(const SourceLocation& where, std::string message, std::string hint = {});
/// The Error of a file that something at `where` names: its hint says so as "named by `what` at file:line".
Error named_by(Error error, std::string_view what, const SourceLocation& where);

enum class ParameterType : std::uint8_t {
    boolean,
    integer,
    real,
    string,
    rgb,
    blackbody,
    spectrum,
    point2,
    vector2,
    point3,
    vector3,
    normal,
    texture
};

/// As scene files write it: "float", "point3", ...
[[nodiscard]] const char* type_name(ParameterType type);

/// One named parameter as the user wrote it. Numbers are kept as double: exact for every int32 and float.
struct Parameter {
    std::string name;
    ParameterType type = ParameterType::real;
    std::vector<double> numbers;       ///< real, integer, rgb, blackbody (kelvin), points, sampled spectra (pairs)
    std::vector<std::string> strings;  ///< string, texture name, named or file spectrum
    std::vector<std::uint8_t> booleans;
    SourceLocation location;
    mutable bool used = false;  ///< set by every look-up; what stays false is reported as unknown
};

/// The parameters of one object. Look-ups mark a parameter as used; the `_or` forms fall back when it is absent.
/// A parameter of the wrong type or count is an Error naming both.
class ParameterSet {
  public:
    std::vector<Parameter> parameters;
    SourceLocation location;  ///< of the directive that opened the set

    [[nodiscard]] const Parameter* find(std::string_view name) const;
    [[nodiscard]] Result<double> real_or(std::string_view name, double fallback) const;
    [[nodiscard]] Result<std::int64_t> integer_or(std::string_view name, std::int64_t fallback) const;
    [[nodiscard]] Result<bool> boolean_or(std::string_view name, bool fallback) const;
    [[nodiscard]] Result<std::string> string_or(std::string_view name, std::string_view fallback) const;
    /// One of `choices`. Errors stand at the parameter and name the near miss.
    [[nodiscard]] Result<std::string> choice_or(std::string_view name, std::string_view fallback,
                                                const std::vector<std::string>& choices) const;
    /// Names never looked up, in the order written.
    [[nodiscard]] std::vector<const Parameter*> unused() const;
};

/// One row of what a registered object accepts: feeds `--help`, strict TOML, near misses and sweeps.
struct ParameterDescription {
    std::string name;
    ParameterType type = ParameterType::real;
    std::string fallback;  ///< default, as the user would write it
    std::string help;      ///< one line: meaning, unit, range
};

/// The text with A to Z in lower case; other bytes stay.
std::string lower_case(std::string_view text);

/// Optimal string alignment distance (insert, delete, replace, swap neighbours), letter case ignored.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate nearest to `word` by edit distance, or empty when none is close enough to be a likely slip.
std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates);

/// The same as an error's hint: "did you mean 'NAME'?", or empty.
std::string near_miss(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace raylex
