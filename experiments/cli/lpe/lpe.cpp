// raylex lpe: commands about light path expressions. Each group of subcommands has its own file beside this one.
#include "experiments/cli/commands.h"
#include "experiments/cli/lpe/commands.h"

namespace raylex::experiments {

void add_lpe_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "lpe",
        "Explains, matches, draws and compares light path expressions, and proves that channels partition the beauty.");
    command->require_subcommand(1);
    add_lpe_match_commands(*command, context);
    add_lpe_check_commands(*command, context);
    add_lpe_relation_commands(*command, context);
    add_lpe_path_commands(*command, context);
    add_lpe_explain_commands(*command, context);
    add_lpe_graph_commands(*command, context);
    add_lpe_split_commands(*command, context);
    add_lpe_truth_command(*command, context);
}

}  // namespace raylex::experiments
