#include "experiments/study/plan/config_text.h"

#include <string_view>
#include <utility>

#include "experiments/job/text/toml_text.h"

namespace raylex::experiments {
namespace {

std::vector<std::string> split_key(std::string_view key) {
    std::vector<std::string> parts;
    for (;;) {
        const std::size_t dot = key.find('.');
        parts.emplace_back(key.substr(0, dot));
        if (dot == std::string_view::npos) return parts;
        key.remove_prefix(dot + 1);
    }
}

toml::source_region region_of(const std::string& origin) {
    return {{1, 1}, {1, 1}, std::make_shared<const std::string>(origin)};
}

/// Puts a node at a path. `value` has the node under the key "v", with its origin.
void put_node(toml::table& root, const std::vector<std::string>& path, std::size_t at, toml::table& value,
              const std::string& origin) {
    toml::table* table = &root;
    for (; at + 1 < path.size(); ++at) {
        toml::node* next = table->get(path[at]);
        // A list of one table, such as a method's only [[method.sample_filter]], counts as that table.
        if (next != nullptr && next->is_array_of_tables() && next->as_array()->size() == 1) {
            table = next->as_array()->front().as_table();
            continue;
        }
        if (next != nullptr && next->is_string()) {
            toml::table made;
            made.insert("type", std::move(*next->as_string()));
            table->insert_or_assign(toml::key(path[at], region_of(origin)), std::move(made));
        } else if (next == nullptr || !next->is_table()) {
            table->insert_or_assign(toml::key(path[at], region_of(origin)), toml::table());
        }
        table = table->get(path[at])->as_table();
    }
    table->erase(path[at]);
    // Moved, because a copied node loses its source position.
    value.get("v")->visit(
        [&](auto& node) { table->insert_or_assign(toml::key(path[at], region_of(origin)), std::move(node)); });
}

/// Parses VALUE as TOML, or else as a plain word.
toml::table parse_value(const std::string& value, const std::string& origin) {
    try {
        return toml::parse("v = " + value, origin);
    } catch (const toml::parse_error&) {
        toml::table word;
        word.insert("v", value);
        std::string quoted = "v = '" + value + "'";
        try {
            return toml::parse(quoted, origin);
        } catch (const toml::parse_error&) { return word; }
    }
}

std::string table_name(const toml::node& node) {
    const toml::table* table = node.as_table();
    return table != nullptr ? (*table)["name"].value_or(std::string()) : std::string();
}

}  // namespace

toml::table* named_table(toml::table& root, std::string_view key, std::string_view name) {
    toml::array* list = root[key].as_array();
    if (list == nullptr) return nullptr;
    for (toml::node& each : *list)
        if (each.is_table() && table_name(each) == name) return each.as_table();
    return nullptr;
}

ConfigText::ConfigText(std::string file, std::string text, std::vector<std::string> overrides)
    : file_(std::move(file)), text_(std::move(text)), overrides_(std::move(overrides)) {}

Result<toml::table> ConfigText::parse() const {
    auto parsed = parse_toml(text_, file_);
    if (!parsed) return parsed.error();
    toml::table root = *std::move(parsed);
    for (const std::string& each : overrides_)
        if (Status applied = apply(each, root); !applied) return applied.error();
    return root;
}

void ConfigText::put(toml::table& table, const std::string& key, const AxisValue& value) {
    toml::table holder;
    std::visit([&](const auto& each) { holder.insert("v", each); }, value.value);
    put_node(table, split_key(key), 0, holder, {});
}

Status ConfigText::apply(const std::string& override, toml::table& root) const {
    const std::string origin = "--set " + override;
    const SourceLocation where{origin, 0, 0};
    const std::size_t equals = override.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == override.size())
        return error_at(where,
                        "this sets nothing; expected KEY=VALUE, such as replicates=2 or method.path.max_depth=4");
    if (Status shallow = check_toml_depth(override, origin); !shallow) return shallow;
    const std::vector<std::string> path = split_key(std::string_view(override).substr(0, equals));
    const std::string value = override.substr(equals + 1);
    for (const std::string& each : path)
        if (each.empty())
            return error_at(where, "the key has an empty part; expected for example method.path.max_depth");
    toml::array* list = path.size() > 1 ? root[path.front()].as_array() : nullptr;
    const bool listed = list != nullptr && !list->empty() && list->front().is_table();
    if (!listed) {
        toml::table node = parse_value(value, origin);
        put_node(root, path, 0, node, origin);
        return success();
    }
    std::vector<std::string> names;
    std::string known;
    bool found = false;
    for (toml::node& each : *list) {
        const std::string name = table_name(each);
        names.push_back(name);
        known += (known.empty() ? "" : ", ") + name;
        if (path[1] != "*" && path[1] != name) continue;
        found = true;
        if (path.size() < 3)
            return error_at(where, "'" + path[0] + "." + path[1] +
                                       "' is a table; expected the key of one of its values, such as " + path[0] + "." +
                                       path[1] + ".file");
        toml::table node = parse_value(value, origin);
        put_node(*each.as_table(), path, 2, node, origin);
    }
    if (found) return success();
    return error_at(where, "unknown [[" + path[0] + "]] '" + path[1] + "'; expected one of: " + known + ", or *",
                    near_miss(path[1], names));
}

}  // namespace raylex::experiments
