// Channels from files of any format (TOML, RIB, USD ASCII, rendermn.ini), and back into them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/channels/channel_file.h"

namespace raylex::experiments {

/// What the files say, taken together. Expressions stand as the files have them; expanded_channels() resolves names.
struct ChannelSet {
    lpe::ChannelFile file;                              ///< channels, macros, lobe options, warnings
    std::vector<PartitionRequest> partitions;           ///< of TOML files
    std::vector<display::StatisticRequest> statistics;  ///< of TOML files; RIB and USD have channels of them
    std::vector<AovRequest> aovs;              ///< of TOML files; RIB and USD have channels without expressions
    bool of_renderman = false;                 ///< some file is RIB or rendermn.ini, and none is of another kind
    std::vector<std::string> renderman_files;  ///< RIB, rendermn.ini, and USD read in the dialect renderman
    /// Channels that stand in a further file too, with the same meaning: their names and that file.
    std::vector<std::pair<std::string, std::string>> also_in;
    std::vector<Job> tables;    ///< TOML files: rules, layers, typed channels, what [channels] asks for
    std::vector<Error> errors;  ///< of single channels, which are not in `file`
};

/// Whether two channels have the same prefixes and count the same paths.
bool mean_the_same(const lpe::ChannelSource& a, const lpe::ChannelSource& b, const lpe::MacroTable& macros);

/// Channels of one name that mean the same are one from here on. A name that stands for two meanings, and a macro that
/// cannot be one, is added to the set's errors.
void take_same_once(ChannelSet& set);

/// The channel with the macros in place of their names, where it has any; else as it stands.
lpe::ChannelSource without_macros(const lpe::ChannelSource& source, const lpe::MacroTable& macros);

/// rib, usda or ini.
std::optional<lpe::ChannelFormat> channel_format_named(const std::string& name);
/// Names of formats: toml, rib, usda, ini.
const std::vector<std::string>& channel_format_names();

/// `format` is a name of the list above, or empty: by each file's name and content. `dialect` is that of expressions
/// whose file does not say. When no file has a channel, the macros of rendermn.ini are the channels. The first error of
/// a single channel is the result, or with `every_error` all are in the set.
Result<ChannelSet> read_channel_files(const std::vector<std::string>& paths, const std::string& format,
                                      lpe::Dialect dialect, bool every_error = false);

/// The channels with their names replaced by what they stand for; what is worth knowing is added to `warnings`.
Result<std::vector<lpe::ChannelSource>> expanded_channels(const ChannelSet& set, std::vector<std::string>& warnings);

/// Makes the set's channels, names, lobe slots and partitions a job's, after those it has; channels without an
/// expression become the AOVs that raylex has by their sources, and filters that are rules become rules. A channel with
/// the name of the image itself ("beauty") that takes all light of surfaces is what the image is anyway, and left out.
/// What is left out, settings that only other renderers know included, is named in `warnings`. Errors: no channel at
/// all, a name or slot that is there twice.
Status add_to_job(const ChannelSet& set, Job& job, std::vector<std::string>& warnings);

/// The set as a text of the format; an empty format is told by the end of `path`. What the format cannot hold is left
/// out and named in `warnings`. Errors: for RenderMan (`reader`) an expression that it does not read.
Result<std::string> channel_set_text(const ChannelSet& set, const std::string& path, const std::string& format,
                                     std::vector<std::string>& warnings, lpe::Reader reader);

/// Writes the text to a file that appears whole or not at all; an empty path is standard output, as "-" is.
Status write_channel_text(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
