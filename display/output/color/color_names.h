// The names that a colour config has, for lists and for options that take them.
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
    std::vector<ColorSpaceEntry> spaces;  ///< in the config's order
    std::vector<std::string> looks;
};
/// Of the config that ColorManager::open takes for this path, with the same errors. Displays and views are the
/// manager's.
Result<ConfigNames> config_names(const std::string& config_path);

/// Whether the config has this display, and this view of it; an empty name is the default's. Errors name near misses,
/// and the display that has the view.
Status check_view(const ColorManager& color, const std::string& display, const std::string& view);

}  // namespace raylex::display
