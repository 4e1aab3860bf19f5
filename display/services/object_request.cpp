#include "display/services/object_request.h"

#include <charconv>

namespace raylex {
namespace {

bool read_number(const std::string& text, double& number) {
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
    return failed == std::errc() && end == text.data() + text.size();
}

/// Splits at `separator` outside '...', and removes the quotes.
std::vector<std::string> split_list(const std::string& text, char separator) {
    std::vector<std::string> items(1);
    bool quoted = false;
    for (const char c : text) {
        if (c == '\'') quoted = !quoted;
        else if (c == separator && !quoted) items.emplace_back();
        else items.back() += c;
    }
    return items;
}

Result<Parameter> typed(const ParameterDescription& description, const std::string& text, const SourceLocation& where) {
    Parameter parameter;
    parameter.name = description.name;
    parameter.type = description.type;
    parameter.location = where;
    const auto wrong = [&](const char* expected) {
        return error_at(where, "parameter '" + description.name + "' is '" + text + "'; expected " + expected);
    };
    switch (description.type) {
        case ParameterType::boolean:
            if (text != "true" && text != "false") return wrong("true or false");
            parameter.booleans = {static_cast<std::uint8_t>(text == "true")};
            return parameter;
        case ParameterType::integer:
        case ParameterType::real: {
            double number = 0;
            if (!read_number(text, number)) return wrong("a number");
            if (description.type == ParameterType::integer && number != static_cast<double>(static_cast<long>(number)))
                return wrong("a whole number");
            parameter.numbers = {number};
            return parameter;
        }
        case ParameterType::rgb:
            for (const std::string& item : split_list(text, ' ')) {
                double number = 0;
                if (item.empty()) continue;
                if (!read_number(item, number)) return wrong("a number, or three with blanks between them");
                parameter.numbers.push_back(number);
            }
            return parameter;
        default:
            parameter.strings = {text};
            return parameter;
    }
}

}  // namespace

Result<ParameterSet> parse_parameters(const std::string& text, const std::vector<ParameterDescription>& descriptions,
                                      const std::string& kind, const SourceLocation& where) {
    ParameterSet set;
    set.location = where;
    if (text.empty()) return set;
    for (const std::string& item : split_list(text, ',')) {
        const std::size_t equals = item.find('=');
        if (equals == std::string::npos || equals == 0)
            return error_at(where, "'" + item + "' is not a parameter of a " + kind + "; expected KEY=VALUE",
                            set.parameters.empty() ? std::string()
                                                   : "separate several numbers of one parameter by blanks: " +
                                                         set.parameters.back().name + "='1 0 0'");
        ParameterDescription description{item.substr(0, equals), ParameterType::string, {}, {}};
        for (const ParameterDescription& each : descriptions)
            if (each.name == description.name) description = each;
        auto parameter = typed(description, item.substr(equals + 1), where);
        if (!parameter) return parameter.error();
        set.parameters.push_back(std::move(*parameter));
    }
    return set;
}

Status check_all_used(const ParameterSet& parameters, const std::vector<ParameterDescription>& descriptions,
                      const std::string& kind, const std::string& name) {
    const std::vector<const Parameter*> unused = parameters.unused();
    if (unused.empty()) return success();
    std::vector<std::string> known;
    std::string list;
    for (const ParameterDescription& each : descriptions) {
        known.push_back(each.name);
        list += (list.empty() ? "" : ", ") + each.name;
    }
    return error_at(unused.front()->location,
                    kind + " '" + name + "' has no parameter '" + unused.front()->name +
                        (list.empty() ? "'; it has none" : "'; expected one of: " + list),
                    near_miss(unused.front()->name, known));
}

}  // namespace raylex
