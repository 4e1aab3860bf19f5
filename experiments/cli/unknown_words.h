// What stands on a command line and is not known, each with its near miss.
#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

namespace raylex::experiments {

/// "raylex lpe explain".
std::string command_words(const CLI::App& command);

/// "expected one of: match, check".
std::string expected_subcommands(const CLI::App& command);
/// "unknown subcommand 'rendr'; expected one of: ...", and what may have been meant.
std::string unknown_subcommand(const CLI::App& command, const std::string& word);

/// "unknown option '--threds'; did you mean '--threads'?" of the first one that `command` or one above it was given
/// and left over, or empty.
std::string unknown_option(const CLI::App& command);

/// For commands that take all that is left over, which may stand behind "--". Throws CLI::ExtrasError where an option
/// is among it, so that the error reads as that of any other command.
std::vector<std::string> further_words(const CLI::App& command);

}  // namespace raylex::experiments
