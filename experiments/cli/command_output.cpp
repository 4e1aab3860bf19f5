#include "experiments/cli/command_output.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>

#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

/// Options whose values are files or folders. The value of --plugin or --ocio can also be a name instead of a file.
const std::set<std::string> path_options{"-o",       "--output",   "--stats", "--ocio",       "--atlas",
                                         "--plugin", "--channels", "--to",    "--references", "--guide-file"};

bool is_path_option(const CLI::Option& option) {
    const auto listed = [](const std::vector<std::string>& names, const char* dashes) {
        return std::any_of(names.begin(), names.end(),
                           [&](const std::string& name) { return path_options.contains(dashes + name); });
    };
    return listed(option.get_lnames(), "--") || listed(option.get_snames(), "-");
}

std::string value_standing_alone(const CLI::Option& option, const std::string& value) {
    if (!is_path_option(option) || is_standard_output(value)) return value;
    std::error_code failed;
    const bool by_name = option.check_lname("plugin") || option.check_lname("ocio");
    return by_name && !fs::exists(value, failed) ? value : absolute_path(value);
}

}  // namespace

void add_command_output_options(CLI::App& command, CommandOutputOptions& options, const std::string& group) {
    std::string formats;
    for (const std::string& each : command_formats()) formats += (formats.empty() ? "" : ", ") + each;
    command
        .add_flag("--commands{shell}", options.format,
                  "prints one command per shard instead of running them, and the commands that follow. A command runs "
                  "by itself, can be restarted, and does nothing if its work is done. =FORMAT: " +
                      formats + ", or the file of your own template")
        ->group(group.empty() ? "Options" : group);
    CLI::Option* uncalibrated = command.get_option_no_throw("--no-calibration");
    if (uncalibrated == nullptr)
        command
            .add_flag("--no-calibration", options.no_calibration,
                      "with --commands: skips the test render; the CPU seconds are then unknown")
            ->group(group.empty() ? "Options" : group);
}

std::vector<std::string> standing_alone(const CLI::App& command, const std::vector<std::string>& arguments,
                                        const std::set<std::string>& without) {
    std::vector<std::string> result{program_path()};
    auto at = arguments.begin();
    std::vector<std::string> names{command.get_name()};
    for (const CLI::App* above = command.get_parent(); above->get_parent() != nullptr; above = above->get_parent())
        names.insert(names.begin(), above->get_name());
    for (const std::string& name : names) {
        at = std::find(at, arguments.end(), name);
        if (at != arguments.end()) ++at;
        result.push_back(name);
    }
    std::error_code failed;
    for (; at != arguments.end(); ++at) {
        // Forms: --name value, --name=value, -n value, -nvalue
        const bool is_long = at->starts_with("--");
        const std::size_t equals = is_long ? at->find('=') : std::string::npos;
        const bool joined = is_long ? equals != std::string::npos : at->size() > 2;
        const std::string name = at->substr(0, is_long ? equals : 2);
        const CLI::Option* option =
            name.size() > 1 && name.front() == '-' ? command.get_option_no_throw(name) : nullptr;
        if (option == nullptr) {  // a positional argument: a scene or a config
            result.push_back(fs::exists(*at, failed) ? absolute_path(*at) : *at);
            continue;
        }
        const bool takes_value = option->get_expected_min() > 0, apart = takes_value && !joined;
        const bool kept = !without.contains(name);
        if (kept) result.push_back(takes_value ? name : *at);
        if (apart && std::next(at) != arguments.end()) ++at;
        if (kept && takes_value)
            result.push_back(value_standing_alone(*option, apart ? *at : at->substr(is_long ? equals + 1 : 2)));
    }
    return result;
}

std::string absolute_path(const std::string& path) {
    return fs::absolute(path).lexically_normal().string();
}

int print_commands(const CommandPlan& plan, const std::string& format) {
    auto text = plan_text(plan, format);
    if (!text) return report_error(text.error());
    write_output(*text);
    return exit_holds;
}

}  // namespace raylex::experiments
