// The colour side of a render: the OpenColorIO config, the rendering space and its primaries.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "display/output/color/color_manager.h"
#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Primaries of the spaces a pbrt scene can name.
display::Chromaticities chromaticities_of(transport::ColorSpace space);

struct ColorSetup {
    std::optional<display::ColorManager> manager;  ///< absent when the config cannot be read and nothing needs it
    std::string description;                       ///< for headers: the config, or why there is none
    std::string warning;  ///< not empty: the config cannot be read, or has rules that never fit
    /// "FILE: SPACE; ..." of the textures read by file rules so far; filled while a scene is built.
    std::shared_ptr<std::string> texture_spaces = std::make_shared<std::string>();
};

/// Opens the config that the job, $OCIO or raylex itself names. An Error when it cannot be read and the job needs it (a
/// preview, a rendering space, a config named outright), or when the job's display or view is not in it.
Result<ColorSetup> open_color(const Job& job);

/// `color` must outlive the scene when the job wants texture rules. Sets `scene.color` for the job's rendering space
/// and returns the primaries of the image to come.
Result<display::Chromaticities> choose_rendering_space(const Job& job, const ColorSetup& color,
                                                       transport::SceneDescription& scene);

}  // namespace raylex::experiments
