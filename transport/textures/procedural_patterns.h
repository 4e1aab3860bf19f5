// pbrt-v4's procedural textures: directionmix, dots, fbm, marble, windy and wrinkled.
//
// They are evaluated at a point. pbrt-v4 omits octaves of noise that are finer than a pixel; here all octaves are used
// and camera samples do the filtering. So means agree except for `wrinkled`, where pbrt replaces each omitted octave by
// 0.2.
#pragma once

#include "transport/textures/pattern.h"

namespace raylex::transport {

void register_procedural_patterns(Registry<PatternFactory>& registry);

}  // namespace raylex::transport
