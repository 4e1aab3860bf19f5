// A scene ready to be rendered: all tables that do not depend on render settings. Build once, render many times.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "transport/cameras/camera_motion.h"
#include "transport/integrators/integrator.h"
#include "transport/render/render.h"
#include "transport/scene/loading_progress.h"
#include "transport/scene/surface_names.h"

namespace raylex::transport {

class BuiltScene {
  public:
    /// Copies or compiles everything, so the description may be destroyed afterwards. Threads of `machine` read images
    /// and build the acceleration structure. `progress`, unless null, receives the items that are read and built.
    static Result<std::shared_ptr<const BuiltScene>> build(const SceneDescription& description,
                                                           const MachineSettings& machine = {},
                                                           LoadingProgress* progress = nullptr);

    [[nodiscard]] SceneView view() const {
        return {geometry_.get(), &textures_, &materials_, &lights_, &media_, general_code_, moves_, wavelengths_.get()};
    }
    [[nodiscard]] const std::string& isa() const { return geometry_->isa(); }
    /// The channels to which patterns write.
    [[nodiscard]] std::span<const display::ChannelDefinition> pattern_channels() const { return pattern_channels_; }
    /// The space of the tables of view().
    [[nodiscard]] const RenderSpace& space() const { return geometry_->space(); }
    [[nodiscard]] const SurfaceNames& surface_names() const { return surface_names_; }
    /// The scene's own camera, film, filter, sampler and integrator, which settings may override.
    SceneEntity camera, film, filter, sampler, integrator;
    Transform camera_to_world;                          ///< of the world, not of render space; when the shutter opens
    std::shared_ptr<const CameraMotion> camera_motion;  ///< null: the camera does not move
    std::string file;
    std::vector<Error> warnings;
    std::vector<Error> dark_lights;  ///< warnings for renders with outputs that need light (dark_lights.h)
    double build_seconds = 0, build_cpu_seconds = 0;

  private:
    BuiltScene() = default;
    Status place_camera(const SceneDescription& description, const ShutterSpan& shutter);
    TextureTable textures_;
    MaterialTable materials_;
    LightTable lights_;
    MediumTable media_;
    EffectSet general_code_;
    bool moves_ = false;
    std::unique_ptr<const WavelengthDistribution> wavelengths_;  // null: paths have no wavelengths
    std::unique_ptr<EmbreeScene> geometry_;
    SurfaceNames surface_names_;
    std::vector<display::ChannelDefinition> pattern_channels_;
};

/// Returns scene_alphabet(description), from the tables that already exist.
[[nodiscard]] SceneAlphabet scene_alphabet(const SceneDescription& description, const BuiltScene& built,
                                           const lpe::LobeSlots& slots = {}, bool regularizes = false);

/// Renders a scene that was built from `description`: the image has the same bits as that of render(description, ...),
/// and checkpoints identify the scene.
Result<RenderOutput> render(const SceneDescription& description, const BuiltScene& scene,
                            const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress = {},
                            const std::atomic<bool>* stop = nullptr);

/// Renders without the description: checkpoints do not identify the scene.
Result<RenderOutput> render(const BuiltScene& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress = {},
                            const std::atomic<bool>* stop = nullptr);

/// Checks whether a render can begin. Errors concern its camera, film, filter, sampler, integrator or settings.
Status check_render(const BuiltScene& scene, const RenderSettings& settings);

}  // namespace raylex::transport
