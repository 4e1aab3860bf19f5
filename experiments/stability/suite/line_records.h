// Lines of the table as JSON and as CSV.
#pragma once

#include <string>
#include <vector>

#include "experiments/job/text/json.h"
#include "experiments/stability/suite/suite_runner.h"

namespace raylex::experiments {

const char* name_of(LineVerdict verdict);
Json line_record(const LineResult& line);
/// What line_record() made. Throws Json::exception where it is something else.
LineResult line_of_record(const Json& record);

/// results.json: the lines, and of which program they are. Numbers that JSON does not have are strings.
std::string results_json(const SuiteResults& results);
/// What results_json() made of another run; errors name the file.
Result<SuiteResults> read_results_json(const std::string& path);
/// One row a line, with a heading.
std::string results_csv(const SuiteResults& results);

}  // namespace raylex::experiments
