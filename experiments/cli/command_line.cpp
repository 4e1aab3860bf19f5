#include "experiments/cli/command_line.h"

#include <exception>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "experiments/cli/commands.h"
#include "experiments/cli/image_commands.h"
#include "experiments/cli/input_options.h"
#include "experiments/cli/unknown_words.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/tint.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {
namespace {

/// Returns the exit code of a parse that ended early. CLI11's own codes (101 to 114) all mean bad usage; help and
/// version are success.
int finish_parse(const CLI::App& app, const CLI::ParseError& error) {
    std::ostringstream help;
    const int code = app.exit(error, help, std::cerr);
    write_output(help.str());
    if (output_is_lost()) return report_error("cannot write to standard output");
    return code == 0 ? exit_holds : exit_bad_input;
}

/// Returns the error message of a failed parse. CLI11 reports a missing subcommand or a missing required option even
/// when the real cause is a misspelt word, so unknown words come first.
std::string what_failed(const CLI::App& command, const CLI::Error& error) {
    const auto* extras = dynamic_cast<const CLI::ExtrasError*>(&error);
    const auto* required = dynamic_cast<const CLI::RequiredError*>(&error);
    const bool has_subcommands = !command.get_subcommands([](const CLI::App*) { return true; }).empty();
    const std::vector<std::string> rest = command.remaining();
    // An unknown word in place of a subcommand. The words after it belong to that subcommand.
    if (has_subcommands && !rest.empty() && !rest.front().starts_with('-'))
        return unknown_subcommand(command, rest.front());
    if (extras != nullptr || required != nullptr)
        if (std::string unknown = unknown_option(command); !unknown.empty()) return unknown;
    if (!has_subcommands) return error.what();
    return rest.empty() ? std::string(error.what()) + "; " + expected_subcommands(command)
                        : unknown_subcommand(command, rest.front());
}

/// Adds --color to `app` and to every subcommand, so that it works on either side of a subcommand's name. It applies to
/// everything printed after it is parsed.
void add_color_option(CLI::App& app) {
    app.add_option_function<std::string>(
           "--color",
           [](const std::string& choice) {
               choose_color(choice == "always"  ? ColorChoice::always
                            : choice == "never" ? ColorChoice::never
                                                : ColorChoice::automatic);
           },
           "coloured output: auto (default: on a terminal, unless $NO_COLOR is set), always or never")
        ->option_text("WHEN")
        ->group("Options")
        ->check(CLI::IsMember({"auto", "always", "never"}))
        ->trigger_on_parse();
    for (CLI::App* each : app.get_subcommands([](const CLI::App*) { return true; })) add_color_option(*each);
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
    CommandContext context;
    context.arguments.assign(argv, argv + argc);
    CLI::App app{
        "raylex renders pbrt-v4 scenes, splits their light by light path expressions, and checks that the splits add "
        "up.",
        "raylex"};
    app.set_version_flag("--version", "raylex " + raylex_version() + " (" + raylex_revision() + ")");
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 success, and all checks hold; 1 a check does not hold; 2 bad usage or input; 130 after "
        "Ctrl-C.\n"
        "'raylex SUBCOMMAND --help' describes each subcommand. The environment variable RAYLEX_BUDGETS=NAME=VALUE,... "
        "sets limits as --budget does.");
    app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
        // The help of the innermost subcommand on the command line is the relevant one.
        const CLI::App* innermost = failed;
        while (!innermost->get_subcommands().empty()) innermost = innermost->get_subcommands().front();
        return "raylex: " + tinted("error:", Tint::error, true) + " " + what_failed(*innermost, error) + "\nRun '" +
               command_words(*innermost) + " --help' for its options.\n";
    });
    add_render_command(app, context);
    add_passes_command(app, context);
    add_lpe_command(app, context);
    add_verify_command(app, context);
    add_ask_command(app, context);
    add_compare_command(app, context);
    add_denoise_command(app, context);
    add_preview_command(app, context);
    add_report_command(app, context);
    add_merge_command(app, context);
    add_mix_command(app, context);
    add_experiment_command(app, context);
    add_submit_command(app, context);
    add_status_command(app, context);
    add_scene_command(app, context);
    add_stability_command(app, context);
    add_plugins_command(app, context);
    add_new_command(app, context);
    add_ocio_command(app, context);
    add_help_command(app, context);
    add_color_option(app);
    add_input_options(app);
    if (Status ready = prepare_reading(); !ready) return report_error(ready.error());
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) { return finish_parse(app, error); } catch (const std::bad_alloc&) {
        return report_error("out of memory; lower --resolution or request fewer channels");
    } catch (const std::exception& error) {
        return report_error(std::string("unexpected failure: ") + error.what());
    } catch (...) {
        return report_error("unexpected failure: an exception that is not a std::exception, perhaps from a plugin");
    }
    if (output_is_lost()) return report_error("cannot write to standard output");
    // An interrupt during reading is not bad input.
    if (context.exit_code == exit_bad_input && reading_stopped()) return exit_interrupted;
    return context.exit_code;
}

}  // namespace raylex::experiments
