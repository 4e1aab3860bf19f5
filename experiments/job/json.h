// JSON. Compiled once: headers that are all templates would be compiled anew wherever a number is written.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "lpe/result.h"

namespace raylex::experiments {

/// Objects keep the order in which their members were set.
using Json = nlohmann::ordered_json;

/// Throws Json::exception, which says where the text is not JSON.
Json parse_json(std::string_view text);

/// A file of JSON; `what` it is: "a reference.json". Errors name the file: Budget::record_bytes, what is not JSON.
Result<Json> read_json_file(const std::string& path, const std::string& what);

/// In one line without a blank when `indent` is -1. Bytes that are no UTF-8 become U+FFFD.
std::string json_text(const Json& json, int indent = -1);

}  // namespace raylex::experiments
