// What is true of every scene, whatever is in it: checked on the scene at hand, without a reference image.
//
// Each invariant renders the scene, and mostly a variant of it of which the answer follows, and gives one number that a
// bound holds against. Renders are small (a few pixels and samples), so that a scene takes milliseconds; those of means
// compare independent seeds by Student's t with a level that stands for a million comparisons.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/result.h"

namespace raylex::experiments {

enum class InvariantState : std::uint8_t { holds, violated, skipped };

struct Verdict {
    std::string invariant;
    InvariantState outcome = InvariantState::skipped;
    double measured = 0, bound = 0;
    std::string note;  ///< what was measured; of skipped ones why
};

struct InvariantInfo {
    std::string_view name, help;
    bool of_means;     ///< many renders
    bool of_ordinary;  ///< true of scenes of ordinary size alone: elsewhere numbers leave float's range by right
};
/// All there are, in the order that they are checked.
std::vector<InvariantInfo> invariants();

struct InvariantOptions {
    std::uint64_t seed = 0;         ///< of samples and of the random expressions that split the light
    std::vector<std::string> only;  ///< names; empty: all, those of means if `means`
    bool means = true;
    bool ordinary = true;       ///< the scene is of ordinary size
    int most_pixels = 64;       ///< larger films are rendered smaller
    int most_samples = 4;       ///< per pixel, of renders whose bits are compared
    int replicates = 8;         ///< of renders whose means are; four times as many confirm a suspicion
    int samples_of_means = 64;  ///< per pixel of each
};

struct SceneReport {
    std::string refused;  ///< the scene makes no image, for this reason: a fair outcome, nothing is checked
    std::vector<Verdict> verdicts;

    [[nodiscard]] bool holds() const;
};

/// Checks the scene of a pbrt text; `path` is what its relative file names are relative to. Errors: an unknown name in
/// `only`.
Result<SceneReport> check_invariants(const std::string& text, const std::string& path, const InvariantOptions& options);

}  // namespace raylex::experiments
