// raylex lpe words, complement, intersection, union, difference: show the paths of combinations of expressions.
#include <array>
#include <memory>

#include "experiments/cli/lpe/commands.h"
#include "experiments/cli/unknown_words.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "lpe/algebra/proofs/paths.h"

namespace raylex::experiments {
namespace {

struct PathOptions {
    DialectOption dialect;
    std::string first;
    std::size_t samples = 5;
    std::size_t events = 8;
};

std::string count_text(std::uint64_t count) {
    return count >= 1'000'000'000'000'000'000 ? "1e18 or more" : std::to_string(count);
}

void print_paths(const lpe::PathSet& paths) {
    for (const std::string& warning : paths.warnings) print_warning(warning);
    if (paths.empty()) {
        print_line("no path");
        return;
    }
    for (const lpe::Witness& sample : paths.samples) {
        print_line(sample.sentence);
        print_line("    " + sample.text);
    }
    std::string line = "Kinds of paths by number of events:";
    for (std::size_t events = 0; events < paths.counts.size(); ++events) {
        if (paths.counts[events] > 0)
            line +=
                (line.back() == ':' ? " " : ", ") + std::to_string(events) + ": " + count_text(paths.counts[events]);
    }
    if (line.back() == ':') line += " none that are so short";
    print_line(line);
    print_line(paths.longest ? "The longest has " + std::to_string(*paths.longest) + " events."
                             : "There is no longest path.");
}

int run_paths(lpe::Operation operation, const PathOptions& options, const std::vector<std::string>& others) {
    std::vector<lpe::ChannelSource> sources{
        bare_expression(options.first, options.dialect.value(), "", others.empty() ? "expression" : "expression 1")};
    for (const std::string& text : others)
        sources.push_back(
            bare_expression(text, options.dialect.value(), "", "expression " + std::to_string(sources.size() + 1)));
    lpe::PathSetOptions look;
    look.samples = options.samples;
    look.longest_counted = options.events;
    auto paths = lpe::look_at_paths(operation, sources, {}, look);
    if (!paths) return report_error(paths.error());
    print_paths(*paths);
    return paths->empty() ? exit_does_not_hold : exit_holds;
}

struct Command {
    lpe::Operation operation;
    const char* name;
    const char* description;
    const char* example;
    bool many;
};

constexpr std::array<Command, 5> commands{{
    {lpe::Operation::words, "words",
     "Shows paths that the expression matches: the shortest, a few others, and how many there are.",
     "raylex lpe words 'C<RD>L'", false},
    {lpe::Operation::complement, "complement", "Shows paths of the beauty that the expression does not match.",
     "raylex lpe complement 'C[DS]*L'", false},
    {lpe::Operation::intersection, "intersection", "Shows paths that all of the expressions match.",
     "raylex lpe intersection 'C.*D.*' 'C.*S.*'", true},
    {lpe::Operation::united, "union", "Shows paths that any of the expressions matches.", "raylex lpe union 'CL' 'CDL'",
     true},
    {lpe::Operation::difference, "difference",
     "Shows paths that the first expression matches and none of the others does.",
     "raylex lpe difference 'C<RD>.*' 'osl:C<RD>.*'", true},
}};

void add_command(CLI::App& lpe, CommandContext& context, const Command& entry) {
    auto options = std::make_shared<PathOptions>();
    CLI::App* command = lpe.add_subcommand(entry.name, entry.description);
    // The parser of a list option would read an expression such as [C]L[DS] as a list, so only the first expression is
    // an option.
    command->add_option("EXPR", options->first, entry.many ? "the expressions, one or more" : "the expression")
        ->required()
        ->option_text(entry.many ? "..." : "(required)");
    if (entry.many) command->allow_extras();
    command->add_option("--samples", options->samples, "how many paths to show; default: 5")
        ->option_text("N")
        ->check(CLI::Range(1, 1'000));
    command->add_option("--events", options->events, "counts paths of at most N events; default: 8")
        ->option_text("N")
        ->check(CLI::Range(2, 64));
    add_dialect_option(*command, options->dialect);
    command->footer(
        "Paths a scene can produce, the shortest first, each in words and as 'raylex lpe match' reads it. In the "
        "counts, events "
        "that\ndiffer in type or scattering are different; lobe numbers and labels count as far as the expressions "
        "tell them "
        "apart.\nExpressions of different dialects may be put together. Example: " +
        std::string(entry.example) +
        "\nExit codes: 0 there are such paths, 1 there is none (proved), 2 bad usage or input.");
    command->callback([options, command, operation = entry.operation, &context] {
        context.exit_code = run_paths(operation, *options, further_words(*command));
    });
}

}  // namespace

void add_lpe_path_commands(CLI::App& lpe, CommandContext& context) {
    for (const Command& entry : commands) add_command(lpe, context, entry);
}

}  // namespace raylex::experiments
