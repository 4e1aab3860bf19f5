// raylex lpe graph: minimised automata as drawings.
#include <memory>

#include "experiments/cli/lpe/commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "lpe/algebra/graphs/graph.h"

namespace raylex::experiments {
namespace {

struct GraphOptions {
    DialectOption dialect;
    ChannelArguments channels;
    std::string output;
};

/// NAME=EXPR rather than an expression: before the '=' stand neither labels nor groups.
bool is_named(const std::string& text) {
    const std::size_t equals = text.find('=');
    return equals != std::string::npos && equals > 0 && text.find_first_of("<'") > equals;
}

int run_graph(const GraphOptions& options) {
    std::vector<lpe::ChannelSource> sources;
    ChannelArguments named = options.channels;
    named.named.clear();
    for (const std::string& text : options.channels.named) {
        auto file = is_channel_file(text);
        if (!file) return report_error(file.error());
        if (*file) {
            named.files.push_back(text);
            continue;
        }
        if (is_named(text)) named.named.push_back(text);
        else sources.push_back(bare_expression(text, options.dialect.value(), "", "expression"));
    }
    if (!named.named.empty() || !named.files.empty() || sources.empty()) {
        auto channels = read_channels(named, options.dialect.value());
        if (!channels) return report_error(channels.error());
        sources.insert(sources.end(), channels->begin(), channels->end());
    }
    const bool svg = options.output.ends_with(".svg");
    const bool no_file = options.output.empty() || is_standard_output(options.output);
    if (!svg && !no_file && !options.output.ends_with(".dot") && !options.output.ends_with(".gv"))
        return report_error("-o " + options.output + ": expected a name that ends with .svg, .dot or .gv");
    auto graph = lpe::graph_of(sources);
    if (!graph) return report_error(graph.error());
    for (const std::string& warning : graph->warnings) print_warning(warning);
    if (Status written = write_channel_text(svg ? lpe::to_svg(*graph) : lpe::to_dot(*graph), options.output); !written)
        return report_error(written.error());
    if (graph->states.empty()) print_warning("no path is accepted: the automaton has no state");
    return exit_holds;
}

}  // namespace

void add_lpe_graph_commands(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<GraphOptions>();
    CLI::App* graph = lpe.add_subcommand("graph", "Draws the minimised automaton of expressions as SVG or DOT.");
    add_channel_arguments(*graph, options->channels)
        ->description("expressions, channels NAME=EXPR, or files of channels");
    graph->add_option("-o,--output", options->output, "file to write; default, and -: DOT to standard output")
        ->option_text("FILE.{svg,dot}");
    add_dialect_option(*graph, options->dialect);
    graph->footer(
        "All channels share one automaton, cut to the paths a scene can produce. An edge is labelled with the events "
        "that take "
        "it, in\nthe notation of expressions; where paths may end stand the names of the channels that match; what "
        "leads "
        "nowhere is left out.\nIn the SVG the pointer over a state shows a shortest path to it. No other program is "
        "needed; "
        "Graphviz reads the DOT.\nAt most 32 channels and 250 states. Example: raylex lpe graph 'CDS+L' -o "
        "caustics.svg\n"
        "Exit codes: 0 drawn, 2 bad usage or input.");
    graph->callback([options, &context] { context.exit_code = run_graph(*options); });
}

}  // namespace raylex::experiments
