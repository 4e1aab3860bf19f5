// Renders a scene with settings into a frame buffer, in one call.
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
#include "display/services/samples/path_alphabet.h"
#include "geoaovs/cryptomatte.h"
#include "lpe/channels/lobe_slots.h"
#include "lpe/result.h"
#include "transport/paths/counters.h"
#include "transport/paths/guide/guide_summary.h"
#include "transport/render/render_settings.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// A render with everything resolved and nothing allocated yet.
struct RenderPlan {
    int width = 0, height = 0;
    std::uint64_t samples_per_pixel = 0;
    std::span<const display::ChannelDefinition> channels;  ///< as in RenderOutput::frame_buffer
    display::ChannelId beauty = display::invalid_channel;
    display::PixelRegion crop;  ///< the rendered pixels; without a crop the whole image
    const display::PixelFilter* filter = nullptr;
    bool splat = false;
    bool raster = false;                                 ///< the integrator's light paths splat anywhere on the image
    bool signed_light = false;                           ///< paths of one wavelength, whose RGB may be negative
    std::shared_ptr<const display::PathAlphabet> words;  ///< made by LabelSettings::words
    /// changed by sample filters: partitions with these do not sum
    std::vector<display::ChannelId> altered;
    std::vector<display::MemoryItem> memory;  ///< of the frame buffer, layer by layer, and cryptomattes
    /// maximum for a render in buckets, whose memory holds one bucket
    int bucket_rows = 0;
    std::size_t buckets = 0;  ///< number of buckets; 0: the whole image is in memory
    /// The identity in a checkpoint of this render: the caller's fields, then the render's own.
    display::RecordIdentity identity{};
    std::span<const Error> warnings{};  ///< known before the first sample; RenderOutput::warnings begin with them
};

/// The image while it is being rendered, for live views.
class LiveImage {
  public:
    virtual ~LiveImage() = default;
    /// FrameBuffer::resolve() of the current samples. Threads with samples of these pixels wait meanwhile.
    [[nodiscard]] virtual std::vector<double> resolve(display::ChannelId id,
                                                      const display::PixelRegion& region) const = 0;
    [[nodiscard]] virtual std::vector<double> resolve_alpha(const display::PixelRegion& region) const = 0;
    /// FrameBuffer::resolve_variance_of_mean(); empty if the channel keeps no statistics.
    [[nodiscard]] virtual std::vector<double> resolve_variance_of_mean(display::ChannelId id,
                                                                       const display::PixelRegion& region) const = 0;
};

struct RenderProgress {
    std::uint64_t samples_done = 0, samples_total = 0;  ///< camera samples
    /// wall time since rendering began, including interrupted sessions
    double seconds = 0;
    const display::AdaptiveProgress* adaptive =
        nullptr;                       ///< null unless sampling is adaptive; samples_total is predicted
    const LiveImage* image = nullptr;  ///< valid during the call only
    std::uint64_t samples_least = 0;   ///< display::Forecast::least, of samples_total
};

struct GuideView;

struct RenderStatistics {
    double build_seconds = 0, build_cpu_seconds = 0;      ///< scene tables and acceleration structure
    double prepare_seconds = 0, prepare_cpu_seconds = 0;  ///< the integrator's tables, pilots and start-up
    std::uint64_t pilot_rays = 0;                         ///< traced to plan paths; not part of the image
    GuideSummary guide;                                   ///< what was learned about directions
    /// Set if the guide was used and PathSettings::guide_view is true.
    std::shared_ptr<const GuideView> guide_view{};
    double render_seconds = 0, render_cpu_seconds = 0;
    std::uint64_t camera_samples = 0, camera_rays = 0, scattering_rays = 0, shadow_rays = 0;
    std::uint64_t discarded_samples = 0;               ///< in iterations that the integrator discarded, in this session
    std::uint64_t branches = 0;                        ///< additional branches of split paths
    PrunedCounts pruned{};                             ///< [Pruned]
    std::vector<std::uint64_t> path_length_histogram;  ///< [scattering events of the path]
    std::uint64_t attribution_overflow = 0;            ///< trackers that had to merge states at random
    std::uint64_t invalid_samples = 0;                 ///< contributions and values rejected as not finite
    std::vector<std::uint64_t> invalid_by_channel;     ///< [channel] rejected values that it would have received
    /// the first ones in the order of samples, independent of threads
    std::vector<display::InvalidSample> invalid_log;
    std::uint64_t refused_services_calls = 0;
    std::vector<display::RefusalCounts> refusals;  ///< per channel; the last entry is for calls without a channel
    std::uint64_t checkpoints = 0;                 ///< written in this session
    double checkpoint_stall_seconds = 0;           ///< wall time for which all threads waited for them
};

/// The number of samples of a render, and whether it is complete.
struct SamplesTaken {
    bool complete = true;  ///< false: an interrupt or a limit of time ended the render before its last sample
    /// Samples of each pixel: the requested number, or the number reached under a SampleLimit. Under adaptive sampling:
    /// the most that a pixel may get.
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

/// The frame buffer's reports on its sums, over all buckets of the image.
struct ImageSums {
    std::uint64_t rejected = 0;  ///< number of sums of blocks that were not finite: FrameBuffer::rejected_count()
    double light_magnitude = 0;  ///< 0, or the largest sum that cancelled in a pixel: FrameBuffer::light_magnitude()
};

struct RenderOutput {
    display::FrameBuffer frame_buffer;                     ///< the image; after a render in buckets one empty row
    BucketImage buckets;                                   ///< the image after a render in buckets
    std::shared_ptr<const display::PixelImage> sum{};      ///< the image if several renders are summed; else null
    std::vector<geoaovs::Cryptomatte> cryptomatte;         ///< one for each of MatteSettings::kinds
    display::ChannelId beauty = display::invalid_channel;  ///< the beauty's id in frame_buffer.channels()
    ImageSums sums;
    SamplesTaken samples;
    ImageView view;
    UsedSettings used;
    RenderStatistics statistics;
    std::vector<Error> warnings;  ///< for the user, such as fallbacks and unused parameters

    [[nodiscard]] const display::PixelImage& image() const {
        if (sum) return *sum;
        return buckets.image ? static_cast<const display::PixelImage&>(*buckets.image) : frame_buffer;
    }
};

/// Renders. `progress` is called from one thread, a few times a second. Setting `*stop` ends the render after the
/// current blocks, but leaves batches that take longer than a moment, and returns the image so far, marked incomplete.
Result<RenderOutput> render(const SceneDescription& scene, const RenderSettings& settings,
                            const std::function<void(const RenderProgress&)>& progress = {},
                            const std::atomic<bool>* stop = nullptr);

/// Removes the files that a render in buckets has saved in its folder, and the folder if it is then empty.
Status remove_buckets(const std::string& folder);

/// Labels, light groups, lobes and terminals that this scene can produce: the alphabet of proofs and close matches.
struct SceneAlphabet {
    std::vector<std::string> object_labels, light_groups;
    bool has_lights = false, has_background = false, has_straight = false;
    std::vector<lpe::Event> scattering;  ///< one per distinct event of the scene
    std::vector<lpe::Event> terminals;
    std::vector<display::ChannelDefinition> pattern_channels;  ///< to which textures write; AOVs by these names
};
/// The definition of an AOV by name: one of `patterns`, else a plugin's channel, else a geometric AOV, else an Error
/// with the closest match.
Result<display::ChannelDefinition> named_channel(const std::string& name,
                                                 std::span<const display::ChannelDefinition> patterns);
/// `regularizes` is the field of IntegratorTraits.
Result<SceneAlphabet> scene_alphabet(const SceneDescription& scene, const lpe::LobeSlots& slots = {},
                                     bool regularizes = false);

}  // namespace raylex::transport
