// The display driver "png": one layer as an 8-bit picture, light through a display and view of the colour config.
#pragma once

#include "display/drivers/display_driver.h"

namespace raylex::experiments {

/// Adds "png" to display_driver_registry(), unless the name is there already.
void register_png_driver();

}  // namespace raylex::experiments
