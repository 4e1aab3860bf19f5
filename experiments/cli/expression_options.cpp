#include "experiments/cli/expression_options.h"

#include <algorithm>
#include <utility>

#include "experiments/job/channels/channel_set.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

SourceLocation at_option(const std::string& name) {
    return {name, 0, 0};
}

/// Adds the channels of a file to the job, as one --lpe per channel would. Applies the entries of `renames`, OLD=NEW,
/// that name one of these channels, and removes them from the list.
Status read_channel_file(const std::string& file, lpe::Dialect dialect, std::vector<std::string>& renames, Job& job) {
    auto set = read_channel_files({file}, {}, dialect);
    if (!set) return set.error();
    for (lpe::FileChannel& channel : set->file.channels) {
        const auto rename = std::find_if(renames.begin(), renames.end(), [&](const std::string& each) {
            return each.starts_with(channel.source.name + "=");
        });
        if (rename == renames.end()) continue;
        channel.source.name = rename->substr(channel.source.name.size() + 1);
        renames.erase(rename);
    }
    std::vector<std::string> warnings = std::move(set->file.warnings);
    Status added = add_to_job(*set, job, warnings);
    if (!added) {
        Error error = added.error();
        if (error.file == "--channels") error.file = file;
        return error;
    }
    for (const std::string& warning : warnings) print_warning(warning);
    return added;
}

}  // namespace

Result<ExpressionRequest> parse_named_expression(const std::string& text, lpe::Dialect dialect,
                                                 const std::string& option) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        return error_at(
            at_option(option),
            "'" + text + "' is not a named expression; expected NAME=EXPR, such as caustics='CDS+L'" +
                std::string(option == "channel" ? ", or a file of channels: .toml, .rib, .usda, .usd or .ini" : ""));
    ExpressionRequest request;
    request.name = text.substr(0, equals);
    request.expression = text.substr(equals + 1);
    request.dialect = dialect;
    take_dialect_mark(request.expression, request.dialect);
    request.location = at_option(option + " " + request.name);
    return request;
}

void add_expression_options(const OptionGroup& group) {
    for (const char* flag : {"--lpe", "--channels", "--rename", "--dialect", "--partition", "--light-groups"})
        group.add(setting_of_flag(flag));
}

bool has_expressions(const CLI::App& command) {
    for (const char* flag : {"--lpe", "--channels", "--partition", "--light-groups"})
        if (command.count(flag) > 0) return true;
    return false;
}

Status read_expressions(const CLI::App& command, Job& job) {
    const auto values = [&](const char* flag) { return command.get_option(flag)->results(); };
    const std::vector<std::string> dialects = values("--dialect"), expressions = values("--lpe"),
                                   files = values("--channels");
    lpe::Dialect dialect = lpe::Dialect::renderman;
    std::size_t next_expression = 0, next_dialect = 0, next_file = 0;
    bool rules_nothing = false;
    const auto check_dialect = [&]() -> Status {
        if (!rules_nothing) return success();
        return error_at(at_option("--dialect"),
                        "no --lpe or --channels follows '--dialect " + dialects[next_dialect - 1] +
                            "', which applies to those after it; expected --dialect before them");
    };
    std::vector<std::string> renames = values("--rename");
    for (const CLI::Option* option : command.parse_order()) {
        if (option->get_name() == "--dialect") {
            if (Status used = check_dialect(); !used) return used;
            auto parsed = parse_dialect(dialects[next_dialect++], at_option("--dialect"));
            if (!parsed) return parsed.error();
            dialect = *parsed;
            rules_nothing = true;
        } else if (option->get_name() == "--lpe") {
            auto request = parse_named_expression(expressions[next_expression++], dialect, "--lpe");
            if (!request) return request.error();
            job.expressions.push_back(std::move(*request));
            rules_nothing = false;
        } else if (option->get_name() == "--channels") {
            const std::string& file = files[next_file++];
            if (Status read = read_channel_file(file, dialect, renames, job); !read) return read;
            rules_nothing = false;
        }
    }
    if (Status used = check_dialect(); !used) return used;
    if (!renames.empty())
        return error_at(at_option("--rename"), "no --channels file declares the channel of '" + renames.front() +
                                                   "'; expected OLD=NEW, the name of such a channel before '='");
    job.shipped_partition = job.shipped_partition || command.count("--partition") > 0;
    job.light_groups = job.light_groups || command.count("--light-groups") > 0;
    return success();
}

}  // namespace raylex::experiments
