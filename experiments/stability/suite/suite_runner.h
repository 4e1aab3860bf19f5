// Runs cases, each in a process that may die without taking the others along.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "experiments/stability/suite/judge_line.h"
#include "experiments/stability/suite/stability_case.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct SuiteOptions {
    bool fast = false;               ///< without the cases and values that are slow
    std::vector<std::string> names;  ///< of cases, with * and ?; empty: all
    std::vector<int> rows;           ///< of the hard cases; empty: all
    int threads = 0;                 ///< 0: all the machine offers
    double seconds_per_case = 600;   ///< then its process is ended
    std::string pictures;            ///< folder that gets FAMILY.png; empty: none
};

struct SuiteResults {
    std::vector<LineResult> lines;  ///< in the order of the files
    double seconds = 0;
    bool interrupted = false;

    [[nodiscard]] std::size_t count(LineVerdict verdict) const;
};

/// Whether the options let a case through.
bool is_chosen(const StabilityCase& each, const SuiteOptions& options);

/// `done` is called after every case with its lines. What goes wrong with a line, an Error included, makes it fail with
/// that as its note. Errors: no process could be made.
Result<SuiteResults> run_suite(const std::vector<CaseFamily>& families, const SuiteOptions& options,
                               const std::atomic<bool>* stop,
                               const std::function<void(const std::vector<LineResult>&)>& done);

}  // namespace raylex::experiments
