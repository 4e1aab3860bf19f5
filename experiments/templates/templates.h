// The sources that `raylex new plugin` writes, compiled into the program.
#pragma once

#include <array>
#include <string_view>

namespace raylex::experiments {

/// The kinds of plugin there is a template for.
inline constexpr std::array<const char*, 5> plugin_kinds{"integrator", "pattern", "material", "filter", "driver"};

/// C++ with the plugin's name as @NAME@; `kind` is one of plugin_kinds.
std::string_view plugin_template(std::string_view kind);

}  // namespace raylex::experiments
