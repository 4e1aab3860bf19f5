// Searches for scenes that violate an invariant. Each random scene is checked in a separate process, which may crash or
// hang. Failing scenes are shrunk and saved.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "experiments/invariants/checking_process.h"
#include "tests/stability/search/shrink.h"

namespace raylex::experiments {

struct SearchOptions {
    std::uint64_t seed = 0;    ///< number of the first scene; others are consecutive
    std::uint64_t scenes = 0;  ///< maximum number; 0: no limit
    double seconds = 0;        ///< time limit in seconds; 0: no limit
    std::size_t most_findings = 20;
    double seconds_a_scene = 30;  ///< a scene that takes longer counts as hanging
    /// every how many scenes of ordinary size invariants of means are checked; 0: never
    std::uint64_t means_every = 6;
    std::string folder = "raylex-search";  ///< folder for failing scenes and for the images of scenes
    InvariantOptions check;
    ShrinkLimits shrink;
};

/// A failing scene.
struct Finding {
    std::uint64_t scene = 0;
    std::string invariant;   ///< name of the invariant, or "death" if the process ended
    InvariantResult result;  ///< for the scene before shrinking
    std::string text;        ///< after shrinking
    std::string file;        ///< path of the saved scene
    std::size_t lines_before = 0, lines = 0, trials = 0;
};

struct SearchReport {
    std::uint64_t scenes = 0, refused = 0, tame = 0;
    double seconds = 0;
    std::map<std::string, std::uint64_t> checked, skipped;  ///< counts by invariant
    std::vector<Finding> findings;
};

using SearchProgress = std::function<void(const SearchReport&, const Finding*)>;

/// Runs the search. Errors: the folder is not writable; a process cannot be started.
Result<SearchReport> search_scenes(const SearchOptions& options, const SearchProgress& progress = {},
                                   const std::atomic<bool>* stop = nullptr);

/// The command that repeats a finding.
std::string command_of(const Finding& finding);

}  // namespace raylex::experiments
