// JSON. Compiled once: headers that are all templates would be compiled anew wherever a number is written.
#pragma once

#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "lpe/result.h"

namespace raylex::experiments {

/// Objects keep the order in which their members were set.
using Json = nlohmann::ordered_json;

/// Throws Json::exception, which says where the text is not JSON.
Json parse_json(std::string_view text);

/// A file of JSON; `what` it is: "a reference.json". Errors name the file: Budget::record_bytes, what is not JSON.
Result<Json> read_json_file(const std::string& path, const std::string& what);

/// A number of a record as whatever integer it is asked to be. JSON's own conversion has no defined result for a number
/// that does not fit or is no whole one; here it throws Json::exception.
class Whole {
  public:
    explicit Whole(const Json& json) : json_(json) {}
    template <std::integral T>
    operator T() const {  // NOLINT(google-explicit-constructor): stands where the number stood
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

/// In one line without a blank when `indent` is -1. Bytes that are no UTF-8 become U+FFFD.
std::string json_text(const Json& json, int indent = -1);

}  // namespace raylex::experiments
