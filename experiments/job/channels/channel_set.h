// Reads channels from files of any format (TOML, RIB, USD ASCII, rendermn.ini), and writes them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/channels/channel_file.h"

namespace raylex::experiments {

/// The contents of all channel files. Expressions are unchanged; expanded_channels() resolves names.
struct ChannelSet {
    lpe::ChannelFile file;                              ///< channels, macros, lobe options, warnings
    std::vector<PartitionRequest> partitions;           ///< from TOML files
    std::vector<display::StatisticRequest> statistics;  ///< from TOML files; RIB and USD have channels for them
    std::vector<AovRequest> aovs;              ///< from TOML files; RIB and USD have channels without expressions
    bool of_renderman = false;                 ///< all files are RIB or rendermn.ini, and there is at least one
    std::vector<std::string> renderman_files;  ///< RIB, rendermn.ini, and USD read in the dialect renderman
    /// Channels that a further file declares with the same meaning: their names and that file.
    std::vector<std::pair<std::string, std::string>> also_in;
    std::vector<Job> tables;    ///< from TOML files: rules, layers, typed channels, settings of [channels]
    std::vector<Error> errors;  ///< errors of single channels, which are not in `file`
};

/// Returns whether two channels have the same prefixes and match the same paths.
bool mean_the_same(const lpe::ChannelSource& a, const lpe::ChannelSource& b, const lpe::MacroTable& macros);

/// Removes duplicate channels of equal name and meaning. Adds an error to the set for a name with two meanings and for
/// an invalid macro.
void take_same_once(ChannelSet& set);

/// Returns the channel with its macros expanded.
lpe::ChannelSource without_macros(const lpe::ChannelSource& source, const lpe::MacroTable& macros);

/// Returns the format of a name: rib, usda or ini.
std::optional<lpe::ChannelFormat> channel_format_named(const std::string& name);
/// Returns the names of formats: toml, rib, usda, ini.
const std::vector<std::string>& channel_format_names();

/// Reads channel files. `format` is one of these names, or empty to decide by each file's name and content. `dialect`
/// is the dialect of files that do not declare one. If no file has a channel, the macros of rendermn.ini become
/// channels. Returns the first error of a channel, or with `every_error` a set with all errors.
Result<ChannelSet> read_channel_files(const std::vector<std::string>& paths, const std::string& format,
                                      lpe::Dialect dialect, bool every_error = false);

/// Returns the channels with names in expressions expanded. Adds notes to `warnings`.
Result<std::vector<lpe::ChannelSource>> expanded_channels(const ChannelSet& set, std::vector<std::string>& warnings);

/// Adds the set's channels, macros, lobe slots and partitions to the job, after the job's own. Channels without an
/// expression become raylex's AOVs, and filters that are rules become rules. A channel with the name of the image
/// ("beauty") that accepts all light of surfaces equals the image and is left out. `warnings` names everything left
/// out, also settings of other renderers. Errors: no channel, a duplicate name or slot.
Status add_to_job(const ChannelSet& set, Job& job, std::vector<std::string>& warnings);

/// Returns the set as text in the format; an empty format is decided by the end of `path`. `warnings` names everything
/// that the format cannot store. Errors: an expression that RenderMan cannot read, if it is the `reader`.
Result<std::string> channel_set_text(const ChannelSet& set, const std::string& path, const std::string& format,
                                     std::vector<std::string>& warnings, lpe::Reader reader);

/// Writes the text atomically to a file. An empty path, like "-", is standard output.
Status write_channel_text(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
