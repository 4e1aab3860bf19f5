// Loads and builds each scene of an experiment once, and renders all images: cells, references, calibrations and
// replays.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/job/channels/channel_plan.h"
#include "experiments/job/channels/scene_path_strings.h"
#include "experiments/job/passes/pass_render.h"
#include "experiments/job/rendering/job_scene.h"
#include "experiments/study/plan/config.h"
#include "experiments/study/results.h"
#include "experiments/study/run/cells/run_closer.h"
#include "transport/render/built_scene.h"

namespace raylex::experiments {

struct StudyScene {
    std::unique_ptr<JobScene> loaded;
    std::shared_ptr<const transport::BuiltScene> built;
    Phase load, build;
    std::string hash;  ///< hash of the scene, its rendering space and the instruction set
    int width = 0, height = 0;
};

/// One render. `samples` is the number of samples, or with a limit the maximum; 0: as many as the limit allows.
struct RenderOrder {
    std::size_t scene = 0, variant = 0;
    std::uint64_t samples = 0, seed = 0;
    std::uint64_t first_sample = 0;                ///< above 0, or with fewer `samples` than the cell: a part of a cell
    std::optional<std::uint64_t> whole{};          ///< transport::SampleSettings::whole
    std::optional<std::uint32_t> guide_samples{};  ///< transport::PathSettings::guide_samples
    std::optional<transport::SampleLimit> limit{};
    std::optional<transport::CheckpointSettings> checkpoint{};
    const RunCloser* beside = nullptr;  ///< runs at the same time; its CPU time is subtracted
};

struct Rendered {
    Job job;
    transport::RenderOutput output;
    std::vector<display::PartitionDeclaration> partitions;
    std::vector<PassResult> passes;  ///< of a method with several passes
    std::string pass_lines;          ///< JobOutput::pass_lines()
    std::vector<Phase> phases;       ///< load, plan, build, prepare, render
    std::vector<std::string> warnings;
    std::vector<OmittedPathsInfo> omits;  ///< paths of this scene that the integrator declares not to find
    std::uint64_t peak_memory_bytes = 0;
    double seconds = 0;  ///< wall seconds of prepare and render
    double cpu_seconds = 0;
};

class SceneStore {
  public:
    explicit SceneStore(const ExperimentConfig& config) : config_(config) {}
    SceneStore(const SceneStore&) = delete;
    SceneStore& operator=(const SceneStore&) = delete;

    /// Returns the scene. Loads and builds it at the first call, once for each choice of effects.
    Result<const StudyScene*> scene(std::size_t index, const transport::EffectChoices& effects = {});
    /// Returns the proved channels of a variant in a scene, with statistics if the variant supports them.
    Result<const ChannelPlan*> channels(std::size_t scene, std::size_t variant);
    /// Renders. After an interrupt the result is incomplete, and its checkpoint stays.
    Result<Rendered> render(const RenderOrder& order,
                            const std::function<void(const transport::RenderProgress&)>& progress,
                            const std::atomic<bool>* stop);
    /// Returns the estimated size in bytes of a cell's frame buffer.
    Result<std::uint64_t> frame_buffer_bytes(std::size_t scene, std::size_t variant);

    /// Wall seconds in loading, building, preparing and rendering.
    [[nodiscard]] double seconds() const { return seconds_; }

  private:
    Result<Job> job_of(std::size_t scene, std::size_t variant);
    /// Returns the paths that the variant's integrator does not find, if the scene has such paths.
    static std::vector<OmittedPathsInfo> omissions(const Job& job, const StudyScene& scene,
                                                   const ScenePathStrings& words);

    const ExperimentConfig& config_;
    std::map<std::pair<std::size_t, std::string>, StudyScene> scenes_;  // by scene and choice of effects
    std::map<std::pair<std::size_t, std::size_t>, std::vector<OmittedPathsInfo>> omissions_;
    std::map<std::pair<std::size_t, std::size_t>, std::pair<ChannelPlan, Phase>> channels_;
    struct StudyPasses {
        PassPlan plan;
        ChannelPlan channels;  // those of `channels_`, and a layer for each pass
    };
    std::map<std::pair<std::size_t, std::size_t>, StudyPasses> passes_;  // of variants with passes
    double seconds_ = 0;
};

/// Returns AdaptiveProgress::error of the beauty with neighbourhood 0: the root mean square over pixels of the relative
/// standard error. Negative if the render has no statistics.
double relative_error(const transport::RenderOutput& output);

}  // namespace raylex::experiments
