#include "experiments/stability/suite/line_records.h"

#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "experiments/job/rendering/provenance.h"
#include "transport/math/real.h"

namespace raylex::experiments {
namespace {

constexpr std::array verdict_names{std::pair(LineVerdict::holds, "holds"), std::pair(LineVerdict::fails, "fails"),
                                   std::pair(LineVerdict::died, "died"),
                                   std::pair(LineVerdict::not_applicable, "not applicable")};

/// JSON has no infinities and no NaN.
Json number_record(double value) {
    if (std::isfinite(value)) return value;
    return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}
double number_of(const Json& record) {
    if (record.is_number()) return record.get<double>();
    const auto text = record.get<std::string>();
    return text == "inf" ? INFINITY : text == "-inf" ? -INFINITY : NAN;
}

std::string csv_text(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + "\"";
}

}  // namespace

const char* name_of(LineVerdict verdict) {
    for (const auto& [each, name] : verdict_names)
        if (each == verdict) return name;
    return "";
}

Json line_record(const LineResult& line) {
    return {{"family", line.family},
            {"case", line.name},
            {"setting", line.setting},
            {"rows", line.rows},
            {"verdict", name_of(line.verdict)},
            {"expected", number_record(line.expected)},
            {"measured", number_record(line.measured)},
            {"error", number_record(line.error)},
            {"allowed", number_record(line.allowed)},
            {"standard_error", number_record(line.standard_error)},
            {"ulp", number_record(line.ulp)},
            {"tolerance", line.tolerance},
            {"note", line.note},
            {"seconds", line.seconds}};
}

LineResult line_of_record(const Json& record) {
    LineResult line;
    line.family = record.at("family");
    line.name = record.at("case");
    line.setting = record.at("setting");
    line.rows = record.at("rows").get<std::vector<int>>();
    for (const auto& [verdict, name] : verdict_names)
        if (record.at("verdict") == name) line.verdict = verdict;
    line.expected = number_of(record.at("expected"));
    line.measured = number_of(record.at("measured"));
    line.error = number_of(record.at("error"));
    line.allowed = number_of(record.at("allowed"));
    line.standard_error = number_of(record.at("standard_error"));
    line.ulp = number_of(record.at("ulp"));
    line.tolerance = record.at("tolerance");
    line.note = record.at("note");
    line.seconds = record.at("seconds");
    return line;
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
            << line.standard_error << ',' << line.ulp << ',' << csv_text(line.tolerance) << ',' << name_of(line.verdict)
            << ',' << line.seconds << ',' << csv_text(line.note) << '\n';
    }
    return csv.str();
}

}  // namespace raylex::experiments
