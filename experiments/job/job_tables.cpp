#include "experiments/job/job_tables.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <utility>

#include "experiments/job/output_requests.h"
#include "experiments/program/resource.h"

namespace raylex::experiments {
namespace {

using Selector = transport::LabelRule::Selector;
struct SelectorKey {
    const char* key;
    Selector selector;
};

/// Reads [[label]] or [[light_group]] tables. [[label]] may have holdout = true, with or without a label; light groups
/// may not.
void read_rules(TomlTable& root, const char* kind, const char* target, std::initializer_list<SelectorKey> selectors,
                bool of_objects, Job& job) {
    for (const toml::table* table : root.take_tables(kind)) {
        TomlTable reader(root.source(), *table, "a [[" + std::string(kind) + "]] table");
        transport::LabelRule rule;
        rule.location = reader.location();
        int found = 0;
        std::string keys;
        for (const SelectorKey& each : selectors) {
            keys += (keys.empty() ? "" : ", ") + std::string(each.key);
            if (!reader.has(each.key)) continue;
            reader.require(each.key, rule.pattern);
            rule.selector = each.selector;
            rule.location = reader.location_of(each.key);
            ++found;
        }
        for (const SelectorKey& each : selectors) reader.take(each.key);
        bool holdout = false;
        if (of_objects && reader.read("holdout", holdout)) rule.holdout = holdout;
        rule.keeps_label = rule.holdout.has_value() && !reader.has(target);
        if (!rule.keeps_label) reader.require(target, rule.label);
        if (found != 1)
            root.source().fail(reader.location(), reader.description() + " has " + std::to_string(found) +
                                                      " selectors; expected exactly one of: " + keys);
        reader.close();
        job.label_rules.push_back(std::move(rule));
    }
}

}  // namespace

void read_plugins(TomlTable& root, const std::string& job_path, Job& job) {
    std::vector<std::string> files;
    std::vector<SourceLocation> locations;
    if (!root.read("plugins", files, &locations)) return;
    for (std::size_t i = 0; i < files.size(); ++i)
        job.plugins.push_back(
            {is_shipped_plugin(files[i]) ? shipped_plugin(files[i]) : beside_job(job_path, files[i]), locations[i]});
}

bool is_shipped_plugin(const std::string& name) {
    return name.find('/') == std::string::npos && std::filesystem::path(name).extension() != ".so";
}

std::string shipped_plugin(const std::string& name) {
    const auto found = resource("plugins/lib" + name + ".so");
    return found ? *found : found.error().file;
}

void read_color_table(TomlTable& root, const std::string& job_path, Job& job) {
    const toml::table* table = root.take_table("color");
    if (table == nullptr) return;
    TomlTable color(root.source(), *table, "[color]");
    if (color.read("ocio", job.ocio_config)) job.ocio_config = beside_job(job_path, job.ocio_config);
    color.read("rendering_space", job.rendering_space);
    color.read("display", job.display);
    color.read("view", job.view);
    if (const toml::node* node = color.take("exposure")) {
        const auto stops = node->value<double>();
        if (stops && std::abs(*stops) <= largest_exposure) job.exposure = *stops;
        else
            root.source().fail(color.location_of("exposure"),
                               "'exposure' in [color] is not a number of stops; expected -60 to 60");
    }
    color.read("texture_rules", job.texture_rules);
    color.close();
}

void read_resolution(TomlTable& render, Job& job) {
    const toml::node* node = render.take("resolution");
    if (node == nullptr) return;
    const SourceLocation where = render.location_of("resolution");
    if (const auto* text = node->as_string()) {
        auto size = parse_resolution(text->get(), where);
        if (size) job.settings.film.resolution = *size;
        else render.source().fail(size.error());
        return;
    }
    const toml::array* list = node->as_array();
    const auto number = [&](std::size_t i) { return list->get(i)->value_exact<std::int64_t>().value_or(0); };
    const bool fits = list != nullptr && list->size() == 2 && number(0) >= 1 && number(0) <= 65536 && number(1) >= 1 &&
                      number(1) <= 65536;
    if (fits) job.settings.film.resolution = {{static_cast<int>(number(0)), static_cast<int>(number(1))}};
    else
        render.source().fail(where,
                             "'resolution' in " + render.description() +
                                 " is not a pair of pixel counts; expected [width, height], each from 1 to 65536");
}

void read_method_settings(TomlTable& table, transport::RenderSettings& settings) {
    std::int64_t number = 0;
    table.read("prune", settings.paths.prune);
    if (table.read("max_depth", number, 0, std::numeric_limits<std::int32_t>::max())) settings.paths.max_depth = number;
    std::string mode;
    if (table.read("filter_mode", mode)) {
        settings.film.splat = mode == "splat";
        if (mode != "splat" && mode != "importance")
            table.source().fail(table.location_of("filter_mode"), "'filter_mode' in " + table.description() + " is '" +
                                                                      mode + "'; expected \"importance\" or \"splat\"");
    }
    std::string lobes;
    if (table.read("lobes", lobes)) {
        settings.labels.picked_lobes = lobes == "picked";
        if (lobes != "picked" && lobes != "exact")
            table.source().fail(table.location_of("lobes"), "'lobes' in " + table.description() + " is '" + lobes +
                                                                "'; expected \"exact\" or \"picked\"");
    }
}

void read_effects(TomlTable& table, transport::EffectChoices& effects) {
    const toml::table* inner = table.take_table("effects");
    if (inner == nullptr) return;
    TomlTable reader(table.source(), *inner, "'effects' of " + table.description());
    for (const auto& [key, node] : *inner) {
        const std::string name(key.str());
        bool forced = false;
        auto effect = transport::effect_named(name, reader.location_of(name));
        if (!effect) table.source().fail(effect.error());
        else if (reader.read(name, forced)) effects[*effect] = forced;
    }
}

void read_entity(TomlTable& root, const char* key, std::optional<transport::SceneEntity>& entity) {
    std::string name;
    if (const toml::node* node = root.take(key); node != nullptr && node->is_string()) {
        if (!root.require(key, name)) return;
        entity.emplace();
        entity->type = name;
        entity->location = entity->parameters.location = root.location_of(key);
        return;
    }
    const toml::table* table = root.take_table(key);
    if (table == nullptr) return;
    TomlTable reader(root.source(), *table, "[" + std::string(key) + "]");
    transport::SceneEntity result;
    if (!reader.require("type", result.type)) return;
    result.location = reader.location_of("type");
    result.parameters = reader.take_parameters();
    entity = std::move(result);
}

void read_sample_filters(TomlTable& root, transport::ChannelSettings& channels) {
    for (const toml::table* table : root.take_tables("sample_filter")) {
        TomlTable reader(root.source(), *table, "a [[sample_filter]] table");
        transport::SceneEntity filter;
        if (!reader.require("type", filter.type)) continue;
        filter.location = reader.location_of("type");
        filter.parameters = reader.take_parameters();
        filter.parameters.location = filter.location;
        channels.sample_filters.push_back(std::move(filter));
    }
}

void read_label_tables(TomlTable& root, Job& job) {
    read_rules(root, "label", "label",
               {{"material", Selector::material}, {"mesh", Selector::mesh_file}, {"instance", Selector::instance}},
               true, job);
    read_rules(root, "light_group", "group",
               {{"light", Selector::light}, {"area_light_material", Selector::area_light_material}}, false, job);
}

}  // namespace raylex::experiments
