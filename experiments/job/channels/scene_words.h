// The paths that a scene can produce, as a job renders it: what proofs and warnings are relative to. No ray is traced.
#pragma once

#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/result.h"
#include "lpe/words.h"
#include "transport/render/built_scene.h"

namespace raylex::experiments {

struct SceneWords {
    transport::SceneAlphabet alphabet;
    lpe::Words words;              ///< W: the alphabet's events, at most so many scatterings as the integrator follows
    std::vector<lpe::Event> user;  ///< what surfaces say of themselves (U2, U6): in channels' words, in none of W
    bool holdouts = false;         ///< some object is one

    /// W and the words with user events in them.
    [[nodiscard]] lpe::Words with_user_events() const;
};

/// Of a scene whose labels are given (apply_label_rules), by its tables if it is `built` already. Errors: materials,
/// textures or an integrator that do not build.
Result<SceneWords> scene_words(const Job& job, const transport::SceneDescription& scene,
                               const transport::BuiltScene* built = nullptr);

/// Of a file: a pbrt-v4 scene, or a TOML job (.toml) with its scene, labels, light groups, lobe slots and depth limit.
Result<SceneWords> read_scene_words(const std::string& path);

}  // namespace raylex::experiments
