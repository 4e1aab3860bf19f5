#include "experiments/job/channels/channel_set.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "experiments/job/channel_tables.h"
#include "experiments/program/console.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/channels/channel_errors.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

Status add_toml(const std::string& text, const std::string& path, ChannelSet& set) {
    auto job = parse_channel_tables(text, path);
    if (!job) return job.error();
    for (ExpressionRequest& request : job->expressions) {
        lpe::FileChannel channel;
        channel.source = {request.name,
                          request.expression,
                          request.dialect,
                          request.location.file,
                          request.location.line,
                          request.location.column,
                          {},
                          request.map};
        set.file.channels.push_back(std::move(channel));
    }
    set.file.macros.insert(set.file.macros.end(), job->macros.list().begin(), job->macros.list().end());
    set.file.lobe_options.insert(set.file.lobe_options.end(), job->lobe_options.begin(), job->lobe_options.end());
    set.partitions.insert(set.partitions.end(), job->partitions.begin(), job->partitions.end());
    const std::vector<display::StatisticRequest>& statistics = job->settings.channels.statistics;
    set.statistics.insert(set.statistics.end(), statistics.begin(), statistics.end());
    set.aovs.insert(set.aovs.end(), job->aovs.begin(), job->aovs.end());
    job->job_text = text;
    set.tables.push_back(*std::move(job));
    return success();
}

Status add_file(const std::string& path, const std::string& format, lpe::Dialect dialect, ChannelSet& set) {
    auto text = read_input(path, NamedBy::command_line, "a file of channels");
    if (!text) return text.error();
    if (format == "toml" || (format.empty() && path.ends_with(".toml"))) {
        set.of_renderman = false;
        return add_toml(*text, path, set);
    }
    std::optional<lpe::ChannelFormat> kind = channel_format_named(format);
    if (!kind) {
        auto told = lpe::channel_format(path, *text);
        if (!told) {
            Error error = told.error();
            error.hint = "choose the format with --write-as";
            return error;
        }
        kind = *told;
    }
    if (*kind == lpe::ChannelFormat::usda) set.of_renderman = false;
    if (*kind != lpe::ChannelFormat::usda || dialect == lpe::Dialect::renderman) set.renderman_files.push_back(path);
    auto file = lpe::parse_channels(*text, path, *kind, set.errors);
    if (!file) return file.error();
    for (lpe::FileChannel& channel : file->channels) {
        // RIB and rendermn.ini use RenderMan's dialect; USD files do not declare one.
        if (*kind == lpe::ChannelFormat::usda) channel.source.dialect = dialect;
        set.file.channels.push_back(std::move(channel));
    }
    const auto append = [](auto& to, auto& from) {
        to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
    };
    append(set.file.macros, file->macros);
    append(set.file.lobe_options, file->lobe_options);
    append(set.file.other_channels, file->other_channels);
    append(set.file.warnings, file->warnings);
    return success();
}

/// Returns whether a channel accepts every path, or all paths without media: the beauty of most renderers.
bool is_all_light(const lpe::ChannelSource& source, const lpe::MacroTable& macros) {
    auto expansion = lpe::expand_names(source, macros);
    if (!expansion) return false;  // reported when the channel is planned
    lpe::PathStrings surfaces;
    surfaces.volume = false;
    for (const lpe::PathStrings& words : {lpe::PathStrings{}, surfaces})
        if (auto all = lpe::is_beauty(expansion->source, words); all && *all) return true;
    return false;
}

/// Adds a request unless it exists. Returns whether it was added.
bool add_once(display::StatisticRequest request, std::vector<display::StatisticRequest>& requested) {
    for (const display::StatisticRequest& each : requested)
        if (each.channel == request.channel && each.statistic == request.statistic) return false;
    requested.push_back(std::move(request));
    return true;
}

/// Adds a channel of a file that contains statistics of another channel, as a statistics layer of the channel with the
/// same expression.
void add_statistic(const ChannelSet& set, const lpe::FileChannel& channel, Job& job,
                   std::vector<std::string>& warnings) {
    const lpe::ChannelSource& source = channel.source;
    const std::string statistic = lpe::statistics_of(channel);
    std::string of = source.expression == "Ci" || is_all_light(source, job.macros) ? "beauty" : "";
    for (const lpe::FileChannel& other : set.file.channels)
        if (of.empty() && other.source.expression == source.expression && other.source.dialect == source.dialect &&
            lpe::statistics_of(other).empty())
            of = other.source.name;
    for (const ExpressionRequest& other : job.expressions)
        if (of.empty() && other.expression == source.expression && other.dialect == source.dialect) of = other.name;
    if (of == "beauty" && !job.settings.channels.beauty) of.clear();
    const std::string who = "channel '" + source.name + "' of " + source.origin + " contains statistics (" + statistic;
    if (of.empty()) {
        warnings.push_back(who + ") of an expression that no other channel has; it is left out");
        return;
    }
    auto request =
        display::parse_statistic_request(of, statistic, {source.origin, source.origin_line, source.origin_column});
    if (!request) return warnings.push_back(request.error().to_string());
    const bool twice = !add_once(*std::move(request), job.settings.channels.statistics);
    const std::string layer = of + "_" + statistic;
    if (twice || layer != source.name) warnings.push_back(who + ") of '" + of + "': it is the layer '" + layer + "'");
}

/// Adds the parameters of a channel other than expression and statistics. A filter that is a rule becomes the rule of
/// the job's channel `name`, or with `beside` a further layer of the channel. All other parameters are left out.
/// Returns whether it added a further layer.
bool add_parameters(const lpe::FileChannel& channel, const std::string& name, Job& job, lpe::LeftOut& left,
                    bool beside = false) {
    const lpe::ChannelSource& source = channel.source;
    bool further = false;
    for (const std::string& each : channel.parameters) {
        lpe::LeftOut out;
        lpe::leave_out(channel, each, out);
        const std::string& parameter = out.begin()->first;
        if (parameter == "source" || parameter.ends_with("statistics")) continue;
        const std::size_t end = each.rfind('"'), begin = end == 0 ? end : each.rfind('"', end - 1);
        auto rule = display::parse_rule_request(name, begin < end ? each.substr(begin + 1, end - begin - 1) : "",
                                                {source.origin, source.origin_line, source.origin_column});
        const bool known = std::any_of(job.settings.channels.rules.begin(), job.settings.channels.rules.end(),
                                       [&](const display::RuleRequest& other) { return other.channel == name; });
        const bool filter = parameter == "filter" || parameter.ends_with(":filter");
        const bool light_or_aov = !name.empty() && lpe::statistics_of(channel).empty();
        if (!filter || !light_or_aov || !rule || rule->rule == display::FilterRule::filter || (known && !beside)) {
            lpe::leave_out(channel, each, left);
        } else if (beside) {
            job.settings.channels.layers.push_back({source.name, name, rule->rule, rule->location});
            further = true;
        } else {
            job.settings.channels.rules.push_back(*std::move(rule));
        }
    }
    return further;
}

/// Adds the tables of TOML files other than channels, statistics and partitions.
void add_tables(const ChannelSet& set, Job& job) {
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    for (const Job& from : set.tables) {
        append(job.settings.channels.rules, from.settings.channels.rules);
        append(job.settings.channels.layers, from.settings.channels.layers);
        append(job.declared, from.declared);
        for (const geoaovs::MatteKind kind : from.settings.mattes.kinds)
            if (std::count(job.settings.mattes.kinds.begin(), job.settings.mattes.kinds.end(), kind) == 0)
                job.settings.mattes.kinds.push_back(kind);
        if (from.settings.mattes.ranks != geoaovs::Cryptomatte::default_ranks)
            job.settings.mattes.ranks = from.settings.mattes.ranks;
        job.shipped_partition |= from.shipped_partition;
        job.light_groups |= from.light_groups;
        if (from.techniques) job.techniques = from.techniques;
    }
}

/// Adds channels without an expression: raylex's AOVs, the image and its statistics. Warns of all others.
void add_others(const ChannelSet& set, Job& job, lpe::LeftOut& settings, std::vector<std::string>& warnings) {
    std::string left;
    for (const lpe::FileChannel& channel : set.file.other_channels) {
        const lpe::ChannelSource& source = channel.source;
        const bool image = source.expression == "Ci", spread = !lpe::statistics_of(channel).empty();
        const auto aov = transport::named_channel(source.expression, {});
        if (image && spread) add_statistic(set, channel, job, warnings);
        if (image) continue;
        if (aov && !spread) {
            job.aovs.push_back({aov->name, {source.origin, source.origin_line, source.origin_column}});
            const bool beside = aov->name != source.name && check_layer_name(source.name, {}) &&
                                std::any_of(set.file.other_channels.begin(), set.file.other_channels.end(),
                                            [&](const auto& each) { return each.source.name == aov->name; });
            if (!add_parameters(channel, aov->name, job, settings, beside) && aov->name != source.name)
                warnings.push_back("channel '" + source.name + "' of " + source.origin + " is the layer '" + aov->name +
                                   "'");
        } else {
            left += (left.empty() ? "'" : ", '") + source.name + "'";
        }
    }
    if (!left.empty()) warnings.push_back("channels of data that raylex does not have are left out: " + left);
}

}  // namespace

std::optional<lpe::ChannelFormat> channel_format_named(const std::string& name) {
    if (name == "rib") return lpe::ChannelFormat::rib;
    if (name == "usda") return lpe::ChannelFormat::usda;
    if (name == "ini") return lpe::ChannelFormat::ini;
    return std::nullopt;
}

const std::vector<std::string>& channel_format_names() {
    static const std::vector<std::string> names{"toml", "rib", "usda", "ini"};
    return names;
}

Result<ChannelSet> read_channel_files(const std::vector<std::string>& paths, const std::string& format,
                                      lpe::Dialect dialect, bool every_error) {
    ChannelSet set;
    set.of_renderman = !paths.empty();
    for (const std::string& path : paths)
        if (Status added = add_file(path, format, dialect, set); !added) return added.error();
    if (!every_error && !set.errors.empty()) return set.errors.front();
    if (set.file.channels.empty()) {
        for (lpe::ChannelSource& macro : set.file.macros) {
            lpe::FileChannel channel;
            channel.source = macro;
            set.file.channels.push_back(std::move(channel));
        }
    }
    return set;
}

bool mean_the_same(const lpe::ChannelSource& a, const lpe::ChannelSource& b, const lpe::MacroTable& macros) {
    if (a.expression == b.expression && a.dialect == b.dialect) return true;
    const auto one = lpe::expand_names(a, macros), other = lpe::expand_names(b, macros);
    if (!one || !other) return false;
    const auto prefixes = lpe::expression_prefixes(one->source), others = lpe::expression_prefixes(other->source);
    if (!prefixes || !others || *prefixes != *others) return false;
    const auto difference = lpe::find_difference(one->source, other->source);
    return difference && !*difference;
}

void take_same_once(ChannelSet& set) {
    lpe::MacroTable macros;
    for (const lpe::ChannelSource& macro : set.file.macros)
        if (Status added = macros.add(macro); !added) set.errors.push_back(added.error());
    std::vector<lpe::FileChannel> kept;
    std::map<std::string, std::size_t> known;
    for (lpe::FileChannel& channel : set.file.channels) {
        const lpe::ChannelSource source = channel.source;
        const auto [place, fresh] = known.emplace(source.name, kept.size());
        const bool same = !fresh && lpe::statistics_of(kept[place->second]) == lpe::statistics_of(channel) &&
                          mean_the_same(kept[place->second].source, source, macros);
        if (same) set.also_in.emplace_back(source.name, source.origin);
        if (fresh) kept.push_back(std::move(channel));
        if (fresh || same) continue;
        const lpe::ChannelSource& first = kept[place->second].source;
        const std::string line = first.origin_line > 0 ? ":" + std::to_string(first.origin_line) : "";
        set.errors.push_back(
            error_at({source.origin_line > 0 ? source.origin : std::string(), source.origin_line, 0},
                     "the channel name '" + source.name +
                         "' is used twice with two meanings; expected every channel to have its own name",
                     source.origin_line > 0 ? "the first one is in " + first.origin + line : std::string()));
    }
    set.file.channels = std::move(kept);
}

lpe::ChannelSource without_macros(const lpe::ChannelSource& source, const lpe::MacroTable& macros) {
    auto with = lpe::expand_names(source, macros);
    const auto built_in = lpe::expand_names(source);
    const bool uses = with && (!built_in || built_in->source.expression != with->source.expression);
    return uses ? std::move(with->source) : source;
}

Result<std::vector<lpe::ChannelSource>> expanded_channels(const ChannelSet& set, std::vector<std::string>& warnings) {
    lpe::MacroTable macros;
    for (const lpe::ChannelSource& macro : set.file.macros)
        if (Status added = macros.add(macro); !added) return added.error();
    std::vector<lpe::ChannelSource> sources;
    for (const lpe::FileChannel& channel : set.file.channels) {
        auto expansion = lpe::expand_names(channel.source, macros);
        if (!expansion) return expansion.error();
        for (const std::string& each : expansion->warnings)
            warnings.push_back("channel '" + channel.source.name + "': " + each);
        sources.push_back(std::move(expansion->source));
    }
    return sources;
}

Status add_to_job(const ChannelSet& set, Job& job, std::vector<std::string>& warnings) {
    const std::size_t aovs = job.aovs.size();
    for (const lpe::ChannelSource& macro : set.file.macros)
        if (Status added = job.macros.add(macro); !added) return added;
    for (const lpe::LobeOption& option : set.file.lobe_options) {
        if (Status filled = job.settings.labels.lobe_slots.set(option); !filled) return filled;
        job.lobe_options.push_back(option);
    }
    lpe::LeftOut settings;
    for (const lpe::FileChannel& channel : set.file.channels) {
        const lpe::ChannelSource& source = channel.source;
        if (!lpe::statistics_of(channel).empty()) {
            add_parameters(channel, source.name, job, settings);
            add_statistic(set, channel, job, warnings);
            continue;
        }
        if (!check_layer_name(source.name, {}) && is_all_light(source, job.macros)) {
            warnings.push_back("channel '" + source.name + "' of " + source.origin +
                               " is the image itself; no further layer is made");
            add_parameters(channel, "", job, settings);
            continue;
        }
        add_parameters(channel, source.name, job, settings);
        job.expressions.push_back({source.name,
                                   source.expression,
                                   source.dialect,
                                   {source.origin, source.origin_line, source.origin_column},
                                   source.map});
    }
    job.partitions.insert(job.partitions.end(), set.partitions.begin(), set.partitions.end());
    job.aovs.insert(job.aovs.end(), set.aovs.begin(), set.aovs.end());
    for (const display::StatisticRequest& each : set.statistics) add_once(each, job.settings.channels.statistics);
    add_tables(set, job);
    std::vector<std::string> of_others;
    add_others(set, job, settings, of_others);
    if (!settings.empty())
        warnings.push_back("parameters of channels that a job cannot store are left out: " +
                           lpe::left_out_text(settings));
    warnings.insert(warnings.end(), of_others.begin(), of_others.end());
    const bool asks = std::any_of(set.tables.begin(), set.tables.end(), [](const Job& each) {
        return !each.declared.empty() || !each.settings.channels.layers.empty() ||
               !each.settings.mattes.kinds.empty() || each.shipped_partition || each.light_groups || each.techniques;
    });
    if (set.file.channels.empty() && !asks && job.aovs.size() == aovs)
        return error_at({"--channels", 0, 0},
                        "the file declares no channel with an expression and no AOV of raylex; expected at least one");
    return success();
}

}  // namespace raylex::experiments
