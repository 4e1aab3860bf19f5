// Data that a render provides to all code that follows paths: tables that last as long as the render, and the rays and
// services of one call.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/samples/display_services.h"
#include "display/services/samples/lpe_services.h"
#include "display/services/samples/raster_splats.h"
#include "geoaovs/geoaovs.h"
#include "transport/paths/camera_view.h"
#include "transport/paths/direction_sampler.h"
#include "transport/paths/event_table.h"
#include "transport/paths/plan/later_radiance.h"
#include "transport/paths/plan/path_plan.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

/// The inputs from which the geometric AOVs of first hits are computed.
struct FirstHitSetup {
    const geoaovs::GeometricAovs* aovs = nullptr;  ///< the geometric AOVs of the render
    bool pattern_channels = false;                 ///< true: patterns or materials write a channel, so hits are shaded
    Real world_to_camera[3][4] = {};               ///< rigid part of the camera's transform, for geoaovs::ShadingBatch
    Vec2 pixel_size;  ///< width and height of a pixel on the plane at distance 1 before the camera
};

/// The inputs from which an integrator or a pilot makes LPE services on a sample table of its own.
struct ServicesSetup {
    std::span<const display::ChannelDefinition> channels;  ///< the channels of the frame buffer
    const display::LpeSetup* lpe = nullptr;                ///< the automata of these channels
    std::uint64_t seed = 0;                                ///< keys random choices of the render
    /// How lobes share the light of a contribution.
    display::LpeServices::Attribution attribution = display::LpeServices::Attribution::exact;

    [[nodiscard]] display::LpeServices on(display::SampleTable& table) const {
        return {*lpe, table, seed, attribution};
    }
    /// The expression channels that take samples, that is, without outputs that reuse the samples of another channel.
    [[nodiscard]] std::vector<display::ChannelId> light_channels() const {
        std::vector<display::ChannelId> ids;
        for (std::size_t i = 0; i < channels.size(); ++i)
            if (channels[i].style == display::ChannelStyle::expression && display::takes_samples(channels[i]))
                ids.push_back(static_cast<display::ChannelId>(i));
        return ids;
    }
};

/// The tables with which paths are followed. The pointers are valid as long as the render.
struct PathContext {
    SceneView scene;
    const EventTable* events = nullptr;            ///< path events as the channels see them
    const PathPlan* plan = nullptr;                ///< null: no path is split, and no technique or light is left out
    const DirectionSampler* directions = nullptr;  ///< null: closures draw the directions of paths themselves
    CameraView view;
    FirstHitSetup first_hits;
    ServicesSetup services;
    bool beauty = true;      ///< false: what no channel can accept need not be simulated (Law 4)
    int batch_capacity = 0;  ///< most rays of one batch

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
    bool startup = false;  ///< true: the samples of the batch are dropped; see Integrator::starts_up
    /// Factors of the light along each ray; empty where all are 1. For integrators with the trait camera_weights.
    std::span<const Real> weights{};
};

struct ThreadServices {
    display::DisplayServices& display;
    display::LpeServices& lpe;
    display::RasterSplats* raster = nullptr;   ///< for integrators with the trait raster_splats; else null
    const std::atomic<bool>* leave = nullptr;  ///< set when the render ends without waiting for batches; null: never
    bool left = false;  ///< set by leaving(): the batch is not finished, and the engine drops its contributions
    LaterRadiance* later = nullptr;  ///< receives the vertices that camera subpaths leave; null: they are not recorded

    /// Returns true if the integrator must leave the batch unfinished and return at once. Call it in every loop that a
    /// scene can make endless; one call for each scattering event of a batch has no measurable cost.
    [[nodiscard]] bool leaving() {
        left = left || (leave != nullptr && leave->load(std::memory_order_relaxed));
        return left;
    }
};

}  // namespace raylex::transport
