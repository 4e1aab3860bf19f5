// The command of an external renderer: placeholders such as {scene}, and the safe insertion of values.
#pragma once

#include <string>

#include "display/services/parameters.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A shell command, and the environment variables that are added to raylex's own.
struct ShellCommand {
    std::string text;
    NamedValues environment;
};

/// Fills in {scene} and other placeholders; ${scene} belongs to the shell. A shell never interprets a value: a value of
/// only letters, digits and _./:,+@%=- is inserted directly; any other is passed in the environment as RAYLEX_SCENE and
/// so on (like all values), and its placeholder becomes that variable with quotes as the context requires. Errors at
/// `where`: such a value in a command that passes text to another shell (eval, sh -c, ssh) or in a here document.
Result<ShellCommand> fill_command(const std::string& command, const NamedValues& places, const SourceLocation& where);
/// Returns whether the command uses the placeholder, as {spp} or as its variable.
bool has_place(const std::string& command, const std::string& name);
/// Returns the variable of a placeholder: RAYLEX_SCENE for "scene", RAYLEX_INTEGRATOR_STRATEGY for
/// "integrator.strategy".
std::string place_variable(const std::string& name);

}  // namespace raylex::experiments
