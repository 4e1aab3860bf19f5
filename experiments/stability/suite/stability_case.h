// A hard case as data: the scene or probe, the expected value, the tolerance and its reason.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/stability/suite/formula.h"
#include "experiments/study/plan/axis.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// A string of a case with its source position.
struct CaseText {
    std::string text;
    SourceLocation location;
    [[nodiscard]] bool empty() const { return text.empty(); }
};

/// The quantity that a case measures in its images.
enum class SceneMeasure {
    mean,        ///< mean of a channel over all pixels, with the standard error of independent seeds
    largest,     ///< largest pixel of a channel, over all seeds
    same_image,  ///< p-value of the hypothesis that this image and that of `against` have equal means in all blocks
    same_bits,   ///< number of values that differ from those of `against`
    split,       ///< largest |sum of the shipped partition - beauty| of a pixel, relative to the sum of their sizes
    outcome      ///< number of non-finite values in the image; an error with a message counts as 0
};

/// The scene and its render settings.
struct SceneSubject {
    CaseText scene;  ///< pbrt text with ${...}
    SceneMeasure measure = SceneMeasure::mean;
    std::vector<std::string> integrators;                   ///< types; by default only "path"
    transport::RenderSettings settings;                     ///< integrator parameters, sampler, filter, max_depth ...
    std::string channel = "beauty";                         ///< "beauty", an expression, or a geometric AOV
    int component = -1;                                     ///< 0, 1 or 2; -1: the mean over all
    CaseText samples, seeds, threads;                       ///< formulas
    std::vector<std::pair<std::string, CaseText>> against;  ///< numbers with other values in the second image
    std::string against_integrator;                         ///< integrator of the second image; empty: the same
};

enum class Comparison { equal, at_most, at_least };

struct CaseAxis {
    std::string name;
    std::vector<AxisValue> values;
    SourceLocation location;
};

struct StabilityCase {
    std::string name;
    std::vector<int> rows;  ///< rows in the list of hard cases
    std::string symptom, reason, source;
    std::string not_applicable;  ///< the missing feature; nothing is measured
    bool slow = false;
    SourceLocation location;
    std::string probe;  ///< name of the probe; empty: `scene` is set
    std::optional<SceneSubject> scene;
    std::vector<CaseAxis> constants, varied;  ///< in the order of the file; constants have one value
    std::vector<CaseAxis> fast;               ///< the values of `varied` for --fast
    CaseText expected, tolerance, ulp_of;
    Comparison comparison = Comparison::equal;

    /// Returns every combination of varied values; the last axis varies fastest. Strings that are formulas become
    /// numbers; others are words.
    [[nodiscard]] Result<std::vector<Setting>> settings(bool only_fast = false) const;
};

/// A file of cases.
struct CaseFamily {
    std::string name;     ///< name of the file without extension
    std::string title;    ///< "Media"
    std::string about;    ///< one or two sentences
    std::string picture;  ///< the case whose first image illustrates the family; may be empty
    std::string file;
    std::vector<StabilityCase> cases;
};

}  // namespace raylex::experiments
