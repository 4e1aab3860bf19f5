// The state that AttributeBegin saves and AttributeEnd restores.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "transport/import/builder/scene_builder.h"

namespace raylex::transport {

/// A parameter set by Attribute, with the colour space at that place.
struct DefaultParameter {
    Parameter parameter;
    ColorSpace space = ColorSpace::srgb;
};

struct GraphicsState {
    std::array<Transform, 2> ctm;            ///< at the opening and at the closing of the shutter
    std::array<bool, 2> active{true, true};  ///< the transforms to which directives apply (ActiveTransform)
    bool reverse_orientation = false;
    MaterialHandle material;
    AreaLightHandle area_light;
    MediumHandle inside_medium, outside_medium;
    ColorSpace color_space = ColorSpace::srgb;
    /// Parameters by Attribute's target. The map is shared until it is modified, since every block keeps the state
    /// around it.
    std::shared_ptr<const std::map<std::string, std::vector<DefaultParameter>>> defaults =
        std::make_shared<const std::map<std::string, std::vector<DefaultParameter>>>();
};

}  // namespace raylex::transport
