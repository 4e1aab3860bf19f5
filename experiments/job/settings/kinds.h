// Makes the values of a row of the settings table from a function that returns a reference to its field in a job. The
// defaults are those of a default-constructed job.
#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "experiments/job/settings/setting.h"

namespace raylex::experiments {

template <typename T>
struct IsOptional : std::false_type {};
template <typename T>
struct IsOptional<std::optional<T>> : std::true_type {};

std::string plain_number(double number);

template <typename Field>
auto usual_value(Field field) {
    Job job;
    return field(job);
}

/// The default of a number as text; empty: unset.
template <typename Field>
std::string usual_number(Field field) {
    const auto value = usual_value(field);
    if constexpr (!IsOptional<std::remove_const_t<decltype(value)>>::value)
        return plain_number(static_cast<double>(value));
    return {};
}

template <typename Field>
auto assign_number(Field field) {
    return [field](Job& job, auto number) {
        using To = std::remove_reference_t<decltype(field(job))>;
        if constexpr (IsOptional<To>::value) field(job) = static_cast<typename To::value_type>(number);
        else field(job) = static_cast<To>(number);
    };
}

template <typename Field>
Setting::Values whole(std::uint64_t least, std::uint64_t most, Field field, std::uint64_t step = 1) {
    return {Setting::Whole{least, most, step, assign_number(field)}, usual_number(field)};
}

template <typename Field>
Setting::Values real(double least, double most, Field field) {
    return {Setting::Real{least, most, assign_number(field)}, usual_number(field)};
}

/// One of the words, stored as a boolean or enumeration that counts them.
template <typename Field>
Setting::Values choice(std::vector<std::string> words, Field field) {
    std::string usual = words[static_cast<std::size_t>(usual_value(field))];
    return {Setting::Choice{std::move(words), assign_number(field)}, std::move(usual)};
}

template <typename Field>
Setting::Values on_or_off(Field field) {
    return {Setting::Switch{[field](Job& job, bool on) { field(job) = on; }}, usual_value(field) ? "true" : "false"};
}

template <typename Field>
Setting::Values text(Field field, bool is_path = false) {
    const auto set = [field](Job& job, const std::string& text, const SourceLocation&) {
        field(job) = text;
        return success();
    };
    return {Setting::Text{set, is_path}};
}

template <typename Field>
Setting::Values path(Field field) {
    return text(field, true);
}

/// A text that `parse` turns into the value of the field, or into an Error at its location.
template <typename Parse, typename Field>
Setting::Values parsed(Parse parse, Field field, std::string usual = {}) {
    const auto set = [parse, field](Job& job, const std::string& text, const SourceLocation& where) -> Status {
        auto value = parse(text, where);
        if (!value) return value.error();
        field(job) = std::move(*value);
        return success();
    };
    return {Setting::Text{set}, std::move(usual)};
}

/// Numbers that a flag joins with `separator` and a job may have as an array.
template <typename Parse, typename Field>
Setting::Values parsed_numbers(std::string separator, std::string array, Parse parse, Field field) {
    Setting::Values values = parsed(parse, field);
    auto& kind = std::get<Setting::Text>(values.kind);
    kind.separator = std::move(separator);
    kind.array = std::move(array);
    return values;
}

/// A text that a function of the job applies.
inline Setting::Values applied(Status (*set)(Job&, const std::string&, const SourceLocation&), bool is_path = false) {
    return {Setting::Text{set, is_path}};
}

/// Several texts, applied one after the other.
inline Setting::Values each(Status (*add)(Job&, const std::string&, const SourceLocation&), bool has_commas = false) {
    return {Setting::Texts{[add](Job& job, const std::vector<Setting::Item>& items) {
                               for (const Setting::Item& item : items)
                                   if (Status added = add(job, item.text, item.location); !added) return added;
                               return success();
                           },
                           has_commas}};
}

}  // namespace raylex::experiments
