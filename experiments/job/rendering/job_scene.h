// The steps before and after every render of a job, for `raylex render` and for cells of experiments.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "display/output/writer/exr_writer.h"
#include "experiments/job/job.h"
#include "experiments/job/rendering/color_setup.h"
#include "lpe/result.h"
#include "transport/render/render.h"
#include "transport/scene/loading_progress.h"

namespace raylex::experiments {

/// The scene of a job with labels, colours and effects. The scene refers to `color`, so this object must not move.
struct JobScene {
    ColorSetup color;
    transport::SceneDescription scene;
    display::Chromaticities primaries;
    transport::EffectFindings effects;  ///< effects that the scene needs, before the job's choices are applied
    std::vector<std::string> warnings;
};

/// Loads the scene of a job. Errors: unknown parameters in the job, a colour config or scene that cannot be read,
/// labels that match nothing.
Result<std::unique_ptr<JobScene>> load_job_scene(const Job& job, transport::LoadingProgress* progress = nullptr);

/// Prepares a loaded scene for a job; does not read the job's scene file.
Result<std::unique_ptr<JobScene>> prepare_job_scene(const Job& job, transport::SceneDescription scene);

/// Adds the further layers of the scene's film to the job's AOVs, except for names that the job uses itself.
void ask_for_film_layers(const transport::SceneEntity& film, Job& job);

/// Adds the clamp of the scene's film, "maxcomponentvalue", to the job's sample filters, as pbrt clamps samples. Sample
/// filters in the job ("none" too) take precedence. Returns the reason if the clamp is impossible.
std::optional<std::string> ask_for_film_clamp(const transport::SceneDescription& scene, Job& job);

/// Returns the identity of a checkpoint beyond the renderer's: the program, and the source of colours and lobe numbers.
display::RecordIdentity checkpoint_identity(const Job& job, const ColorSetup& color);

/// Returns the description of the image file. `output` must outlive it.
display::ImageDescription image_description(const Job& job, const JobScene& scene,
                                            const transport::RenderOutput& output,
                                            const std::vector<display::PartitionDeclaration>& partitions,
                                            const std::map<std::string, std::string>& attributes);

}  // namespace raylex::experiments
