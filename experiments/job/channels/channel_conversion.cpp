// Writes a set of channels in each format.
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "experiments/job/channels/channel_set.h"
#include "experiments/job/text/toml_table.h"
#include "experiments/job/text/toml_text.h"
#include "experiments/program/console.h"
#include "lpe/channels/file_text.h"

namespace raylex::experiments {
namespace {

/// Maps channel names to valid layer names.
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

/// Returns a TOML key, with quotes if necessary.
std::string key_text(const std::string& name) {
    const bool bare = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
    return bare && !name.empty() ? name : lpe::quoted(name);
}

std::string techniques_text(const TechniqueRequest& request) {
    std::string names;
    for (const std::string& each : request.channels) names += (names.empty() ? "" : ",") + each;
    return "pyramid:" + names;
}

/// Returns the keys of [channels].
std::string requested_text(const Job& job, const std::map<std::string, std::string>& rules) {
    std::vector<std::string> aovs, mattes;
    for (const AovRequest& each : job.aovs) aovs.push_back(each.name);
    for (const geoaovs::MatteKind kind : job.settings.mattes.kinds)
        mattes.push_back(lower_case(geoaovs::matte_layer(kind).substr(std::string_view("Crypto").size())));
    std::string text = aovs.empty() ? "" : "aovs = " + list_text(aovs) + "\n";
    if (!mattes.empty()) text += "cryptomatte = " + list_text(mattes) + "\n";
    if (const int ranks = job.settings.mattes.ranks; ranks != geoaovs::Cryptomatte::default_ranks)
        text += "cryptomatte_ranks = " + std::to_string(ranks) + "\n";
    std::string pairs;
    for (const auto& [channel, rule] : rules)
        pairs += (pairs.empty() ? "" : ", ") + key_text(channel) + " = " + lpe::quoted(rule);
    if (!pairs.empty()) text += "rules = { " + pairs + " }\n";
    if (job.shipped_partition) text += "shipped_partition = true\n";
    if (job.light_groups) text += "light_groups = true\n";
    if (job.techniques) text += "techniques = " + lpe::quoted(techniques_text(*job.techniques)) + "\n";
    return text;
}

using SettingsOf = std::map<std::string, std::vector<std::string>>;

/// Returns the tables of channels and layers, each after an empty line. Settings that go into a channel's own table are
/// removed from `statistics` and `rules`.
std::string channel_texts(const ChannelSet& set, const Job& job, LayerNames& names, SettingsOf& statistics,
                          std::map<std::string, std::string>& rules) {
    std::string text;
    for (const ExpressionRequest& request : job.expressions) {
        const auto file = std::find_if(set.file.channels.begin(), set.file.channels.end(),
                                       [&](const auto& each) { return each.source.name == request.name; });
        text += "\n" + lpe::commented(file->comment, "#") +
                "[[channel]]\nname = " + lpe::quoted(names.fit(request.name)) +
                "\nlpe = " + lpe::quoted(request.expression) + "\n";
        if (request.dialect == lpe::Dialect::osl) text += "dialect = \"osl\"\n";
        if (const auto found = statistics.find(request.name); found != statistics.end()) {
            text += "statistics = " + list_text(found->second) + "\n";
            statistics.erase(found);
        }
        if (const auto found = rules.find(request.name); found != rules.end()) {
            text += "rule = " + lpe::quoted(found->second) + "\n";
            rules.erase(found);
        }
    }
    for (const display::ChannelDefinition& each : job.declared)
        text += "\n[[channel]]\nname = " + lpe::quoted(each.name) +
                "\ntype = " + lpe::quoted(display::type_name(each.type)) + "\n";
    for (const display::LayerRequest& each : job.settings.channels.layers)
        text += "\n[[layer]]\nname = " + lpe::quoted(each.name) + "\nchannel = " + lpe::quoted(each.channel) +
                "\nrule = " + lpe::quoted(display::rule_name(each.rule)) + "\n";
    return text;
}

/// Returns the set as tables of a job.
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
    SettingsOf statistics;
    for (const display::StatisticRequest& each : job.settings.channels.statistics)
        statistics[each.channel].emplace_back(display::statistic_name(each.statistic));
    std::map<std::string, std::string> rules;
    for (const display::RuleRequest& each : job.settings.channels.rules)
        rules[each.channel] = display::rule_name(each.rule);
    LayerNames names;
    const std::string channels = channel_texts(set, job, names, statistics, rules);
    if (const std::string requested = requested_text(job, rules); !requested.empty()) {
        separate();
        text += "[channels]\n" + requested;
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
        warnings.push_back(std::to_string(names.changed()) +
                           " channel names are not valid layer names and are changed");
    return text;
}

/// Returns the name of a channel type in RIB.
std::string rib_type(display::ChannelType type) {
    return type == display::ChannelType::rgb ? "color" : display::type_name(type);
}

/// Warns of everything that the format cannot store, by name and place.
void name_left_out(const ChannelSet& set, lpe::ChannelFormat format, std::vector<std::string>& warnings) {
    const std::string target = format == lpe::ChannelFormat::rib    ? "RIB"
                               : format == lpe::ChannelFormat::usda ? "USD"
                                                                    : "rendermn.ini";
    const auto leave = [&](const SourceLocation& where, const std::string& what) {
        warnings.push_back(where.file + (where.line > 0 ? ":" + std::to_string(where.line) : "") + ": " + target +
                           " cannot store " + what + "; it is left out");
    };
    for (const PartitionRequest& each : set.partitions) leave(each.location, "the partition '" + each.name + "'");
    for (const Job& job : set.tables) {
        const auto table = parse_toml(job.job_text, job.job_file);
        if (!table) continue;  // read above
        const TomlSource source(job.job_file, job.job_text);
        for (const char* key : {"shipped_partition", "light_groups", "techniques", "cryptomatte"})
            if (const auto node = (*table)["channels"][key]; node && node.value_or(true))
                leave(source.location(*node.node()), "'" + std::string(key) + "' of [channels]");
    }
}

/// Expands macros for formats without macros, with a warning for each macro.
void write_out_macros(lpe::ChannelFile& file, std::vector<std::string>& warnings) {
    lpe::MacroTable macros;
    for (const lpe::ChannelSource& macro : file.macros)
        if (Status added = macros.add(macro); !added) warnings.push_back(added.error().to_string());
    std::set<std::string> channels;
    for (lpe::FileChannel& channel : file.channels) {
        channel.source = without_macros(channel.source, macros);
        channels.insert(channel.source.name);
    }
    for (const lpe::ChannelSource& macro : file.macros)
        if (!channels.contains(macro.name))
            warnings.push_back(macro.origin + ":" + std::to_string(macro.origin_line) + ": the macro '" + macro.name +
                               "' is expanded in the channels, because the format has no macros");
}

std::string filter_parameter(display::FilterRule rule) {
    return "\"string filter\" [\"" + std::string(display::rule_name(rule)) + "\"]";
}

/// Returns the set for formats that have only channels. Statistics, AOVs, rules and layers of TOML tables become
/// channels.
lpe::ChannelFile as_channels(const ChannelSet& set, lpe::ChannelFormat format, std::vector<std::string>& warnings) {
    lpe::ChannelFile file = set.file;
    if (format != lpe::ChannelFormat::ini) write_out_macros(file, warnings);
    name_left_out(set, format, warnings);
    for (const AovRequest& each : set.aovs) {
        lpe::FileChannel& other = file.other_channels.emplace_back();
        other.source.name = other.source.expression = each.name;
        if (const auto aov = transport::named_channel(each.name, {})) other.type = rib_type(aov->type);
    }
    for (const Job& job : set.tables)
        for (const display::ChannelDefinition& each : job.declared) {
            lpe::FileChannel& other = file.other_channels.emplace_back();
            other.source.name = other.source.expression = each.name;
            other.type = rib_type(each.type);
        }
    const auto add = [&file](const std::string& channel, const std::string& name, std::string parameter) {
        lpe::FileChannel more;
        more.source.expression = channel == "beauty" ? "C.*[<L.>O]" : channel;
        bool light = channel == "beauty";
        for (const auto* list : {&file.channels, &file.other_channels})
            for (const lpe::FileChannel& of : *list) {
                if (of.source.name != channel) continue;
                light = list == &file.channels;
                more.source = of.source;
                more.type = of.type;
            }
        more.source.name = name;
        more.parameters = {std::move(parameter)};
        (light ? file.channels : file.other_channels).push_back(std::move(more));
    };
    for (const display::StatisticRequest& each : set.statistics) {
        const std::string kind = display::statistic_name(each.statistic);
        add(each.channel, each.channel + "_" + kind, "\"string statistics\" [\"" + kind + "\"]");
    }
    for (const Job& job : set.tables) {
        for (const display::LayerRequest& each : job.settings.channels.layers)
            add(each.channel, each.name, filter_parameter(each.rule));
        for (const display::RuleRequest& each : job.settings.channels.rules)
            for (auto* list : {&file.channels, &file.other_channels})
                for (lpe::FileChannel& channel : *list)
                    if (channel.source.name == each.channel) channel.parameters.push_back(filter_parameter(each.rule));
    }
    return file;
}

}  // namespace

Result<std::string> channel_set_text(const ChannelSet& set, const std::string& path, const std::string& format,
                                     std::vector<std::string>& warnings, lpe::Reader reader) {
    const bool no_file = path.empty() || is_standard_output(path);
    if (format == "toml" || (format.empty() && (no_file || path.ends_with(".toml")))) return toml_text(set, warnings);
    std::optional<lpe::ChannelFormat> kind = channel_format_named(format);
    if (!kind) {
        auto told = lpe::channel_format(path, {});
        if (!told) return told.error();
        kind = *told;
    }
    return lpe::write_channel_file(as_channels(set, *kind, warnings), *kind, warnings, reader);
}

Status write_channel_text(const std::string& text, const std::string& path) {
    return write_text(path.empty() ? "-" : path, text);
}

}  // namespace raylex::experiments
