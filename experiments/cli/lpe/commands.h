// The groups of `raylex lpe` subcommands, one file each, and what they share: the dialect option, and channels from the
// command line.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/cli/commands.h"
#include "experiments/job/channels/channel_set.h"
#include "experiments/job/channels/scene_path_strings.h"
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

/// The value of --dialect.
struct DialectOption {
    std::string name = "renderman";
    [[nodiscard]] lpe::Dialect value() const;
};
CLI::Option* add_dialect_option(CLI::App& command, DialectOption& dialect);

/// The values of --scene and --plugin. Proofs are then relative to the paths that the scene can produce.
struct SceneOption {
    std::string path;
    std::vector<std::string> plugins;  ///< plugins that the scene needs
    /// Returns the paths that the scene can produce; nothing without a scene.
    [[nodiscard]] Result<std::optional<ScenePathStrings>> load() const;
};
CLI::Option* add_scene_option(CLI::App& command, SceneOption& scene);
/// Returns the words of the scene; without a scene, all words.
lpe::PathStrings path_strings_of(const std::optional<ScenePathStrings>& scene);
/// Warns of channels that match no path of the scene, and of labels that nothing in the scene has.
void warn_about_scene(std::span<const lpe::ChannelSource> channels, const std::optional<ScenePathStrings>& scene);

/// Channels from the command line: NAME=EXPR arguments and channel files. An argument that names an existing channel
/// file (.rib, .usda, .usd, .ini, .toml) is read as a file.
struct ChannelArguments {
    std::vector<std::string> named, files;
    std::string format;  ///< format of the files; empty: by name and contents
};
CLI::Option* add_channel_arguments(CLI::App& command, ChannelArguments& arguments);
/// Adds --channels and --format.
CLI::Option* add_channel_files(CLI::App& command, ChannelArguments& arguments);

/// Returns whether an argument is the path of a channel file. Errors: the argument also reads as NAME=EXPR, or it ends
/// like a channel file but does not exist.
Result<bool> is_channel_file(const std::string& text);
/// Moves the file names among the arguments to `arguments.files`. Each command calls this first.
Status take_channel_files(ChannelArguments& arguments);

/// Reads the channels of files and arguments and prints warnings. Returns the first error, or with `every_error` a set
/// that contains all errors.
Result<ChannelSet> read_channel_set(const ChannelArguments& arguments, lpe::Dialect dialect, bool every_error = false);

/// Returns the channels of the set, with names in expressions resolved, and prints warnings. Errors: the set has no
/// channel.
Result<std::vector<lpe::ChannelSource>> resolved_channels(const ChannelSet& set, const ChannelArguments& arguments);

/// Returns the channels of files and arguments, with names in expressions resolved, and prints warnings. Commands use
/// only this result. Errors: there is no channel.
Result<std::vector<lpe::ChannelSource>> read_channels(const ChannelArguments& arguments, lpe::Dialect dialect);

/// Returns the channel of a file that is named `text`, or `text` as an expression that may use the files' macros.
/// `what` names the argument in errors ("--of").
Result<lpe::ChannelSource> channel_or_expression(const std::string& text, const ChannelArguments& arguments,
                                                 lpe::Dialect dialect, const std::string& what);

/// Returns the error for a text that is neither a channel of the set nor an expression. The hint suggests names of the
/// set.
Error about_channel_name(Error error, const std::string& text, const ChannelSet& set);

/// Values of -o and --write-as: output file and format of channels.
struct ChannelOutput {
    std::string path, format;
};
void add_channel_output(CLI::App& command, ChannelOutput& output, const std::string& description);
/// Writes the set. Warns of everything that the format cannot store.
Status write_channels(const ChannelSet& set, const ChannelOutput& output, lpe::Reader reader);

/// The value of --for: the program whose syntax channels in RenderMan's formats must follow.
struct ReaderOption {
    std::string name = "renderman";
    [[nodiscard]] lpe::Reader value() const { return name == "raylex" ? lpe::Reader::raylex : lpe::Reader::renderman; }
};
CLI::Option* add_reader_option(CLI::App& command, ReaderOption& reader);

/// Returns an expression from the command line as a channel source. `what` names it in errors ("expression", "--of").
lpe::ChannelSource bare_expression(std::string_view text, lpe::Dialect dialect, std::string name, std::string what);

/// Prints the result and the events of the counterexample, and returns the exit code.
int print_result(bool holds, const std::string& summary, const lpe::Witness& witness,
                 const std::vector<std::string>& warnings);

/// Returns an error about a command-line text, shown with that text.
Error about_argument(Error error, const std::string& what, const std::string& text);

}  // namespace raylex::experiments
