// raylex lpe match, raylex lpe vectors: match paths against expressions.
#include <memory>
#include <span>

#include "experiments/cli/lpe/commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "lpe/algebra/explanation/why_not.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/match.h"
#include "lpe/vectors.h"

namespace raylex::experiments {
namespace {

struct MatchOptions {
    DialectOption dialect;
    std::string expression, events;
    std::vector<std::string> event_arguments;
};

struct VectorOptions {
    DialectOption dialect;
    std::string file;
};

/// Returns the pieces of the expression that failed: "'S' (column 3)", "'D' (column 3) or 'L' (column 7)".
std::string pieces_text(const lpe::WhyNot& why) {
    constexpr std::size_t most = 6;
    std::vector<std::string> items;
    for (const lpe::WantedPiece& piece : why.pieces) {
        if (items.size() == most) {
            items.emplace_back("others");
            break;
        }
        items.push_back("'" + why.expression.substr(piece.begin, piece.end - piece.begin) + "' (column " +
                        std::to_string(piece.begin + 1) + ")");
    }
    return lpe::joined_by(items);
}

/// Prints how many events match, a caret under the event that fails, and what the expression expects there.
void print_reason(const lpe::WhyNot& why, const lpe::PlacedEvents& path, const MatchOptions& options) {
    if (!why.any_path) {
        print_line("the expression matches no path at all");
        return;
    }
    const std::size_t live = why.live_events;
    const bool ended = live == path.events.size();
    const std::span<const lpe::Event> good(path.events.data(), live);
    print_line(live == 0 ? "the first event does not match:"
               : ended   ? "all " + std::to_string(live) +
                             " events match, but the path ends too early: " + lpe::to_sentence(good)
                       : "the path matches up to event " + std::to_string(live) + ": " + lpe::to_sentence(good));
    if (options.events.find('\n') == std::string::npos) {
        print_line("  " + options.events);
        print_line("  " + std::string(ended ? options.events.size() : path.offsets[live], ' ') + "^");
    }
    std::string line =
        ended ? "found the end of the path"
              : "found " + lpe::to_sentence(path.events[live]) + " at column " + std::to_string(path.offsets[live] + 1);
    line += "; expected ";
    line += why.wanted.empty() ? "the end of the path" : why.wanted;
    if (why.complete && !why.wanted.empty()) line += ", or the end of the path";
    print_line(line);
    if (!why.pieces.empty())
        print_line("the expected piece is " + pieces_text(why) +
                   (why.expression == options.expression ? " of the expression" : " of " + why.expression));
    if (!why.hint.empty()) print_line(why.hint);
}

int run_match(MatchOptions& options) {
    for (const std::string& argument : options.event_arguments)
        options.events += (options.events.empty() ? "" : " ") + argument;
    auto path = lpe::parse_placed_events(options.events);
    if (!path) return report_error(about_argument(path.error(), "events", options.events));
    const lpe::ChannelSource source = bare_expression(options.expression, options.dialect.value(), "", "expression");
    auto matches = lpe::match(source.expression, path->events, source.dialect);
    if (!matches) return report_error(about_argument(matches.error(), "expression", source.expression));
    print_line(*matches ? "match" : "no match");
    if (*matches) return exit_holds;
    auto why = lpe::why_not(source, path->events);
    if (!why) {
        print_warning("the reason cannot be determined: " + why.error().message);
    } else {
        print_reason(*why, *path, options);
    }
    return exit_does_not_hold;
}

int run_vectors(const VectorOptions& options) {
    auto report = lpe::run_vectors(options.file, options.dialect.value());
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

void add_match(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<MatchOptions>();
    CLI::App* match = lpe.add_subcommand("match", "Prints 'match' if an expression accepts a path, else 'no match'.");
    match->add_option("EXPR", options->expression, "the expression")->required()->option_text("(required)");
    match
        ->add_option(
            "EVENTS", options->event_arguments,
            "the path, in one or more arguments: events type,scatter[,label...] separated by blanks, '-' for no "
            "scatter")
        ->required()
        ->option_text("(required)");
    add_dialect_option(*match, options->dialect);
    match->footer(
        "If there is no match, further lines show where the path fails and what the expression expects there.\n"
        "Types C R T V L B O U1..U12; scatter D G S s or -. Labels with blanks or commas need quotes.\n"
        "Example: raylex lpe match \"CD*<L.'key'>\" 'C,- R,D,floor L,-,key'\nExit codes: 0 match, 1 no match, 2 bad "
        "usage or input.");
    match->callback([options, &context] { context.exit_code = run_match(*options); });
}

void add_vectors(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<VectorOptions>();
    CLI::App* vectors = lpe.add_subcommand(
        "vectors", "Tests rows EXPR<TAB>EVENTS<TAB>1|0|ERR|NOCRASH and prints every row with a different result.");
    vectors->add_option("FILE.tsv", options->file, "the rows; '#' starts a comment")
        ->required()
        ->option_text("(required)");
    add_dialect_option(*vectors, options->dialect);
    vectors->footer(
        "The last line is 'N agree, M disagree'. Exit codes: 0 all agree, 1 some disagree, 2 bad usage or input.");
    vectors->callback([options, &context] { context.exit_code = run_vectors(*options); });
}

}  // namespace

void add_lpe_match_commands(CLI::App& lpe, CommandContext& context) {
    add_match(lpe, context);
    add_vectors(lpe, context);
}

}  // namespace raylex::experiments
