// Text into HTML, and the parts of the page that never change.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace raylex::experiments {

/// &, <, > and quotes as entities; control characters other than line breaks and tabs become blanks.
std::string escape_html(std::string_view text);

/// RFC 4648, section 4.
std::string base64(std::span<const unsigned char> bytes);

/// "data:image/png;base64,..."
std::string data_uri(std::span<const unsigned char> png);

std::string_view page_style();   ///< for <style>
std::string_view page_script();  ///< for <script>

}  // namespace raylex::experiments
