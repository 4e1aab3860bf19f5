#include "experiments/job/job_tables.h"

#include <filesystem>
#include <utility>

#include "experiments/job/output_requests.h"
#include "experiments/job/settings/setting.h"
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
            {is_shipped_plugin(files[i]) ? shipped_plugin(files[i]) : relative_to_job(job_path, files[i]),
             locations[i]});
}

bool is_shipped_plugin(const std::string& name) {
    return name.find('/') == std::string::npos && std::filesystem::path(name).extension() != ".so";
}

std::string shipped_plugin(const std::string& name) {
    const auto found = resource("plugins/lib" + name + ".so");
    return found ? *found : found.error().file;
}

void read_method_settings(TomlTable& table, transport::RenderSettings& settings) {
    Job job;
    job.settings = std::move(settings);
    for (const char* key : {"render.prune", "render.max_depth", "render.filter_mode", "render.lobes"})
        read_setting(table, key, job);
    settings = std::move(job.settings);
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
    for (ObjectRequest& request : read_objects(root, "sample_filter")) {
        const SourceLocation where = request.parameters.location;
        channels.sample_filters.push_back({{}, std::move(request.name), std::move(request.parameters), where});
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
