// Samplers by name, as a scene's Sampler directive or --sampler selects them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "display/services/registry.h"
#include "transport/samplers/pixel_sampler.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// The meaning of a Sampler directive: the sequence, and the number of samples per pixel.
struct SamplerChoice {
    SamplerKind kind = SamplerKind::sobol;
    std::string name;                      ///< the sampler that is used: "sobol", "zsobol" or "independent"
    std::uint64_t samples_per_pixel = 16;  ///< "pixelsamples" (stratified: the product of its two counts)
    std::uint32_t arrangement_bits = 4;    ///< zsobol: log2 of the samples of a pixel that are arranged together
    std::uint64_t seed = 0;                ///< the scene's own seed, added to the render's
    bool stands_in = false;                ///< for another sequence of pbrt: same expectation, other noise
};

using SamplerFactory = std::function<Result<SamplerChoice>(const SceneEntity&)>;

/// The registered samplers: independent, sobol, zsobol, and pbrt's other names, which stand for Owen-scrambled Sobol'.
Registry<SamplerFactory>& sampler_registry();

/// Makes the choice for a directive. An empty type means the default, sobol with 16 samples.
Result<SamplerChoice> choose_sampler(const SceneEntity& entity);

}  // namespace raylex::transport
