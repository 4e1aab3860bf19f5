// The driver that shows the image in a running tev viewer while it is being rendered.
#pragma once

#include "display/drivers/display_driver.h"

namespace raylex::display {

Registry<DisplayDriverFactory>::Entry tev_driver_entry();

/// "host:port", "host" or ":port" (localhost, 14158 when left out; [::1]:14158 for numeric IPv6) as the parameters of a
/// tev driver. Errors at `where`.
Result<ParameterSet> tev_address(const std::string& text, const SourceLocation& where);

}  // namespace raylex::display
