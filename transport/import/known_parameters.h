// Which parameters each type takes in a scene file. pbrt-v4 ends when it finds one that nobody reads, and so does
// raylex; one that pbrt reads and raylex does not is a warning.
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

/// "`kind` 'TYPE' has no parameter 'NAME'; expected one of: ...", with the near miss, at the parameter's place.
Error unknown_parameter(const std::string& kind, const std::string& type, const Parameter& parameter,
                        const std::vector<std::string>& known);

/// What a plugin or an in-tree type says that it takes; null when it is not registered.
const std::vector<ParameterDescription>* declared_parameters(EntityKind kind, const std::string& type);

/// Judges the parameters of one scene. What a type takes is what its registry entry declares and what the table in
/// known_parameters.cpp adds; a type that neither knows is left to whoever refuses it by name.
class ParameterChecker {
  public:
    /// The first `own` parameters of `set` stand at the directive itself and must be known; the others come from
    /// Attribute and, as in pbrt, may mean nothing to this type: those are taken out. A parameter that pbrt-v4 reads
    /// and raylex does not adds a warning, the first time for its kind and type, and counts as used.
    Status check(EntityKind kind, const std::string& type, ParameterSet& set, std::size_t own,
                 std::vector<Error>& warnings);

  private:
    std::set<std::string> said_;  ///< warnings so far
};

}  // namespace raylex::transport
