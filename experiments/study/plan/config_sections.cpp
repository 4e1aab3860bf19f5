#include "experiments/study/plan/config_sections.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>

#include "experiments/job/sampling_requests.h"
#include "experiments/study/plan/shell_places.h"
#include "experiments/study/results_file.h"

namespace raylex::experiments {
namespace {

constexpr std::array budget_kinds{BudgetKind::samples, BudgetKind::seconds, BudgetKind::error};

/// Reads a relative error as a number or "1%".
std::optional<double> error_value(const AxisValue& value) {
    if (const auto* text = std::get_if<std::string>(&value.value)) {
        auto parsed = parse_tolerance(*text, {});
        return parsed ? std::optional(*parsed) : std::nullopt;
    }
    if (const double* real = std::get_if<double>(&value.value)) return *real;
    return std::nullopt;
}

/// Reads a time as a number of seconds or "2m".
std::optional<double> seconds_value(const AxisValue& value) {
    if (const auto* text = std::get_if<std::string>(&value.value)) {
        auto parsed = parse_interval(*text, {});
        return parsed ? std::optional(*parsed) : std::nullopt;
    }
    if (const auto* whole = std::get_if<std::int64_t>(&value.value)) return static_cast<double>(*whole);
    if (const double* real = std::get_if<double>(&value.value)) return *real;
    return std::nullopt;
}

std::optional<double> samples_value(const AxisValue& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value.value)) return static_cast<double>(*whole);
    return std::nullopt;
}

/// Returns the value if it is valid for a budget of this kind.
Result<double> budget_value(BudgetKind kind, const AxisValue& value, const SourceLocation& where) {
    std::optional<double> number;
    bool fits = false;
    const char* expected = "";
    switch (kind) {
        case BudgetKind::samples:
            number = samples_value(value);
            fits = number && *number >= 1 && *number <= std::numeric_limits<std::int32_t>::max();
            expected = "an integer number of samples per pixel from 1 to 2147483647";
            break;
        case BudgetKind::seconds:
            number = seconds_value(value);
            fits = number && *number > 0 && *number <= 30.0 * 24 * 3600;
            expected = "seconds above 0 and at most 30 days, such as 2.5 or \"2m\"";
            break;
        case BudgetKind::error:
            number = error_value(value);
            fits = number && *number > 0 && *number <= 10;
            expected = "a relative error above 0 and at most 10, such as \"1%\" or 0.01";
            break;
    }
    if (fits) return *number;
    return error_at(where,
                    "'" + value.text() + "' is not a budget of " + budget_kind_name(kind) + "; expected " + expected);
}

std::string listed(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& each : names) list += (list.empty() ? "" : ", ") + each;
    return list;
}

Status require_name(const char* what, const std::string& name, const std::vector<std::string>& known,
                    const SourceLocation& where) {
    if (std::find(known.begin(), known.end(), name) != known.end()) return success();
    return error_at(where, std::string("unknown ") + what + " '" + name + "'; expected one of: " + listed(known),
                    near_miss(name, known));
}

std::vector<std::string> scene_names(const ExperimentConfig& config) {
    std::vector<std::string> names;
    for (const SceneRequest& each : config.scenes) names.push_back(each.name);
    return names;
}

std::vector<std::string> method_names(const ExperimentConfig& config) {
    std::vector<std::string> names;
    for (const MethodRequest& each : config.methods) names.push_back(each.name);
    return names;
}

void fail_unless(TomlSource& source, const Status& status) {
    if (!status) source.fail(status.error());
}

bool is_word(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
    });
}

/// Checks the {words} of a command, which the runner replaces. Other braces, and ${word}, belong to the shell.
Status check_command(const MethodRequest& method, std::size_t scenes, bool replicates) {
    std::vector<std::string> known{"scene", "scene_name", "seed",   "spp",    "seconds",
                                   "out",   "width",      "height", "threads"};
    for (const SweepAxis& axis : method.sweep) known.push_back(axis.key);
    const std::string& command = method.command;
    for (std::size_t at = 0; (at = command.find('{', at)) != std::string::npos; ++at) {
        const std::size_t end = command.find('}', at);
        if (end == std::string::npos) break;
        const std::string word = command.substr(at + 1, end - at - 1);
        if (!is_word(word) || (at > 0 && command[at - 1] == '$')) continue;
        if (Status s = require_name("placeholder", word, known, method.location); !s) return s;
    }
    if (!has_place(command, "out"))
        return error_at(method.location, "the command of method '" + method.name +
                                             "' lacks {out}; expected it in place of the image file");
    // A renderer with its own scene format can name its file by {scene_name}.
    if (scenes > 1 && !has_place(command, "scene") && !has_place(command, "scene_name"))
        return error_at(method.location, "the command of method '" + method.name +
                                             "' would render the same image for " + std::to_string(scenes) +
                                             " scenes; expected {scene}, the scene's file, or {scene_name} in it");
    if (replicates && !has_place(command, "seed"))
        return error_at(method.location, "the command of method '" + method.name +
                                             "' lacks {seed}: its replicates would be "
                                             "the same image; expected it, or replicates = 1");
    return success();
}

/// Checks a render without beauty, whose light is all in its channels.
Status check_without_beauty(const ExperimentConfig& config, const Variant& variant) {
    const MethodRequest& method = config.methods[variant.method];
    const std::string who = "method '" + method.name + "' has beauty = false, ";
    const Job& base = config.base;
    if (base.expressions.empty() && !base.light_groups && !base.shipped_partition)
        return error_at(method.location,
                        who + "and there is no channel, so nothing is rendered; expected a [[channel]]");
    if (!variant.planned)
        return error_at(config.reference.location,
                        who + "but references contain everything that any method renders; expected another method");
    for (const Budget& budget : config.budgets)
        if (budget.kind == BudgetKind::error)
            return error_at(
                budget.location,
                who + "but a budget of error applies to the beauty; expected budgets of samples or seconds");
    return success();
}

}  // namespace

void check_short_name(TomlTable& table, std::string_view key, const std::string& name) {
    const bool fits = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
    if (!fits || name.size() > 64)
        table.source().fail(table.location_of(key),
                            "'" + name +
                                "' cannot be a part of file names; expected at most 64 letters, "
                                "digits, _ and -");
}

void read_timeout(TomlTable& table, double& seconds) {
    std::string text;
    if (!table.read("timeout", text)) return;
    auto parsed = parse_interval(text, table.content_location_of("timeout"));
    if (parsed) seconds = *parsed;
    else table.source().fail(parsed.error());
}

void require_file(TomlTable& table, std::string_view key, const std::string& path, const char* what) {
    std::error_code failed;
    if (!std::filesystem::is_regular_file(path, failed))
        table.source().fail(table.location_of(key),
                            std::string("cannot find ") + what + " '" + path + "'; expected a file");
}

void read_budgets(TomlTable& root, std::vector<Budget>& budgets) {
    const toml::table* table = root.take_table("budget");
    if (table == nullptr) {
        if (!root.has("budget"))
            root.source().fail(root.location(),
                               "the config has no [budget]; expected for example samples = \"pow2(0..8)\", "
                               "seconds = [1, 4] or error = [\"5%\", \"1%\"]");
        return;
    }
    TomlTable reader(root.source(), *table, "[budget]");
    for (const BudgetKind kind : budget_kinds) {
        const std::string key = budget_kind_name(kind);
        const toml::node* node = reader.take(key);
        if (node == nullptr) continue;
        auto values = read_axis(root.source(), *node, key);
        if (!values) {
            root.source().fail(values.error());
            continue;
        }
        for (const AxisValue& each : *values) {
            auto value = budget_value(kind, each, reader.location_of(key));
            if (value) budgets.push_back({kind, *value, reader.location_of(key)});
            else root.source().fail(value.error());
        }
    }
    reader.close();
    if (budgets.empty() && !root.source().error())
        root.source().fail(root.location_of("budget"), "[budget] is empty; expected samples, seconds or error");
}

void read_reference(TomlTable& root, ExperimentConfig& config) {
    const toml::table* table = root.take_table("reference");
    if (table == nullptr) return;
    TomlTable reader(root.source(), *table, "[reference]");
    ReferenceRequest& reference = config.reference;
    reference.location = reader.location();
    if (reader.require("method", reference.method))
        fail_unless(root.source(),
                    require_name("method", reference.method, method_names(config), reader.location_of("method")));
    std::int64_t number = 0;
    if (reader.read("spp", number, 1, std::numeric_limits<std::int32_t>::max()))
        reference.samples = static_cast<std::uint64_t>(number);
    if (const toml::node* node = reader.take("error")) {
        auto values = read_axis(root.source(), *node, "error");
        if (values && values->size() != 1)
            root.source().fail(reader.location_of("error"), "a reference has one error; expected for example \"0.2%\"");
        auto value = values ? budget_value(BudgetKind::error, values->front(), reader.location_of("error"))
                            : Result<double>(values.error());
        if (value) reference.error = *value;
        else root.source().fail(value.error());
    }
    read_timeout(reader, reference.timeout);
    if (reader.read("cache", reference.cache)) reference.cache = relative_to_job(config.file, reference.cache);
    reader.close();
    if (reference.samples == 0 && reference.error == 0)
        root.source().fail(reader.location(),
                           "[reference] has neither error nor spp; expected error = \"0.2%\" or spp = 4096, or both, "
                           "to stop at the first reached");
}

void read_regions(TomlTable& root, ExperimentConfig& config) {
    for (const toml::table* each : root.take_tables("region")) {
        TomlTable table(root.source(), *each, "a [[region]] table");
        Region region;
        if (table.require("name", region.name)) check_short_name(table, "name", region.name);
        if (table.read("scene", region.scene))
            fail_unless(root.source(),
                        require_name("scene", region.scene, scene_names(config), table.location_of("scene")));
        if (table.read("mask", region.mask_file)) {
            region.mask_file = relative_to_job(config.file, region.mask_file);
            require_file(table, "mask", region.mask_file, "the mask");
        }
        if (const toml::node* node = table.take("crop")) {
            const toml::array* list = node->as_array();
            bool fits = list != nullptr && list->size() == 4;
            for (std::size_t i = 0; fits && i < 4; ++i) {
                const auto number = list->get(i)->value_exact<std::int64_t>();
                fits = number && *number >= 0 && *number <= 65536;
                if (fits) region.crop[i] = static_cast<int>(*number);
            }
            if (!fits || region.crop[0] >= region.crop[2] || region.crop[1] >= region.crop[3])
                root.source().fail(table.location_of("crop"),
                                   "'crop' is not a rectangle; expected [x0, y0, x1, y1] in pixels, with "
                                   "x0 below x1 and y0 below y1");
        }
        if (table.has("crop") == table.has("mask"))
            root.source().fail(table.location(),
                               "a [[region]] has either a crop or a mask; expected exactly one of them");
        table.close();
        config.regions.push_back(std::move(region));
    }
}

void read_exclusions(TomlTable& root, ExperimentConfig& config) {
    TomlSource& source = root.source();
    std::vector<std::string> axes;
    for (const MethodRequest& method : config.methods)
        for (const SweepAxis& axis : method.sweep) axes.push_back(axis.key);
    for (const toml::table* each : root.take_tables("exclude")) {
        TomlTable table(source, *each, "an [[exclude]] table");
        Exclusion exclusion;
        exclusion.location = table.location();
        if (table.read("scene", exclusion.scene))
            fail_unless(source,
                        require_name("scene", exclusion.scene, scene_names(config), table.location_of("scene")));
        if (table.read("method", exclusion.method))
            fail_unless(source,
                        require_name("method", exclusion.method, method_names(config), table.location_of("method")));
        for (const BudgetKind kind : budget_kinds) {
            const std::string key = budget_kind_name(kind);
            const toml::node* node = table.take(key);
            if (node == nullptr) continue;
            exclusion.kind = kind;
            if (node->is_boolean()) continue;  // samples = true: all budgets of this kind
            auto values = read_axis(source, *node, key);
            if (!values) source.fail(values.error());
            for (const AxisValue& value : values ? *values : std::vector<AxisValue>()) {
                auto number = budget_value(kind, value, table.location_of(key));
                if (number) exclusion.budgets.push_back(*number);
                else source.fail(number.error());
            }
        }
        for (const std::string& axis : axes) {
            const toml::node* node = table.take(axis);
            if (node == nullptr) continue;
            auto values = read_axis(source, *node, axis);
            if (!values) {
                source.fail(values.error());
                continue;
            }
            std::vector<std::string> texts;
            for (const AxisValue& value : *values) texts.push_back(value.text());
            exclusion.settings.emplace_back(axis, std::move(texts));
        }
        table.close();
        config.exclusions.push_back(std::move(exclusion));
    }
}

Status check_config(ExperimentConfig& config) {
    for (const Variant& variant : config.variants)
        if (!variant.render.channels.beauty)
            if (Status s = check_without_beauty(config, variant); !s) return s;
    for (const MethodRequest& method : config.methods) {
        const auto refuse_error = [&](const SourceLocation& where) {
            return error_at(where, "method '" + method.name +
                                       "' has passes, and no pass has the error of the image; "
                                       "expected samples or seconds");
        };
        for (const Budget& budget : config.budgets)
            if (!method.passes.empty() && budget.kind == BudgetKind::error) return refuse_error(budget.location);
        if (!method.passes.empty() && method.name == config.reference.method && config.reference.error > 0)
            return refuse_error(config.reference.location);
        if (method.command.empty()) continue;
        if (method.name == config.reference.method)
            return error_at(config.reference.location,
                            "references cannot be made by the external command '" + method.name +
                                "'; expected a method of this program, or reference = \"FILE.exr\" in a "
                                "[[scene]]");
        if (Status s = check_command(method, config.scenes.size(), config.replicates > 1); !s) return s;
        const bool usable = std::any_of(config.budgets.begin(), config.budgets.end(), [&](const Budget& budget) {
            return (budget.kind == BudgetKind::samples && has_place(method.command, "spp")) ||
                   (budget.kind == BudgetKind::seconds && has_place(method.command, "seconds"));
        });
        if (!usable)
            return error_at(method.location, "no budget suits the command of method '" + method.name +
                                                 "': it needs {spp} for budgets of samples or {seconds} for budgets of "
                                                 "time; budgets of error are not possible");
    }
    return success();
}

}  // namespace raylex::experiments
