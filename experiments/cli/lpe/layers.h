// The input of `raylex lpe check`: the channels that are layers of a split, the whole that they split, and the set of
// paths.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/cli/lpe/commands.h"

namespace raylex::experiments {

/// Values of --volume, --no-volume, --groups, --labels and --all-labelled.
struct PathOptions {
    bool volume = false, no_volume = false, all_labelled = false;
    std::vector<std::string> groups, labels;
};
void add_path_options(CLI::App& command, PathOptions& options);

/// Returns the paths of the scene, or all paths, restricted by the options. By default, RIB and rendermn.ini files
/// exclude paths with volumes unless an expression names V.
Result<lpe::PathStrings> path_strings_of(const PathOptions& options, const std::optional<ScenePathStrings>& scene,
                                         const ChannelSet& set, std::span<const lpe::ChannelSource> channels);

/// Which channels are written for RenderMan: none, or all, with macros or with macros expanded.
enum class Written : std::uint8_t { nothing, with_macros, without_macros };

/// Returns the channels as expressions and prints warnings. Adds to `errors`, in the order of the files' lines: the
/// set's own errors and all expressions that cannot be read; for a RenderMan reader also all uses of raylex's
/// extensions.
std::vector<lpe::ChannelSource> read_all(const ChannelSet& set, std::vector<Error>& errors, lpe::Reader reader,
                                         Written written);

struct Layers {
    std::vector<lpe::ChannelSource> sources;
    std::optional<lpe::ChannelSource> whole;  ///< what they must sum to; none: every path
    std::string whole_name;                   ///< the name of the channel that is the whole, or empty
    /// names of other channels, and why they are not layers
    std::vector<std::pair<std::string, std::string>> no_layers;
};

/// Chooses the layers. Channels of files are not layers if they have prefixes or statistics other than the mean, or
/// equal the whole. `of` is the value of --of, or none. Errors: no layer is left; errors of the algebra.
Result<Layers> choose_layers(const ChannelSet& set, std::vector<lpe::ChannelSource> sources,
                             std::optional<lpe::ChannelSource> of, const lpe::PathStrings& words);

}  // namespace raylex::experiments
