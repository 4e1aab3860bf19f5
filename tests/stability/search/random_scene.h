// Random small scenes with every material, texture, light, medium, filter, sampler, integrator and strategy, under
// transforms that shear, mirror, nest and move far away.
//
// Wild scenes have numbers of any magnitude; they test that numbers stay finite, that layers sum, and that results do
// not depend on threads. An error message is a valid result for them. Tame scenes have ordinary sizes and albedos below
// 1, so all invariants can be measured on them.
#pragma once

#include <cstdint>
#include <string>

#include "transport/scene/scene_description.h"

namespace raylex::experiments {

struct RandomScene {
    bool tame = false;
    transport::SceneDescription scene;
};

/// Writes the image files of random scenes to FOLDER/files.
Status write_scene_files(const std::string& folder);

/// Makes scene number `seed`, whose files are in `folder`. Items that the scene API rejects are left out. Errors: the
/// whole scene is rejected.
Result<RandomScene> random_scene(std::uint64_t seed, const std::string& folder);

}  // namespace raylex::experiments
