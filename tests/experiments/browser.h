// Pages as they are after their scripts have run in a real browser.
#pragma once

#include <string>
#include <vector>

#include "support.h"

namespace raylex::test {

/// Returns whether headless Chromium is installed.
bool has_browser(const Folder& folder);

/// Opens `page` of `folder` in a window of `size` ("1400,900") and waits until each of `selectors` matches something,
/// at most a minute, up to three times. `out`: the document at that time, without its scripts; empty after a timeout.
/// `err`: the output of the browser and the page.
Outcome in_browser(const Folder& folder, const std::string& page, const std::string& size,
                   const std::vector<std::string>& selectors);

}  // namespace raylex::test
