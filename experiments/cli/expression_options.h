// Flags that request layers of light, shared by render and ask.
#pragma once

#include <string>
#include <vector>

#include "experiments/cli/option_group.h"
#include "experiments/job/job.h"

namespace raylex::experiments {

struct ExpressionOptions {
    std::vector<std::string> expressions, channel_files, renames, dialects;
    std::string partition;
    bool light_groups = false;

    [[nodiscard]] bool any() const {
        return !expressions.empty() || !channel_files.empty() || !partition.empty() || light_groups;
    }
};

void add_expression_options(const OptionGroup& group, ExpressionOptions& options);
/// Adds layers to the job: first --lpe NAME=EXPR and --channels FILE in command-line order, each in the dialect of the
/// last --dialect before it, then the partition and the light groups. Errors: an invalid value, and a --dialect that no
/// expression follows.
Status read_expressions(const CLI::App& command, const ExpressionOptions& options, Job& job);

/// Parses "NAME=EXPR", the value of `option`.
Result<ExpressionRequest> parse_named_expression(const std::string& text, lpe::Dialect dialect,
                                                 const std::string& option);

}  // namespace raylex::experiments
