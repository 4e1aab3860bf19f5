// Names of split layers in other renderers, so that `raylex verify --preset cycles` finds the layers.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"
#include "display/output/splits/split_check.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// The spellings of one pass, the most common first: "DiffDir|Diffuse Direct". The comparison ignores case, blanks, _
/// and -, and a prefix "VRay".
using PassNames = const char*;

/// (first + second + ...) * times
struct PresetTerm {
    std::vector<std::vector<PassNames>>
        alternatives;  ///< lists of passes that are added; the first list that exists completely is used
    PassNames times = nullptr;
    bool shared = false;  ///< several splits have this term, so it does not identify one
};

struct PresetSplit {
    const char* title;
    std::vector<PresetTerm> terms;
    PassNames groups = nullptr;  ///< instead of terms: every layer with this name, _ and the name of a group
};

struct Preset {
    const char* name;
    const char* renderer;
    PassNames whole;
    std::vector<PresetSplit> splits;
    display::Allowance allowance;  ///< used if the header does not have the number of samples
    /// Header attribute with the number of samples, such as "cycles.*.samples" with * for the view layer; null if there
    /// is none.
    const char* samples_attribute;
    PassNames background;  ///< the term that is not part of an image with a transparent film; null if it is
    const char* advice;    ///< advice for the user: why a correct image may not sum
};

/// Returns the presets: cycles, renderman, arnold, vray.
std::span<const Preset> presets();
Result<const Preset*> find_preset(const std::string& name);

/// A split of a preset that an image has.
struct FoundSplit {
    std::string title;    ///< "passes", "light groups"; with " of SECTION" if the image has several view layers
    std::string of;       ///< full name of the layer that is split
    std::string sum;      ///< expression for check_split
    std::string formula;  ///< the expression for people, without prefix and quotes
    display::Allowance allowance;
    std::string note;                  ///< which layers were left out and why; usually empty
    std::vector<std::string> missing;  ///< passes of the preset that the image lacks
};

/// Returns all splits to check, in the preset's order. `of` replaces the preset's whole if not empty. Errors: no layers
/// with these names; no layer that they split.
Result<std::vector<FoundSplit>> find_splits(const Preset& preset, const display::ExrImage& image,
                                            const std::string& of);

/// Checks one of them, with its allowance if there is no other. The partition of the result is its title in the form of
/// a file name.
Result<display::SplitResult> check_found(const display::ExrImage& image, const FoundSplit& split,
                                         const std::optional<display::Allowance>& allowance = {});

/// Returns whether the image has most layers of the renderer's beauty, under the renderer's names.
bool is_named_after(const Preset& preset, const display::ExrImage& image);

}  // namespace raylex::experiments
