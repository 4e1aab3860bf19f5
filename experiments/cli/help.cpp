// raylex help: prints the same text as --help.
#include <algorithm>
#include <memory>

#include "experiments/cli/commands.h"
#include "experiments/cli/unknown_words.h"
#include "experiments/job/settings/setting.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"

namespace raylex::experiments {
namespace {

int print_help(const CLI::App& app, const std::vector<std::string>& words) {
    if (words == std::vector<std::string>{"settings"}) {
        write_output(settings_page());
        return exit_holds;
    }
    const CLI::App* command = &app;
    for (const std::string& word : words) {
        const std::vector<const CLI::App*> below = command->get_subcommands([](const CLI::App*) { return true; });
        if (below.empty())
            return report_error("'" + command_words(*command) + "' has no subcommands; expected nothing after it");
        const auto named =
            std::find_if(below.begin(), below.end(), [&](const CLI::App* each) { return each->get_name() == word; });
        if (named == below.end()) return report_error(unknown_subcommand(*command, word));
        command = *named;
    }
    // App::help() would describe the subcommand on the command line, which is `help` itself.
    const std::string text =
        command->get_formatter()->make_help(command, command_words(*command), CLI::AppFormatMode::Normal);
    write_output(text);
    return exit_holds;
}

}  // namespace

void add_help_command(CLI::App& app, CommandContext& context) {
    CLI::App* help = app.add_subcommand("help", "Describes a subcommand, like its --help.");
    auto words = std::make_shared<std::vector<std::string>>();
    help->add_option(
            "SUBCOMMAND", *words,
            "such as render or lpe check; settings: all settings of a render as Markdown; default: raylex itself")
        ->option_text("...");
    // For the installation.
    auto folder = std::make_shared<std::string>();
    help->add_option("--write", *folder)->group("");
    help->callback([&app, words, folder, &context] {
        if (folder->empty()) context.exit_code = print_help(app, *words);
        else if (Status written = write_manual(app, *folder); !written)
            context.exit_code = report_error(written.error());
    });
}

}  // namespace raylex::experiments
