// The source templates of `raylex new plugin`, compiled into the program.
#pragma once

#include <array>
#include <string_view>

namespace raylex::experiments {

/// The kinds of plugin with a template.
inline constexpr std::array<const char*, 5> plugin_kinds{"integrator", "pattern", "material", "filter", "driver"};

/// Returns C++ source with @NAME@ for the plugin's name. `kind` is one of plugin_kinds.
std::string_view plugin_template(std::string_view kind);

}  // namespace raylex::experiments
