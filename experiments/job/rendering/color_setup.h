// The colour settings of a render: the OpenColorIO config, the rendering space and its primaries.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "display/output/color/color_manager.h"
#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Returns the primaries of a colour space that pbrt scenes can name.
display::Chromaticities chromaticities_of(transport::ColorSpace space);

struct ColorSetup {
    std::optional<display::ColorManager> manager;  ///< absent if the config cannot be read and is not needed
    std::string description;                       ///< for headers: the config, or why there is none
    std::string warning;  ///< not empty: the config cannot be read, or has rules that never apply
    /// "FILE: SPACE; ..." of the textures converted by file rules so far. It is filled while a scene is built.
    std::shared_ptr<std::string> texture_spaces = std::make_shared<std::string>();
};

/// Opens the config of the job, $OCIO or raylex itself. Returns an Error if it cannot be read and the job needs it (for
/// a preview, a rendering space, or a config named explicitly), or if it lacks the job's display or view.
Result<ColorSetup> open_color(const Job& job);

/// Sets `scene.color` for the job's rendering space and returns the primaries of the image. `color` must outlive the
/// scene if the job uses texture rules.
Result<display::Chromaticities> choose_rendering_space(const Job& job, const ColorSetup& color,
                                                       transport::SceneDescription& scene);

}  // namespace raylex::experiments
