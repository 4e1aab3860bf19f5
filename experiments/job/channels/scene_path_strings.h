// The paths that a scene can produce under the settings of a job. Proofs and warnings are relative to them. No ray is
// traced.
#pragma once

#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/path_strings.h"
#include "lpe/result.h"
#include "transport/render/built_scene.h"

namespace raylex::experiments {

struct ScenePathStrings {
    transport::SceneAlphabet alphabet;
    lpe::PathStrings words;  ///< W: the alphabet of events, and the integrator's maximum number of scattering events
    std::vector<lpe::Event> user;  ///< user events of surfaces (U2, U6): in words of channels, but not in W
    bool holdouts = false;         ///< some object is a holdout

    /// Returns W extended by words with user events.
    [[nodiscard]] lpe::PathStrings with_user_events() const;
};

/// Returns the words of a scene with labels (after apply_label_rules); uses the tables of `built` if it exists. Errors:
/// materials, textures or an integrator that cannot be built.
Result<ScenePathStrings> scene_path_strings(const Job& job, const transport::SceneDescription& scene,
                                            const transport::BuiltScene* built = nullptr);

/// Returns the words of a file: a pbrt-v4 scene, or a TOML job (.toml) with its scene, labels, light groups, lobe slots
/// and depth limit.
Result<ScenePathStrings> read_scene_path_strings(const std::string& path);

}  // namespace raylex::experiments
