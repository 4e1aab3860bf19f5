// Values as pbrt's files write them, with the digits that read back as the same number.
#pragma once

#include <string>

#include "transport/math/transform.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

void append_number(std::string& text, double value);
/// Shorter: it needs to read back as the same float only.
void append_number(std::string& text, float value);
[[nodiscard]] std::string quoted(const std::string& text);
/// "[m00 m10 ...]", column by column.
[[nodiscard]] std::string matrix_text(const Matrix4& matrix);
/// ` "float radius" 2`, for each in turn.
[[nodiscard]] std::string parameters_text(const ParameterSet& set);
/// The parameters of a shape, those of its mesh inline.
[[nodiscard]] std::string shape_text(const SceneShape& shape, bool reverse_orientation);
/// Of a plymesh, nothing where it is not displaced.
[[nodiscard]] std::string displacement_text(const SceneShape& shape);
/// The parameters of one curve of a group.
[[nodiscard]] std::string curve_text(const SceneShape& shape, std::size_t number);
/// The parameter that every kind of shape has.
[[nodiscard]] std::string alpha_text(const SceneShape& shape);
/// The mesh as a binary PLY file.
[[nodiscard]] std::string ply_content(const SceneShape& shape, bool reverse_orientation);

}  // namespace raylex::transport
