// Converts values to the types with which pbrt-v4 reads them. Code may pass an integer, `fov = 40`, and raylex's
// readers accept it; pbrt-v4 stops at "integer fov".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "transport/import/known_parameters.h"

namespace raylex::transport {

/// The declared type of a parameter; nothing if no table contains it.
std::optional<ParameterType> known_type(EntityKind kind, const std::string& type, std::string_view name);

/// Converts integers to floats where floats are expected, and one number to a grey rgb where a colour is expected; the
/// scene stays equivalent. Reflectances above 1 stay numbers, since rgb rejects them. `float_texture` is true for
/// textures of single numbers, whose inputs are numbers too.
void use_known_types(EntityKind kind, const std::string& type, bool float_texture, ParameterSet& set);

}  // namespace raylex::transport
