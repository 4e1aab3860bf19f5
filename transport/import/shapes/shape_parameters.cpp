#include "transport/import/shapes/shape_parameters.h"

#include <string>
#include <utility>

namespace raylex::transport {

Result<std::span<const double>> array_of(const ParameterSet& set, std::string_view name, ParameterType type,
                                         const char* type_name) {
    const Parameter* parameter = set.find(name);
    if (parameter == nullptr) return std::span<const double>();
    if (parameter->type != type)
        return error_at(parameter->location, "parameter '" + std::string(name) + "' has the wrong type; expected \"" +
                                                 type_name + " " + std::string(name) + "\"");
    return std::span<const double>(parameter->numbers);
}

const SourceLocation& location_of(const ParameterSet& set, std::string_view name) {
    const Parameter* parameter = set.find(name);
    return parameter != nullptr ? parameter->location : set.location;
}

Result<std::vector<StoredVec3>> triples(const ParameterSet& set, std::string_view name, ParameterType type,
                                        const char* type_name) {
    const Result<std::span<const double>> numbers = array_of(set, name, type, type_name);
    if (!numbers) return numbers.error();
    std::vector<StoredVec3> result(numbers->size() / 3);
    for (std::size_t i = 0; i < result.size(); ++i) {
        const double* n = numbers->data() + 3 * i;
        result[i] = {static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
        if (!is_finite(result[i]) && type != ParameterType::normal)
            return error_at(location_of(set, name), "vertex " + std::to_string(i) + " of '" + std::string(name) +
                                                        "' is beyond the range of float");
    }
    return result;
}

Result<std::vector<std::uint32_t>> indices_of(const ParameterSet& set, std::size_t vertices, std::size_t group,
                                              std::vector<Error>& warnings) {
    const Result<std::span<const double>> numbers = array_of(set, "indices", ParameterType::integer, "integer");
    if (!numbers) return numbers.error();
    std::vector<std::uint32_t> indices;
    if (numbers->empty()) {
        if (vertices != group)
            return error_at(set.location, "mesh of " + std::to_string(vertices) +
                                              " vertices has no \"integer indices\"; expected them, or exactly " +
                                              std::to_string(group) + " vertices");
        for (std::size_t i = 0; i < group; ++i) indices.push_back(static_cast<std::uint32_t>(i));
        return indices;
    }
    const SourceLocation& where = location_of(set, "indices");
    const std::size_t excess = numbers->size() % group, count = numbers->size() - excess;
    if (excess > 0) {
        Error uneven = error_at(where, "'indices' has " + std::to_string(numbers->size()) +
                                           " values; expected a multiple of " + std::to_string(group));
        if (count == 0) return uneven;
        uneven.message += ", and the last " + std::to_string(excess) + (excess == 1 ? " is" : " are") + " ignored";
        warnings.push_back(std::move(uneven));
    }
    indices.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double value = (*numbers)[i];
        if (value < 0 || value >= static_cast<double>(vertices))
            return error_at(where, "index " + std::to_string(static_cast<std::int64_t>(value)) + " (value " +
                                       std::to_string(i) + " of 'indices') is out of range; expected 0 to " +
                                       std::to_string(static_cast<std::int64_t>(vertices) - 1));
        indices.push_back(static_cast<std::uint32_t>(value));
    }
    return indices;
}

}  // namespace raylex::transport
