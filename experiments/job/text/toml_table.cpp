#include "experiments/job/text/toml_table.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace raylex::experiments {
namespace {

const char* kind_of(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return "an array";
        case toml::node_type::string:
            return "a string";
        case toml::node_type::integer:
            return "an integer";
        case toml::node_type::floating_point:
            return "a float";
        case toml::node_type::boolean:
            return "a boolean";
        case toml::node_type::date:
        case toml::node_type::time:
        case toml::node_type::date_time:
            return "a date or time";
        case toml::node_type::none:
            break;
    }
    return "nothing";
}

/// Converts a value to a parameter: a boolean, integer, real or string, or an array of one of these types.
bool to_parameter(const toml::node& node, Parameter& parameter) {
    if (const auto* flag = node.as_boolean()) {
        parameter.type = ParameterType::boolean;
        parameter.booleans.push_back(flag->get() ? 1 : 0);
    } else if (const auto* whole = node.as_integer()) {
        parameter.type = ParameterType::integer;
        parameter.numbers.push_back(static_cast<double>(whole->get()));
    } else if (const auto* real = node.as_floating_point()) {
        parameter.type = ParameterType::real;
        parameter.numbers.push_back(real->get());
    } else if (const auto* text = node.as_string()) {
        parameter.type = ParameterType::string;
        parameter.strings.push_back(text->get());
    } else if (const auto* list = node.as_array(); list != nullptr && !list->empty()) {
        bool any_real = false;
        for (const toml::node& each : *list) {
            if (each.is_array() || !to_parameter(each, parameter)) return false;
            any_real = any_real || parameter.type == ParameterType::real;
        }
        const std::size_t count = parameter.booleans.size() + parameter.numbers.size() + parameter.strings.size();
        const bool one_kind = parameter.booleans.size() == count || parameter.numbers.size() == count ||
                              parameter.strings.size() == count;
        if (any_real) parameter.type = ParameterType::real;
        return one_kind;
    } else {
        return false;
    }
    return true;
}

}  // namespace

TomlSource::TomlSource(std::string file, std::string_view text)
    : file_(std::move(file)),
      text_(std::make_shared<const lpe::TextFile>(lpe::TextFile{file_, std::string(text), true})) {
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        std::string_view line = text.substr(0, end);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        lines_.emplace_back(line);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
}

SourceLocation TomlSource::location(const toml::source_region& region) const {
    // inserted from elsewhere, such as a command line
    if (region.path && *region.path != file_) return {*region.path, 0, 0};
    const auto line = static_cast<std::size_t>(region.begin.line);
    std::size_t column = region.begin.column;
    if (line >= 1 && line <= lines_.size()) {
        // Adds one to the column for each UTF-8 continuation byte before it.
        const std::string& text = lines_[line - 1];
        for (std::size_t byte = 0; byte + 1 < column && byte < text.size(); ++byte)
            if ((static_cast<unsigned char>(text[byte]) & 0xC0U) == 0x80U) ++column;
    }
    return {file_, static_cast<int>(line), static_cast<int>(column)};
}

SourceLocation TomlSource::content_location(const toml::node& node) const {
    SourceLocation where = location(node);
    if (where.line < 1 || static_cast<std::size_t>(where.line) > lines_.size()) return where;
    const std::string& line = lines_[static_cast<std::size_t>(where.line) - 1];
    const auto quote = static_cast<std::size_t>(where.column - 1);
    if (quote >= line.size()) return where;
    const bool triple = quote + 2 < line.size() && line[quote + 1] == line[quote] && line[quote + 2] == line[quote];
    where.column += triple ? 3 : 1;
    return where;
}

void TomlSource::fail(Error error) {
    if (error_ && std::tie(error_->line, error_->column) <= std::tie(error.line, error.column)) return;
    if (error.excerpt.empty() && error.file == file_ && error.line >= 1 &&
        static_cast<std::size_t>(error.line) <= lines_.size())
        error.excerpt = lines_[static_cast<std::size_t>(error.line) - 1];
    error_ = std::move(error);
}

void TomlSource::fail(const SourceLocation& where, std::string message, std::string hint) {
    fail(error_at(where, std::move(message), std::move(hint)));
}

TomlTable::TomlTable(TomlSource& source, const toml::table& table, std::string description)
    : source_(source), table_(table), description_(std::move(description)) {}

const toml::node* TomlTable::take(std::string_view key) {
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
    return table_.get(key);
}

SourceLocation TomlTable::location_of(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return source_.location(node != nullptr ? *node : static_cast<const toml::node&>(table_));
}

SourceLocation TomlTable::content_location_of(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return node != nullptr ? source_.content_location(*node) : location();
}

std::shared_ptr<const lpe::SourceMap> TomlTable::string_map_of(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return node != nullptr ? source_.string_map(*node) : nullptr;
}

void TomlTable::wrong_type(std::string_view key, const toml::node& node, const char* expected) {
    source_.fail(source_.location(node),
                 "'" + std::string(key) + "' in " + description_ + " is " + kind_of(node) + "; expected " + expected);
}

bool TomlTable::read(std::string_view key, std::string& value) {
    const toml::node* node = take(key);
    if (node == nullptr) return false;
    const auto* text = node->as_string();
    if (text == nullptr) {
        wrong_type(key, *node, "a string");
        return false;
    }
    value = text->get();
    return true;
}

bool TomlTable::read(std::string_view key, bool& value) {
    const toml::node* node = take(key);
    if (node == nullptr) return false;
    const auto* flag = node->as_boolean();
    if (flag == nullptr) {
        wrong_type(key, *node, "true or false");
        return false;
    }
    value = flag->get();
    return true;
}

bool TomlTable::read(std::string_view key, std::int64_t& value, std::int64_t least, std::int64_t most) {
    const toml::node* node = take(key);
    if (node == nullptr) return false;
    const auto* whole = node->as_integer();
    if (whole == nullptr) {
        wrong_type(key, *node, "an integer");
        return false;
    }
    if (whole->get() < least || whole->get() > most) {
        source_.fail(source_.location(*node), "'" + std::string(key) + "' in " + description_ + " is " +
                                                  std::to_string(whole->get()) + "; expected an integer from " +
                                                  std::to_string(least) + " to " + std::to_string(most));
        return false;
    }
    value = whole->get();
    return true;
}

bool TomlTable::read(std::string_view key, std::vector<std::string>& value, std::vector<SourceLocation>* locations) {
    const toml::node* node = take(key);
    if (node == nullptr) return false;
    const toml::array* list = node->as_array();
    if (list == nullptr) {
        wrong_type(key, *node, "an array of strings");
        return false;
    }
    std::vector<std::string> result;
    for (const toml::node& each : *list) {
        const auto* text = each.as_string();
        if (text == nullptr) {
            source_.fail(source_.location(each), "an entry of '" + std::string(key) + "' in " + description_ + " is " +
                                                     kind_of(each) + "; expected a string");
            return false;
        }
        result.push_back(text->get());
        if (locations != nullptr) locations->push_back(source_.content_location(each));
    }
    value = std::move(result);
    return true;
}

bool TomlTable::require(std::string_view key, std::string& value) {
    if (table_.get(key) == nullptr) {
        take(key);
        source_.fail(location(),
                     description_ + " has no '" + std::string(key) + "'; expected " + std::string(key) + " = \"...\"");
        return false;
    }
    if (!read(key, value)) return false;
    if (!value.empty()) return true;
    source_.fail(location_of(key), "'" + std::string(key) + "' in " + description_ + " is empty; expected some text");
    return false;
}

const toml::table* TomlTable::take_table(std::string_view key) {
    const toml::node* node = take(key);
    if (node == nullptr) return nullptr;
    const toml::table* table = node->as_table();
    if (table == nullptr) wrong_type(key, *node, ("a table: [" + std::string(key) + "]").c_str());
    return table;
}

std::vector<const toml::table*> TomlTable::take_tables(std::string_view key) {
    std::vector<const toml::table*> result;
    const toml::node* node = take(key);
    if (node == nullptr) return result;
    const toml::array* list = node->as_array();
    const bool tables = list != nullptr &&
                        std::all_of(list->begin(), list->end(), [](const toml::node& each) { return each.is_table(); });
    if (!tables) {
        wrong_type(key, *node, ("tables: [[" + std::string(key) + "]]").c_str());
        return result;
    }
    for (const toml::node& each : *list) result.push_back(each.as_table());
    return result;
}

ParameterSet TomlTable::take_parameters() {
    ParameterSet set;
    set.location = location();
    for (const auto& [key, node] : table_) {
        if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
        Parameter parameter;
        parameter.name = std::string(key.str());
        parameter.location = source_.location(key.source());
        if (!to_parameter(node, parameter)) {
            wrong_type(key.str(), node, "a boolean, a number, a string, or an array of one of these");
            continue;
        }
        set.parameters.push_back(std::move(parameter));
    }
    for (const Parameter& parameter : set.parameters) known_.push_back(parameter.name);
    return set;
}

void TomlTable::close() {
    for (const auto& [key, node] : table_) {
        if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
        std::string expected;
        for (const std::string& name : known_) expected += (expected.empty() ? "" : ", ") + name;
        source_.fail(
            source_.location(key.source()),
            "unknown key '" + std::string(key.str()) + "' in " + description_ + "; expected one of: " + expected,
            near_miss(key.str(), known_));
    }
}

}  // namespace raylex::experiments
