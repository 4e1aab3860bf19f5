// What `raylex lpe check` judges: which channels of files are layers of a split, what they are held against, and the
// paths that there are.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/cli/lpe/commands.h"

namespace raylex::experiments {

/// --volume, --no-volume, --groups, --labels, --all-labelled.
struct PathOptions {
    bool volume = false, no_volume = false, all_labelled = false;
    std::vector<std::string> groups, labels;
};
void add_path_options(CLI::App& command, PathOptions& options);

/// The paths of the scene, else all, cut by the options; without a word on volumes RIB and rendermn.ini have none
/// unless an expression names V.
Result<lpe::Words> words_of(const PathOptions& options, const std::optional<SceneWords>& scene, const ChannelSet& set,
                            std::span<const lpe::ChannelSource> channels);

/// What of the channels is written for RenderMan: nothing, or all, with macros or with what they stand for.
enum class Written : std::uint8_t { nothing, with_macros, without_macros };

/// The channels as expressions. Every one that cannot be read is an error of the list, as are the set's own errors; for
/// a reader of RenderMan's also what its files, or all channels where they are written for it, have of ours. The list
/// is in the order of the files' lines. Warnings are printed.
std::vector<lpe::ChannelSource> read_all(const ChannelSet& set, std::vector<Error>& errors, lpe::Reader reader,
                                         Written written);

struct Layers {
    std::vector<lpe::ChannelSource> sources;
    std::optional<lpe::ChannelSource> whole;                     ///< what they are held against; none: every path
    std::string whole_name;                                      ///< the channel that it is, or empty
    std::vector<std::pair<std::string, std::string>> no_layers;  ///< names, and why they are no part of the split
};

/// Of channels from files, those with prefixes, with statistics other than the mean, and those that are the whole
/// itself are no layers. `of` is --of, or none. Errors: nothing is left; the algebra's.
Result<Layers> choose_layers(const ChannelSet& set, std::vector<lpe::ChannelSource> sources,
                             std::optional<lpe::ChannelSource> of, const lpe::Words& words);

}  // namespace raylex::experiments
