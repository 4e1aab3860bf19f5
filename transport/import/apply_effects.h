// Applies a user's choices about effects to a scene before the scene is built (scene/effects/effects.h).
#pragma once

#include "lpe/result.h"
#include "transport/scene/effects/effects.h"

namespace raylex::transport {

/// Removes from `scene` every effect that is forced off and that the scene uses, and records the effects that are
/// forced on. Reads the image of a texture if the mean of the image replaces the texture. Errors: such an image cannot
/// be read.
Status apply_effects(SceneDescription& scene, const EffectChoices& choices);

}  // namespace raylex::transport
