// Runs cases, each in a process that may crash without affecting others.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "experiments/stability/suite/check_line.h"
#include "experiments/stability/suite/stability_case.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct SuiteOptions {
    bool fast = false;               ///< omit slow cases and values
    std::vector<std::string> names;  ///< names of cases, with * and ?; empty: all
    std::vector<int> rows;           ///< rows in the list of hard cases; empty: all
    int threads = 0;                 ///< 0: all cores
    double seconds_per_case = 600;   ///< time limit of a case's process in seconds
    std::string pictures;            ///< folder for FAMILY.png; empty: none
};

struct SuiteResults {
    std::vector<LineResult> lines;  ///< in the order of the files
    double seconds = 0;
    bool interrupted = false;

    [[nodiscard]] std::size_t count(LineState result) const;
};

/// Returns whether the options select a case.
bool is_chosen(const StabilityCase& each, const SuiteOptions& options);

/// Runs the cases and calls `done` after each with its lines. A line with an Error, or any other failure, fails with
/// that as its note. Errors: no process could be started.
Result<SuiteResults> run_suite(const std::vector<CaseFamily>& families, const SuiteOptions& options,
                               const std::atomic<bool>* stop,
                               const std::function<void(const std::vector<LineResult>&)>& done);

}  // namespace raylex::experiments
