#include "experiments/stability/suite/line_records.h"

#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "experiments/job/rendering/provenance.h"
#include "experiments/job/text/json_fields.h"
#include "transport/math/real.h"

namespace raylex::experiments {
namespace {

constexpr std::array state_names{std::pair(LineState::holds, "holds"), std::pair(LineState::fails, "fails"),
                                 std::pair(LineState::died, "died"),
                                 std::pair(LineState::not_applicable, "not applicable")};

/// JSON has no infinities and no NaN, which are texts.
struct AnyNumber {
    double& value;
};
void to_json(Json& json, const AnyNumber& number) {
    const double value = number.value;
    if (std::isfinite(value)) json = value;
    else json = std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}
void from_json(const Json& json, AnyNumber& number) {
    if (json.is_number()) return json.get_to(number.value), void();
    const auto text = json.get<std::string>();
    number.value = text == "inf" ? INFINITY : text == "-inf" ? -INFINITY : NAN;
}

std::string csv_text(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + "\"";
}

}  // namespace

const char* name_of(LineState result) {
    for (const auto& [each, name] : state_names)
        if (each == result) return name;
    return "";
}

static void to_json(Json& json, LineState result) {
    json = name_of(result);
}
static void from_json(const Json& json, LineState& result) {
    for (const auto& [each, name] : state_names)
        if (json == name) result = each;
}

static void visit_fields(auto visit, LineResult& line) {
    visit("family", line.family);
    visit("case", line.name);
    visit("setting", line.setting);
    visit("rows", line.rows);
    visit("verdict", line.result);
    visit("expected", AnyNumber{line.expected});
    visit("measured", AnyNumber{line.measured});
    visit("error", AnyNumber{line.error});
    visit("allowed", AnyNumber{line.allowed});
    visit("standard_error", AnyNumber{line.standard_error});
    visit("ulp", AnyNumber{line.ulp});
    visit("tolerance", line.tolerance);
    visit("note", line.note);
    visit("seconds", line.seconds);
}

Json line_record(const LineResult& line) {
    return line;
}
LineResult line_of_record(const Json& record) {
    return record;
}

std::string results_json(const SuiteResults& results) {
    Json lines = Json::array();
    for (const LineResult& line : results.lines) lines.push_back(line_record(line));
    const Json all{{"raylex", raylex_version() + " (" + raylex_revision() + ")"},
                   {"arithmetic", transport::real_is_double ? "double" : "float"},
                   {"build", build_description()},
                   {"host", host_description()},
                   {"time", utc_time()},
                   {"seconds", results.seconds},
                   {"lines", std::move(lines)}};
    return json_text(all, 1) + "\n";
}

Result<SuiteResults> read_results_json(const std::string& path) {
    auto json = read_json_file(path, "results of the stability suite");
    if (!json) return json.error();
    try {
        SuiteResults results;
        results.seconds = json->at("seconds");
        for (const Json& line : json->at("lines")) results.lines.push_back(line_of_record(line));
        return results;
    } catch (const Json::exception& error) {
        return error_at({path, 0, 0}, std::string("these are not results of the stability suite: ") + error.what());
    }
}

std::string results_csv(const SuiteResults& results) {
    std::ostringstream csv;
    csv.precision(17);
    csv << "family,case,setting,rows,expected,measured,error,allowed,standard_error,ulp,tolerance,verdict,seconds,"
           "note\n";
    for (const LineResult& line : results.lines) {
        std::string rows;
        for (const int row : line.rows) rows += (rows.empty() ? "" : " ") + std::to_string(row);
        csv << csv_text(line.family) << ',' << csv_text(line.name) << ',' << csv_text(line.setting) << ',' << rows
            << ',' << line.expected << ',' << line.measured << ',' << line.error << ',' << line.allowed << ','
            << line.standard_error << ',' << line.ulp << ',' << csv_text(line.tolerance) << ',' << name_of(line.result)
            << ',' << line.seconds << ',' << csv_text(line.note) << '\n';
    }
    return csv.str();
}

}  // namespace raylex::experiments
