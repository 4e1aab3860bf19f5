// Parameters in code, by the types of pbrt's files: typed::real("fov", 40), typed::rgb("L", {1, 1, 1}).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "display/services/parameters.h"

namespace raylex::transport::typed {

/// A parameter of numbers: points and vectors coordinate by coordinate, sampled spectra in pairs (nm, value).
[[nodiscard]] inline Parameter numbers(std::string name, ParameterType type, std::vector<double> values) {
    Parameter parameter;
    parameter.name = std::move(name);
    parameter.type = type;
    parameter.numbers = std::move(values);
    return parameter;
}
[[nodiscard]] inline Parameter real(std::string name, double value) {
    return numbers(std::move(name), ParameterType::real, {value});
}
[[nodiscard]] inline Parameter integer(std::string name, std::int64_t value) {
    return numbers(std::move(name), ParameterType::integer, {static_cast<double>(value)});
}
[[nodiscard]] inline Parameter boolean(std::string name, bool value) {
    Parameter parameter = numbers(std::move(name), ParameterType::boolean, {});
    parameter.booleans = {static_cast<std::uint8_t>(value)};
    return parameter;
}
[[nodiscard]] inline Parameter text(std::string name, std::string value) {
    Parameter parameter = numbers(std::move(name), ParameterType::string, {});
    parameter.strings = {std::move(value)};
    return parameter;
}
/// A list of names, such as the "materials" of a mix.
[[nodiscard]] inline Parameter texts(std::string name, std::vector<std::string> values) {
    Parameter parameter = numbers(std::move(name), ParameterType::string, {});
    parameter.strings = std::move(values);
    return parameter;
}
/// A colour in the scene's colour space, linear.
[[nodiscard]] inline Parameter rgb(std::string name, const std::array<double, 3>& value) {
    return numbers(std::move(name), ParameterType::rgb, {value.begin(), value.end()});
}
[[nodiscard]] inline Parameter blackbody(std::string name, double kelvin) {
    return numbers(std::move(name), ParameterType::blackbody, {kelvin});
}
/// A spectrum by its name ("metal-Cu-eta") or by its file.
[[nodiscard]] inline Parameter spectrum(std::string name, std::string value) {
    Parameter parameter = text(std::move(name), std::move(value));
    parameter.type = ParameterType::spectrum;
    return parameter;
}
[[nodiscard]] inline Parameter point3(std::string name, const std::array<double, 3>& value) {
    return numbers(std::move(name), ParameterType::point3, {value.begin(), value.end()});
}
[[nodiscard]] inline Parameter point2(std::string name, const std::array<double, 2>& value) {
    return numbers(std::move(name), ParameterType::point2, {value.begin(), value.end()});
}
[[nodiscard]] inline Parameter vector2(std::string name, const std::array<double, 2>& value) {
    return numbers(std::move(name), ParameterType::vector2, {value.begin(), value.end()});
}
[[nodiscard]] inline Parameter vector3(std::string name, const std::array<double, 3>& value) {
    return numbers(std::move(name), ParameterType::vector3, {value.begin(), value.end()});
}
[[nodiscard]] inline Parameter normal(std::string name, const std::array<double, 3>& value) {
    return numbers(std::move(name), ParameterType::normal, {value.begin(), value.end()});
}
/// The name of a texture that gives the parameter's value.
[[nodiscard]] inline Parameter texture(std::string name, std::string texture_name) {
    Parameter parameter = text(std::move(name), std::move(texture_name));
    parameter.type = ParameterType::texture;
    return parameter;
}

}  // namespace raylex::transport::typed
