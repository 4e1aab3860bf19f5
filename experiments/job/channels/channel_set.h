// Channels from files of any format (TOML, RIB, USD ASCII, rendermn.ini), and back into them.
#pragma once

#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/channels/channel_file.h"

namespace raylex::experiments {

/// What the files say, taken together. Expressions stand as the files have them; expanded_channels() resolves names.
struct ChannelSet {
    lpe::ChannelFile file;                     ///< channels, macros, lobe options, warnings
    std::vector<PartitionRequest> partitions;  ///< of TOML files
    bool of_renderman = false;                 ///< some file is RIB or rendermn.ini, and none is of another kind
};

/// Names of formats: toml, rib, usda, ini.
const std::vector<std::string>& channel_format_names();

/// `format` is a name of the list above, or empty: by each file's name and content. `dialect` is that of expressions
/// whose file does not say. When no file has a channel, the macros of rendermn.ini are the channels.
Result<ChannelSet> read_channel_files(const std::vector<std::string>& paths, const std::string& format,
                                      lpe::Dialect dialect);

/// The channels with their names replaced by what they stand for; what is worth knowing is added to `warnings`.
Result<std::vector<lpe::ChannelSource>> expanded_channels(const ChannelSet& set, std::vector<std::string>& warnings);

/// Makes the set's channels, names, lobe slots and partitions a job's, after those it has. A channel with the name of
/// the image itself ("beauty") that takes all light of surfaces is what the image is anyway, and left out. What is left
/// out, settings that only other renderers know included, is named in `warnings`. Errors: no channel at all, a name or
/// slot that is there twice.
Status add_to_job(const ChannelSet& set, Job& job, std::vector<std::string>& warnings);

/// The set as a text of the format; an empty format is told by the end of `path`. What the format cannot hold is left
/// out and named in `warnings`.
Result<std::string> channel_set_text(const ChannelSet& set, const std::string& path, const std::string& format,
                                     std::vector<std::string>& warnings);

/// Writes the text to a file that appears whole or not at all; an empty path is standard output, as "-" is.
Status write_channel_text(const std::string& text, const std::string& path);

}  // namespace raylex::experiments
