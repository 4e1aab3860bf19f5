// Traits of paths as automata, such as "ends at emission" or "has a volume scattering". explain intersects an
// expression's language with them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lpe/language/ast.h"

namespace raylex::lpe {

enum class Feature : std::uint8_t { volume, background, emission, straight, light, diffuse, glossy, singular };
inline constexpr std::size_t feature_count = 8;
/// Features that a scene can lack. Two expressions can be equal for scenes without them.
inline constexpr std::array<Feature, 4> optional_features{Feature::volume, Feature::background, Feature::emission,
                                                          Feature::straight};

/// All words that contain an event of that kind; pass-through events count as letters.
[[nodiscard]] Expression path_strings_with(Feature feature);

}  // namespace raylex::lpe
