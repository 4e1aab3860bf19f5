// Settings resolved against a scene: the first stage of a render, and all that can be refused before the integrator
// looks at the scene. Private to transport/render.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "display/buffer/pixel_filter.h"
#include "display/services/samples/sample_filter.h"
#include "transport/cameras/camera.h"
#include "transport/integrators/integrator.h"
#include "transport/render/built_scene.h"
#include "transport/render/film.h"
#include "transport/render/render.h"
#include "transport/render/tiles.h"
#include "transport/scene/sampler.h"

namespace raylex::transport {

/// Where camera samples fall, and of which numbers they are made.
struct CameraSampling {
    FilmSettings film;
    std::unique_ptr<Camera> camera;
    bool times = false;  ///< each sample draws one
    bool cones = false;  ///< somebody filters by them: each as wide as its sample's pixel_share()
    std::unique_ptr<display::PixelFilter> filter;
    SourceLocation filter_location;    ///< for errors
    bool splat = false;                ///< FilmOverrides::splat
    int padding_x = 0, padding_y = 0;  ///< pixels around the image whose samples reach into it
    SamplerKind sampler = SamplerKind::sobol;
    std::uint32_t arrangement_bits = 4;  ///< SamplerChoice has it
    std::string sampler_name;
    std::uint64_t seed = 0;
    std::uint64_t samples_per_pixel = 0;  ///< as settings or the scene's sampler say
};

/// Channels as the frame buffer will have them.
struct JobChannels {
    std::vector<display::ChannelDefinition> list;
    display::ChannelId beauty = display::invalid_channel;
    display::SampleFilterChain filters;
    std::unique_ptr<display::LpeSetup> lpe;
    bool keeps_words = false;  ///< LabelSettings::words is set
    bool written_by_plugins =
        false;  ///< some plain channel is no geometric AOV: patterns, materials and integrators write it
    display::LpeServices::Attribution attribution = display::LpeServices::Attribution::exact;
};

/// How many samples, and which: what make_schedule() makes a Schedule of.
struct Budget {
    std::uint64_t samples_per_pixel = 0;  ///< at most
    std::uint64_t first_sample = 0;       ///< of a shard
    std::optional<SampleLimit> limit;
    std::optional<display::AdaptiveSettings> adaptive;
    std::optional<SampleChoice> only;
};

class ResolvedJob {
  public:
    /// Both must outlive the job. An Error says why the render cannot be.
    static Result<ResolvedJob> resolve(const BuiltScene& scene, const RenderSettings& settings);

    [[nodiscard]] Integrator& integrator() const { return *chosen.integrator; }
    /// Whether the integrator's light lands anywhere on the image.
    [[nodiscard]] bool raster() const { return splats_anywhere(chosen); }
    [[nodiscard]] static bool splats_anywhere(const ChosenIntegrator& chosen) {
        return chosen.integrator->traits().raster_splats;
    }

    const BuiltScene& scene;
    const RenderSettings& settings;
    std::optional<CheckpointSettings> checkpoint;  ///< as settings say, or a bucket's
    CameraSampling sampling;
    ChosenIntegrator chosen;
    JobChannels channels;
    Budget budget;
    TileGrid grid;
    std::optional<display::RowRange> bucket;  ///< of the image, while a render in buckets is in it
    int threads = 1;
    bool has_extra_rows = false;  ///< camera rays may leave rows in media
    std::vector<Error> warnings;

  private:
    ResolvedJob(const BuiltScene& of, const RenderSettings& by)
        : scene(of), settings(by), checkpoint(by.checkpoint), warnings(of.warnings) {}
};

}  // namespace raylex::transport
