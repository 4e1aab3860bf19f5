// JSON functions, compiled once because the library's headers are expensive templates.
#pragma once

#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "lpe/result.h"

namespace raylex::experiments {

/// JSON values. Objects keep the order in which their members were set.
using Json = nlohmann::ordered_json;

/// Parses a text. Throws Json::exception with the position of an error.
Json parse_json(std::string_view text);

/// Reads a JSON file; `what` describes it in errors, such as "a reference.json". Errors name the file: it exceeds
/// Budget::record_bytes, or it is not JSON.
Result<Json> read_json_file(const std::string& path, const std::string& what);

/// Converts a JSON number to any integer type. JSON's own conversion is undefined for a number that is out of range or
/// not an integer; this one throws Json::exception.
class Whole {
  public:
    explicit Whole(const Json& json) : json_(json) {}
    template <std::integral T>
    operator T() const {  // NOLINT(google-explicit-constructor): replaces the JSON number
        if (json_.is_number_unsigned()) {
            const auto value = json_.get<std::uint64_t>();
            if (std::in_range<T>(value)) return static_cast<T>(value);
        } else if (json_.is_number_integer()) {
            const auto value = json_.get<std::int64_t>();
            if (std::in_range<T>(value)) return static_cast<T>(value);
        }
        fail();
    }

  private:
    [[noreturn]] void fail() const;
    const Json& json_;
};
inline Whole whole(const Json& json) {
    return Whole(json);
}

/// Returns the JSON as text, on one line without blanks if `indent` is -1. Bytes that are not UTF-8 become U+FFFD.
std::string json_text(const Json& json, int indent = -1);

}  // namespace raylex::experiments
