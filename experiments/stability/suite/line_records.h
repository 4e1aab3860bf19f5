// Converts lines of the table to JSON and CSV.
#pragma once

#include <string>
#include <vector>

#include "experiments/job/text/json.h"
#include "experiments/stability/suite/suite_runner.h"

namespace raylex::experiments {

const char* name_of(LineState result);
Json line_record(const LineResult& line);
/// Parses the record of line_record(). Throws Json::exception for any other JSON.
LineResult line_of_record(const Json& record);

/// Returns results.json: the lines, and the program that measured them. Non-finite numbers are strings.
std::string results_json(const SuiteResults& results);
/// Reads the results of another run. Errors name the file.
Result<SuiteResults> read_results_json(const std::string& path);
/// Returns one row per line, with a heading.
std::string results_csv(const SuiteResults& results);

}  // namespace raylex::experiments
