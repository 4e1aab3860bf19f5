// Array parameters of shapes.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// The values of an array parameter; empty if it is absent. A parameter of another type is an Error.
Result<std::span<const double>> array_of(const ParameterSet& set, std::string_view name, ParameterType type,
                                         const char* type_name);
/// The position of the parameter, or of the directive if it is absent.
const SourceLocation& location_of(const ParameterSet& set, std::string_view name);
/// The values of a parameter as triples; the coordinates of points must be finite as floats.
Result<std::vector<StoredVec3>> triples(const ParameterSet& set, std::string_view name, ParameterType type,
                                        const char* type_name);
/// Indices, `group` per primitive, checked against `vertices`; 0 1 2 ... if they are absent and there is one primitive.
/// An incomplete primitive at the end is dropped, as in pbrt-v4, with a warning.
Result<std::vector<std::uint32_t>> indices_of(const ParameterSet& set, std::size_t vertices, std::size_t group,
                                              std::vector<Error>& warnings);

}  // namespace raylex::transport
