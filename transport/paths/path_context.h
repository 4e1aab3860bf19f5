// What a render hands to everything that follows paths: tables that last as long as the render, and the rays and
// services of one call.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "display/services/samples/display_services.h"
#include "display/services/samples/lpe_services.h"
#include "display/services/samples/raster_splats.h"
#include "geoaovs/geoaovs.h"
#include "transport/paths/camera_view.h"
#include "transport/paths/event_table.h"
#include "transport/paths/path_plan.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

/// The pointers live as long as the render.
struct PathContext {
    SceneView scene;
    const EventTable* events = nullptr;
    const geoaovs::GeometricAovs* aovs = nullptr;
    bool pattern_channels = false;    ///< some channel is written by patterns or materials: first hits must be shaded
    Real world_to_camera[3][4] = {};  ///< rigid part, for geoaovs::ShadingBatch
    Vec2 pixel_size;                  ///< of a pixel on the plane at distance 1 before the camera
    bool beauty = true;               ///< false: what no channel can accept need not be simulated (Law 4)
    int batch_capacity = 0;           ///< most rays of one batch
    const Camera* camera = nullptr;
    int width = 0, height = 0;               ///< of the image, in pixels
    Vec2 filter_radius;                      ///< the distance from the image at which light still counts, in pixels
    const display::LpeSetup* lpe = nullptr;  ///< for LPE services on a table of one's own
    const PathPlan* plan = nullptr;          ///< null: as a plan that changes nothing

    [[nodiscard]] CameraView view() const { return {camera, width, height, filter_radius}; }
    /// Whether beauty or a channel takes light that was scattered.
    [[nodiscard]] bool takes_scattered_light() const {
        return beauty || (events->any() && events->liveness().at_camera().scatters);
    }
};

/// Camera rays of one call. Ray i belongs to row i and draws from samplers[i].
struct CameraBatch {
    std::span<const Ray> rays;
    std::span<const PixelSampler> samplers;
    std::span<const display::CameraRow> rows;
    /// The tile of the pixels. Within an iteration of a synchronous integrator, no two threads hold batches of one
    /// tile.
    std::uint32_t tile = 0;
    bool startup = false;  ///< not of the image: see Integrator::starts_up
    /// Factors of the light along each ray; empty where all are 1. For integrators with the trait camera_weights.
    std::span<const Real> weights{};
};

struct ThreadServices {
    display::DisplayServices& display;
    display::LpeServices& lpe;
    display::RasterSplats* raster = nullptr;   ///< for integrators with the trait raster_splats; else null
    const std::atomic<bool>* leave = nullptr;  ///< set when the render ends without waiting for batches; null: never
    bool left = false;                         ///< this batch is not finished: the engine drops its contributions

    /// Whether to leave the batch as it is and return at once. Call it in every loop that a scene can make endless; one
    /// call for each scattering event of a batch costs nothing that can be measured.
    [[nodiscard]] bool leaving() {
        left = left || (leave != nullptr && leave->load(std::memory_order_relaxed));
        return left;
    }
};

}  // namespace raylex::transport
