// A hard case as data: what is rendered or probed, what must hold of it, how near, and why.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/stability/suite/formula.h"
#include "experiments/study/plan/axis.h"
#include "transport/render/render.h"

namespace raylex::experiments {

/// A string of a case and where it stands.
struct CaseText {
    std::string text;
    SourceLocation location;
    [[nodiscard]] bool empty() const { return text.empty(); }
};

/// What a case makes of its images.
enum class SceneMeasure {
    mean,        ///< of a channel over all pixels, with the standard error of independent seeds
    largest,     ///< pixel of a channel, over all seeds
    same_image,  ///< the p-value that this image and that of `against` have the same means in all blocks
    same_bits,   ///< how many values differ from those of `against`
    split,       ///< the largest |sum of the shipped partition - beauty| of a pixel, over the sum of their sizes
    outcome      ///< how many values of the image are no numbers; an error that says what is wrong counts as none
};

/// What is rendered.
struct SceneSubject {
    CaseText scene;  ///< pbrt text with ${...}
    SceneMeasure measure = SceneMeasure::mean;
    std::vector<std::string> integrators;                   ///< types; the first by default "path"
    transport::RenderSettings settings;                     ///< integrator parameters, sampler, filter, max_depth ...
    std::string channel = "beauty";                         ///< or an expression, or a geometric AOV
    int component = -1;                                     ///< 0, 1 or 2; -1: the mean over all
    CaseText samples, seeds, threads;                       ///< formulas
    std::vector<std::pair<std::string, CaseText>> against;  ///< numbers that are others in the second image
    std::string against_integrator;                         ///< of the second image, unless empty
};

enum class Comparison { equal, at_most, at_least };

struct CaseAxis {
    std::string name;
    std::vector<AxisValue> values;
    SourceLocation location;
};

struct StabilityCase {
    std::string name;
    std::vector<int> rows;  ///< of the hard cases
    std::string symptom, reason, source;
    std::string not_applicable;  ///< which feature is missing; nothing is measured then
    bool slow = false;
    SourceLocation location;
    std::string probe;  ///< its name; empty: `scene` is set
    std::optional<SceneSubject> scene;
    std::vector<CaseAxis> constants, varied;  ///< in the order of the file; constants have one value
    std::vector<CaseAxis> fast;               ///< what --fast keeps to of those of `varied`
    CaseText expected, tolerance, ulp_of;
    Comparison comparison = Comparison::equal;

    /// Every combination of what varies, the last axis fastest. Strings that are formulas of numbers are numbers,
    /// others words.
    [[nodiscard]] Result<std::vector<Setting>> settings(bool only_fast = false) const;
};

/// A file of cases.
struct CaseFamily {
    std::string name;     ///< of the file, without ending
    std::string title;    ///< "Media"
    std::string about;    ///< a sentence or two
    std::string picture;  ///< the case whose first image stands for the family; may be empty
    std::string file;
    std::vector<StabilityCase> cases;
};

}  // namespace raylex::experiments
