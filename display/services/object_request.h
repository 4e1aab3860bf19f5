// An object from a registry as a command line names it: NAME:KEY=VALUE,...
#pragma once

#include <string>
#include <vector>

#include "display/services/registry.h"

namespace raylex {

struct ObjectRequest {
    std::string name;
    ParameterSet parameters;
};

/// "key=value,..." typed by the descriptions. A value may be quoted with '...' to hold commas; three numbers for a
/// colour stand with blanks between them. A key that is not described goes in as a string: whoever makes the object
/// refuses it. Errors at `where`: an item that is no KEY=VALUE, a value of the wrong type. `kind` is how errors call
/// the object.
Result<ParameterSet> parse_parameters(const std::string& text, const std::vector<ParameterDescription>& descriptions,
                                      const std::string& kind, const SourceLocation& where);

/// An Error for the first parameter that nobody looked up, with the near miss among `descriptions`; success without
/// one.
Status check_all_used(const ParameterSet& parameters, const std::vector<ParameterDescription>& descriptions,
                      const std::string& kind, const std::string& name);

/// "NAME" or "NAME:key=value,...". Errors at `where`: no such object (with near misses), and those of parse_parameters.
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

/// For --help: every object of a registry and what it takes.
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
