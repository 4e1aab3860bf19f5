// JSON. Compiled once: headers that are all templates would be compiled anew wherever a number is written.
#pragma once

#include <istream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

extern template class nlohmann::basic_json<nlohmann::ordered_map>;

namespace raylex::experiments {

/// Objects keep the order in which their members were set.
using Json = nlohmann::ordered_json;

/// Throws Json::exception, which says where the text is not JSON.
Json parse_json(std::istream& text);
Json parse_json(std::string_view text);

/// In one line without a blank when `indent` is -1. Bytes that are no UTF-8 become U+FFFD.
std::string json_text(const Json& json, int indent = -1);

}  // namespace raylex::experiments
