// One call from a scene and settings to a filled frame buffer.
#pragma once

#include <array>
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
#include "display/services/channel_settings.h"
#include "display/services/samples/display_services.h"
#include "display/services/samples/lpe_services.h"
#include "display/services/samples/word_alphabet.h"
#include "geoaovs/cryptomatte.h"
#include "lpe/channels/lobe_slots.h"
#include "lpe/result.h"
#include "transport/paths/counters.h"
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
    std::shared_ptr<const display::WordAlphabet> words;  ///< what RenderSettings::words came to
    std::vector<display::ChannelId> altered;             ///< by sample filters: partitions with these do not sum
    std::vector<display::MemoryItem> memory;             ///< of the frame buffer, layer by layer, and cryptomattes
    int bucket_rows = 0;                                 ///< at most, of a render in buckets, whose memory is of one
    std::size_t buckets = 0;                             ///< how many; 0: the image is in memory as a whole
    /// What a checkpoint of this render says that it is of, the caller's fields before the render's own.
    display::RecordIdentity identity{};
    std::span<const Error> warnings{};  ///< known before the first sample; RenderOutput::warnings begin with them
};

/// An image larger than memory: it is rendered a bucket, a band of its rows, after another, and each finished bucket is
/// saved and its memory given back. Same bits. See render/loop/buckets.h for how, and what cannot be rendered so.
struct BucketSettings {
    /// What the process may take in all, until the image is written; 0: no limit. An image that fits is rendered as a
    /// whole.
    std::uint64_t memory = 0;
    int rows = 0;  ///< of a bucket, whether or not the image fits; 0: as `memory` allows
};

/// Saving the render now and then, so that it can go on after a crash. See render/stages/checkpoint.h for how.
struct CheckpointSettings {
    /// Replaced whole or not at all; the caller removes it in the end. Of a render in buckets, a folder with a file for
    /// each.
    std::string file;
    /// From one to the next; the last is saved when `*stop` ends the render. Infinity: nothing is saved but buckets.
    double seconds = 60;
    bool resume = false;  ///< go on from `file`; an Error when it does not fit
    /// What the render is of beyond what render() sees: another value refuses to resume. The scene, when a description
    /// is rendered, need not be here.
    display::RecordIdentity identity;
};

/// Ends a render at a number of samples per pixel that is found on the way; at most RenderSettings::samples_per_pixel.
/// All pixels get as many, so the image is, bit for bit, the one that asking for that number gives.
struct SampleLimit {
    /// Wall time since render() was called on a built scene, what the integrator prepares included; 0 = none. It is
    /// exceeded by half a second at most: a pass that cannot end by then is taken back, or, without any before it, the
    /// render incomplete.
    double seconds = 0;
    double seconds_per_sample = 0;  ///< what a sample of all pixels should take; 0: not known
    double error = 0;               ///< AdaptiveProgress::error of the beauty, neighbourhood 0; 0 = none
};

/// One sample of one pixel.
struct SampleChoice {
    int x = 0, y = 0;
    std::uint64_t sample = 0;
};

/// What overrides the scene file. Unset means: as the scene says, else pbrt's default.
struct RenderSettings {
    std::optional<std::uint64_t> samples_per_pixel;
    std::uint64_t seed = 0;
    int threads = 0;  ///< 0 = all the machine offers
    std::optional<std::array<int, 2>> resolution;
    std::optional<SceneEntity> integrator, sampler, filter;  ///< type and parameters replace the scene's
    std::optional<std::int64_t> max_depth;                   ///< overrides the integrator's "maxdepth"
    std::vector<SceneEntity> sample_filters;  ///< applied in this order to raw samples, before pixel filtering
    std::string isa;                          ///< sse2, sse4.2, avx, avx2 or avx512 for Embree; "" = the widest here
    bool splat = false;  ///< samples are shared by pixels instead of drawn as the pixel filter says
    /// Renders these pixels alone, to the bits that they have in the whole image; the others get no samples.
    std::optional<display::PixelRegion> crop;
    std::optional<SampleChoice> only;  ///< renders this sample and no other, as the whole image would have it
    bool beauty = true;                ///< false: only what the channels below accept is simulated
    bool prune = true;                 ///< false: without beauty all is simulated too, to see what that costs
    bool picked_lobes = false;         ///< label by one drawn lobe instead of exact shares
    lpe::LobeSlots lobe_slots;         ///< which numbers (D2, S4) lobes get by their names
    /// LPE channels, rest layers and geometric AOVs by name. `rest_of` counts in this list.
    std::vector<display::ChannelDefinition> channels;
    std::vector<display::RuleRequest> rules;            ///< other rules for some of them, by name
    std::vector<display::LayerRequest> layers;          ///< further outputs of them, by other rules
    std::vector<display::StatisticRequest> statistics;  ///< layers of statistics, after all channels
    /// Called once before memory is taken; an Error ends the render. It may add to `sinks`, which get every finished
    /// batch beside the frame buffer; they must outlive the render.
    std::function<Status(const RenderPlan&, std::vector<display::SampleSink*>& sinks)> before_rendering;
    /// Has the words of all light told apart by these rules and kept: for a path atlas, which is among the sinks.
    std::optional<display::WordRules> words;
    std::vector<geoaovs::MatteKind> cryptomatte;  ///< which sets of mattes to make; not with negative pixel filters
    int cryptomatte_ranks = geoaovs::Cryptomatte::default_ranks;  ///< even, at most Cryptomatte::most_ranks
    /// Samples go where the error is above a tolerance, instead of samples_per_pixel everywhere.
    std::optional<display::AdaptiveSettings> adaptive;
    std::optional<CheckpointSettings> checkpoint;
    std::optional<BucketSettings> buckets;  ///< with `checkpoint`, which says where they are saved
    std::optional<SampleLimit> limit;       ///< samples_per_pixel unset means any number then
    /// Samples [first_sample, samples_per_pixel) of each pixel alone, a shard: a multiple of the frame buffer's block
    /// size. Shards that share none merge to the bits of the whole (FrameBuffer::merge).
    std::uint64_t first_sample = 0;
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

struct RenderOutput {
    display::FrameBuffer frame_buffer;  ///< of a render in buckets, the last one's
    /// All of a render in buckets, read from where they were saved; null of others.
    std::unique_ptr<const display::BandedImage> bands;
    std::vector<display::RowRange> buckets;                ///< whose files are there
    std::uint64_t rejected_block_sums = 0;                 ///< FrameBuffer::rejected_count(), of all buckets
    double light_magnitude = 0;                            ///< FrameBuffer::light_magnitude(), the largest of all
    std::vector<geoaovs::Cryptomatte> cryptomatte;         ///< as RenderSettings::cryptomatte asks for
    display::ChannelId beauty = display::invalid_channel;  ///< id in frame_buffer.channels(); LPEs and AOVs follow it
    RenderStatistics statistics;
    bool complete = true;  ///< false after an interrupt: fewer samples than asked for
    int width = 0, height = 0, threads = 0;
    std::optional<display::PixelRegion> crop;           ///< what was rendered, where that is not all
    std::uint64_t samples_per_pixel = 0;                ///< asked for, or reached under a limit; the most when adaptive
    std::optional<display::AdaptiveProgress> adaptive;  ///< as it stood in the end; of a limit by error too
    std::uint64_t unconverged_pixels = 0;  ///< adaptive: with all the samples they may have, above the tolerance
    std::uint64_t resumed_samples = 0;     ///< camera samples that came out of a checkpoint
    std::uint64_t seed = 0;
    bool splat = false;
    std::string integrator, sampler, filter, isa;  ///< what was really used
    Matrix4 world_to_camera, world_to_screen;
    std::vector<Error> warnings;  ///< fallbacks (integrator not there yet), unused parameters

    [[nodiscard]] const display::PixelImage& image() const {
        return bands ? static_cast<const display::PixelImage&>(*bands) : frame_buffer;
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
