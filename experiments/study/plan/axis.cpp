#include "experiments/study/plan/axis.h"

#include <charconv>
#include <optional>
#include <set>

#include "experiments/program/console.h"

namespace raylex::experiments {
namespace {

constexpr std::size_t most_values = 10'000;
constexpr const char* forms =
    "expected a value, a list of values, a range such as \"1..8\" or \"1..9 step 2\", or \"pow2(0..10)\"";

std::optional<AxisValue> scalar(const toml::node& node) {
    if (const auto* flag = node.as_boolean()) return AxisValue{flag->get()};
    if (const auto* whole = node.as_integer()) return AxisValue{whole->get()};
    if (const auto* real = node.as_floating_point()) return AxisValue{real->get()};
    if (const auto* text = node.as_string()) return AxisValue{text->get()};
    return std::nullopt;
}

/// Parses "A..B" with an optional " step S". Empty if the text is not a range.
struct Range {
    std::int64_t first = 0, last = 0, step = 1;
};
std::optional<Range> parse_range(std::string_view text) {
    const auto skip = [&] {
        while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    };
    const auto number = [&](std::int64_t& value) {
        skip();
        const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (failed != std::errc()) return false;
        text.remove_prefix(static_cast<std::size_t>(end - text.data()));
        skip();
        return true;
    };
    const auto word = [&](std::string_view expected) {
        if (!text.starts_with(expected)) return false;
        text.remove_prefix(expected.size());
        return true;
    };
    Range range;
    if (!number(range.first) || !word("..") || !number(range.last)) return std::nullopt;
    if (word("step") && !number(range.step)) return std::nullopt;
    return text.empty() ? std::optional(range) : std::nullopt;
}

/// Returns nothing if the text is a plain word.
Result<std::optional<std::vector<AxisValue>>> expand(const std::string& text, const SourceLocation& where) {
    std::string_view inner = text;
    const bool powers = text.starts_with("pow2(") && text.ends_with(")");
    if (powers) inner = inner.substr(5, inner.size() - 6);
    const std::optional<Range> range = parse_range(inner);
    if (!range) {
        if (powers || text.find("..") != std::string::npos)
            return error_at(where, "'" + text + "' is not a range; " + forms);
        return std::optional<std::vector<AxisValue>>();
    }
    if (range->step <= 0 || range->last < range->first)
        return error_at(where, "the range '" + text +
                                   "' has no values; expected a first value at most the last, and a step above 0");
    if (powers && (range->first < 0 || range->last > 62 || range->step != 1))
        return error_at(
            where, "'" + text + "' has exponents out of range; expected integers from 0 to 62, such as pow2(0..10)");
    std::vector<AxisValue> values;
    for (std::int64_t at = range->first; at <= range->last; at += range->step) {
        if (values.size() == most_values) return error_at(where, "'" + text + "' has more than 10000 values");
        values.push_back({powers ? std::int64_t{1} << at : at});
        if (at > range->last - range->step) break;  // the next value could overflow 64 bits
    }
    return std::optional(std::move(values));
}

}  // namespace

std::string AxisValue::text() const {
    if (const bool* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
    if (const double* real = std::get_if<double>(&value)) return number_text(*real, 12);
    return std::get<std::string>(value);
}

Result<std::vector<AxisValue>> read_axis(const TomlSource& source, const toml::node& node, const std::string& what) {
    const SourceLocation where = source.location(node);
    std::vector<AxisValue> values;
    if (const toml::array* list = node.as_array()) {
        for (const toml::node& each : *list) {
            auto value = scalar(each);
            if (!value)
                return error_at(source.location(each), "an entry of '" + what + "' is not a single value; " + forms);
            values.push_back(std::move(*value));
        }
        if (values.empty()) return error_at(where, "'" + what + "' is empty; " + forms);
        if (values.size() > most_values) return error_at(where, "'" + what + "' has more than 10000 values");
    } else {
        auto value = scalar(node);
        if (!value) return error_at(where, "'" + what + "' is a table; " + forms);
        if (const auto* text = std::get_if<std::string>(&value->value)) {
            auto expanded = expand(*text, where);
            if (!expanded) return expanded.error();
            if (*expanded) values = std::move(**expanded);
        }
        if (values.empty()) values.push_back(std::move(*value));
    }
    std::set<std::string> seen;
    for (const AxisValue& each : values)
        if (!seen.insert(each.text()).second)
            return error_at(where, "'" + what + "' has the value " + each.text() + " twice; expected every value once");
    return values;
}

}  // namespace raylex::experiments
