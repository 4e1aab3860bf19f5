// The magnitude of channel values in a scene, for the exact sums of the frame buffer.
#pragma once

#include <vector>

#include "display/services/channel.h"
#include "transport/render/built_scene.h"

namespace raylex::transport {

/// Sets ChannelDefinition::scale_exponent. It is 0 if the brightest light, or the scene's extent, is between 2^-20 and
/// 2^20, so that most scenes have the same quantum; otherwise it is the excess. It depends on the scene only, so that
/// shards, resumed renders and cells of a study agree.
void set_scales(const BuiltScene& scene, std::vector<display::ChannelDefinition>& channels);

}  // namespace raylex::transport
