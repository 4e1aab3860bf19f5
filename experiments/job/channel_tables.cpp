#include "experiments/job/channel_tables.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "experiments/job/job_file.h"
#include "experiments/job/settings/setting.h"
#include "experiments/job/text/toml_text.h"

namespace raylex::experiments {
namespace {

std::optional<lpe::Dialect> read_dialect(TomlTable& table) {
    std::string name;
    if (!table.read("dialect", name)) return std::nullopt;
    auto dialect = parse_dialect(name, table.location_of("dialect"));
    if (dialect) return *dialect;
    table.source().fail(dialect.error());
    return std::nullopt;
}

void read_statistics(TomlTable& table, std::string_view key, const std::string& channel, Job& job) {
    std::vector<std::string> names;
    std::vector<SourceLocation> places;
    table.read(key, names, &places);
    for (std::size_t i = 0; i < names.size(); ++i) {
        auto request = display::parse_statistic_request(channel, names[i], places[i]);
        if (request) job.settings.channels.statistics.push_back(std::move(*request));
        else table.source().fail(request.error());
    }
}

void read_rule(TomlTable& table, std::string_view key, const std::string& channel, Job& job) {
    std::string name;
    if (!table.read(key, name)) return;
    auto request = display::parse_rule_request(channel, name, table.location_of(key));
    if (request) job.settings.channels.rules.push_back(std::move(*request));
    else table.source().fail(request.error());
}

/// Reads [channels.statistics] and [channels.rules], by channel name, for channels without a table of their own.
void read_channel_settings(TomlTable& channels, Job& job) {
    const auto each = [&](const char* key, void (*read)(TomlTable&, std::string_view, const std::string&, Job&)) {
        const toml::table* table = channels.take_table(key);
        if (table == nullptr) return;
        TomlTable settings(channels.source(), *table, "[channels." + std::string(key) + "]");
        for (const auto& [name, node] : *table) read(settings, name.str(), std::string(name.str()), job);
    };
    each("statistics", read_statistics);
    each("rules", read_rule);
}

/// Reads [[layer]]: a further layer from a channel's samples, with another rule.
void read_layers(TomlTable& root, Job& job) {
    for (const toml::table* table : root.take_tables("layer")) {
        TomlTable reader(root.source(), *table, "a [[layer]] table");
        std::string name, channel, rule;
        bool whole = reader.require("name", name);
        whole = reader.require("channel", channel) && whole;
        whole = reader.require("rule", rule) && whole;
        reader.close();
        if (!whole) continue;
        auto layer = read_layer_request(name, channel, rule, reader.location());
        if (layer) job.settings.channels.layers.push_back(std::move(*layer));
        else root.source().fail(layer.error());
    }
}

/// Reads a [[channel]] with a type and without an expression, which plugins write to.
void read_declared(TomlTable& table, const std::string& name, const std::string& type, Job& job) {
    const SourceLocation where = table.location_of("type");
    const auto parsed = display::parse_channel_type(type, where);
    if (!parsed) return table.source().fail(parsed.error());
    display::ChannelDefinition channel = display::declared_channel(name, *parsed);
    channel.origin = where.file;
    channel.origin_line = where.line;
    channel.origin_column = where.column;
    if (std::string expression; table.read("lpe", expression))
        table.source().fail(
            table.location_of("lpe"),
            "channel '" + name +
                "' has both 'lpe' and 'type'; expected an expression of light, or the type of a plugin's channel");
    read_statistics(table, "statistics", name, job);
    read_rule(table, "rule", name, job);
    table.close();
    job.declared.push_back(std::move(channel));
}

void read_channels(TomlTable& root, Job& job) {
    read_layers(root, job);
    lpe::Dialect usual = lpe::Dialect::renderman;
    if (const toml::table* table = root.take_table("channels")) {
        TomlTable channels(root.source(), *table, "[channels]");
        read_settings(channels, "channels", {}, job);
        read_channel_settings(channels, job);
        usual = read_dialect(channels).value_or(usual);
        channels.close();
    }
    for (const toml::table* table : root.take_tables("channel")) {
        TomlTable channel(root.source(), *table, "a [[channel]] table");
        ExpressionRequest request;
        if (channel.require("name", request.name)) {
            Status status = check_layer_name(request.name, channel.location_of("name"));
            if (!status) root.source().fail(status.error());
        }
        if (std::string type; channel.read("type", type)) {
            read_declared(channel, request.name, type, job);
            continue;
        }
        channel.require("lpe", request.expression);
        request.location = channel.content_location_of("lpe");
        request.map = channel.string_map_of("lpe");
        request.dialect = read_dialect(channel).value_or(usual);
        read_statistics(channel, "statistics", request.name, job);
        read_rule(channel, "rule", request.name, job);
        channel.close();
        job.expressions.push_back(std::move(request));
    }
}

void read_partitions(TomlTable& root, Job& job) {
    for (const toml::table* table : root.take_tables("partition")) {
        TomlTable partition(root.source(), *table, "a [[partition]] table");
        PartitionRequest request;
        request.location = partition.location();
        if (partition.require("name", request.name)) {
            Status status = check_layer_name(request.name, partition.location_of("name"));
            if (!status) root.source().fail(status.error());
        }
        partition.read("of", request.of);
        if (request.of == "beauty") request.of.clear();
        if (!partition.read("channels", request.channels) || request.channels.empty())
            root.source().fail(partition.location_of("channels"),
                               "a [[partition]] table has no channels; expected channels = [\"name\", ...]");
        if (partition.read("rest", request.rest)) {
            Status status = check_layer_name(request.rest, partition.location_of("rest"));
            if (!status) root.source().fail(status.error());
        }
        partition.close();
        job.partitions.push_back(std::move(request));
    }
}

/// Reads [macros]: name = "expression"
void read_macros(TomlTable& root, Job& job) {
    const toml::table* table = root.take_table("macros");
    if (table == nullptr) return;
    TomlTable macros(root.source(), *table, "[macros]");
    for (const auto& [key, node] : *table) {
        lpe::ChannelSource source;
        source.name = std::string(key.str());
        if (!macros.require(key.str(), source.expression)) continue;
        const SourceLocation where = macros.content_location_of(key.str());
        source.origin = where.file;
        source.origin_line = where.line;
        source.origin_column = where.column;
        source.map = macros.string_map_of(key.str());
        if (Status added = job.macros.add(std::move(source)); !added) root.source().fail(added.error());
    }
}

/// Reads [lobe_slots]: specular5 = "coat,clearcoat", or an array of names.
void read_lobe_slots(TomlTable& root, Job& job) {
    const toml::table* table = root.take_table("lobe_slots");
    if (table == nullptr) return;
    TomlTable slots(root.source(), *table, "[lobe_slots]");
    for (const auto& [key, node] : *table) {
        lpe::LobeOption option;
        option.slot = std::string(key.str());
        const SourceLocation where = slots.location_of(key.str());
        option.origin = where.file;
        option.line = where.line;
        option.column = where.column;
        if (node.is_array()) {
            std::vector<std::string> names;
            if (!slots.read(key.str(), names)) continue;
            for (const std::string& name : names) option.names += (option.names.empty() ? "" : ",") + name;
        } else if (!slots.read(key.str(), option.names)) {
            continue;
        }
        if (Status filled = job.settings.labels.lobe_slots.set(option); !filled) root.source().fail(filled.error());
        job.lobe_options.push_back(std::move(option));
    }
}

}  // namespace

void read_channel_tables(TomlTable& root, Job& job) {
    read_channels(root, job);
    read_partitions(root, job);
    read_macros(root, job);
    read_lobe_slots(root, job);
}

Result<Job> parse_channel_tables(const std::string& text, const std::string& path) {
    TomlSource source(path, text);
    const auto table = parse_toml(text, path);
    if (!table) return table.error();
    if (table->contains("scene")) return parse_job(text, path);
    Job job;
    job.job_file = path;
    TomlTable root(source, *table, "a file of channels");
    read_channel_tables(root, job);
    root.close();
    if (source.error()) return *source.error();
    return job;
}

}  // namespace raylex::experiments
