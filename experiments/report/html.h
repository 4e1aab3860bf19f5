// Text into HTML, and the parts of pages that never change.
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

/// JSON that can stand inside <script>: no text of it ends the element or opens a comment.
std::string script_json(std::string_view json);

// Scripts and styles, compiled in from the files of these names (assets.cpp.in).
std::string_view page_style();     ///< page.css
std::string_view pixels_script();  ///< pixels.js
std::string_view panes_script();   ///< panes.js
std::string_view split_script();   ///< split_page.js

}  // namespace raylex::experiments
