// Tensor files, the format of RGL's measured materials: named arrays of any shape (Dupuy and Jakob 2018; the format of
// their supplemental "powitacq"). Little-endian: "tensor_file", a zero byte, a version of two bytes (1, 0) and the
// number of fields; then for each field its name, rank, type, the offset of its values, and its shape.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "lpe/result.h"

namespace raylex::transport {

struct Tensor {
    std::vector<std::size_t> shape;
    std::vector<float> values;  ///< row-major: the last index varies fastest
};

/// Reads the numeric fields of the file at `path`, by name, and skips others. Errors describe the damage.
Result<std::map<std::string, Tensor>> read_tensor_file(const std::string& path);

}  // namespace raylex::transport
