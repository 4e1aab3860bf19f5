// Errors for unknown words on a command line, each with the closest match.
#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

namespace raylex::experiments {

/// Returns the words of a command: "raylex lpe explain".
std::string command_words(const CLI::App& command);

/// Lists the subcommands: "expected one of: match, check".
std::string expected_subcommands(const CLI::App& command);
/// Returns the error message of an unknown subcommand: "unknown subcommand 'rendr'; expected one of: ...", with the
/// closest match.
std::string unknown_subcommand(const CLI::App& command, const std::string& word);

/// Returns the error message of the first option that `command`, or a command above it, was given and did not
/// recognise: "unknown option '--threds'; did you mean '--threads'?". Empty if there is none.
std::string unknown_option(const CLI::App& command);

/// Returns the remaining words of a command that accepts any number of them, also after "--". Throws CLI::ExtrasError
/// if one of them is an option, so that the error message is the usual one.
std::vector<std::string> further_words(const CLI::App& command);

}  // namespace raylex::experiments
