// The whole picture of a check, for people and for tools.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/cli/lpe/layers.h"
#include "lpe/algebra/proofs/overview.h"
#include "lpe/algebra/proofs/sorting.h"

namespace raylex::experiments {

struct CheckPicture {
    std::string partition;           ///< its name where a TOML file declares it
    std::size_t channels = 0;        ///< that were read
    std::vector<std::string> files;  ///< they came from
    Layers layers;
    lpe::Words words;
    bool alone = false;  ///< one file of several, whose verdict together decides
    bool holds = false;
    std::string verdict;  ///< "partition", "missed", "counted twice", "outside", "disjoint", "overlaps"
    std::string summary;
    lpe::Witness witness;
    std::vector<std::string> warnings;
    lpe::Overview overview;  ///< empty where it holds
    lpe::Sorting sorting;    ///< of layers from files that overlap
    std::string rest;        ///< an expression for what is missed, or empty
    std::string rest_note;   ///< who reads it, or why there is none
};

/// To standard output: what was read, where it came from files; overlaps, holes; the verdict, and the path against it.
void print_picture(const CheckPicture& picture);

/// One JSON array with an object for each picture.
std::string pictures_as_json(const std::vector<CheckPicture>& pictures);

}  // namespace raylex::experiments
