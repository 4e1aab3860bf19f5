// Objects of a registry in command-line notation: NAME:KEY=VALUE,...
#pragma once

#include <string>
#include <vector>

#include "display/services/registry.h"

namespace raylex {

struct ObjectRequest {
    std::string name;
    ParameterSet parameters;
};

/// Parses "key=value,..." with the types of the descriptions. '...' around a value permits commas in it; the three
/// numbers of a colour are separated by blanks. A key without a description becomes a string, which the factory of the
/// object refuses. Errors, at `where`: an item that is not KEY=VALUE, a value of the wrong type. `kind` is the name of
/// the object's kind in errors.
Result<ParameterSet> parse_parameters(const std::string& text, const std::vector<ParameterDescription>& descriptions,
                                      const std::string& kind, const SourceLocation& where);

/// An Error for the first parameter that was never looked up, with a similar name from `descriptions`; success if there
/// is none.
Status check_all_used(const ParameterSet& parameters, const std::vector<ParameterDescription>& descriptions,
                      const std::string& kind, const std::string& name);

/// Parses "NAME" or "NAME:key=value,...". Errors, at `where`: no such object (with similar names), and the errors of
/// parse_parameters().
template <class Factory>
Result<ObjectRequest> parse_object_request(const std::string& text, const Registry<Factory>& registry,
                                           const std::string& kind, const SourceLocation& where) {
    const std::size_t colon = text.find(':');
    ObjectRequest request{text.substr(0, colon), {}};
    auto entry = registry.require(request.name, where);
    if (!entry) return entry.error();
    auto parameters = parse_parameters(colon == std::string::npos ? std::string() : text.substr(colon + 1),
                                       (*entry)->parameters, kind, where);
    if (!parameters) return parameters.error();
    request.parameters = std::move(*parameters);
    return request;
}

/// Lists every object of a registry and its parameters for --help.
template <class Factory>
std::string registry_summary(const Registry<Factory>& registry) {
    std::string list;
    for (const auto& entry : registry.entries()) {
        list += (list.empty() ? "" : "; ") + entry.name;
        for (const ParameterDescription& each : entry.parameters)
            list += (&each == &entry.parameters.front() ? " (" : ", ") + each.name;
        if (!entry.parameters.empty()) list += ")";
    }
    return list;
}

}  // namespace raylex
