// The tee pattern: passes its input through and writes it to a display channel of its own, where the camera sees the
// surface directly (pattern.h). Every render of the scene can request the channel by name like an AOV; if it is not
// requested, nothing is written.
#pragma once

#include <vector>

#include "display/services/channel.h"
#include "lpe/result.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/pattern.h"

namespace raylex::transport {

Registry<PatternFactory>::Entry tee_entry();

/// The channels that a scene's textures name: those of tees, and of every pattern with a string parameter "channel".
/// Each is listed once, in file order: rgb for spectrum textures, else one number; filtered; 0 where nothing is
/// written. Errors at the texture: no name, a name of raylex's own channels, one channel with two types.
Result<std::vector<display::ChannelDefinition>> texture_channels(const SceneDescription& scene);

}  // namespace raylex::transport
