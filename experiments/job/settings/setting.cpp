#include "experiments/job/settings/setting.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <type_traits>

#include "experiments/job/settings/kinds.h"
#include "experiments/job/text/toml_table.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

/// Returns what a value must be: "a whole number from 0 to 4096".
std::string range_of(const Setting::Whole& whole) {
    return std::string(whole.step == 2 ? "an even" : "a whole") + " number from " + std::to_string(whole.least) +
           " to " + std::to_string(whole.most);
}

std::string range_of(const Setting::Real& real) {
    return "a number from " + plain_number(real.least) + " to " + plain_number(real.most);
}

std::string range_of(const std::vector<std::string>& words, const char* quote) {
    std::string list;
    for (std::size_t i = 0; i < words.size(); ++i)
        list += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + (quote + words[i] + quote);
    return list;
}

bool fits(const Setting::Real& real, double number) {
    return number >= real.least && number <= real.most;
}

template <typename Number>
bool parse_whole_text(const std::string& text, Number& number) {
    const char* const end = text.data() + text.size();
    const auto [last, failed] = std::from_chars(text.data(), end, number);
    return failed == std::errc() && last == end;
}

/// Sets a setting from the values of a flag.
struct FlagReader {
    const Setting& setting;
    const std::string& flag;
    const std::vector<std::string>& values;
    Job& job;

    [[nodiscard]] const std::string& text() const { return values.back(); }
    [[nodiscard]] Status refused(const std::string& expected, const std::string& hint = {}) const {
        return error_at({flag, 0, 0}, "'" + text() + "' is not a valid value; expected " + expected, hint);
    }
    Status operator()(const Setting::Whole& whole) const {
        std::uint64_t number = 0;
        if (!parse_whole_text(text(), number) || number < whole.least || number > whole.most ||
            number % whole.step != 0)
            return refused(range_of(whole));
        whole.set(job, number);
        return success();
    }
    Status operator()(const Setting::Real& real) const {
        double number = 0;
        if (!parse_whole_text(text(), number) || !fits(real, number)) return refused(range_of(real));
        real.set(job, number);
        return success();
    }
    Status operator()(const Setting::Choice& choice) const {
        const auto found = std::find(choice.words.begin(), choice.words.end(), text());
        if (found == choice.words.end()) return refused(range_of(choice.words, ""), near_miss(text(), choice.words));
        choice.set(job, static_cast<std::size_t>(found - choice.words.begin()));
        return success();
    }
    Status operator()(const Setting::Switch& on_or_off) const {
        if (setting.value == "on|off" && text() != "on" && text() != "off") return refused("on or off");
        on_or_off.set(job, (text() != "off" && text() != "false") != setting.flag.starts_with("--no-"));
        return success();
    }
    Status operator()(const Setting::Text& kind) const { return kind.set(job, text(), {flag, 0, 0}); }
    Status operator()(const Setting::Texts& kind) const {
        std::vector<Setting::Item> items;
        for (const std::string& each : values) items.push_back({each, {flag, 0, 0}});
        return kind.set(job, items);
    }
    Status operator()(const Setting::Own&) const { return success(); }
};

/// Reads a setting from a table of a job.
struct KeyReader {
    TomlTable& table;
    const std::string key;
    const std::string& job_path;
    Job& job;

    void fail(const std::string& what, const std::string& hint = {}) const {
        table.source().fail(table.location_of(key), "'" + key + "' in " + table.description() + " is " + what, hint);
    }
    void check(const Status& status) const {
        if (!status) table.source().fail(status.error());
    }
    [[nodiscard]] std::string located(const std::string& text, bool is_path) const {
        return is_path && !is_standard_output(text) ? beside_job(job_path, text) : text;
    }
    void operator()(const Setting::Whole& whole) const {
        constexpr std::uint64_t largest = std::numeric_limits<std::int64_t>::max();
        std::int64_t number = 0;
        if (!table.read(key, number, static_cast<std::int64_t>(whole.least),
                        static_cast<std::int64_t>(std::min(whole.most, largest))))
            return;
        if (static_cast<std::uint64_t>(number) % whole.step != 0)
            return fail(std::to_string(number) + "; expected " + range_of(whole));
        whole.set(job, static_cast<std::uint64_t>(number));
    }
    void operator()(const Setting::Real& real) const {
        const toml::node* node = table.take(key);
        if (node == nullptr) return;
        const auto number = node->is_string() ? std::nullopt : node->value<double>();
        if (number && fits(real, *number)) real.set(job, *number);
        else fail("not " + range_of(real));
    }
    void operator()(const Setting::Choice& choice) const {
        std::string word;
        if (!table.read(key, word)) return;
        const auto found = std::find(choice.words.begin(), choice.words.end(), word);
        if (found == choice.words.end())
            return fail("'" + word + "'; expected " + range_of(choice.words, "\""), near_miss(word, choice.words));
        choice.set(job, static_cast<std::size_t>(found - choice.words.begin()));
    }
    void operator()(const Setting::Switch& on_or_off) const {
        bool on = false;
        if (table.read(key, on)) on_or_off.set(job, on);
    }
    void operator()(const Setting::Text& kind) const {
        const toml::node* node = table.take(key);
        if (node == nullptr) return;
        std::string text;
        if (kind.array.empty() || node->is_string()) {
            if (table.read(key, text))
                check(kind.set(job, located(text, kind.is_path), table.content_location_of(key)));
            return;
        }
        if (const toml::array* list = node->as_array())
            for (const toml::node& each : *list)
                text += (text.empty() ? "" : kind.separator) +
                        std::to_string(each.value_exact<std::int64_t>().value_or(-1));
        if (!kind.set(job, text, {})) fail("out of range or not an array of integers; expected " + kind.array);
    }
    void operator()(const Setting::Texts& kind) const {
        std::vector<std::string> texts;
        std::vector<SourceLocation> places;
        if (kind.is_single_key) {
            if (!table.read(key, texts.emplace_back())) return;
            places.push_back(table.content_location_of(key));
        } else if (!table.read(key, texts, &places)) {
            return;
        }
        std::vector<Setting::Item> items;
        for (std::size_t i = 0; i < texts.size(); ++i) items.push_back({located(texts[i], kind.is_path), places[i]});
        check(kind.set(job, items));
    }
    void operator()(const Setting::Own&) const {}
};

/// Returns what a value can be, for the reference page.
std::string range_text(const Setting& setting) {
    return std::visit(
        [&](const auto& kind) -> std::string {
            using Kind = std::decay_t<decltype(kind)>;
            if constexpr (std::is_same_v<Kind, Setting::Whole> || std::is_same_v<Kind, Setting::Real>)
                return range_of(kind);
            else if constexpr (std::is_same_v<Kind, Setting::Choice>) return range_of(kind.words, "`");
            else if constexpr (std::is_same_v<Kind, Setting::Switch>) return "`true` or `false`";
            else return setting.value.empty() ? "" : "`" + setting.value + "`";
        },
        setting.values.kind);
}

std::string cell(std::string text, const char* quote) {
    for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) text.insert(at, "\\");
    return text.empty() ? " |" : " " + (quote + text) + quote + " |";
}

}  // namespace

std::string plain_number(double number) {
    char text[32];
    std::snprintf(text, sizeof(text), std::abs(number) < 1 ? "%.2g" : "%.17g", number);
    return text;
}

std::string Setting::text() const {
    if (value == "on|off") return help + "; default " + (values.usual == "true" ? "on" : "off");
    const bool is_stated = !values.usual.empty() && !std::holds_alternative<Switch>(values.kind);
    return is_stated ? help + "; default " + values.usual : help;
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

const Setting& setting_of_flag(std::string_view flag) {
    for (const SettingGroup& group : setting_groups())
        for (const Setting& setting : group.settings)
            if (setting.flag == flag) return setting;
    std::abort();
}

Status set_from_flag(const Setting& setting, const std::string& flag, const std::vector<std::string>& values,
                     Job& job) {
    if (values.empty() || values.back().empty()) return success();
    return std::visit(FlagReader{setting, flag, values, job}, setting.values.kind);
}

void read_settings(TomlTable& table, std::string_view name, const std::string& job_path, Job& job) {
    for (const SettingGroup& group : setting_groups())
        for (const Setting& setting : group.settings) {
            const std::string_view key = setting.key;
            const std::size_t dot = key.find('.');
            if (dot == std::string_view::npos || key.substr(0, dot) != name || key.find('.', dot + 1) != key.npos)
                continue;
            std::visit(KeyReader{table, std::string(key.substr(dot + 1)), job_path, job}, setting.values.kind);
        }
}

void read_setting(TomlTable& table, std::string_view key, Job& job) {
    for (const SettingGroup& group : setting_groups())
        for (const Setting& setting : group.settings)
            if (setting.key == key)
                std::visit(KeyReader{table, std::string(key.substr(key.rfind('.') + 1)), {}, job}, setting.values.kind);
}

std::string settings_page() {
    std::string page =
        "# Settings of a render\n\n"
        "Each setting as a flag of `raylex render`, as a key of a [job](jobs.md) and as an argument of "
        "`raylex.render()`\n([Python](../python.md)). `raylex help settings` prints this page.\n";
    for (const SettingGroup& group : setting_groups()) {
        page += "\n## " + group.heading + "\n\n| flag | key | Python | value | default | effect |\n" +
                "|---|---|---|---|---|---|\n";
        for (const Setting& setting : group.settings)
            page += "|" + cell(setting.flag, "`") + cell(setting.key, "`") + cell(setting.python, "`") +
                    cell(range_text(setting), "") + cell(setting.values.usual, "`") + cell(setting.help, "") + "\n";
    }
    return page;
}

}  // namespace raylex::experiments
