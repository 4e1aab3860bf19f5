// Substitutes for pbrt-v4's integrators that raylex has under other names.
#pragma once

#include <optional>
#include <string>

#include "transport/integrators/integrator.h"

namespace raylex::transport {

struct IntegratorSubstitute {
    SceneEntity entity;
    std::string note;                                ///< difference from the requested integrator, for a warning
    std::optional<std::uint64_t> samples_per_pixel;  ///< number that the parameters request
};

/// Returns a substitute for `mlt`, `sppm`, `lightpath`, `simplepath`, `simplevolpath`, `randomwalk`, `ambientocclusion`
/// and `function`, and nothing for other types. The substitute receives the parameters that it understands. Errors:
/// parameters of a wrong type.
Result<std::optional<IntegratorSubstitute>> substitute_for_pbrt(const SceneEntity& entity);

}  // namespace raylex::transport
