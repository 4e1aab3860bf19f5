// Random small scenes: every material, texture, light, medium, filter, sampler, integrator and strategy there is, in
// transforms that shear, mirror, nest and lie far away.
//
// Wild ones have numbers of any size that a float has: their images say whether numbers stay finite, sum up and do not
// depend on threads, and an error is a fair answer to them. Tame ones are of ordinary size, albedos below 1: what is
// true of every scene can be measured on them.
#pragma once

#include <cstdint>
#include <string>

#include "transport/scene/scene_description.h"

namespace raylex::experiments {

struct RandomScene {
    bool tame = false;
    transport::SceneDescription scene;
};

/// Writes the images that random scenes read to FOLDER/files.
Status write_scene_files(const std::string& folder);

/// Scene number `seed`; `folder` is where its files are. What the scene-building API refuses is left out of it.
/// Errors: of scenes that are refused as a whole.
Result<RandomScene> random_scene(std::uint64_t seed, const std::string& folder);

}  // namespace raylex::experiments
