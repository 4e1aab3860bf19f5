// Scene descriptions written in C++, for tests that must not depend on the importer.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "transport/scene/scene_description.h"

namespace raylex::test {

inline Parameter parameter(ParameterType type, std::string name, std::vector<double> numbers, int line = 7) {
    Parameter p;
    p.name = std::move(name);
    p.type = type;
    p.numbers = std::move(numbers);
    p.location = {"scene.pbrt", line, 3};
    return p;
}
inline Parameter rgb(std::string name, double r, double g, double b) {
    return parameter(ParameterType::rgb, std::move(name), {r, g, b});
}
inline Parameter real(std::string name, double value) {
    return parameter(ParameterType::real, std::move(name), {value});
}
inline Parameter text(ParameterType type, std::string name, std::vector<std::string> strings) {
    Parameter p = parameter(type, std::move(name), {});
    p.strings = std::move(strings);
    return p;
}
inline Parameter texture(std::string name, std::string value) {
    return text(ParameterType::texture, std::move(name), {std::move(value)});
}
inline Parameter string(std::string name, std::string value) {
    return text(ParameterType::string, std::move(name), {std::move(value)});
}
inline Parameter boolean(std::string name, bool value) {
    Parameter p = parameter(ParameterType::boolean, std::move(name), {});
    p.booleans = {static_cast<std::uint8_t>(value)};
    return p;
}

template <class Entity = transport::SceneEntity>
Entity entity(std::string type, std::vector<Parameter> parameters, std::string name = {}) {
    Entity e;
    e.type = std::move(type);
    e.name = std::move(name);
    e.location = {"scene.pbrt", 5, 1};
    e.parameters.parameters = std::move(parameters);
    e.parameters.location = e.location;
    return e;
}
inline transport::SceneTexture colour_texture(std::string type, std::string name, std::vector<Parameter> parameters) {
    auto t = entity<transport::SceneTexture>(std::move(type), std::move(parameters), std::move(name));
    t.spectrum = true;
    return t;
}
inline transport::SceneTexture real_texture(std::string type, std::string name, std::vector<Parameter> parameters) {
    return entity<transport::SceneTexture>(std::move(type), std::move(parameters), std::move(name));
}

}  // namespace raylex::test
