#include "experiments/job/channels/channel_set.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "experiments/job/channel_tables.h"
#include "experiments/program/console.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/channels/file_text.h"
#include "lpe/read_input.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;

std::optional<lpe::ChannelFormat> format_named(const std::string& name) {
    if (name == "rib") return lpe::ChannelFormat::rib;
    if (name == "usda") return lpe::ChannelFormat::usda;
    if (name == "ini") return lpe::ChannelFormat::ini;
    return std::nullopt;
}

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
    const std::vector<display::StatisticRequest>& statistics = job->settings.statistics;
    set.statistics.insert(set.statistics.end(), statistics.begin(), statistics.end());
    set.aovs.insert(set.aovs.end(), job->aovs.begin(), job->aovs.end());
    return success();
}

Status add_file(const std::string& path, const std::string& format, lpe::Dialect dialect, ChannelSet& set) {
    auto text = read_input(path, NamedBy::command_line, "a file of channels");
    if (!text) return text.error();
    if (format == "toml" || (format.empty() && path.ends_with(".toml"))) {
        set.of_renderman = false;
        return add_toml(*text, path, set);
    }
    std::optional<lpe::ChannelFormat> kind = format_named(format);
    if (!kind) {
        auto told = lpe::channel_format(path, *text);
        if (!told) {
            Error error = told.error();
            error.hint = "name the kind with --write-as";
            return error;
        }
        kind = *told;
    }
    if (*kind == lpe::ChannelFormat::usda) set.of_renderman = false;
    if (*kind != lpe::ChannelFormat::usda || dialect == lpe::Dialect::renderman) set.renderman_files.push_back(path);
    auto file = lpe::parse_channel_file(*text, path, *kind);
    if (!file) return file.error();
    for (lpe::FileChannel& channel : file->channels) {
        // RIB and rendermn.ini are RenderMan's own; USD says nothing of the language.
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

/// Names that layers may have; others are changed into ones that they may.
class LayerNames {
  public:
    std::string fit(const std::string& name) {
        std::string fitted;
        for (const char c : name) {
            const bool fits = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
                              c == '-' || c == ':' || c == '.';
            if (fits) fitted += c;
            else if (fitted.empty() || fitted.back() != '_') fitted += '_';
        }
        while (!fitted.empty() && fitted.back() == '.') fitted.pop_back();
        if (!check_layer_name(fitted, {})) fitted = "layer_" + fitted.substr(0, 100);
        if (!check_layer_name(fitted, {})) fitted = "layer";
        const std::string stem = fitted;
        for (int k = 2; !taken_.insert(fitted).second; ++k) fitted = stem + "_" + std::to_string(k);
        if (fitted != name) ++changed_;
        return fitted;
    }
    [[nodiscard]] std::size_t changed() const { return changed_; }

  private:
    std::set<std::string> taken_;
    std::size_t changed_ = 0;
};

std::string list_text(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& each : names) text += (text.empty() ? "" : ", ") + lpe::quoted(each);
    return "[" + text + "]";
}

/// Whether a channel takes every path there is, or all that meet no medium: what renderers call the beauty.
bool is_all_light(const lpe::ChannelSource& source, const lpe::MacroTable& macros) {
    auto expansion = lpe::expand_names(source, macros);
    if (!expansion) return false;  // told where the channel is planned
    lpe::Words surfaces;
    surfaces.volume = false;
    for (const lpe::Words& words : {lpe::Words{}, surfaces})
        if (auto all = lpe::is_beauty(expansion->source, words); all && *all) return true;
    return false;
}

/// Whether nobody asked for it yet.
bool add_once(display::StatisticRequest request, std::vector<display::StatisticRequest>& asked) {
    for (const display::StatisticRequest& each : asked)
        if (each.channel == request.channel && each.statistic == request.statistic) return false;
    asked.push_back(std::move(request));
    return true;
}

/// A channel of a file that holds the spread of another one: the layer of statistics of the channel with its
/// expression.
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
    if (of == "beauty" && !job.settings.beauty) of.clear();
    const std::string who = "channel '" + source.name + "' of " + source.origin + " holds statistics (" + statistic;
    if (of.empty()) {
        warnings.push_back(who + ") of an expression that no other channel has, and is left out");
        return;
    }
    auto request =
        display::parse_statistic_request(of, statistic, {source.origin, source.origin_line, source.origin_column});
    if (!request) return warnings.push_back(request.error().to_string());
    const bool twice = !add_once(*std::move(request), job.settings.statistics);
    const std::string layer = of + "_" + statistic;
    if (twice || layer != source.name) warnings.push_back(who + ") of '" + of + "': it is the layer '" + layer + "'");
}

/// Channels without an expression: AOVs that raylex has, the image and its statistics; the others are named.
void add_others(const ChannelSet& set, Job& job, std::vector<std::string>& warnings) {
    std::string left;
    for (const lpe::FileChannel& channel : set.file.other_channels) {
        const lpe::ChannelSource& source = channel.source;
        const bool image = source.expression == "Ci", spread = !lpe::statistics_of(channel).empty();
        const auto aov = transport::named_channel(source.expression, {});
        if (image && spread) add_statistic(set, channel, job, warnings);
        if (image) continue;
        if (aov && !spread) {
            job.aovs.push_back({aov->name, {source.origin, source.origin_line, source.origin_column}});
            if (aov->name != source.name)
                warnings.push_back("channel '" + source.name + "' of " + source.origin + " is the layer '" + aov->name +
                                   "'");
        } else {
            left += (left.empty() ? "'" : ", '") + source.name + "'";
        }
    }
    if (!left.empty()) warnings.push_back("channels of what raylex has no name for are left out: " + left);
}

/// The set for formats that hold channels alone: what TOML keeps in tables of statistics and AOVs are channels there.
lpe::ChannelFile as_channels(const ChannelSet& set) {
    lpe::ChannelFile file = set.file;
    for (const display::StatisticRequest& each : set.statistics) {
        lpe::FileChannel spread;
        spread.source.expression = each.channel == "beauty" ? "C.*[<L.>O]" : each.channel;
        const std::string kind = display::statistic_name(each.statistic);
        for (const lpe::FileChannel& of : set.file.channels)
            if (of.source.name == each.channel) spread.source = of.source;
        spread.source.name = each.channel + "_" + kind;
        spread.parameters = {"\"string statistics\" [\"" + kind + "\"]"};
        const bool light = spread.source.expression != each.channel;
        (light ? file.channels : file.other_channels).push_back(std::move(spread));
    }
    for (const AovRequest& each : set.aovs) {
        lpe::FileChannel& other = file.other_channels.emplace_back();
        other.source.name = other.source.expression = each.name;
        const auto aov = transport::named_channel(each.name, {});
        if (aov && display::component_count(aov->type) == 1) other.type = "float";
    }
    return file;
}

}  // namespace

const std::vector<std::string>& channel_format_names() {
    static const std::vector<std::string> names{"toml", "rib", "usda", "ini"};
    return names;
}

Result<ChannelSet> read_channel_files(const std::vector<std::string>& paths, const std::string& format,
                                      lpe::Dialect dialect) {
    ChannelSet set;
    set.of_renderman = !paths.empty();
    for (const std::string& path : paths)
        if (Status added = add_file(path, format, dialect, set); !added) return added.error();
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

Status take_same_once(ChannelSet& set) {
    lpe::MacroTable macros;
    for (const lpe::ChannelSource& macro : set.file.macros)
        if (Status added = macros.add(macro); !added) return added;
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
        return error_at({source.origin_line > 0 ? source.origin : std::string(), source.origin_line, 0},
                        "the channel name '" + source.name +
                            "' is used twice with two meanings; expected every channel to have "
                            "its own name",
                        source.origin_line > 0 ? "the first one is in " + first.origin + line : std::string());
    }
    set.file.channels = std::move(kept);
    return success();
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
        if (Status filled = job.settings.lobe_slots.set(option); !filled) return filled;
        job.lobe_options.push_back(option);
    }
    lpe::LeftOut settings;
    for (const lpe::FileChannel& channel : set.file.channels) {
        const lpe::ChannelSource& source = channel.source;
        for (const std::string& each : channel.parameters)
            if (each.find("statistics") == std::string::npos) lpe::leave_out(channel, each, settings);
        if (!lpe::statistics_of(channel).empty()) {
            add_statistic(set, channel, job, warnings);
            continue;
        }
        if (!check_layer_name(source.name, {}) && is_all_light(source, job.macros)) {
            warnings.push_back("channel '" + source.name + "' of " + source.origin +
                               " is the image itself, and is not made a layer beside it");
            continue;
        }
        job.expressions.push_back({source.name,
                                   source.expression,
                                   source.dialect,
                                   {source.origin, source.origin_line, source.origin_column},
                                   source.map});
    }
    job.partitions.insert(job.partitions.end(), set.partitions.begin(), set.partitions.end());
    job.aovs.insert(job.aovs.end(), set.aovs.begin(), set.aovs.end());
    for (const display::StatisticRequest& each : set.statistics) add_once(each, job.settings.statistics);
    if (!settings.empty())
        warnings.push_back("what channels say beside their expression has no place in a job, and is left out: " +
                           lpe::left_out_text(settings));
    add_others(set, job, warnings);
    if (set.file.channels.empty() && job.aovs.size() == aovs)
        return error_at({"--channels", 0, 0},
                        "the file declares no channel with an expression, and no AOV that raylex has; expected one");
    return success();
}

/// What a render of the set would be asked for, as tables of a job.
Result<std::string> toml_text(const ChannelSet& set, std::vector<std::string>& warnings) {
    Job job;
    if (Status added = add_to_job(set, job, warnings); !added) return added.error();
    std::string text;
    const auto separate = [&text] { text += text.empty() ? "" : "\n"; };
    if (!set.file.macros.empty()) text += "[macros]\n";
    for (const lpe::ChannelSource& macro : set.file.macros)
        text += macro.name + " = " + lpe::quoted(macro.expression) + "\n";
    if (!set.file.lobe_options.empty()) {
        separate();
        text += "[lobe_slots]\n";
    }
    for (const lpe::LobeOption& option : set.file.lobe_options)
        text += option.slot + " = " + lpe::quoted(option.names) + "\n";
    std::vector<std::string> aovs;
    std::map<std::string, std::vector<std::string>> statistics;
    for (const AovRequest& each : job.aovs) aovs.push_back(each.name);
    for (const display::StatisticRequest& each : job.settings.statistics)
        statistics[each.channel].emplace_back(display::statistic_name(each.statistic));
    LayerNames names;
    std::string channels;
    for (const ExpressionRequest& request : job.expressions) {
        const auto file = std::find_if(set.file.channels.begin(), set.file.channels.end(),
                                       [&](const auto& each) { return each.source.name == request.name; });
        channels += "\n" + lpe::commented(file->comment, "#") +
                    "[[channel]]\nname = " + lpe::quoted(names.fit(request.name)) +
                    "\nlpe = " + lpe::quoted(request.expression) + "\n";
        if (request.dialect == lpe::Dialect::osl) channels += "dialect = \"osl\"\n";
        if (const auto found = statistics.find(request.name); found != statistics.end()) {
            channels += "statistics = " + list_text(found->second) + "\n";
            statistics.erase(found);
        }
    }
    if (!aovs.empty()) {
        separate();
        text += "[channels]\naovs = " + list_text(aovs) + "\n";
    }
    if (!statistics.empty()) {
        separate();
        text += "[channels.statistics]\n";
    }
    for (const auto& [channel, kinds] : statistics) text += lpe::quoted(channel) + " = " + list_text(kinds) + "\n";
    text += channels.substr(text.empty() && !channels.empty() ? 1 : 0);
    for (const PartitionRequest& partition : set.partitions) {
        separate();
        text += "[[partition]]\nname = " + lpe::quoted(partition.name) + "\n";
        if (!partition.of.empty()) text += "of = " + lpe::quoted(partition.of) + "\n";
        text += "channels = [";
        for (const std::string& name : partition.channels) text += "\n    " + lpe::quoted(name) + ",";
        text += "\n]\n";
        if (!partition.rest.empty()) text += "rest = " + lpe::quoted(partition.rest) + "\n";
    }
    if (names.changed() > 0)
        warnings.push_back(std::to_string(names.changed()) + " names of channels cannot be layers; they are changed");
    return text;
}

Result<std::string> channel_set_text(const ChannelSet& set, const std::string& path, const std::string& format,
                                     std::vector<std::string>& warnings, lpe::Reader reader) {
    const bool no_file = path.empty() || is_standard_output(path);
    if (format == "toml" || (format.empty() && (no_file || path.ends_with(".toml")))) return toml_text(set, warnings);
    std::optional<lpe::ChannelFormat> kind = format_named(format);
    if (!kind) {
        auto told = lpe::channel_format(path, {});
        if (!told) return told.error();
        kind = *told;
    }
    return lpe::write_channel_file(as_channels(set), *kind, warnings, reader);
}

Status write_channel_text(const std::string& text, const std::string& path) {
    return write_text(path.empty() ? "-" : path, text);
}

}  // namespace raylex::experiments
