// One call from a scene and settings to a filled frame buffer.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "display/buffer/adaptive/adaptive_sampler.h"
#include "display/buffer/frame_buffer/banded_image.h"
#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/buffer/pixel_filter.h"
#include "display/buffer/sample_sink.h"
#include "display/checkpoint/record_file.h"
#include "display/services/channel.h"
#include "display/services/samples/display_services.h"
#include "display/services/samples/lpe_services.h"
#include "display/services/samples/word_alphabet.h"
#include "geoaovs/cryptomatte.h"
#include "lpe/channels/lobe_slots.h"
#include "lpe/result.h"
#include "transport/paths/counters.h"
#include "transport/render/render_settings.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// A render with everything resolved and nothing allocated yet.
struct RenderPlan {
    int width = 0, height = 0;
    std::uint64_t samples_per_pixel = 0;
    std::span<const display::ChannelDefinition> channels;  ///< as RenderOutput::frame_buffer will have them
    display::ChannelId beauty = display::invalid_channel;
    display::PixelRegion crop;  ///< what is rendered; all of the image without a crop
    const display::PixelFilter* filter = nullptr;
    bool splat = false;
    bool raster = false;                                 ///< the integrator's light lands anywhere on the image
    bool signed_light = false;                           ///< paths of one wavelength, whose RGB may be negative
    std::shared_ptr<const display::WordAlphabet> words;  ///< made by LabelSettings::words
    std::vector<display::ChannelId> altered;             ///< by sample filters: partitions with these do not sum
    std::vector<display::MemoryItem> memory;             ///< of the frame buffer, layer by layer, and cryptomattes
    int bucket_rows = 0;                                 ///< at most, of a render in buckets, whose memory is of one
    std::size_t buckets = 0;                             ///< how many; 0: the image is in memory as a whole
    /// What a checkpoint of this render says that it is of, the caller's fields before the render's own.
    display::RecordIdentity identity{};
    std::span<const Error> warnings{};  ///< known before the first sample; RenderOutput::warnings begin with them
};

/// The image while it is being rendered, for live views.
class LiveImage {
  public:
    virtual ~LiveImage() = default;
    /// As FrameBuffer::resolve, of the samples there are. Threads that bring samples of these pixels wait meanwhile.
    [[nodiscard]] virtual std::vector<double> resolve(display::ChannelId id,
                                                      const display::PixelRegion& region) const = 0;
    [[nodiscard]] virtual std::vector<double> resolve_alpha(const display::PixelRegion& region) const = 0;
    /// As FrameBuffer::resolve_variance_of_mean; empty where the channel keeps no statistics.
    [[nodiscard]] virtual std::vector<double> resolve_variance_of_mean(display::ChannelId id,
                                                                       const display::PixelRegion& region) const = 0;
};

struct RenderProgress {
    std::uint64_t samples_done = 0, samples_total = 0;  ///< camera samples
    double seconds = 0;                                 ///< wall, since rendering began, of interrupted sessions too
    const display::AdaptiveProgress* adaptive =
        nullptr;                       ///< null unless sampling is adaptive; samples_total is predicted
    const LiveImage* image = nullptr;  ///< during the call only
    std::uint64_t samples_least = 0;   ///< display::Forecast::least, of samples_total
};

struct RenderStatistics {
    double build_seconds = 0, build_cpu_seconds = 0;      ///< scene tables and acceleration structure
    double prepare_seconds = 0, prepare_cpu_seconds = 0;  ///< the integrator's tables, pilots and start-up
    std::uint64_t pilot_rays = 0;                         ///< traced to plan the paths, of no image
    double render_seconds = 0, render_cpu_seconds = 0;
    std::uint64_t camera_samples = 0, camera_rays = 0, scattering_rays = 0, shadow_rays = 0;
    std::uint64_t discarded_samples = 0;               ///< of iterations that the integrator discarded, in this session
    std::uint64_t branches = 0;                        ///< beside the first, of split paths
    PrunedCounts pruned{};                             ///< [Pruned]
    std::vector<std::uint64_t> path_length_histogram;  ///< [scattering events of the path]
    std::uint64_t attribution_overflow = 0;            ///< trackers that had to merge by choice
    std::uint64_t invalid_samples = 0;                 ///< contributions and values refused as not finite
    std::vector<std::uint64_t> invalid_by_channel;     ///< [channel] how many of them it would have taken
    std::vector<display::InvalidSample> invalid_log;   ///< the first ones in the order of samples, for any threads
    std::uint64_t refused_services_calls = 0;
    std::vector<display::RefusalCounts> refusals;  ///< per channel; the last are of calls that name none
    std::uint64_t checkpoints = 0;                 ///< written in this session
    double checkpoint_stall_seconds = 0;           ///< wall, for which all threads stood still for them
};

/// How many samples a render took, and whether that is all.
struct SamplesTaken {
    bool complete = true;  ///< false: an interrupt or a limit of time ended the render before its last sample
    /// Samples of each pixel: the number asked for, or the number reached under a SampleLimit; the most that a pixel
    /// may get under adaptive sampling.
    std::uint64_t per_pixel = 0;
    std::uint64_t resumed = 0;  ///< camera samples that a checkpoint held
    /// The error at the end; set under adaptive sampling and under a SampleLimit of error.
    std::optional<display::AdaptiveProgress> adaptive;
    /// Adaptive sampling: pixels that have the most samples they may get and an error above the tolerance.
    std::uint64_t unconverged_pixels = 0;
};

/// The image and its camera.
struct ImageView {
    int width = 0, height = 0;                 ///< of the image in pixels
    std::optional<display::PixelRegion> crop;  ///< the pixels that were rendered; unset: all
    Matrix4 world_to_camera;                   ///< from the scene's world to camera space, when the shutter opens
    Matrix4 world_to_screen;                   ///< from the scene's world to the screen window, when the shutter opens
};

/// The settings that a render used, after the scene's values and defaults filled what RenderSettings left unset.
struct UsedSettings {
    std::string integrator{}, sampler{}, filter{};  ///< their types
    std::string isa{};                              ///< Embree's instruction set
    bool splat = false;                             ///< filter mode splat, otherwise importance
    int threads = 0;                                ///< number of threads, at least 1
    std::uint64_t seed = 0;                         ///< SampleSettings::seed
};

/// The finished buckets of a render in buckets.
struct BucketImage {
    std::unique_ptr<const display::BandedImage> image{};  ///< reads all rows from the buckets' files; null: no buckets
    std::vector<display::RowRange> rows{};                ///< the rows of each bucket that has a file
};

/// What the frame buffer reports of its sums, over all buckets of the image.
struct ImageSums {
    std::uint64_t rejected = 0;  ///< number of sums of blocks that were not finite: FrameBuffer::rejected_count()
    double light_magnitude = 0;  ///< 0, or the largest sum that cancelled in a pixel: FrameBuffer::light_magnitude()
};

struct RenderOutput {
    display::FrameBuffer frame_buffer;                     ///< the image; after a render in buckets one empty row
    BucketImage buckets;                                   ///< the image after a render in buckets
    std::vector<geoaovs::Cryptomatte> cryptomatte;         ///< one for each of MatteSettings::kinds
    display::ChannelId beauty = display::invalid_channel;  ///< the beauty's id in frame_buffer.channels()
    ImageSums sums;
    SamplesTaken samples;
    ImageView view;
    UsedSettings used;
    RenderStatistics statistics;
    std::vector<Error> warnings;  ///< for the user, such as fallbacks and unused parameters

    [[nodiscard]] const display::PixelImage& image() const {
        return buckets.image ? static_cast<const display::PixelImage&>(*buckets.image) : frame_buffer;
    }
};

/// Renders. `progress` is called from one thread, a few times a second. Setting `*stop` ends the render after the
/// current blocks, without batches that take longer than a moment, and returns what there is, marked incomplete.
Result<RenderOutput> render(const SceneDescription& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress = {},
                            const std::atomic<bool>* stop = nullptr);

/// Removes what a render in buckets has saved in its folder, and the folder when nothing else is in it.
Status remove_buckets(const std::string& folder);

/// Labels, light groups, lobes and terminals that this scene can produce: the words that proofs and near misses use.
struct SceneAlphabet {
    std::vector<std::string> object_labels, light_groups;
    bool has_lights = false, has_background = false, has_straight = false;
    std::vector<lpe::Event> scattering;  ///< one per distinct event of the scene
    std::vector<lpe::Event> terminals;
    std::vector<display::ChannelDefinition> pattern_channels;  ///< that textures name; AOVs by these names
};
/// The definition of an AOV by its name: one of `patterns`, else a plugin's channel, else a geometric AOV, else an
/// Error with the near miss.
Result<display::ChannelDefinition> named_channel(const std::string& name,
                                                 std::span<const display::ChannelDefinition> patterns);
/// `regularizes`: IntegratorTraits'.
Result<SceneAlphabet> scene_alphabet(const SceneDescription& scene, const lpe::LobeSlots& slots = {},
                                     bool regularizes = false);

}  // namespace raylex::transport
