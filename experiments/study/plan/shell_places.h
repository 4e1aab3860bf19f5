// The command of a renderer outside this program: places such as {scene}, and how values are put in without a shell
// reading them.
#pragma once

#include <string>

#include "display/services/parameters.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A line for a shell, and the environment that it gets beside this program's own.
struct ShellCommand {
    std::string text;
    NamedValues environment;
};

/// The command with {scene} and so on filled in; ${scene} is the shell's own. A value never becomes text that a shell
/// reads: one of nothing but letters, digits and _./:,+@%=- stands as it is, any other travels in the environment as
/// RAYLEX_SCENE and so on (all places do), and its place becomes that variable, quoted as the text around it asks.
/// Errors, at `where`: such a value in a command that hands text to another shell (eval, sh -c, ssh) or in a here
/// document.
Result<ShellCommand> fill_command(const std::string& command, const NamedValues& places, const SourceLocation& where);
/// Whether the command asks for it, as {spp} or by the variable that has it.
bool has_place(const std::string& command, const std::string& name);
/// RAYLEX_SCENE for "scene", RAYLEX_INTEGRATOR_STRATEGY for "integrator.strategy".
std::string place_variable(const std::string& name);

}  // namespace raylex::experiments
