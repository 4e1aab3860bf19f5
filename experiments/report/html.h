// Text as HTML, and the fixed parts of pages.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace raylex::experiments {

/// The text with &, <, > and quotes as entities. Control characters other than line breaks and tabs become blanks.
std::string escape_html(std::string_view text);

/// The bytes in base64 (RFC 4648, section 4).
std::string base64(std::span<const unsigned char> bytes);

/// "data:image/png;base64,..."
std::string data_uri(std::span<const unsigned char> png);

/// The JSON in a form that can stand inside <script>: nothing in it ends the element or opens a comment.
std::string script_json(std::string_view json);

// Scripts and styles. The build compiles these files into the program (assets.cpp.in).
std::string_view page_style();     ///< page.css
std::string_view pixels_script();  ///< pixels.js
std::string_view panes_script();   ///< panes.js
std::string_view split_script();   ///< split_page.js

}  // namespace raylex::experiments
