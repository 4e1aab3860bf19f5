// Other programs, run to their end without a shell.
#pragma once

#include <string>
#include <vector>

#include "lpe/result.h"

namespace raylex::experiments {

struct ProgramOutcome {
    int exit_code = 0;           ///< 128 + signal if a signal ended the program
    std::string output, errors;  ///< what it wrote to standard output and standard error
};

/// Runs the program `arguments[0]`, found in PATH, with `input` as its standard input. Errors: the program does not
/// start.
Result<ProgramOutcome> run_program(const std::vector<std::string>& arguments, const std::string& input = {});

}  // namespace raylex::experiments
