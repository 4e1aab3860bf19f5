#include "experiments/cli/input_options.h"

#include <cstdlib>
#include <string>
#include <vector>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include "experiments/program/interrupt.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {

namespace {

constexpr const char* variable = "RAYLEX_BUDGETS";
constexpr const char* file_options[] = {"--output", "--stats",    "--deep",  "--atlas",   "--ocio",  "--to",
                                        "--plugin", "--channels", "--scene", "--preview", "--driver"};

/// Sets budgets and adds them to the environment, so that child processes (the runs of a study) use them too. Returns
/// an error message, or an empty string.
std::string raise_budgets(const std::vector<std::string>& assignments) {
    const char* earlier = std::getenv(variable);
    std::string all = earlier != nullptr ? earlier : "";
    for (const std::string& each : assignments) {
        if (Status set = set_budget(each); !set) return set.error().message;
        all += (all.empty() ? "" : ",") + each;
    }
    ::setenv(variable, all.c_str(), 1);
    return {};
}

void add_to(CLI::App& command) {
    for (CLI::App* each : command.get_subcommands([](CLI::App*) { return true; })) add_to(*each);
    for (const char* name : file_options)
        if (CLI::Option* option = command.get_option_no_throw(name))
            option->check([](const std::string& value) {
                return value.empty() ? std::string("the name is empty; expected the name of a file") : std::string();
            });
    if (!command.get_subcommands([](CLI::App*) { return true; }).empty()) return;
    command
        .add_option_function<std::vector<std::string>>(
            "--budget",
            [](const std::vector<std::string>& assignments) {
                if (const std::string wrong = raise_budgets(assignments); !wrong.empty())
                    throw CLI::ValidationError("--budget", wrong);
            },
            "raises or lowers a safety limit for reading files, such as include_files=20000 (suffixes K, M, G: powers "
            "of 1024); "
            "experiments/docs/rendering/limits.md lists the limits")
        ->option_text("NAME=VALUE")
        ->allow_extra_args(false)
        ->trigger_on_parse();
}

}  // namespace

Status prepare_reading() {
    stop_reading_when(&interrupt_flag());
    const char* assignments = std::getenv(variable);
    if (assignments == nullptr) return success();
    Status set = set_budgets(assignments);
    if (set) return set;
    Error error = set.error();
    error.file = std::string("the environment variable ") + variable;
    return error;
}

void add_input_options(CLI::App& app) {
    add_to(app);
}

}  // namespace raylex::experiments
