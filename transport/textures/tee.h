// The tee pattern: passes its input through and writes it to a display channel of its own, where the camera sees the
// surface directly (pattern.h). The channel exists for every render of the scene, which asks for it by name as for an
// AOV; where nobody asks, nothing is written.
#pragma once

#include <vector>

#include "display/services/channel.h"
#include "lpe/result.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/pattern.h"

namespace raylex::transport {

Registry<PatternFactory>::Entry tee_entry();

/// The channels that a scene's textures name: tees, and those of every pattern that takes a string parameter "channel".
/// Each once, in file order: rgb for spectrum textures, else one number; filtered; 0 where nothing is written. Errors
/// at the texture: no name, a name that is raylex's own, one channel of two types.
Result<std::vector<display::ChannelDefinition>> texture_channels(const SceneDescription& scene);

}  // namespace raylex::transport
