// Properties that hold for every scene, checked without a reference image.
//
// Each invariant renders the scene, and usually a variant with a known relation to it, and compares one number with a
// bound. Renders are small (few pixels and samples), so a scene takes milliseconds. Invariants of means compare
// independent seeds by Student's t at a level for a million comparisons.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/result.h"

namespace raylex::experiments {

enum class InvariantState : std::uint8_t { holds, violated, skipped };

struct InvariantResult {
    std::string invariant;
    InvariantState outcome = InvariantState::skipped;
    double measured = 0, bound = 0;
    std::string note;  ///< what was measured; for skipped invariants the reason
};

struct InvariantInfo {
    std::string_view name, help;
    bool of_means;     ///< it needs many renders
    bool of_ordinary;  ///< true only of scenes of ordinary size; elsewhere numbers can leave the range of float
};
/// Returns all invariants in the order in which they are checked.
std::vector<InvariantInfo> invariants();

struct InvariantOptions {
    std::uint64_t seed = 0;         ///< seed of samples and of the random expressions that split the light
    std::vector<std::string> only;  ///< names; empty: all, with those of means only if `means`
    bool means = true;
    bool ordinary = true;       ///< the scene is of ordinary size
    int most_pixels = 64;       ///< larger films are rendered smaller
    int most_samples = 4;       ///< per pixel, for renders whose bits are compared
    int replicates = 8;         ///< renders per mean; four times as many confirm a suspicion
    int samples_of_means = 64;  ///< per pixel and render, for means
};

struct SceneReport {
    std::string refused;  ///< why the scene gives no image; this is a valid result, and nothing is checked
    std::vector<InvariantResult> results;

    [[nodiscard]] bool holds() const;
};

/// Checks the scene in a pbrt text. Relative file names are relative to `path`. Errors: an unknown name in `only`.
Result<SceneReport> check_invariants(const std::string& text, const std::string& path, const InvariantOptions& options);

}  // namespace raylex::experiments
