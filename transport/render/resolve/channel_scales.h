// How large the values of channels are in a scene, for the exact sums of the frame buffer.
#pragma once

#include <vector>

#include "display/services/channel.h"
#include "transport/render/built_scene.h"

namespace raylex::transport {

/// Sets ChannelDefinition::scale_exponent: 0 where the brightest light, or the scene's extent, is between 2^-20 and
/// 2^20, so that most scenes have one quantum; beyond, what is left of it. Only the scene decides, so that shards,
/// resumed renders and cells of a study agree.
void set_scales(const BuiltScene& scene, std::vector<display::ChannelDefinition>& channels);

}  // namespace raylex::transport
