// Compares another program with this one on the same cases, and on scenes with the same seeds. The difference between
// two builds of one source shows the accuracy of float and the time of double.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "experiments/stability/suite/suite_runner.h"

namespace raylex::experiments {

/// A scene rendered by both programs with the same random numbers.
struct SceneDifference {
    std::string scene;
    double relative_mse = 0;  ///< between the two images (display::find_metric("relmse")): rounding, not noise
    double mean_ratio = 1;    ///< mean of this program's image relative to the other's
    double cpu_seconds = 0, baseline_cpu_seconds = 0;  ///< minimum of several alternating runs, including loading
};

struct BaselineRun {
    std::string name;  ///< name of the other program on the page
    SuiteResults results;
    std::vector<SceneDifference> scenes;
};

struct BaselineOptions {
    std::string program;
    std::vector<std::string> files;   ///< files with cases
    std::vector<std::string> scenes;  ///< pbrt files
    std::string samples = "16";       ///< samples per pixel of scenes
    int runs = 3;
    std::string folder;  ///< the folder for the files in "beside"
};

/// Runs the comparison. Errors: the program does not run, or it rejects its input; the message has its last output.
Result<BaselineRun> run_baseline(const BaselineOptions& options, const SuiteOptions& suite,
                                 const std::atomic<bool>* stop);

}  // namespace raylex::experiments
