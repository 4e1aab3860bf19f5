// Looks for scenes on which an invariant does not hold: random ones, each checked in a process of its own that may die
// or hang; what fails is shrunk and saved.
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
    std::uint64_t seed = 0;    ///< of the first scene; the others follow
    std::uint64_t scenes = 0;  ///< at most; 0: any number
    double seconds = 0;        ///< at most; 0: any time
    std::size_t most_findings = 20;
    double seconds_a_scene = 30;           ///< what takes longer hangs
    std::uint64_t means_every = 6;         ///< of scenes of ordinary size, for invariants of means; 0: never
    std::string folder = "raylex-search";  ///< for scenes that fail, and the images that scenes read
    InvariantOptions check;
    ShrinkLimits shrink;
};

/// A scene that fails.
struct Finding {
    std::uint64_t scene = 0;
    std::string invariant;  ///< or "death": what ended the process
    Verdict verdict;        ///< of the scene as it was found
    std::string text;       ///< shrunk
    std::string file;       ///< where it is saved
    std::size_t lines_before = 0, lines = 0, trials = 0;
};

struct SearchReport {
    std::uint64_t scenes = 0, refused = 0, tame = 0;
    double seconds = 0;
    std::map<std::string, std::uint64_t> checked, skipped;  ///< by invariant
    std::vector<Finding> findings;
};

using SearchProgress = std::function<void(const SearchReport&, const Finding*)>;

/// Errors: a folder that cannot be written to, processes that cannot be made.
Result<SearchReport> search_scenes(const SearchOptions& options, const SearchProgress& progress = {},
                                   const std::atomic<bool>* stop = nullptr);

/// The command that repeats a finding.
std::string command_of(const Finding& finding);

}  // namespace raylex::experiments
