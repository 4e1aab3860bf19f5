// The page of the stability suite.
#pragma once

#include <string>
#include <vector>

#include "experiments/stability/suite/suite_runner.h"

namespace raylex::experiments {

struct SuitePage {
    const std::vector<CaseFamily>* families = nullptr;
    const SuiteResults* results = nullptr;
    const SuiteResults* beside = nullptr;  ///< of another program, by the same cases; null: none
    std::string name_beside;               ///< "double"
    std::string pictures;                  ///< folder that may hold FAMILY.png; they are embedded
};

/// One HTML file that fetches nothing: verdicts first, then each family with its picture, a chart of how much of every
/// tolerance was used, and all lines.
std::string suite_page(const SuitePage& page);

}  // namespace raylex::experiments
