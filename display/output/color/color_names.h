// The names in a colour config, for lists and for options.
#pragma once

#include <string>
#include <vector>

#include "lpe/result.h"

namespace raylex::display {

class ColorManager;

struct ColorSpaceEntry {
    std::string name;
    bool scene_linear = false, data = false;
};

struct ConfigNames {
    std::vector<ColorSpaceEntry> spaces;  ///< in the order of the config
    std::vector<std::string> looks;
};
/// The names in the config that ColorManager::open() opens for this path, with the same errors. ColorManager itself
/// lists displays and views.
Result<ConfigNames> config_names(const std::string& config_path);

/// Checks that the config has this display and this view of it; an empty name means the default. Errors suggest similar
/// names, and the display that has the view.
Status check_view(const ColorManager& color, const std::string& display, const std::string& view);

}  // namespace raylex::display
