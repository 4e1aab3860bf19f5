// Finds the methods that differ from the reference of a scene's channel, and whether the difference is evidence of
// bias.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {

/// The images for the bias test of a variant: those of the budget with most samples in total, at least two replicates.
struct BiasCandidate {
    double weight = -1, budget = 0, samples = 0;  ///< samples per pixel of a replicate; 0: unknown
    BiasSide side;
    std::vector<double> mean;  ///< of all replicates, by pixel
};
using BiasCandidates = std::map<std::string, BiasCandidate>;  ///< by variant; without replicates: no images

/// Replaces `best` if these images of one budget, in the order of its cells, have more samples. Ignores empty images.
void offer_candidate(BiasCandidate& best, double budget, const std::vector<const StudyRun*>& runs,
                     const std::vector<PixelArray>& images);

/// Adds a verdict for each candidate to Study::bias, in the order of the variants. Call it after the curves of the
/// channel. Variants are compared with the reference. The method that made the reference is compared with the most
/// precise other method that agrees with the reference, if there is one, because a mistake of that method is in both
/// its images and the reference.
///
/// If the reference may be wrong by more than its variance (the variance is unknown, or its method has rare samples),
/// the replicates of another method must confirm a difference.
void check_bias(Study& study, const SceneInfo& scene, const ChannelInfo& channel, BiasCandidates candidates,
                const PixelArray& reference, const std::optional<PixelArray>& variance);

}  // namespace raylex::experiments
