// Runs the program inside a test's process, so that the test can inject file faults (display::set_file_fault).
#pragma once

#include <fcntl.h>
#include <unistd.h>
#include <cstdio>
#include <string>
#include <vector>

#include "experiments/cli/command_line.h"

namespace raylex::test {

/// Runs the program without output and returns its exit code.
inline int run_here(const std::vector<std::string>& arguments) {
    std::vector<const char*> words{"raylex"};
    for (const std::string& each : arguments) words.push_back(each.c_str());
    std::fflush(stdout);
    std::fflush(stderr);
    const int null = open("/dev/null", O_WRONLY), out = dup(1), err = dup(2);
    dup2(null, 1);
    dup2(null, 2);
    const int code = raylex::experiments::run_command_line(static_cast<int>(words.size()), words.data());
    std::fflush(stdout);
    std::fflush(stderr);
    dup2(out, 1);
    dup2(err, 2);
    for (const int each : {null, out, err}) close(each);
    return code;
}

}  // namespace raylex::test
