// What AttributeBegin saves and AttributeEnd restores.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "transport/import/builder/scene_builder.h"

namespace raylex::transport {

/// A parameter set by Attribute, with the colour space that held there.
struct DefaultParameter {
    Parameter parameter;
    ColorSpace space = ColorSpace::srgb;
};

struct GraphicsState {
    std::array<Transform, 2> ctm;            ///< at the shutter's opening and closing
    std::array<bool, 2> active{true, true};  ///< which of the two ActiveTransform writes to
    bool reverse_orientation = false;
    MaterialHandle material;
    AreaLightHandle area_light;
    MediumHandle inside_medium, outside_medium;
    ColorSpace color_space = ColorSpace::srgb;
    /// By Attribute's target. Shared until written to: every block keeps the state around it, however much is in here.
    std::shared_ptr<const std::map<std::string, std::vector<DefaultParameter>>> defaults =
        std::make_shared<const std::map<std::string, std::vector<DefaultParameter>>>();
};

}  // namespace raylex::transport
