// Flags that request layers of light, shared by render and ask.
#pragma once

#include <string>
#include <vector>

#include "experiments/cli/option_group.h"
#include "experiments/job/job.h"

namespace raylex::experiments {

void add_expression_options(const OptionGroup& group);
/// Returns whether one of these flags requests a layer.
bool has_expressions(const CLI::App& command);
/// Adds layers to the job: first --lpe NAME=EXPR and --channels FILE in command-line order, each in the dialect of the
/// last --dialect before it, then the partition and the light groups. Errors: an invalid value, and a --dialect that no
/// expression follows.
Status read_expressions(const CLI::App& command, Job& job);

/// Parses "NAME=EXPR", the value of `option`.
Result<ExpressionRequest> parse_named_expression(const std::string& text, lpe::Dialect dialect,
                                                 const std::string& option);

}  // namespace raylex::experiments
