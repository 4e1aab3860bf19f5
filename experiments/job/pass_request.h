// The passes that a job requests: classes of paths, each rendered by a method of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::experiments {

class TomlTable;

/// One pass, from --pass or a [[pass]] table.
struct PassRequest {
    transport::SceneEntity method;  ///< type and parameters of the integrator
    std::string takes;              ///< "rest", the name of a layer or of a light group, or a light path expression
    SourceLocation location;        ///< of `takes`
    std::string name;               ///< empty: the method's name
    std::optional<std::uint64_t> samples_per_pixel;  ///< unset: the job's
    double time_share = 1;                           ///< of a time limit, relative to the shares of the other passes
    bool has_aovs = false;                           ///< supplies alpha, depth and all layers that are not light
};

/// Parses "METHOD:EXPR", followed by ":KEY=VALUE" for each key of a [[pass]] table, such as ":spp=256".
Result<PassRequest> parse_pass(const std::string& text, const SourceLocation& where);

/// Reads the tables [[key]] in their order: [[pass]] of a job.
void read_passes(TomlTable& root, std::string_view key, std::vector<PassRequest>& passes);

}  // namespace raylex::experiments
