// pbrt-v4's procedural textures: directionmix, dots, fbm, marble, windy and wrinkled.
//
// Looked up at a point. pbrt-v4 leaves out octaves of noise that are finer than a pixel; here all of them count and
// camera samples do the filtering, so that means agree but for `wrinkled`, whose left-out octaves pbrt takes for 0.2
// each.
#pragma once

#include "transport/textures/pattern.h"

namespace raylex::transport {

void register_procedural_patterns(Registry<PatternFactory>& registry);

}  // namespace raylex::transport
