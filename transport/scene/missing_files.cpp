#include "transport/scene/missing_files.h"

#include <array>

#include "transport/scene/typed_parameters.h"

namespace raylex::transport {
namespace {

constexpr std::array<double, 3> magenta{1, 0, 1};

void drop(SceneEntity& entity, const std::string& name) {
    std::erase_if(entity.parameters.parameters, [&](const Parameter& each) { return each.name == name; });
}

void give(SceneEntity& entity, Parameter parameter) {
    parameter.location = entity.location;
    drop(entity, parameter.name);
    entity.parameters.parameters.push_back(std::move(parameter));
}

}  // namespace

bool make_placeholder(SceneEntity& entity, const Parameter& parameter, bool is_float_texture) {
    if (parameter.name == "normalmap") {
        drop(entity, "normalmap");
        return true;
    }
    if (parameter.name != "filename") return false;
    if (entity.type == "imagemap") {
        entity.type = "constant";
        entity.parameters.parameters.clear();
        give(entity, is_float_texture ? typed::real("value", 1) : typed::rgb("value", magenta));
    } else if (entity.type == "measured") {
        entity.type = "diffuse";
        drop(entity, "filename");
        give(entity, typed::rgb("reflectance", magenta));
    } else if (entity.type == "infinite" || entity.type == "diffuse") {
        drop(entity, "filename");
        give(entity, typed::rgb("L", magenta));
    } else if (entity.type == "goniometric" || entity.type == "projection") {
        entity.type = "point";
        drop(entity, "filename");
        drop(entity, "fov");
        give(entity, typed::rgb("I", magenta));
    } else {
        return false;
    }
    return true;
}

}  // namespace raylex::transport
