// raylex lpe graph: draws minimised automata.
#include <filesystem>
#include <memory>

#include "display/services/parameters.h"
#include "experiments/cli/lpe/commands.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "experiments/program/run_program.h"
#include "lpe/algebra/graphs/graph.h"

namespace raylex::experiments {
namespace {

struct GraphOptions {
    DialectOption dialect;
    ChannelArguments channels;
    std::string output;
};

/// Whether the text is NAME=EXPR. A name has no '<' and no quote, so an '=' behind one belongs to a label.
bool is_named(const std::string& text) {
    const std::size_t equals = text.find('=');
    return equals != std::string::npos && equals > 0 && text.find_first_of("<'") > equals;
}

/// What Graphviz draws of `dot`; `output` is the file that is to be written.
Result<std::string> svg_of(const std::string& dot, const std::string& output) {
    const auto drawn = run_program({"dot", "-Tsvg"}, dot);
    if (drawn && drawn->exit_code == 0) return drawn->output;
    const std::string why = drawn ? "'dot' ended with exit code " + std::to_string(drawn->exit_code) + ": " +
                                        drawn->errors.substr(0, drawn->errors.find('\n'))
                                  : drawn.error().message;
    return error_at({}, "-o " + output + ": expected Graphviz, which draws SVG files; " + why,
                    "install the Debian package graphviz, or write DOT: -o " +
                        std::filesystem::path(output).replace_extension(".dot").string());
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
    std::string text = lpe::to_dot(*graph);
    if (svg) {
        auto drawn = svg_of(text, options.output);
        if (!drawn) return report_error(drawn.error());
        text = *std::move(drawn);
    }
    if (Status written = write_channel_text(text, options.output); !written) return report_error(written.error());
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
        "All channels share one automaton, limited to the paths that a scene can produce. The label of an edge lists "
        "its events.\nA state where paths can end names the channels that match them. States that lead nowhere are "
        "left out.\nSVG files need the program dot (Debian package graphviz). In an SVG, point at a state to see a "
        "shortest path to it.\nAt most 32 channels and 250 states. Example: raylex lpe graph 'CDS+L' -o "
        "caustics.svg\n"
        "Exit codes: 0 drawn, 2 bad usage or input.");
    graph->callback([options, &context] { context.exit_code = run_graph(*options); });
}

}  // namespace raylex::experiments
