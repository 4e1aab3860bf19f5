// The text of display/ocio/raylex.ocio, compiled in so that a program finds it wherever it is installed.
#pragma once

namespace raylex::display {

[[nodiscard]] const char* shipped_config_text();

}  // namespace raylex::display
