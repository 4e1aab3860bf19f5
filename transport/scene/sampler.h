// Samplers by name: what a scene's Sampler directive or --sampler chooses.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "display/services/registry.h"
#include "transport/samplers/pixel_sampler.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// What a Sampler directive means: which numbers, and how many samples a pixel.
struct SamplerChoice {
    SamplerKind kind = SamplerKind::sobol;
    std::string name;                      ///< what is really used: "sobol", "zsobol" or "independent"
    std::uint64_t samples_per_pixel = 16;  ///< "pixelsamples" (stratified: the product of its two counts)
    std::uint32_t arrangement_bits = 4;    ///< zsobol: log2 of the samples of a pixel that are arranged together
    std::uint64_t seed = 0;                ///< the scene's own seed, added to the render's
    bool stands_in = false;                ///< for another sequence of pbrt's: same expectation, other noise
};

using SamplerFactory = std::function<Result<SamplerChoice>(const SceneEntity&)>;

/// independent, sobol, zsobol, and pbrt's other names, which all mean our Owen-scrambled Sobol'.
Registry<SamplerFactory>& sampler_registry();

/// An empty type means the default, sobol with 16 samples.
Result<SamplerChoice> choose_sampler(const SceneEntity& entity);

}  // namespace raylex::transport
