// Flags that ask for layers of light, the same for a render and for an atlas.
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
/// Adds to the job: --lpe NAME=EXPR and --channels FILE in the order given, each in the dialect of the last --dialect
/// before it, then partition and light groups. Errors: theirs, and a --dialect that none of them follows.
Status read_expressions(const CLI::App& command, const ExpressionOptions& options, Job& job);

/// "NAME=EXPR" as given to `option`.
Result<ExpressionRequest> parse_named_expression(const std::string& text, lpe::Dialect dialect,
                                                 const std::string& option);

}  // namespace raylex::experiments
