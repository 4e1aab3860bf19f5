// A method's settings as text: for results, and for telling references apart.
#pragma once

#include "experiments/study/results.h"
#include "transport/render/render.h"
#include "transport/scene/effects/effects.h"

namespace raylex::experiments {

/// Everything that a method's table says, key by key; what it leaves out is the scene's, or the program's own.
NamedValues settings_text(const transport::RenderSettings& settings, const transport::EffectChoices& effects = {});

}  // namespace raylex::experiments
