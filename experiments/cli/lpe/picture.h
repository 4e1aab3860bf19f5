// The complete result of a check, as text for people and as JSON for tools.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/cli/lpe/layers.h"
#include "lpe/algebra/proofs/overview.h"
#include "lpe/algebra/proofs/sorting.h"

namespace raylex::experiments {

struct CheckPicture {
    std::string partition;           ///< its name, if a TOML file declares it
    std::size_t channels = 0;        ///< number of channels read
    std::vector<std::string> files;  ///< files of the channels
    Layers layers;
    lpe::PathStrings words;
    bool alone = false;  ///< one of several files; the result of all together decides
    bool holds = false;
    std::string result;  ///< "partition", "missed", "counted twice", "outside", "disjoint", "overlaps"
    std::string summary;
    lpe::Witness witness;
    std::vector<std::string> warnings;
    lpe::Overview overview;  ///< empty if the check holds
    lpe::Sorting sorting;    ///< of overlapping layers from files
    std::string rest;        ///< an expression of the missed paths, or empty
    std::string rest_note;   ///< which programs read it, or why there is none
};

/// Prints to standard output the files and channels, the overlaps, the gaps, the result and the counterexample.
void print_picture(const CheckPicture& picture);

/// Returns a JSON array with one object per picture.
std::string pictures_as_json(const std::vector<CheckPicture>& pictures);

}  // namespace raylex::experiments
