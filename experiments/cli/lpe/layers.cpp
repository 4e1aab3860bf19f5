#include "experiments/cli/lpe/layers.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "experiments/program/console.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/language/extensions.h"

namespace raylex::experiments {
namespace {

/// Returns why a channel of a file cannot be a layer, for reasons other than its paths; empty if it can.
Result<std::string> why_no_layer(const lpe::FileChannel& channel, const lpe::ChannelSource& source) {
    auto other = lpe::why_no_part(source);
    if (!other || !other->empty()) return other;
    const std::string statistics = lpe::statistics_of(channel);
    return statistics.empty() ? std::string() : "statistics " + statistics;
}

bool is_of_file(const lpe::ChannelSource& source) {
    return source.origin_line > 0;
}

/// Returns whether the channel equals the beauty, or the whole `of` if there is one.
Result<bool> is_whole(const lpe::ChannelSource& source, const std::optional<lpe::ChannelSource>& of,
                      const lpe::PathStrings& words) {
    auto beauty = lpe::is_beauty(source, words);
    if (!beauty || *beauty || !of) return beauty;
    auto difference = lpe::find_difference(source, *of, words);
    if (!difference) return difference.error();
    return !difference->has_value();
}

}  // namespace

void add_path_options(CLI::App& command, PathOptions& options) {
    const auto list = [&](const char* name, std::vector<std::string>& to, const char* description) {
        command.add_option(name, to, description)
            ->option_text("NAME[,NAME...]")
            ->delimiter(',')
            ->expected(1)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    };
    CLI::Option* without = command.add_flag(
        "--no-volume", options.no_volume,
        "excludes paths that scatter in media (event V); default for RIB and rendermn.ini files that do not use V");
    command.add_flag("--volume", options.volume, "includes paths that scatter in media, for all files")
        ->excludes(without);
    list("--groups", options.groups,
         "the light groups of the scene; lights without a group exist too, unless --all-labelled");
    list("--labels", options.labels, "the labels of objects and media in the scene; objects without a label exist too");
    command.add_flag("--all-labelled", options.all_labelled, "every light has a group");
}

Result<lpe::PathStrings> path_strings_of(const PathOptions& options, const std::optional<ScenePathStrings>& scene,
                                         const ChannelSet& set, std::span<const lpe::ChannelSource> channels) {
    lpe::PathStrings words = path_strings_of(scene);
    if (scene && (!options.groups.empty() || !options.labels.empty()))
        return error_at({}, "--groups and --labels cannot be combined with --scene, which has its own");
    if (!options.groups.empty()) words.light_groups = options.groups;
    if (!options.labels.empty()) words.object_labels = options.labels;
    words.unlabelled_lights = !options.all_labelled;
    const bool named = std::any_of(channels.begin(), channels.end(), [](const lpe::ChannelSource& channel) {
        return channel.dialect == lpe::Dialect::renderman && lpe::names_volume(channel.expression);
    });
    words.volume = !options.no_volume && (options.volume || scene || named || !set.of_renderman);
    return words;
}

std::vector<lpe::ChannelSource> read_all(const ChannelSet& set, std::vector<Error>& errors, lpe::Reader reader,
                                         Written written) {
    std::vector<lpe::ChannelSource> sources;
    lpe::MacroTable macros;
    for (const lpe::ChannelSource& macro : set.file.macros) static_cast<void>(macros.add(macro));
    std::vector<std::string> warnings;
    std::set<std::string> known;  // reports an error in a macro once, not for every channel that uses it
    const auto refuse = [&](const Status& read) {
        if (!read && known.insert(read.error().to_string()).second) errors.push_back(read.error());
    };
    const auto of_renderman = [&](const lpe::ChannelSource& source) {
        const auto& files = set.renderman_files;
        return reader == lpe::Reader::renderman && std::find(files.begin(), files.end(), source.origin) != files.end();
    };
    for (const lpe::ChannelSource& macro : set.file.macros)
        if (of_renderman(macro)) refuse(lpe::renderman_reads(macro));
    for (const Error& error : set.errors) refuse(error);
    ChannelSet one;
    one.file.macros = macros.list();
    for (const lpe::FileChannel& channel : set.file.channels) {
        one.file.channels.assign(1, channel);
        auto expanded = expanded_channels(one, warnings);
        const Result<std::vector<std::string>> prefixes =
            expanded ? lpe::expression_prefixes(expanded->front()) : Result<std::vector<std::string>>(expanded.error());
        if (!prefixes) {
            refuse(prefixes.error());
            continue;
        }
        const bool writes = written != Written::nothing;
        if (writes || of_renderman(channel.source))
            refuse(lpe::renderman_reads(
                written == Written::without_macros ? without_macros(channel.source, macros) : channel.source, writes));
        sources.push_back(std::move(expanded->front()));
    }
    for (const std::string& warning : warnings) print_warning(warning);
    std::stable_sort(errors.begin(), errors.end(), [](const Error& a, const Error& b) {
        return std::tie(a.file, a.line) < std::tie(b.file, b.line);
    });
    return sources;
}

Result<Layers> choose_layers(const ChannelSet& set, std::vector<lpe::ChannelSource> sources,
                             std::optional<lpe::ChannelSource> of, const lpe::PathStrings& words) {
    Layers layers;
    std::vector<lpe::ChannelSource> wholes;
    for (std::size_t k = 0; k < sources.size(); ++k) {
        lpe::ChannelSource& source = sources[k];
        if (of && !of->name.empty() && source.name == of->name) continue;
        if (!is_of_file(source)) {
            layers.sources.push_back(std::move(source));
            continue;
        }
        auto why = why_no_layer(set.file.channels[k], source);
        if (!why) return why.error();
        if (!why->empty()) {
            layers.no_layers.emplace_back(source.name, *why);
            continue;
        }
        auto whole = is_whole(source, of, words);
        if (!whole) return whole.error();
        (*whole ? wholes : layers.sources).push_back(std::move(source));
    }
    // A single channel is a split of itself. So are several channels that all equal the beauty.
    if (layers.sources.empty() && !of) std::swap(layers.sources, wholes);
    for (const lpe::ChannelSource& each : wholes)
        layers.no_layers.emplace_back(each.name, of ? "what is split" : "the beauty");
    if (of) {
        layers.whole_name = of->name;
        layers.whole = std::move(of);
    } else if (!wholes.empty()) {
        layers.whole_name = wholes.front().name;
        layers.whole = wholes.front();
    }
    if (layers.sources.empty())
        return error_at({}, "no channel can be a layer; expected channels without prefixes and statistics",
                        layers.no_layers.empty()
                            ? std::string()
                            : "'" + layers.no_layers.front().first + "': " + layers.no_layers.front().second);
    return layers;
}

}  // namespace raylex::experiments
