// Tensor files, which RGL's measured materials come in: named arrays of any shape (Dupuy and Jakob 2018; the format of
// their supplemental "powitacq"). Little-endian: "tensor_file", a zero byte, a version of two bytes (1, 0) and a count
// of fields; then of each its name, rank, type, where its values begin, and its shape.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "lpe/result.h"

namespace raylex::transport {

struct Tensor {
    std::vector<std::size_t> shape;
    std::vector<float> values;  ///< row-major: the last index runs fastest
};

/// The fields of numbers of the file at `path`, by name; others are passed over. Damage is an Error that names it.
Result<std::map<std::string, Tensor>> read_tensor_file(const std::string& path);

}  // namespace raylex::transport
