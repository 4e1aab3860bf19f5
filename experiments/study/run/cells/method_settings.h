// The settings of a method as text, for results and to distinguish references.
#pragma once

#include "experiments/job/pass_request.h"
#include "experiments/study/results.h"
#include "transport/render/render.h"
#include "transport/scene/effects/effects.h"

namespace raylex::experiments {

/// Returns all keys of a method's table. Other settings are the scene's, or defaults.
NamedValues settings_text(const transport::RenderSettings& settings, const transport::EffectChoices& effects = {},
                          const std::vector<PassRequest>& passes = {});

}  // namespace raylex::experiments
