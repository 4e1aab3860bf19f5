// raylex lpe check, equal, contains, empty: proofs about channels and expressions.
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "experiments/cli/command_line.h"
#include "experiments/cli/console.h"
#include "experiments/cli/lpe/commands.h"
#include "lpe/algebra/check.h"
#include "lpe/algebra/regex_printing.h"
#include "lpe/algebra/relations.h"

namespace raylex::experiments {
namespace {

struct CheckOptions {
    DialectOption dialect;
    ChannelArguments channels;
    ChannelOutput output;
    SceneOption scene;
    lpe::Words words;  // of the scene
    std::string of, what = "partition", rest;
};

struct RelationOptions {
    DialectOption dialect;
    SceneOption scene;
    lpe::Words words;  // of the scene
    std::string first, second;
};

/// Prints the verdict, then the path against it as events, and returns the exit code.
int verdict(bool holds, const std::string& summary, const lpe::Witness& witness,
            const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) print_warning(warning);
    print_line(summary);
    if (holds) return exit_holds;
    print_line(witness.text);
    return exit_does_not_hold;
}

int verdict(const Result<lpe::Proof>& proof) {
    if (!proof) return report_error(proof.error());
    return verdict(proof->holds, proof->summary, proof->witness, proof->warnings);
}

/// Says what the channels leave, where they share no path; with --rest the layer is added to them and the proof done
/// again.
Result<lpe::PartitionReport> complete(const CheckOptions& options, std::vector<lpe::ChannelSource>& sources,
                                      const std::optional<lpe::ChannelSource>& of, lpe::PartitionReport report) {
    if (report.verdict != lpe::Verdict::missed) return report;
    auto disjoint = lpe::check_disjoint(sources, options.words);
    if (!disjoint || !disjoint->disjoint) return report;
    auto rest = lpe::rest_expression(sources, of, options.words);
    if (!rest || !*rest) {
        print_note("the channels share no path; what they leave has no short expression (at most " +
                   std::to_string(lpe::longest_printed_expression) + " characters)");
        return report;
    }
    const std::string name = options.rest.empty() ? "rest" : options.rest;
    if (options.rest.empty()) {
        print_note("the channels share no path; with this one they are a partition: " + name + "=\"" + **rest + "\"");
        return report;
    }
    sources.push_back(bare_expression(**rest, lpe::Dialect::renderman, name, "--rest"));
    return lpe::check_partition(sources, of, options.words);
}

/// The channels of the set by name. Errors: a name that is not there.
Result<std::vector<lpe::ChannelSource>> members(const std::vector<lpe::ChannelSource>& sources,
                                                const PartitionRequest& partition,
                                                const std::vector<std::string>& wanted) {
    std::vector<lpe::ChannelSource> result;
    for (const std::string& name : wanted) {
        std::vector<std::string> known;
        for (const lpe::ChannelSource& source : sources) {
            known.push_back(source.name);
            if (source.name == name) result.push_back(source);
        }
        const std::string near = nearest_name(name, known);
        if (result.empty() || result.back().name != name)
            return error_at(partition.location,
                            "partition '" + partition.name + "' names the channel '" + name + "', which is not there",
                            near.empty() ? std::string() : "did you mean '" + near + "'?");
    }
    return result;
}

/// The partitions that TOML files declare, each by itself.
int run_declared(const std::vector<lpe::ChannelSource>& sources, const std::vector<PartitionRequest>& partitions,
                 const lpe::Words& words) {
    int code = exit_holds;
    for (const PartitionRequest& partition : partitions) {
        auto channels = members(sources, partition, partition.channels);
        if (!channels) return report_error(channels.error());
        std::optional<lpe::ChannelSource> of;
        if (!partition.of.empty()) {
            auto found = members(sources, partition, {partition.of});
            if (!found) return report_error(found.error());
            of = found->front();
        }
        int one = exit_holds;
        const std::string name = "partition '" + partition.name + "': ";
        if (partition.rest.empty()) {
            auto report = lpe::check_partition(*channels, of, words);
            if (!report) return report_error(report.error());
            one = verdict(report->verdict == lpe::Verdict::partition, name + report->summary, report->witness,
                          report->warnings);
        } else {
            auto report = lpe::check_disjoint(*channels, words);
            if (!report) return report_error(report.error());
            one =
                verdict(report->disjoint,
                        name + report->summary + (report->disjoint ? "; '" + partition.rest + "' takes the rest" : ""),
                        report->witness, report->warnings);
        }
        code = std::max(code, one);
    }
    return code;
}

/// Takes out of an artist's list the channels that are the whole, however they are written, and returns the first of
/// them: the beauty beside its parts is no part. None of several channels, or of one alone, may be left over.
Result<std::optional<lpe::ChannelSource>> take_beauty(std::vector<lpe::ChannelSource>& sources,
                                                      const lpe::Words& words) {
    std::optional<lpe::ChannelSource> beauty;
    lpe::Words without_media = words;
    without_media.volume = false;
    std::vector<lpe::ChannelSource> parts;
    std::string note;
    for (const lpe::ChannelSource& source : sources) {
        auto is_whole = lpe::is_beauty(source, words);
        const bool everywhere = is_whole && *is_whole;
        if (is_whole && !everywhere) is_whole = lpe::is_beauty(source, without_media);
        if (!is_whole) return is_whole.error();
        if (!*is_whole) {
            parts.push_back(source);
            continue;
        }
        if (!beauty) beauty = source;
        note += (note.empty() ? "'" : "; '") + source.name + "' is the beauty" +
                (everywhere ? "" : " where no path scatters in a medium");
    }
    if (parts.empty() || !beauty) return std::optional<lpe::ChannelSource>{};
    print_note(note + ": the others are held against it");
    sources = std::move(parts);
    return beauty;
}

int run_proof(const CheckOptions& options, std::vector<lpe::ChannelSource>& sources) {
    std::optional<lpe::ChannelSource> of;
    if (options.of.empty() && options.what == "partition" && !options.channels.files.empty()) {
        auto found = take_beauty(sources, options.words);
        if (!found) return report_error(found.error());
        of = std::move(*found);
    } else if (!options.of.empty()) {
        auto found = channel_or_expression(options.of, options.channels, options.dialect.value(), "--of");
        if (!found) return report_error(found.error());
        of = std::move(*found);
        std::erase_if(sources, [&](const lpe::ChannelSource& source) { return source.name == options.of; });
    }
    if (options.what == "covers") return verdict(lpe::check_covers(sources, of, options.words));
    if (options.what == "disjoint") {
        if (of) return report_error("--of has no part in --what disjoint; expected it with partition or covers");
        auto report = lpe::check_disjoint(sources, options.words);
        if (!report) return report_error(report.error());
        return verdict(report->disjoint, report->summary, report->witness, report->warnings);
    }
    auto report = lpe::check_partition(sources, of, options.words);
    if (report) report = complete(options, sources, of, std::move(*report));
    if (!report) return report_error(report.error());
    return verdict(report->verdict == lpe::Verdict::partition, report->summary, report->witness, report->warnings);
}

int run_check(CheckOptions options) {
    auto set = read_channel_set(options.channels, options.dialect.value());
    if (!set) return report_error(set.error());
    auto sources = resolved_channels(*set, options.channels);
    if (!sources) return report_error(sources.error());
    auto scene = options.scene.load();
    if (!scene) return report_error(scene.error());
    options.words = words_of(*scene);
    warn_about_scene(*sources, *scene);
    for (const lpe::ChannelSource& source : *sources)
        if (source.name == options.rest)
            return report_error("--rest " + options.rest + ": a channel has that name; expected another one");
    const bool declared =
        !set->partitions.empty() && options.of.empty() && options.rest.empty() && options.what == "partition";
    const int code = declared ? run_declared(*sources, set->partitions, options.words) : run_proof(options, *sources);
    if (code == exit_bad_input || options.output.path.empty()) return code;
    if (!options.rest.empty() && sources->back().name == options.rest)
        set->file.channels.emplace_back().source = sources->back();
    if (Status written = write_channels(*set, options.output); !written) return report_error(written.error());
    return code;
}

int run_equal(const RelationOptions& options) {
    const std::vector<lpe::ChannelSource> both{
        bare_expression(options.first, options.dialect.value(), "", "first expression"),
        bare_expression(options.second, options.dialect.value(), "", "second expression")};
    return verdict(lpe::check_equal(both, options.words));
}

int run_contains(const RelationOptions& options) {
    return verdict(lpe::check_contains(
        bare_expression(options.first, options.dialect.value(), "", "first expression"),
        bare_expression(options.second, options.dialect.value(), "", "second expression"), options.words));
}

int run_empty(const RelationOptions& options) {
    return verdict(
        lpe::check_empty(bare_expression(options.first, options.dialect.value(), "", "expression"), options.words));
}

void add_check(CLI::App& lpe, CommandContext& context) {
    auto options = std::make_shared<CheckOptions>();
    CLI::App* check = lpe.add_subcommand(
        "check", "Proves that the channels partition the beauty, or prints the shortest path that shows the contrary.");
    add_channel_arguments(*check, options->channels);
    check
        ->add_option(
            "--what", options->what,
            "partition (default): every path is in exactly one channel; disjoint: none is in two; covers: every "
            "path is in at least one")
        ->option_text("partition|disjoint|covers")
        ->check(CLI::IsMember({"partition", "disjoint", "covers"}));
    check
        ->add_option("--of", options->of,
                     "what is split, an expression or the name of a channel of --channels; default: the channel of a "
                     "file that denotes the beauty, else every path a scene can produce")
        ->option_text("BEAUTY");
    check
        ->add_option("--rest", options->rest,
                     "channels that share no path get a channel NAME with what they leave, and are proved with it")
        ->option_text("NAME");
    add_channel_output(*check, options->output, "also writes the channels, in any format; any verdict");
    add_scene_option(*check, options->scene);
    add_dialect_option(*check, options->dialect);
    check->footer(
        "Where a TOML file declares partitions, each of them is proved; otherwise all channels together.\n"
        "The path is said in words, then printed as 'raylex lpe match' reads it. Channels with prefixes (noclamp;, "
        "...) are "
        "refused.\nSee also: lpe equal, contains and empty for single expressions.\n"
        "Exit codes: 0 proved, 1 a path is missed, counted twice or outside, 2 bad usage or input.");
    check->callback([options, &context] { context.exit_code = run_check(*options); });
}

void add_relation(CLI::App& lpe, CommandContext& context, const std::string& name, const std::string& description,
                  bool two, const std::string& holds, int (*run)(const RelationOptions&)) {
    auto options = std::make_shared<RelationOptions>();
    CLI::App* command = lpe.add_subcommand(name, description);
    command->add_option(two ? "A" : "EXPR", options->first, "an expression")->required()->option_text("(required)");
    if (two) command->add_option("B", options->second, "another")->required()->option_text("(required)");
    add_scene_option(*command, options->scene);
    add_dialect_option(*command, options->dialect);
    command->footer(
        "Every path that some scene, or the one of --scene, can produce is taken into account. Prefixes play no part: "
        "they do not change which paths match.\n"
        "Exit codes: 0 " +
        holds + ", 1 not: the shortest path that shows it is printed, 2 bad usage or input.");
    command->callback([options, run, &context] {
        auto scene = options->scene.load();
        if (scene) options->words = words_of(*scene);
        context.exit_code = scene ? run(*options) : report_error(scene.error());
    });
}

}  // namespace

void add_lpe_check_commands(CLI::App& lpe, CommandContext& context) {
    add_check(lpe, context);
    add_relation(lpe, context, "equal", "Proves that two expressions match the same paths, whatever their dialects.",
                 true, "equal", run_equal);
    add_relation(lpe, context, "contains", "Proves that the first expression matches every path of the second.", true,
                 "contained", run_contains);
    add_relation(lpe, context, "empty", "Proves that no path matches the expression.", false, "no path matches",
                 run_empty);
}

}  // namespace raylex::experiments
