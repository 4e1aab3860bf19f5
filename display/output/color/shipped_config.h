// The text of display/ocio/raylex.ocio, compiled in, so that a program does not depend on its installation path.
#pragma once

namespace raylex::display {

[[nodiscard]] const char* shipped_config_text();

}  // namespace raylex::display
