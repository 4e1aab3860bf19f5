// The groups of `raylex lpe` subcommands, one file each, and what they share: dialects, and channels from the command
// line.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/cli/commands.h"
#include "experiments/job/channels/channel_set.h"
#include "experiments/job/channels/scene_words.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::experiments {

// Each adds its subcommands to `raylex lpe`.
void add_lpe_match_commands(CLI::App& lpe, CommandContext& context);     ///< match, vectors
void add_lpe_check_commands(CLI::App& lpe, CommandContext& context);     ///< check
void add_lpe_relation_commands(CLI::App& lpe, CommandContext& context);  ///< equal, contains, empty
void add_lpe_path_commands(CLI::App& lpe,
                           CommandContext& context);  ///< words, complement, intersection, union, difference
void add_lpe_explain_commands(CLI::App& lpe, CommandContext& context);  ///< explain
void add_lpe_graph_commands(CLI::App& lpe, CommandContext& context);    ///< graph
void add_lpe_split_commands(CLI::App& lpe, CommandContext& context);    ///< split
void add_lpe_truth_command(CLI::App& lpe, CommandContext& context);     ///< truth

/// --dialect.
struct DialectOption {
    std::string name = "renderman";
    [[nodiscard]] lpe::Dialect value() const;
};
CLI::Option* add_dialect_option(CLI::App& command, DialectOption& dialect);

/// --scene: the paths that proofs are relative to.
struct SceneOption {
    std::string path;
    std::vector<std::string> plugins;  ///< --plugin, for scenes that need them
    /// What the scene can produce; nothing when no scene is given, and every path counts.
    [[nodiscard]] Result<std::optional<SceneWords>> load() const;
};
CLI::Option* add_scene_option(CLI::App& command, SceneOption& scene);
/// The words of the scene, or every word.
lpe::Words words_of(const std::optional<SceneWords>& scene);
/// Warns of channels that can match nothing in the scene, and of labels that nothing in it has.
void warn_about_scene(std::span<const lpe::ChannelSource> channels, const std::optional<SceneWords>& scene);

/// Channels as a command takes them: NAME=EXPR arguments, and files.
/// A text among the arguments that names an existing channel file (.rib, .usda, .usd, .ini, .toml) is one.
struct ChannelArguments {
    std::vector<std::string> named, files;
    std::string format;  ///< of the files; empty: by their names and contents
};
CLI::Option* add_channel_arguments(CLI::App& command, ChannelArguments& arguments);
/// --channels and --format alone.
CLI::Option* add_channel_files(CLI::App& command, ChannelArguments& arguments);

/// Whether the text given by itself is the path of a channel file. Errors: it is as well NAME=EXPR, or ends as one and
/// is not there.
Result<bool> is_channel_file(const std::string& text);
/// Takes the files among the arguments to the files. Commands do so first.
Status take_channel_files(ChannelArguments& arguments);

/// What the files and the arguments say, each channel with its own name; warnings are printed. The first error of a
/// single channel is the result, or with `every_error` all are in the set.
Result<ChannelSet> read_channel_set(const ChannelArguments& arguments, lpe::Dialect dialect, bool every_error = false);

/// The set's channels, names in expressions resolved; warnings are printed. Errors: no channel at all.
Result<std::vector<lpe::ChannelSource>> resolved_channels(const ChannelSet& set, const ChannelArguments& arguments);

/// The channels of files and arguments, names in expressions resolved, each with its own name; warnings are printed.
/// Commands work on what this returns and on nothing else. Errors: no channel at all.
Result<std::vector<lpe::ChannelSource>> read_channels(const ChannelArguments& arguments, lpe::Dialect dialect);

/// What a text given by itself means beside files: the channel of that name in them, or an expression that may use
/// their macros. `what` names it in errors ("--of").
Result<lpe::ChannelSource> channel_or_expression(const std::string& text, const ChannelArguments& arguments,
                                                 lpe::Dialect dialect, const std::string& what);

/// The error of a text that is no channel of the set, and no expression: the hint is about the names of the set.
Error about_channel_name(Error error, const std::string& text, const ChannelSet& set);

/// -o and --write-as: where channels are written, and as what.
struct ChannelOutput {
    std::string path, format;
};
void add_channel_output(CLI::App& command, ChannelOutput& output, const std::string& description);
/// Writes the set; what had to be left out is printed as warnings.
Status write_channels(const ChannelSet& set, const ChannelOutput& output, lpe::Reader reader);

/// --for: whose language the channels of RenderMan's formats are held to.
struct ReaderOption {
    std::string name = "renderman";
    [[nodiscard]] lpe::Reader value() const { return name == "raylex" ? lpe::Reader::raylex : lpe::Reader::renderman; }
};
CLI::Option* add_reader_option(CLI::App& command, ReaderOption& reader);

/// An expression given by itself; `what` names it in errors ("expression", "--of").
lpe::ChannelSource bare_expression(std::string_view text, lpe::Dialect dialect, std::string name, std::string what);

/// Prints the verdict, then the path against it as events, and returns the exit code.
int print_verdict(bool holds, const std::string& summary, const lpe::Witness& witness,
                  const std::vector<std::string>& warnings);

/// An error about a text of the command line, shown under that text.
Error about_argument(Error error, const std::string& what, const std::string& text);

}  // namespace raylex::experiments
