// pbrt-v4's integrators that raylex has under other names: what a scene file asks for, in our terms.
#pragma once

#include <optional>
#include <string>

#include "transport/integrators/integrator.h"

namespace raylex::transport {

struct IntegratorSubstitute {
    SceneEntity entity;
    std::string note;                                ///< how it differs from what was named, for a warning
    std::optional<std::uint64_t> samples_per_pixel;  ///< that the parameters ask for
};

/// For `mlt`, `sppm`, `lightpath`, `simplepath`, `simplevolpath`, `randomwalk`, `ambientocclusion` and `function`;
/// nothing for other types. Parameters that mean something to the substitute are handed on. Errors: parameters of a
/// wrong type.
Result<std::optional<IntegratorSubstitute>> substitute_for_pbrt(const SceneEntity& entity);

}  // namespace raylex::transport
