// Values in the type that pbrt-v4 reads them by. Code says numbers as they come, `fov = 40`, and raylex's readers take
// them; pbrt-v4 ends at "integer fov".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "transport/import/known_parameters.h"

namespace raylex::transport {

/// The type that a parameter is declared with; none for what no table knows.
std::optional<ParameterType> known_type(EntityKind kind, const std::string& type, std::string_view name);

/// Integers where floats are expected become floats, and one number where a colour is expected that grey in rgb: the
/// scene stays what it is. Reflectances above 1 stay numbers, as rgb refuses them. `float_texture`: of a texture of
/// single numbers, whose inputs are numbers too.
void use_known_types(EntityKind kind, const std::string& type, bool float_texture, ParameterSet& set);

}  // namespace raylex::transport
