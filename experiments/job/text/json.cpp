#include "experiments/job/text/json.h"

#include "display/services/parameters.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {

Json parse_json(std::string_view text) {
    return Json::parse(text);
}

Result<Json> read_json_file(const std::string& path, const std::string& what) {
    const Result<std::string> text = read_record(path, what);
    if (!text) return text.error();
    try {
        return parse_json(*text);
    } catch (const Json::exception& error) {
        return error_at({path, 0, 0}, "this is not " + what + ", or it is damaged: " + error.what());
    }
}

void Whole::fail() const {
    throw Json::type_error::create(302, "expected an integer in range, found " + json_text(json_), &json_);
}

std::string json_text(const Json& json, int indent) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace raylex::experiments
