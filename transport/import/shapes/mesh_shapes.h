// Meshes: from parameters or a file to checked vertices, in the space of the parameters or file.
#pragma once

#include "transport/import/shapes/shapes.h"

namespace raylex::transport {

Result<std::vector<SceneShape>> make_triangle_mesh(const ParameterSet& parameters, const ShapeContext& context,
                                                   std::vector<Error>& warnings);
Result<std::vector<SceneShape>> make_bilinear_mesh(const ParameterSet& parameters, const ShapeContext& context,
                                                   std::vector<Error>& warnings);
Result<std::vector<SceneShape>> make_ply_mesh(const ParameterSet& parameters, const ShapeContext& context,
                                              std::vector<Error>& warnings);

}  // namespace raylex::transport
