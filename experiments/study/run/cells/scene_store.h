// The scenes of an experiment, loaded and built once each, and the one way in which its images are rendered: cells,
// references, calibrations and replays.
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
#include "experiments/job/channels/scene_words.h"
#include "experiments/job/rendering/job_scene.h"
#include "experiments/study/plan/config.h"
#include "experiments/study/results.h"
#include "experiments/study/run/cells/cell_closer.h"
#include "transport/render/built_scene.h"

namespace raylex::experiments {

struct StudyScene {
    std::unique_ptr<JobScene> loaded;
    std::shared_ptr<const transport::BuiltScene> built;
    Phase load, build;
    std::string hash;  ///< of the scene, its rendering space and the instruction set
    int width = 0, height = 0;
};

/// What is rendered. `samples` is the number of samples, or under a limit the most; 0: as many as the limit allows.
struct RenderOrder {
    std::size_t scene = 0, variant = 0;
    std::uint64_t samples = 0, seed = 0;
    std::uint64_t first_sample = 0;  ///< more than 0, or fewer `samples` than the cell has: a part of a cell
    std::optional<transport::SampleLimit> limit{};
    std::optional<transport::CheckpointSettings> checkpoint{};  ///< without an identity: that is filled in
    const CellCloser* beside = nullptr;  ///< works meanwhile; its CPU time is none of the render's
};

struct Rendered {
    Job job;
    transport::RenderOutput output;
    std::vector<display::PartitionDeclaration> partitions;
    std::vector<Phase> phases;  ///< load, plan, build, prepare, render
    std::vector<std::string> warnings;
    std::vector<OmittedPathsInfo> omits;  ///< of what this scene has, by its integrator's own account
    std::uint64_t peak_memory_bytes = 0;
    double seconds = 0;  ///< wall, of prepare and render
    double cpu_seconds = 0;
};

class SceneStore {
  public:
    explicit SceneStore(const ExperimentConfig& config) : config_(config) {}
    SceneStore(const SceneStore&) = delete;
    SceneStore& operator=(const SceneStore&) = delete;

    /// Loads and builds it the first time, once for all choices of effects that are alike.
    Result<const StudyScene*> scene(std::size_t index, const transport::EffectChoices& effects = {});
    /// The channels that a variant gets in a scene, proved; each with statistics where the variant keeps them.
    Result<const ChannelPlan*> channels(std::size_t scene, std::size_t variant);
    /// An interrupted render is incomplete, and its checkpoint stays.
    Result<Rendered> render(const RenderOrder& order,
                            const std::function<void(const transport::RenderProgress&)>& progress,
                            const std::atomic<bool>* stop);
    /// Bytes of a cell's frame buffer, as estimated before rendering.
    Result<std::uint64_t> frame_buffer_bytes(std::size_t scene, std::size_t variant);

    /// Wall seconds within all of this: loading, building, preparing, rendering.
    [[nodiscard]] double seconds() const { return seconds_; }

  private:
    Result<Job> job_of(std::size_t scene, std::size_t variant);
    /// What the variant's integrator does not find, as far as the scene has such paths.
    static std::vector<OmittedPathsInfo> omissions(const Job& job, const StudyScene& scene, const SceneWords& words);

    const ExperimentConfig& config_;
    std::map<std::pair<std::size_t, std::string>, StudyScene> scenes_;  // (scene, choices of effects)
    std::map<std::pair<std::size_t, std::size_t>, std::vector<OmittedPathsInfo>> omissions_;
    std::map<std::pair<std::size_t, std::size_t>, std::pair<ChannelPlan, Phase>> channels_;
    double seconds_ = 0;
};

/// AdaptiveProgress::error of the beauty, neighbourhood 0: root mean square over pixels of the standard error relative
/// to the pixel. Negative where the render keeps no statistics.
double relative_error(const transport::RenderOutput& output);

}  // namespace raylex::experiments
