// Which methods differ from the reference of a scene's channel, and whether that says anything of them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {

/// The images that a variant's bias is tested on: of the budget with most samples in all, two replicates at least.
struct BiasCandidate {
    double weight = -1, budget = 0, samples = 0;  ///< samples per pixel of a replicate; 0: not known
    BiasSide side;
    std::vector<double> mean;  ///< of all replicates, pixel by pixel
};
using BiasCandidates = std::map<std::string, BiasCandidate>;  ///< by variant; without replicates: no images

/// Replaces `best` where these images of one budget, in the order of its cells, say more. Empty images are left out.
void offer_candidate(BiasCandidate& best, double budget, const std::vector<const Cell*>& cells,
                     const std::vector<PixelArray>& images);

/// Adds a verdict to Study::bias for each candidate, in the order of the variants, after the curves of the channel:
/// all variants against the reference; that by which the reference was made, against another method where there is
/// one: a mistake of its own is in both. The most precise of those that agree with the reference is taken.
///
/// Where the reference may itself be wrong by more than its variance (there is none, or its method meets rare samples),
/// the replicates of another method must confirm a difference.
void judge_bias(Study& study, const SceneInfo& scene, const ChannelInfo& channel, BiasCandidates candidates,
                const PixelArray& reference, const std::optional<PixelArray>& variance);

}  // namespace raylex::experiments
