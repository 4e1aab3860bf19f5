// What every render of a job begins and ends with, whoever runs it: `raylex render` and the cells of experiments.
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

/// A job's scene with its labels, its colours and the effects that the job leaves it. The scene refers to `color`, so
/// this stays where it is.
struct JobScene {
    ColorSetup color;
    transport::SceneDescription scene;
    display::Chromaticities primaries;
    transport::EffectFindings effects;  ///< what the scene calls for, before the job's choices are applied
    std::vector<std::string> warnings;
};

/// Errors: parameters of the job that nothing has, a colour config or a scene that cannot be read, labels that match
/// nothing.
Result<std::unique_ptr<JobScene>> load_job_scene(const Job& job, transport::LoadingProgress* progress = nullptr);

/// The same of a scene that is there already; the job's file is not read.
Result<std::unique_ptr<JobScene>> prepare_job_scene(const Job& job, transport::SceneDescription scene);

/// Adds what the scene's film would write beside the image to the job's AOVs, but for names that the job gives itself.
void ask_for_film_layers(const transport::SceneEntity& film, Job& job);

/// Adds the clamp that the scene's film asks for, "maxcomponentvalue", to the job's sample filters, as pbrt clamps
/// samples; a job with sample filters of its own ("none" among them) has its way. Why not, where it cannot be.
std::optional<std::string> ask_for_film_clamp(const transport::SceneDescription& scene, Job& job);

/// What a checkpoint is of, beyond what the renderer sees: the program, and what colours and lobe numbers come from.
display::RecordIdentity checkpoint_identity(const Job& job, const ColorSetup& color);

/// The image file's description. `output` must outlive it.
display::ImageDescription image_description(const Job& job, const JobScene& scene,
                                            const transport::RenderOutput& output,
                                            const std::vector<display::PartitionDeclaration>& partitions,
                                            const std::map<std::string, std::string>& attributes);

}  // namespace raylex::experiments
