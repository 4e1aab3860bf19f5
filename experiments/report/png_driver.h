// The display driver "png": one layer as an 8-bit picture, light through a display and view of the colour config.
#pragma once

#include "display/drivers/display_driver.h"

namespace raylex::experiments {

/// Makes "png" known to display_driver_registry(); more than once does no harm.
void register_png_driver();

}  // namespace raylex::experiments
