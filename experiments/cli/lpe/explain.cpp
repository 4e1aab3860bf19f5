// raylex lpe explain: describes an expression in English.
#include <algorithm>
#include <memory>

#include "experiments/cli/lpe/layers.h"
#include "experiments/cli/unknown_words.h"
#include "experiments/job/channels/likely_mistakes.h"
#include "experiments/program/console.h"
#include "experiments/program/exit_codes.h"
#include "lpe/algebra/explanation/explain.h"

namespace raylex::experiments {
namespace {

struct ExplainOptions {
    ChannelArguments channels;
    DialectOption dialect;
    SceneOption scene;
    PathOptions paths;
    std::string expression;           // an expression or a channel file
    std::vector<std::string> others;  // further arguments: channels of the file
};

/// Returns the approximate width on screen: the number of UTF-8 characters.
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

/// Returns the sentence for an expression that matches no path. warn_about_scene has already printed the reasons for a
/// scene.
std::string none_matches(const lpe::ChannelSource& source, const lpe::PathStrings& words, bool of_scene) {
    if (of_scene) return "The expression matches no path of this scene.";
    const std::string mistake = likely_mistake(source, words);
    return "The expression matches no path that a scene can produce" + (mistake.empty() ? "." : ": " + mistake);
}

int print_explanation(const lpe::ChannelSource& source, const lpe::PathStrings& words, bool of_scene) {
    auto explanation = lpe::explain(source, words);
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
    print_section("", {none_matches(source, words, of_scene)});
    return exit_does_not_hold;
}

/// Prints a few lines for every channel of the files.
int print_list(const std::vector<lpe::ChannelSource>& sources, const lpe::PathStrings& words) {
    int code = exit_holds;
    for (const lpe::ChannelSource& source : sources) {
        auto explanation = lpe::explain(source, words);
        if (!explanation) return report_error(explanation.error());
        if (&source != &sources.front()) print_line("");
        print_line(source.name + "    " + source.expression);
        print_line("    " + explanation->sentence);
        for (const auto& [prefix, effect] : explanation->prefixes) print_line("    " + prefix + ": " + effect + ".");
        for (const std::string& same : explanation->same_as) print_line("    " + same);
        for (const std::string& warning : explanation->warnings) print_line("    Warning: " + warning);
        if (!explanation->samples.empty()) continue;
        print_line("    It matches no path.");
        code = exit_does_not_hold;
    }
    return code;
}

/// The expression to explain, and the paths and names that the files declare.
struct Explained {
    std::vector<lpe::ChannelSource> sources;
    ChannelSet set;
    bool whole_files = false;
};

Result<Explained> read_explained(ExplainOptions& options) {
    options.others.insert(options.others.begin(), options.expression);
    std::vector<std::string> texts;
    for (const std::string& text : options.others) {
        auto file = is_channel_file(text);
        if (!file) return file.error();
        (*file ? options.channels.files : texts).push_back(text);
    }
    if (texts.size() > 1)
        return error_at({}, "'" + texts[1] + "' is a second expression; expected one expression and channel files");
    Explained explained;
    auto set = read_channel_set(options.channels, options.dialect.value());
    if (!set) return set.error();
    explained.set = std::move(*set);
    explained.whole_files = texts.empty();
    if (explained.whole_files) {
        auto sources = resolved_channels(explained.set, options.channels);
        if (!sources) return sources.error();
        explained.sources = std::move(*sources);
        return explained;
    }
    auto found = channel_or_expression(texts.front(), options.channels, options.dialect.value(), "expression");
    if (!found) return found.error();
    explained.sources.push_back(std::move(*found));
    return explained;
}

int run_explain(ExplainOptions options) {
    auto explained = read_explained(options);
    if (!explained) return report_error(explained.error());
    auto scene = options.scene.load();
    if (!scene) return report_error(scene.error());
    auto words = path_strings_of(options.paths, *scene, explained->set, explained->sources);
    if (!words) return report_error(words.error());
    warn_about_scene(explained->sources, *scene);
    if (explained->whole_files) return print_list(explained->sources, *words);
    return print_explanation(explained->sources.front(), *words, scene->has_value());
}

}  // namespace

void add_lpe_explain_commands(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<ExplainOptions>();
    CLI::App* explain = lpe.add_subcommand(
        "explain", "Describes an expression in English, shows paths that it matches, and warns of common mistakes.");
    explain
        ->add_option("EXPR", options->expression,
                     "the expression, a built-in name such as lpe:indirectdiffuse, the name of a channel in a file, or "
                     "a channel file")
        ->required()
        ->option_text("... (required)");
    explain->allow_extras();
    add_path_options(*explain, options->paths);
    add_channel_files(*explain, options->channels);
    add_scene_option(*explain, options->scene);
    add_dialect_option(*explain, options->dialect);
    explain->footer(
        "Example: raylex lpe explain show.rib, and raylex lpe explain show.rib rimDiffuse\n"
        "A file alone is explained channel by channel, a few lines each.\n"
        "Prints the expression as a sentence and piece by piece; what its prefixes do; whether it is the beauty, a "
        "shipped "
        "channel\nor a built-in name however it is written; a few paths, in words and as 'raylex lpe match' reads "
        "them; "
        "what it leaves out that\none might expect in it; warnings, where another reading of '|' would differ or a "
        "piece "
        "can never match.\nExit codes: 0 explained, 1 explained, and no path matches, 2 bad usage or input.");
    explain->callback([options, explain, &context] {
        options->others = further_words(*explain);
        context.exit_code = run_explain(*options);
    });
}

}  // namespace raylex::experiments
