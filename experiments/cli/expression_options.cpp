#include "experiments/cli/expression_options.h"

#include <algorithm>
#include <utility>

#include <CLI/Validators.hpp>

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

void add_expression_options(const OptionGroup& group, ExpressionOptions& options) {
    group.add_repeated("--lpe", options.expressions, "NAME=EXPR",
                       "adds a layer NAME with the light that the light path expression accepts");
    group.add_repeated("--channels", options.channel_files, "FILE",
                       "adds a layer for each channel of a file, and the partitions that the file declares. The file "
                       "has RIB DisplayChannel lines, rendermn.ini settings, USD ASCII RenderVar prims or TOML");
    group.add_repeated("--rename", options.renames, "OLD=NEW",
                       "gives the layer of channel OLD the name NEW, for files whose channels have the same name");
    group.add_repeated(
        "--dialect", options.dialects, "D",
        "syntax of the --lpe options and USD channel files after this option: renderman (default) or osl");
    group
        .add("--partition", options.partition, "shipped",
             "'shipped' adds the layers of the partition that comes with raylex")
        ->check(CLI::IsMember({"shipped"}));
    group.add_flag("--light-groups", options.light_groups,
                   "adds one layer per light group, and one for all lights without a group");
}

Status read_expressions(const CLI::App& command, const ExpressionOptions& options, Job& job) {
    lpe::Dialect dialect = lpe::Dialect::renderman;
    std::size_t next_expression = 0, next_dialect = 0, next_file = 0;
    bool rules_nothing = false;
    const auto check_dialect = [&]() -> Status {
        if (!rules_nothing) return success();
        return error_at(at_option("--dialect"),
                        "no --lpe or --channels follows '--dialect " + options.dialects[next_dialect - 1] +
                            "', which applies to those after it; expected --dialect before them");
    };
    std::vector<std::string> renames = options.renames;
    for (const CLI::Option* option : command.parse_order()) {
        if (option->get_name() == "--dialect") {
            if (Status used = check_dialect(); !used) return used;
            auto parsed = parse_dialect(options.dialects[next_dialect++], at_option("--dialect"));
            if (!parsed) return parsed.error();
            dialect = *parsed;
            rules_nothing = true;
        } else if (option->get_name() == "--lpe") {
            auto request = parse_named_expression(options.expressions[next_expression++], dialect, "--lpe");
            if (!request) return request.error();
            job.expressions.push_back(std::move(*request));
            rules_nothing = false;
        } else if (option->get_name() == "--channels") {
            const std::string& file = options.channel_files[next_file++];
            if (Status read = read_channel_file(file, dialect, renames, job); !read) return read;
            rules_nothing = false;
        }
    }
    if (Status used = check_dialect(); !used) return used;
    if (!renames.empty())
        return error_at(at_option("--rename"), "no --channels file declares the channel of '" + renames.front() +
                                                   "'; expected OLD=NEW, the name of such a channel before '='");
    if (!options.partition.empty()) job.shipped_partition = true;
    if (options.light_groups) job.light_groups = true;
    return success();
}

}  // namespace raylex::experiments
