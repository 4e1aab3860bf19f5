// How other renderers name the layers of a split, so that `raylex verify --preset cycles` finds them by itself.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Spellings of one pass, the likeliest first: "DiffDir|Diffuse Direct". Compared without case, spaces, _ and -, and
/// without "VRay" in front.
using PassNames = const char*;

/// (first + second + ...) * times
struct PresetTerm {
    std::vector<std::vector<PassNames>>
        alternatives;  ///< of the passes added; the first that is there as a whole is taken
    PassNames times = nullptr;
    bool shared = false;  ///< several splits have it: by itself it makes none
};

struct PresetSplit {
    const char* title;
    std::vector<PresetTerm> terms;
    PassNames groups = nullptr;  ///< instead of terms: every layer called so with _ and a group's name behind it
};

struct Preset {
    const char* name;
    const char* renderer;
    PassNames whole;
    std::vector<PresetSplit> splits;
    display::Allowance allowance;  ///< where the header does not tell how many samples were added up
    /// "cycles.*.samples": the header's attribute with that number, * being the view layer; null where there is none.
    const char* samples_attribute;
    PassNames background;  ///< one of the terms: no part of an image with a transparent film; null where it is
    const char* advice;    ///< what makes a correct image not sum, for the one who is told so
};

/// cycles, renderman, arnold, vray.
std::span<const Preset> presets();
Result<const Preset*> find_preset(const std::string& name);

/// A split that an image has by a preset.
struct FoundSplit {
    std::string title;    ///< "passes", "light groups"; " of SECTION" behind it where the image has several view layers
    std::string of;       ///< full name of the layer split
    std::string sum;      ///< for check_split
    std::string formula;  ///< the same for people, without prefix and quotes
    display::Allowance allowance;
    std::string note;                  ///< what was left out and why, mostly empty
    std::vector<std::string> missing;  ///< passes of the preset that the image lacks
};

/// Everything to judge, in the preset's order; `of` instead of the preset's own whole when not empty. Errors: no layers
/// named so, none to split.
Result<std::vector<FoundSplit>> find_splits(const Preset& preset, const display::ExrImage& image,
                                            const std::string& of);

}  // namespace raylex::experiments
