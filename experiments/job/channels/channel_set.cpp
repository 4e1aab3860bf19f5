#include "experiments/job/channels/channel_set.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "experiments/job/channel_tables.h"
#include "experiments/program/console.h"
#include "lpe/algebra/proofs/relations.h"
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

/// A TOML basic string.
std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        switch (c) {
            case '"':
                result += "\\\"";
                break;
            case '\\':
                result += "\\\\";
                break;
            case '\n':
                result += "\\n";
                break;
            case '\r':
                result += "\\r";
                break;
            case '\t':
                result += "\\t";
                break;
            default:
                result += c;
        }
    }
    return result + "\"";
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

std::string commented(const std::string& comment) {
    std::string result;
    for (std::size_t begin = 0; begin < comment.size();) {
        const std::size_t end = std::min(comment.find('\n', begin), comment.size());
        result += "# " + comment.substr(begin, end - begin) + "\n";
        begin = end + 1;
    }
    return result;
}

std::string toml_text(const ChannelSet& set, std::vector<std::string>& warnings) {
    std::string text;
    const auto separate = [&text] { text += text.empty() ? "" : "\n"; };
    if (!set.file.macros.empty()) text += "[macros]\n";
    for (const lpe::ChannelSource& macro : set.file.macros)
        text += macro.name + " = " + quoted(macro.expression) + "\n";
    if (!set.file.lobe_options.empty()) {
        separate();
        text += "[lobe_slots]\n";
    }
    for (const lpe::LobeOption& option : set.file.lobe_options)
        text += option.slot + " = " + quoted(option.names) + "\n";
    LayerNames names;
    std::size_t lost = 0;
    for (const lpe::FileChannel& channel : set.file.channels) {
        separate();
        text += commented(channel.comment) + "[[channel]]\nname = " + quoted(names.fit(channel.source.name)) +
                "\nlpe = " + quoted(channel.source.expression) + "\n";
        if (channel.source.dialect == lpe::Dialect::osl) text += "dialect = \"osl\"\n";
        lost += channel.parameters.size();
    }
    for (const PartitionRequest& partition : set.partitions) {
        separate();
        text += "[[partition]]\nname = " + quoted(partition.name) + "\n";
        if (!partition.of.empty()) text += "of = " + quoted(partition.of) + "\n";
        text += "channels = [";
        for (const std::string& name : partition.channels) text += "\n    " + quoted(name) + ",";
        text += "\n]\n";
        if (!partition.rest.empty()) text += "rest = " + quoted(partition.rest) + "\n";
    }
    if (lost > 0)
        warnings.push_back(std::to_string(lost) + " parameters of channels have no place in TOML; they are left out");
    if (names.changed() > 0)
        warnings.push_back(std::to_string(names.changed()) + " names of channels cannot be layers; they are changed");
    return text;
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

/// A channel of a file that holds the spread of another one: the layer of statistics of the channel with its
/// expression.
void add_statistic(const ChannelSet& set, const lpe::FileChannel& channel, const std::string& statistic, Job& job,
                   std::vector<std::string>& warnings) {
    const lpe::ChannelSource& source = channel.source;
    std::string of = is_all_light(source, job.macros) ? "beauty" : "";
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
    std::vector<display::StatisticRequest>& asked = job.settings.statistics;
    const bool twice = std::any_of(asked.begin(), asked.end(), [&](const display::StatisticRequest& each) {
        return each.channel == request->channel && each.statistic == request->statistic;
    });
    const std::string layer = of + "_" + statistic;
    if (twice || layer != source.name) warnings.push_back(who + ") of '" + of + "': it is the layer '" + layer + "'");
    if (!twice) asked.push_back(*std::move(request));
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
    if (set.file.channels.empty())
        return error_at({"--channels", 0, 0}, "the file declares no channel with an expression; expected at least one");
    for (const lpe::ChannelSource& macro : set.file.macros)
        if (Status added = job.macros.add(macro); !added) return added;
    for (const lpe::LobeOption& option : set.file.lobe_options) {
        if (Status filled = job.settings.lobe_slots.set(option); !filled) return filled;
        job.lobe_options.push_back(option);
    }
    std::string with_settings;
    for (const lpe::FileChannel& channel : set.file.channels) {
        const lpe::ChannelSource& source = channel.source;
        if (const std::string statistic = lpe::statistics_of(channel); !statistic.empty()) {
            add_statistic(set, channel, statistic, job, warnings);
            continue;
        }
        if (!channel.parameters.empty()) with_settings += (with_settings.empty() ? "'" : ", '") + source.name + "'";
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
    if (!with_settings.empty())
        warnings.push_back("what channels say beside their expression (filters and the like) is left out: " +
                           with_settings);
    if (set.file.other_channels.empty()) return success();
    std::string list;
    for (const std::string& each : set.file.other_channels) list += (list.empty() ? "" : ", ") + each;
    warnings.push_back("channels without an expression are left out; --aov asks for those that raylex has: " + list);
    return success();
}

Result<std::string> channel_set_text(const ChannelSet& set, const std::string& path, const std::string& format,
                                     std::vector<std::string>& warnings) {
    const bool no_file = path.empty() || is_standard_output(path);
    if (format == "toml" || (format.empty() && (no_file || path.ends_with(".toml")))) return toml_text(set, warnings);
    std::optional<lpe::ChannelFormat> kind = format_named(format);
    if (!kind) {
        auto told = lpe::channel_format(path, {});
        if (!told) return told.error();
        kind = *told;
    }
    return lpe::write_channel_file(set.file, *kind, warnings);
}

Status write_channel_text(const std::string& text, const std::string& path) {
    return write_text(path.empty() ? "-" : path, text);
}

}  // namespace raylex::experiments
