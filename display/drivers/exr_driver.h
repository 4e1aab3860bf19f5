// The driver that writes the whole image as one OpenEXR file at the end of the render.
#pragma once

#include "display/drivers/display_driver.h"

namespace raylex::display {

Registry<DisplayDriverFactory>::Entry exr_driver_entry();

}  // namespace raylex::display
