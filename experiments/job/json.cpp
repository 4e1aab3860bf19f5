#include "experiments/job/json.h"

template class nlohmann::basic_json<nlohmann::ordered_map>;

namespace raylex::experiments {

Json parse_json(std::istream& text) { return Json::parse(text); }

Json parse_json(std::string_view text) { return Json::parse(text); }

std::string json_text(const Json& json, int indent) { return json.dump(indent, ' ', false, Json::error_handler_t::replace); }

}  // namespace raylex::experiments
