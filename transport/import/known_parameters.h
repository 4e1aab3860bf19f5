// The parameters that each type accepts in a scene file. Like pbrt-v4, raylex stops with an error at an unknown
// parameter. A parameter that pbrt reads and raylex does not is a warning.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "display/services/parameters.h"

namespace raylex::transport {

enum class EntityKind : std::uint8_t {
    accelerator,
    area_light,
    camera,
    film,
    integrator,
    light,
    material,
    medium,
    pixel_filter,
    sampler,
    shape,
    texture
};

/// The error "`kind` 'TYPE' has no parameter 'NAME'; expected one of: ...", with the closest match, at the parameter.
Error unknown_parameter(const std::string& kind, const std::string& type, const Parameter& parameter,
                        const std::vector<std::string>& known);

/// The parameters that the registry entry of a plugin or built-in type declares; null if the type is not registered.
const std::vector<ParameterDescription>* declared_parameters(EntityKind kind, const std::string& type);

/// Checks the parameters of one scene. A type accepts the parameters of its registry entry and those of the table in
/// known_parameters.cpp. Types that are in neither are left to the code that rejects unknown types.
class ParameterChecker {
  public:
    /// Checks a set. Its first `own` parameters belong to the directive itself and must be known. The others come from
    /// Attribute and, as in pbrt, may be unknown to this type; those are removed. A parameter that pbrt-v4 reads and
    /// raylex does not adds a warning, once for its kind and type, and counts as used.
    Status check(EntityKind kind, const std::string& type, ParameterSet& set, std::size_t own,
                 std::vector<Error>& warnings);

  private:
    std::set<std::string> said_;  ///< warnings so far
};

}  // namespace raylex::transport
