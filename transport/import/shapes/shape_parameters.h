// Arrays among a shape's parameters.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// The values of an array parameter, where `set` has them, or an Error when it has another type. Absent: no values.
Result<std::span<const double>> array_of(const ParameterSet& set, std::string_view name, ParameterType type,
                                         const char* type_name);
/// Where the parameter stands, or the whole directive.
const SourceLocation& location_of(const ParameterSet& set, std::string_view name);
/// Three values each; those of points must be finite as floats.
Result<std::vector<StoredVec3>> triples(const ParameterSet& set, std::string_view name, ParameterType type,
                                        const char* type_name);
/// Indices of `group` per primitive, checked against `vertices`; 0 1 2 ... when absent and there is one primitive.
/// Those that do not make a whole one at the end are left out, as in pbrt-v4, with a warning.
Result<std::vector<std::uint32_t>> indices_of(const ParameterSet& set, std::size_t vertices, std::size_t group,
                                              std::vector<Error>& warnings);

}  // namespace raylex::transport
