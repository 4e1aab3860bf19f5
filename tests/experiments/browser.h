// Pages as they stand after their scripts have run in a real browser.
#pragma once

#include <string>
#include <vector>

#include "support.h"

namespace raylex::test {

/// Whether headless Chromium is installed.
bool has_browser(const Folder& folder);

/// Opens `page` of `folder` in a window of `size` ("1400,900") and waits until something matches each of `selectors`,
/// at most a minute each of three times. `out`: the document as it is then, without its scripts; empty when the time
/// was over. `err`: what the browser and the page said.
Outcome in_browser(const Folder& folder, const std::string& page, const std::string& size,
                   const std::vector<std::string>& selectors);

}  // namespace raylex::test
