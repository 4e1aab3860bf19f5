#include "experiments/job/settings/setting.h"

#include <cstdlib>

#include "experiments/job/settings/kinds.h"
#include "experiments/job/text/toml_table.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

using Type = RenderSetting::Type;

/// Returns the text of a value in a job as in a flag; empty: a value of another type.
std::string flag_text(const toml::node& node) {
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
    if (const auto* real = node.as_floating_point()) return plain_number(real->get());
    if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
    return {};
}

/// Returns what the type of the node must be; empty: it is of that type.
const char* type_fault(Type type, const toml::node& node) {
    if (type == Type::integer) return node.is_integer() ? "" : "an integer";
    if (type == Type::number) return node.is_number() ? "" : "a number";
    if (type == Type::boolean) return node.is_boolean() ? "" : "true or false";
    return node.is_string() ? "" : "a string";
}

void read_row(TomlTable& table, const RenderSetting& setting, const std::string& job_path, Job& job) {
    const std::string key = setting.key.substr(setting.key.rfind('.') + 1);
    const RenderSetting::Values& values = setting.values;
    if (values.type == Type::own) return;
    const toml::node* node = table.take(key);
    if (node == nullptr) return;
    std::vector<RenderSetting::Item> items;
    if (values.type == Type::strings) {
        std::vector<std::string> texts;
        std::vector<SourceLocation> places;
        if (!table.read(key, texts, &places)) return;
        for (std::size_t i = 0; i < texts.size(); ++i) items.push_back({texts[i], places[i]});
    } else if (const toml::array* list = node->as_array(); list != nullptr && !values.separator.empty()) {
        if (!list->is_homogeneous(toml::node_type::integer)) return table.wrong_type(key, *node, values.range.c_str());
        std::string joined;
        for (const toml::node& each : *list) joined += (joined.empty() ? "" : values.separator) + flag_text(each);
        items.push_back({joined, table.location_of(key)});
    } else if (const std::string expected = type_fault(values.type, *node); !expected.empty()) {
        return table.wrong_type(key, *node, values.separator.empty() ? expected.c_str() : values.range.c_str());
    } else {
        items.push_back(
            {flag_text(*node), node->is_string() ? table.content_location_of(key) : table.location_of(key)});
    }
    if (values.is_path)
        for (RenderSetting::Item& item : items)
            if (!is_standard_output(item.text)) item.text = relative_to_job(job_path, item.text);
    if (const Status set = values.set(job, items); !set) {
        Error error = set.error();
        const std::string where = "'" + key + "' in " + table.description();
        if (node->is_array() && !values.separator.empty())
            error.message = where + " is not valid; expected " + values.range;
        else if (!values.range.empty() && values.separator.empty()) error.message = where + ": " + error.message;
        table.source().fail(std::move(error));
    }
}

std::string cell(std::string text, const char* quote) {
    for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) text.insert(at, "\\");
    return text.empty() ? " |" : " " + (quote + text) + quote + " |";
}

}  // namespace

std::string plain_number(double number) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof(text), number).ptr};
}

std::string words_text(const std::vector<std::string>& words) {
    std::string list;
    for (const std::string& word : words) list += (list.empty() ? "\"" : " or \"") + word + "\"";
    return list;
}

Error invalid_value(const RenderSetting::Item& item, const std::string& expected, const std::string& hint) {
    return error_at(item.location, "'" + item.text + "' is not a valid value; expected " + expected, hint);
}

std::string RenderSetting::text() const {
    if (value == "on|off") return help + "; default " + (values.usual == "true" ? "on" : "off");
    return values.usual.empty() || values.type == Type::boolean || help.find("default") != help.npos
               ? help
               : help + "; default " + values.usual;
}

const std::vector<SettingGroup>& setting_groups() {
    static const std::vector<SettingGroup> groups{{"Files and viewers", file_settings()},
                                                  {"Sampling", sampling_settings()},
                                                  {"Image", image_settings()},
                                                  {"Long renders", schedule_settings()},
                                                  {"Machine", machine_settings()},
                                                  {"Light transport", method_settings()},
                                                  {"Layers of light", light_layer_settings()},
                                                  {"Other layers", sample_layer_settings()},
                                                  {"Colour and previews", color_settings()},
                                                  {"Filters", filter_settings()}};
    return groups;
}

const RenderSetting& setting_of_flag(std::string_view flag) {
    for (const SettingGroup& group : setting_groups())
        for (const RenderSetting& setting : group.settings)
            if (setting.flag == flag) return setting;
    std::abort();
}

Status set_from_flag(const RenderSetting& setting, const std::string& flag, const std::vector<std::string>& values,
                     Job& job) {
    if (values.empty() || setting.values.type == Type::own) return success();
    const bool is_text = setting.values.type == Type::string && !setting.values.has_empty;
    if (is_text && values.back().empty()) return success();
    std::vector<RenderSetting::Item> items;
    for (const std::string& value : values)
        items.push_back({flag.starts_with("--no-") && value == "true" ? "false" : value, {flag, 0, 0}});
    return setting.values.set(job, items);
}

void read_settings(TomlTable& table, std::string_view name, const std::string& job_path, Job& job) {
    for (const SettingGroup& group : setting_groups())
        for (const RenderSetting& setting : group.settings)
            if (const std::size_t dot = setting.key.rfind('.');
                dot != std::string::npos && std::string_view(setting.key).substr(0, dot) == name)
                read_row(table, setting, job_path, job);
}

SourceLocation read_settings_table(TomlTable& root, const std::string& name, const std::string& job_path, Job& job,
                                   const std::function<void(TomlTable&)>& read_more) {
    const toml::table* table = root.take_table(name);
    if (table == nullptr) return {};
    TomlTable reader(root.source(), *table, "[" + name + "]");
    if (read_more) read_more(reader);
    read_settings(reader, name, job_path, job);
    reader.close();
    return reader.location();
}

void read_setting(TomlTable& table, std::string_view key, Job& job) {
    for (const SettingGroup& group : setting_groups())
        for (const RenderSetting& setting : group.settings)
            if (setting.key == key) read_row(table, setting, {}, job);
}

std::string settings_page() {
    std::string page =
        "# Settings of a render\n\n"
        "Each setting as a flag of `raylex render`, as a key of a [job](jobs.md) and as an argument of "
        "`raylex.render()`\n([Python](../python.md)). `raylex help settings` prints this page.\n\n"
        "| flag | key | Python | value | default | effect |\n|---|---|---|---|---|---|\n";
    for (const SettingGroup& group : setting_groups())
        for (const RenderSetting& setting : group.settings)
            page += "|" + cell(setting.flag, "`") + cell(setting.key, "`") + cell(setting.python, "`") +
                    cell(setting.values.range.empty() ? setting.value : setting.values.range, "") +
                    cell(setting.values.usual, "`") + cell(setting.help, "") + "\n";
    return page;
}

}  // namespace raylex::experiments
