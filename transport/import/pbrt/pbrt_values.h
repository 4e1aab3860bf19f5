// Writes values for pbrt files, with the digits that are read back as the same number.
#pragma once

#include <string>

#include "transport/math/transform.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

void append_number(std::string& text, double value);
/// Appends a float, with fewer digits: they only need to be read back as the same float.
void append_number(std::string& text, float value);
[[nodiscard]] std::string quoted(const std::string& text);
/// "[m00 m10 ...]", column by column.
[[nodiscard]] std::string matrix_text(const Matrix4& matrix);
/// ` "float radius" 2` for each parameter of the set.
[[nodiscard]] std::string parameters_text(const ParameterSet& set);
/// The parameters of a shape; its mesh is written inline.
[[nodiscard]] std::string shape_text(const SceneShape& shape, bool reverse_orientation);
/// The displacement of a plymesh; empty if it has none.
[[nodiscard]] std::string displacement_text(const SceneShape& shape);
/// The parameters of one curve of a group.
[[nodiscard]] std::string curve_text(const SceneShape& shape, std::size_t number);
/// The parameter "alpha", which every kind of shape has.
[[nodiscard]] std::string alpha_text(const SceneShape& shape);
/// The mesh as a binary PLY file.
[[nodiscard]] std::string ply_content(const SceneShape& shape, bool reverse_orientation);

}  // namespace raylex::transport
