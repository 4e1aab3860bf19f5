// Makes the values of a row of the settings table from a function that returns the address of its field in a job. The
// defaults are those of a default-constructed job.
#pragma once

#include <algorithm>
#include <charconv>
#include <string>
#include <utility>
#include <vector>

#include "experiments/job/settings/setting.h"

namespace raylex::experiments {

std::string plain_number(double number);
std::string words_text(const std::vector<std::string>& words);
Error invalid_value(const RenderSetting::Item& item, const std::string& expected, const std::string& hint = {});

/// Several texts, set at once.
template <typename Set>
RenderSetting::Values texts(Set set, bool has_commas = false) {
    return {.type = RenderSetting::Type::strings, .is_repeated = true, .has_commas = has_commas, .set = set};
}

/// Several texts, applied one after the other.
template <typename Add>
RenderSetting::Values each(Add add, bool has_commas = false) {
    return texts(
        [add](Job& job, const std::vector<RenderSetting::Item>& items) {
            for (const RenderSetting::Item& item : items)
                if (Status added = add(job, item.text, item.location); !added) return added;
            return success();
        },
        has_commas);
}

/// A text that a function of the job applies.
template <typename Set>
RenderSetting::Values applied(Set set, bool is_path = false, std::string usual = {}) {
    RenderSetting::Values values = each(set);
    values.type = RenderSetting::Type::string;
    values.is_path = is_path;
    values.usual = std::move(usual);
    values.is_repeated = false;
    return values;
}

/// A text that may be empty.
inline RenderSetting::Values has_empty(RenderSetting::Values values) {
    values.has_empty = true;
    return values;
}

/// A number from `least` to `most`, and of integers a multiple of `step`.
template <typename Number, typename Field>
RenderSetting::Values number(Number least, Number most, std::uint64_t step, const std::string& range, Field field) {
    auto values = applied([=](Job& job, const std::string& text, const SourceLocation& where) -> Status {
        Number value = 0;
        const bool has_plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
        const auto [end, failed] = std::from_chars(text.data() + has_plus, text.data() + text.size(), value);
        const bool is_number = failed == std::errc() && end == text.data() + text.size();
        if (!is_number || !(value >= least && value <= most) ||
            (step > 1 && static_cast<std::uint64_t>(value) % step != 0))
            return invalid_value({text, where}, range);
        using To = std::remove_reference_t<decltype(*field(job))>;
        if constexpr (requires { typename To::value_type; }) *field(job) = static_cast<typename To::value_type>(value);
        else *field(job) = static_cast<To>(value);
        return success();
    });
    Job job;
    values.range = range;
    if constexpr (!requires { field(job)->has_value(); })
        if (static_cast<Number>(*field(job)) >= least) values.usual = plain_number(static_cast<double>(*field(job)));
    return values;
}

template <typename Field>
RenderSetting::Values whole(std::uint64_t least, std::uint64_t most, Field field, std::uint64_t step = 1) {
    auto values = number(least, most, step,
                         (step == 2 ? "an even integer from " : "an integer from ") + std::to_string(least) + " to " +
                             std::to_string(most),
                         field);
    values.type = RenderSetting::Type::integer;
    return values;
}

template <typename Field>
RenderSetting::Values real(double least, double most, Field field) {
    auto values = number(least, most, 1, "a number from " + plain_number(least) + " to " + plain_number(most), field);
    values.type = RenderSetting::Type::number;
    return values;
}

/// One of the words, stored as a boolean or enumeration that counts them.
template <typename Field>
RenderSetting::Values choice(const std::vector<std::string>& words, Field field) {
    auto values = applied([=](Job& job, const std::string& text, const SourceLocation& where) -> Status {
        const auto found = std::find(words.begin(), words.end(), text);
        if (found == words.end()) return invalid_value({text, where}, words_text(words), near_miss(text, words));
        *field(job) = static_cast<std::decay_t<decltype(*field(job))>>(found - words.begin());
        return success();
    });
    Job job;
    values.range = words_text(words);
    values.usual = words[static_cast<std::size_t>(*field(job))];
    return values;
}

/// true or false; on or off for a flag with a value.
template <typename Field>
RenderSetting::Values on_or_off(Field field) {
    auto values = applied([field](Job& job, const std::string& text, const SourceLocation&) {
        *field(job) = text != "off" && text != "false";
        return success();
    });
    Job job;
    values.type = RenderSetting::Type::boolean;
    values.range = "true or false";
    values.usual = *field(job) ? "true" : "false";
    return values;
}

/// A text that `parse` turns into the value of the field, or into an Error at its location.
template <typename Parse, typename Field>
RenderSetting::Values parsed(Parse parse, Field field, std::string usual = {}, std::string separator = {},
                             std::string range = {}) {
    auto values = applied([=](Job& job, const std::string& text, const SourceLocation& where) -> Status {
        auto value = parse(text, where);
        if (!value) return value.error();
        *field(job) = std::move(*value);
        return success();
    });
    values.usual = std::move(usual);
    values.separator = std::move(separator);
    values.range = std::move(range);
    return values;
}

template <typename Field>
RenderSetting::Values text(Field field, bool is_path = false) {
    const auto set = [field](Job& job, const std::string& text, const SourceLocation&) {
        *field(job) = text;
        return success();
    };
    return applied(set, is_path);
}

}  // namespace raylex::experiments
