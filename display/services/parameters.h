// Typed parameters with positions, through which scene files, TOML jobs and command lines pass settings to objects of a
// Registry.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/rgb.h"
#include "lpe/result.h"

namespace raylex {

/// A position in user input; `line` and `column` count from 1, 0 = unknown.
struct SourceLocation {
    std::string file;
    int line = 0;
    int column = 0;
};

/// An Error at `where`.
Error error_at(const SourceLocation& where, std::string message, std::string hint = {});
/// Completes the Error of a file that is named at `where`: its hint gets "named by `what` at file:line".
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

/// The name of a type in scene files: "float", "point3", ...
[[nodiscard]] const char* type_name(ParameterType type);

/// One named parameter of a user. Numbers are stored as double: exact for every int32 and float.
struct Parameter {
    std::string name;
    ParameterType type = ParameterType::real;
    std::vector<double> numbers;       ///< real, integer, rgb, blackbody (kelvin), points, sampled spectra (pairs)
    std::vector<std::string> strings;  ///< string, texture name, named or file spectrum
    std::vector<std::uint8_t> booleans;
    SourceLocation location;
    mutable bool used = false;  ///< every look-up sets it; parameters without it are reported as unknown
};

/// The parameters of one object. Look-ups mark a parameter as used; the `_or` functions return a default if it is
/// absent. A parameter of the wrong type or count is an Error that names both types or counts.
class ParameterSet {
  public:
    std::vector<Parameter> parameters;
    SourceLocation location;  ///< position of the directive that opened the set

    [[nodiscard]] const Parameter* find(std::string_view name) const;
    [[nodiscard]] Result<double> real_or(std::string_view name, double fallback) const;
    [[nodiscard]] Result<std::int64_t> integer_or(std::string_view name, std::int64_t fallback) const;
    [[nodiscard]] Result<bool> boolean_or(std::string_view name, bool fallback) const;
    [[nodiscard]] Result<std::string> string_or(std::string_view name, std::string_view fallback) const;
    /// Looks up one of `choices`. Errors are at the parameter and suggest a similar choice.
    [[nodiscard]] Result<std::string> choice_or(std::string_view name, std::string_view fallback,
                                                const std::vector<std::string>& choices) const;
    /// The parameters that were never looked up, in the order of the input.
    [[nodiscard]] std::vector<const Parameter*> unused() const;
};

/// One parameter of a registered object, for `--help`, strict TOML, near misses and sweeps.
struct ParameterDescription {
    std::string name;
    ParameterType type = ParameterType::real;
    std::string fallback;  ///< default, in the user's notation
    std::string help;      ///< one line: meaning, unit, range
};

/// The text with A to Z in lower case; other bytes are unchanged.
std::string lower_case(std::string_view text);

/// The optimal string alignment distance (insert, delete, replace, swap neighbours), ignoring case.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate with the smallest edit distance to `word`, or empty if none is close enough to be a typo.
std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates);

/// The hint of an error: "did you mean 'NAME'?", or empty.
std::string near_miss(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace raylex
