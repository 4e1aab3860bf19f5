// The driver that shows the image in a running tev viewer during the render.
#pragma once

#include "display/drivers/display_driver.h"

namespace raylex::display {

Registry<DisplayDriverFactory>::Entry tev_driver_entry();

/// Parses "host:port", "host" or ":port" into the parameters of a tev driver (defaults: localhost, 14158; [::1]:14158
/// for numeric IPv6). Errors are at `where`.
Result<ParameterSet> tev_address(const std::string& text, const SourceLocation& where);

}  // namespace raylex::display
