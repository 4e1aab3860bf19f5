// Settings resolved for a scene: the first stage of a render, which refuses everything that can be refused before the
// integrator prepares. Private to transport/render.
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

/// The positions of camera samples, and the source of their random numbers.
struct CameraSampling {
    FilmSettings film;
    std::unique_ptr<Camera> camera;
    bool times = false;  ///< each sample draws a time
    /// rays have cones, as wide as the pixel_share() of their sample, since something filters by them
    bool cones = false;
    std::unique_ptr<display::PixelFilter> filter;
    SourceLocation filter_location;    ///< for errors
    bool splat = false;                ///< FilmOverrides::splat
    int padding_x = 0, padding_y = 0;  ///< pixels around the image whose samples reach into it
    SamplerKind sampler = SamplerKind::sobol;
    std::uint32_t arrangement_bits = 4;  ///< as in SamplerChoice
    std::string sampler_name;
    std::uint64_t seed = 0;
    std::uint64_t samples_per_pixel = 0;  ///< from the settings or the scene's sampler
};

/// The channels as in the frame buffer.
struct JobChannels {
    std::vector<display::ChannelDefinition> list;
    display::ChannelId beauty = display::invalid_channel;
    bool takes_all = false;  ///< the beauty takes all paths: ChannelSettings::takes is empty
    display::SampleFilterChain filters;
    std::unique_ptr<display::LpeSetup> lpe;
    bool keeps_path_strings = false;  ///< LabelSettings::words is set
    bool written_by_plugins =
        false;  ///< some plain channel is not a geometric AOV: patterns, materials or integrators write it
    display::LpeServices::Attribution attribution = display::LpeServices::Attribution::exact;
};

/// The number of samples, and which ones; make_schedule() makes a Schedule of it.
struct Budget {
    std::uint64_t samples_per_pixel = 0;  ///< at most
    std::uint64_t first_sample = 0;       ///< of the shard
    /// Samples of each pixel in all shards, at most; least_for_error if only the error ends the render; 0: the clock
    /// does.
    std::uint64_t whole = 0;
    std::optional<SampleLimit> limit;
    std::optional<display::AdaptiveSettings> adaptive;
    std::optional<SampleChoice> only;
};

class ResolvedJob {
  public:
    /// Resolves the settings; both arguments must outlive the job. Errors give the reason why the render is impossible.
    static Result<ResolvedJob> resolve(const BuiltScene& scene, const RenderSettings& settings);

    [[nodiscard]] Integrator& integrator() const { return *chosen.integrator; }
    /// The integrator's request, with the settings' guide_samples.
    [[nodiscard]] GuideRequest guide_request() const;
    /// Whether the integrator's light paths splat anywhere on the image.
    [[nodiscard]] bool raster() const { return splats_anywhere(chosen); }
    [[nodiscard]] static bool splats_anywhere(const ChosenIntegrator& chosen) {
        return chosen.integrator->traits().raster_splats;
    }

    const BuiltScene& scene;
    const RenderSettings& settings;
    std::optional<CheckpointSettings> checkpoint;  ///< from the settings, or of a bucket
    CameraSampling sampling;
    ChosenIntegrator chosen;
    JobChannels channels;
    Budget budget;
    TileGrid grid;
    std::optional<display::RowRange> bucket;  ///< rows of the current bucket of a render in buckets
    int threads = 1;
    bool has_extra_rows = false;  ///< camera rays may add rows in media
    std::vector<Error> warnings;

  private:
    ResolvedJob(const BuiltScene& of, const RenderSettings& by)
        : scene(of), settings(by), checkpoint(by.checkpoint), warnings(of.warnings) {}
};

}  // namespace raylex::transport
