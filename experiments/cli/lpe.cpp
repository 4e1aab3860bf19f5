// raylex lpe: the algebra on the command line.
#include <memory>
#include <optional>
#include <utility>

#include "experiments/cli/command_line.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/console.h"
#include "experiments/cli/render_run.h"
#include "lpe/check.h"
#include "lpe/match.h"
#include "lpe/vectors.h"

namespace raylex::experiments {
namespace {

struct LpeOptions {
    std::string dialect = "renderman", expression, events, file, of;
    std::vector<std::string> channels;
};

lpe::Dialect dialect_of(const LpeOptions& options) {
    return options.dialect == "osl" ? lpe::Dialect::osl : lpe::Dialect::renderman;
}

/// An error about a text of the command line is shown under that text.
Error about(Error error, const std::string& what, const std::string& text) {
    if (error.file.empty()) error.file = what;
    if (error.excerpt.empty() && text.find('\n') == std::string::npos) error.excerpt = text;
    if (error.line == 1) error.line = 0;  // an argument has one line
    return error;
}

int run_match(const LpeOptions& options) {
    auto events = lpe::parse_events(options.events);
    if (!events) return report_error(about(events.error(), "events", options.events));
    auto matches = lpe::match(options.expression, *events, dialect_of(options));
    if (!matches) return report_error(about(matches.error(), "expression", options.expression));
    print_line(*matches ? "match" : "no match");
    return *matches ? exit_holds : exit_does_not_hold;
}

int run_vectors(const LpeOptions& options) {
    auto report = lpe::run_vectors(options.file, dialect_of(options));
    if (!report) return report_error(report.error());
    for (const lpe::VectorRow& row : report->disagree) {
        std::string line = options.file + ":" + std::to_string(row.line) + ": " + row.expression + "\t" + row.events +
                           "\texpected " + row.expected + ", found " + row.found;
        if (!row.message.empty()) line += " (" + row.message + ")";
        print_line(line);
    }
    print_line(std::to_string(report->agree) + " agree, " + std::to_string(report->disagree.size()) + " disagree");
    return report->disagree.empty() ? exit_holds : exit_does_not_hold;
}

/// --of and the channels as the compiler takes them.
Result<std::vector<lpe::ChannelSource>> named_channels(const LpeOptions& options) {
    std::vector<lpe::ChannelSource> sources;
    for (const std::string& text : options.channels) {
        auto request = parse_named_expression(text, dialect_of(options), "channel");
        if (!request) return request.error();
        for (const lpe::ChannelSource& known : sources)
            if (known.name == request->name)
                return error_at({}, "the channel name '" + request->name +
                                        "' is used twice; expected every channel to have its own name");
        sources.push_back({request->name, request->expression, request->dialect, request->location.file, 0, 0, {}});
    }
    return sources;
}

int run_check(const LpeOptions& options) {
    auto sources = named_channels(options);
    if (!sources) return report_error(sources.error());
    std::optional<lpe::ChannelSource> of;
    if (!options.of.empty()) of = lpe::ChannelSource{"beauty", options.of, dialect_of(options), "--of", 0, 0, {}};
    auto report = lpe::check_partition(*sources, of);
    if (!report) return report_error(report.error());
    for (const std::string& warning : report->warnings) print_warning(warning);
    if (report->verdict == lpe::Verdict::partition) {
        print_line(report->summary.empty() ? "partition: every path is in exactly one channel" : report->summary);
        return exit_holds;
    }
    print_line(report->summary);
    print_line(report->witness.text);
    return exit_does_not_hold;
}

CLI::Option* add_dialect(CLI::App& command, LpeOptions& options) {
    return command.add_option("--dialect", options.dialect, "renderman (default) or osl")
        ->option_text("D")
        ->check(CLI::IsMember({"renderman", "osl"}));
}

}  // namespace

void add_lpe_command(CLI::App& app, CommandContext& context) {
    CLI::App* command = app.add_subcommand(
        "lpe", "Light path expressions: matches paths, runs conformance vectors, proves partitions.");
    command->require_subcommand(1);
    auto options = std::make_shared<LpeOptions>();

    CLI::App* match =
        command->add_subcommand("match", "Says whether an expression accepts a path: prints 'match' or 'no match'.");
    match->add_option("EXPR", options->expression, "the expression")->required()->option_text("(required)");
    match
        ->add_option("EVENTS", options->events,
                     "the path: events type,scatter[,label...] between blanks, '-' for no scatter")
        ->required()
        ->option_text("(required)");
    add_dialect(*match, *options);
    match->footer(
        "Types C R T V L B O U1..U12; scatter D G S s or -. Labels with blanks or commas stand in quotes.\n"
        "Example: raylex lpe match \"CD*<L.'key'>\" 'C,- R,D,floor L,-,key'\nExit codes: 0 match, 1 no match, 2 bad "
        "usage or input.");
    match->callback([options, &context] { context.exit_code = run_match(*options); });

    CLI::App* vectors = command->add_subcommand(
        "vectors", "Runs rows EXPR<TAB>EVENTS<TAB>1|0|ERR|NOCRASH and prints every row that disagrees.");
    vectors->add_option("FILE.tsv", options->file, "the rows; '#' starts a comment")
        ->required()
        ->option_text("(required)");
    add_dialect(*vectors, *options);
    vectors->footer("Ends with 'N agree, M disagree'. Exit codes: 0 all agree, 1 some disagree, 2 bad usage or input.");
    vectors->callback([options, &context] { context.exit_code = run_vectors(*options); });

    CLI::App* check = command->add_subcommand(
        "check", "Proves that the channels partition the beauty, or prints the shortest path that shows the contrary.");
    check->add_option("NAME=EXPR", options->channels, "the channels")->required()->option_text("...");
    check->add_option("--of", options->of, "expression for what is split; default: every path a scene can produce")
        ->option_text("BEAUTY");
    add_dialect(*check, *options);
    check->footer("Exit codes: 0 proved, 1 a path is missed, counted twice or outside, 2 bad usage or input.");
    check->callback([options, &context] { context.exit_code = run_check(*options); });
}

}  // namespace raylex::experiments
