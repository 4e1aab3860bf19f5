// Traits of paths as automata: "ends at emission", "has a volume scattering". explain asks a language about them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lpe/language/ast.h"

namespace raylex::lpe {

enum class Feature : std::uint8_t { volume, background, emission, straight, light, diffuse, glossy, singular };
inline constexpr std::size_t feature_count = 8;
/// Those that a scene may lack, so that two expressions are the same without them.
inline constexpr std::array<Feature, 4> optional_features{Feature::volume, Feature::background, Feature::emission,
                                                          Feature::straight};

/// All words with an event of that kind, straight-through events counted as letters.
[[nodiscard]] Expression words_with(Feature feature);

}  // namespace raylex::lpe
