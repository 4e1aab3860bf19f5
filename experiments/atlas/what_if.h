// The factors of an atlas's path strings, for other lights and colours than those of the render.
//
// The light of a path is a product: the emitted light times, at every scattering, the colour that it met there. If the
// colour of an object's lobe becomes c times as large, a path string with k hits of that lobe gets c^k times its light.
// A factor of a light group counts once. Where an atlas merges path strings, only bounds of their factor are known.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "experiments/mix/mix.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct WhatIf {
    std::vector<std::array<double, 3>> factors;  ///< [path string] for red, green and blue; empty if all are 1
    std::vector<std::array<double, 3>> most;     ///< if not empty, `factors` are the least ones, and these the largest
    std::vector<std::string> notes;              ///< notes for the user

    /// Whether only bounds of the factor are known.
    [[nodiscard]] bool is_open(std::uint32_t path_string) const {
        return !most.empty() && most[path_string] != factors[path_string];
    }
};

/// Computes the factors of `mix`. Lights are named by their group, or `default` for those without one. Colours are
/// named OBJECT or OBJECT.LOBE, where LOBE is the name of a lobe, or D (diffuse), G (glossy), S (glossy or specular),
/// R, T, RD, RG, RS, TD, TG, TS, or V (phase scattering).
/// With `intervals`, merged path strings get bounds: a letter of several events has the least to the largest of their
/// factors, and `*` any number of scatterings up to `max_depth`, the longest path of the render (none: no limit).
///
/// Errors name what has no such factor: unknown lights, objects and lobes; a name that occurs twice; roughness and
/// index; coated materials, subsurface bodies and hair, whose light is no product of their colour; path strings that
/// merge scatterings with different factors, without `intervals` or without an upper bound; a colour for paths of one
/// wavelength; a denoised atlas.
Result<WhatIf> what_if(const display::AtlasFile& atlas, const Mix& mix, bool intervals, std::optional<int> max_depth);

}  // namespace raylex::experiments
