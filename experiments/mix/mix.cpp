#include "experiments/mix/mix.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "experiments/job/text/toml_text.h"
#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

constexpr const char* factor_forms =
    "expected a number of at least 0, three of them separated by commas (red, green, blue), or stops such as +1stop";

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    return text;
}

std::optional<double> number_of(std::string_view text) {
    text = trimmed(text);
    if (text.starts_with("+-")) return std::nullopt;
    if (text.starts_with('+')) text.remove_prefix(1);
    double value = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
    return value;
}

std::optional<double> stops_of(std::string_view text) {
    for (const std::string_view unit : {"stops", "stop"})
        if (text.ends_with(unit)) return number_of(text.substr(0, text.size() - unit.size()));
    return std::nullopt;
}

/// Returns one or three numbers; an empty list for any other text.
std::vector<double> numbers_of(std::string_view text) {
    text = trimmed(text);
    constexpr double most_stops = 64;
    if (const auto stops = stops_of(text))
        return std::abs(*stops) <= most_stops ? std::vector<double>{std::exp2(*stops)} : std::vector<double>{};
    std::vector<double> numbers;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t comma = std::min(text.find(',', begin), text.size());
        const auto number = number_of(text.substr(begin, comma - begin));
        if (!number) return {};
        numbers.push_back(*number);
        begin = comma + 1;
    }
    return numbers;
}

Result<ColorFactor> checked_factor(const std::string& name, const std::vector<double>& numbers, const std::string& text,
                                   const SourceLocation& where) {
    bool good = numbers.size() == 1 || numbers.size() == 3;
    for (const double number : numbers) good = good && number >= 0 && std::isfinite(number);
    if (!good) return error_at(where, text + " is not a factor of '" + name + "'; " + std::string(factor_forms));
    return numbers.size() == 3 ? ColorFactor{name, {numbers[0], numbers[1], numbers[2]}, where}
                               : ColorFactor{name, {numbers[0], numbers[0], numbers[0]}, where};
}

/// Reads a number, an array of numbers or a text; anything else is an empty list.
std::vector<double> numbers_of(const toml::node& node) {
    std::vector<double> numbers;
    if (const auto text = node.value_exact<std::string>()) return numbers_of(std::string_view(*text));
    if (const toml::array* list = node.as_array()) {
        for (const toml::node& each : *list) {
            if (!each.is_number()) return {};
            numbers.push_back(*each.value<double>());
        }
    } else if (node.is_number()) {
        numbers.push_back(*node.value<double>());
    }
    return numbers;
}

Result<ColorFactor> parse_factor(const std::string& text, const std::string& option) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0)
        return error_at({option, 0, 0},
                        "'" + text + "' is not a name and its factor; expected NAME=FACTOR, such as key=1.5");
    const std::string value = text.substr(equals + 1), name = text.substr(0, equals);
    return checked_factor(name, numbers_of(std::string_view(value)), "'" + value + "'", {option, 0, 0});
}

}  // namespace

Status add_factors(const std::vector<std::string>& texts, const std::string& option, std::vector<ColorFactor>& to) {
    for (const std::string& text : texts) {
        auto factor = parse_factor(text, option);
        if (!factor) return factor.error();
        to.push_back(*std::move(factor));
    }
    return success();
}

Status read_mix(const std::string& path, Mix& mix) {
    const auto text = read_toml_file(path, NamedBy::command_line, "a TOML file with the tables [light] and [what_if]");
    if (!text) return text.error();
    const auto table = parse_toml(*text, path);
    if (!table) return table.error();
    TomlSource source(path, *text);
    TomlTable root(source, *table, "a mix");
    const std::array<std::pair<const char*, std::vector<ColorFactor>*>, 2> lists{
        {{"light", &mix.lights}, {"what_if", &mix.colors}}};
    for (const auto& [key, factors] : lists) {
        const toml::table* entries = root.take_table(key);
        if (entries == nullptr) continue;
        for (const auto& [name, node] : *entries) {
            auto factor = checked_factor(std::string(name.str()), numbers_of(node), "the value", source.location(node));
            if (factor) factors->push_back(*std::move(factor));
            else source.fail(factor.error());
        }
    }
    root.close();
    if (source.error()) return *source.error();
    return success();
}

std::string factors_text(const std::vector<ColorFactor>& factors) {
    std::string text;
    for (const ColorFactor& factor : factors) {
        text += (text.empty() ? "" : " ") + factor.name + "=";
        for (std::size_t c = 0; c < 3; ++c) text += (c == 0 ? "" : ",") + number_text(factor.rgb[c], 9);
    }
    return text;
}

Status check_once(const std::vector<ColorFactor>& factors) {
    for (std::size_t i = 0; i < factors.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (factors[i].name == factors[j].name)
                return error_at(factors[i].where,
                                "'" + factors[i].name + "' has two factors; expected one factor for each name");
    return success();
}

}  // namespace raylex::experiments
