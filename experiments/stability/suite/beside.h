// Another program beside this one: the same cases, and the same scenes with the same seeds. What float costs in
// accuracy and double in time is the difference between two builds of one source.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "experiments/stability/suite/suite_runner.h"

namespace raylex::experiments {

/// A scene rendered by both programs with the same random numbers.
struct SceneDifference {
    std::string scene;
    double relative_mse = 0;  ///< between the two images (display::find_metric("relmse")): of rounding, not of noise
    double mean_ratio = 1;    ///< mean of this program's image over that of the other
    double cpu_seconds = 0, cpu_seconds_beside = 0;  ///< least of several runs by turns, loading included
};

struct BesideRun {
    std::string name;  ///< what the other program is called on the page
    SuiteResults results;
    std::vector<SceneDifference> scenes;
};

struct BesideOptions {
    std::string program;
    std::vector<std::string> files;   ///< of cases
    std::vector<std::string> scenes;  ///< pbrt files
    std::string samples = "16";       ///< a pixel, of scenes
    int runs = 3;
    std::string folder;  ///< gets a folder "beside" with what was written
};

/// Errors: the program does not run, or ends with bad input; its last words are told.
Result<BesideRun> run_beside(const BesideOptions& options, const SuiteOptions& suite, const std::atomic<bool>* stop);

}  // namespace raylex::experiments
