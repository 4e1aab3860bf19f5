// raylex lpe explain: an expression in words.
#include <algorithm>
#include <memory>

#include "experiments/cli/command_line.h"
#include "experiments/cli/console.h"
#include "experiments/cli/lpe/commands.h"
#include "lpe/algebra/explain.h"

namespace raylex::experiments {
namespace {

struct ExplainOptions {
    ChannelArguments channels;
    DialectOption dialect;
    SceneOption scene;
    std::string expression;
};

/// Characters on the screen, more or less: bytes that begin one.
std::size_t width_of(const std::string& text) {
    return static_cast<std::size_t>(std::count_if(
        text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

void print_pieces(const lpe::Explanation& explanation) {
    constexpr std::size_t widest = 34;
    std::vector<std::string> texts;
    std::size_t width = 0;
    for (const lpe::Piece& piece : explanation.pieces) {
        texts.push_back(std::string(static_cast<std::size_t>(2 + 2 * piece.depth), ' ') +
                        explanation.expression.substr(piece.begin, piece.end - piece.begin));
        std::replace(texts.back().begin(), texts.back().end(), '\n', ' ');
        if (width_of(texts.back()) <= widest) width = std::max(width, width_of(texts.back()));
    }
    for (std::size_t i = 0; i < texts.size(); ++i) {
        if (width_of(texts[i]) > width) {
            print_line(texts[i]);
            print_line(std::string(width + 2, ' ') + explanation.pieces[i].words);
        } else {
            print_line(texts[i] + std::string(width + 2 - width_of(texts[i]), ' ') + explanation.pieces[i].words);
        }
    }
}

void print_section(const std::string& title, const std::vector<std::string>& lines) {
    if (lines.empty()) return;
    print_line("");
    if (!title.empty()) print_line(title);
    for (const std::string& line : lines) print_line(title.empty() ? line : "  " + line);
}

int run_explain(const ExplainOptions& options) {
    auto found = channel_or_expression(options.expression, options.channels, options.dialect.value(), "expression");
    if (!found) return report_error(found.error());
    const lpe::ChannelSource& source = *found;
    auto scene = options.scene.load();
    if (!scene) return report_error(scene.error());
    warn_about_scene({&source, 1}, *scene);
    auto explanation = lpe::explain(source, words_of(*scene));
    if (!explanation) return report_error(about_argument(explanation.error(), "expression", source.expression));
    print_line(explanation->expression + "    (" + (source.dialect == lpe::Dialect::osl ? "osl" : "renderman") + ")");
    print_section("", {explanation->sentence});
    if (explanation->pieces.size() > 1) {
        print_line("");
        print_pieces(*explanation);
    }
    std::vector<std::string> lines;
    for (const auto& [prefix, effect] : explanation->prefixes) lines.push_back(prefix + ": " + effect + ".");
    print_section("Prefixes:", lines);
    print_section("", explanation->same_as);
    lines.clear();
    for (const lpe::Witness& sample : explanation->samples) {
        lines.push_back(sample.sentence);
        lines.push_back("    " + sample.text);
    }
    print_section("Paths it matches, the shortest first:", lines);
    print_section("Note:", explanation->notes);
    print_section("Warning:", explanation->warnings);
    if (!explanation->samples.empty()) return exit_holds;
    print_section("", {*scene ? "No path of this scene matches." : "No path a scene can produce matches."});
    return exit_does_not_hold;
}

}  // namespace

void add_lpe_explain_commands(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<ExplainOptions>();
    CLI::App* explain = lpe.add_subcommand(
        "explain",
        "Says in words what an expression means, shows paths that it matches, and warns of what is easily mistaken.");
    explain
        ->add_option(
            "EXPR", options->expression,
            "the expression, a built-in name such as lpe:indirectdiffuse, or the name of a channel of --channels")
        ->required()
        ->option_text("(required)");
    add_channel_files(*explain, options->channels);
    add_scene_option(*explain, options->scene);
    add_dialect_option(*explain, options->dialect);
    explain->footer(
        "Prints the expression as a sentence and piece by piece; what its prefixes do; whether it is the beauty, a "
        "shipped "
        "channel\nor a built-in name however it is written; a few paths, in words and as 'raylex lpe match' reads "
        "them; "
        "what it leaves out that\none might expect in it; warnings, where another reading of '|' would differ or a "
        "piece "
        "can never match.\nExit codes: 0 explained, 1 explained, and no path matches, 2 bad usage or input.");
    explain->callback([options, &context] { context.exit_code = run_explain(*options); });
}

}  // namespace raylex::experiments
