// The page of the stability suite.
#pragma once

#include <string>
#include <vector>

#include "experiments/stability/suite/baseline.h"
#include "experiments/stability/suite/suite_runner.h"

namespace raylex::experiments {

struct SuitePage {
    const std::vector<CaseFamily>* families = nullptr;
    const SuiteResults* results = nullptr;
    const BaselineRun* baseline = nullptr;  ///< results of another program for the same cases; null: none
    std::string pictures;                   ///< folder with FAMILY.png files, which are embedded if they exist
};

/// Returns one self-contained HTML file: the summary, then each family with its picture, a chart of the used fractions
/// of tolerances, and all lines.
std::string suite_page(const SuitePage& page);

}  // namespace raylex::experiments
