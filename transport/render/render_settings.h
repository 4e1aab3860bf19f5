// The settings of a render: what a caller sets instead of the scene file. Each group has one reader, which render()
// passes that group alone.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "display/buffer/adaptive/adaptive_sampler.h"
#include "display/buffer/sample_sink.h"
#include "display/checkpoint/record_file.h"
#include "display/services/channel.h"
#include "display/services/channel_settings.h"
#include "display/services/samples/path_alphabet.h"
#include "geoaovs/cryptomatte.h"
#include "lpe/channels/lobe_slots.h"
#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct RenderPlan;

/// The threads and instructions that a render uses. BuiltScene::build() and the render read it.
struct MachineSettings {
    /// The instruction set for Embree, of display::instruction_sets(). Empty: the widest that this machine has.
    std::string isa{};
    int threads = 0;  ///< number of threads, at least 0; 0: one for each hardware thread
};

/// Settings that replace parts of the scene's film and pixel filter. Unset fields leave the scene's values.
struct FilmOverrides {
    std::optional<std::array<int, 2>> resolution;  ///< width and height of the image in pixels, each at least 1
    /// The pixels to render: x0 <= x < x1 and y0 <= y < y1 inside the image. These pixels get the same bits as in a
    /// render of the whole image; all other pixels get no samples.
    std::optional<display::PixelRegion> crop;
    std::optional<SceneEntity> filter;  ///< type and parameters of the pixel filter
    /// False (filter mode importance): each sample belongs to one pixel and is drawn in proportion to the filter.
    /// True (filter mode splat): each sample adds to every pixel that the filter reaches.
    bool splat = false;
};

/// One sample of one pixel.
struct SampleChoice {
    int x = 0, y = 0;          ///< the pixel, from 0 at the upper left corner of the image
    std::uint64_t sample = 0;  ///< the number of the sample within its pixel, from 0
};

/// The samples of the pixels, and the source of their random numbers.
struct SampleSettings {
    /// Samples of each pixel, at least 1. Unset: the number in the scene's sampler or integrator; a render with a
    /// SampleLimit then takes as many as its limit allows.
    std::optional<std::uint64_t> per_pixel;
    /// The number of each pixel's first sample: a multiple of 16 (the block size of the frame buffer) below per_pixel.
    /// A render with first > 0 is a shard. Shards that share no sample merge to the bits of the whole render
    /// (FrameBuffer::merge).
    std::uint64_t first = 0;
    /// Of a shard: samples of each pixel of the whole render, on which the training of a guide depends.
    std::optional<std::uint64_t> whole;
    /// Renders this sample and no other, with the same random numbers as in a render of all samples.
    std::optional<SampleChoice> only;
    std::uint64_t seed = 0;              ///< is added to the sampler's own "seed"
    std::optional<SceneEntity> sampler;  ///< type and parameters of the sampler; unset: the scene's
};

/// Ends a render at a number of samples per pixel that the render finds itself; SampleSettings::per_pixel bounds it.
/// Every pixel gets that number, so the image has the same bits as a render that was given it as per_pixel.
struct SampleLimit {
    /// Wall time in seconds from the call of render() on a built scene, including the integrator's preparation; 0: no
    /// limit. A render exceeds it by at most half a second: it discards a pass that is still running then, or, in the
    /// first pass, returns an incomplete image.
    double seconds = 0;
    double seconds_per_sample = 0;  ///< expected wall time in seconds of one sample of every pixel; 0: unknown
    /// The error of the beauty at which the render ends: AdaptiveProgress::error with neighbourhood 0; 0: no limit.
    double error = 0;
};

/// Limits that end a render before each pixel has all its samples. At most one of the two is set.
struct StopSettings {
    /// Adaptive sampling: each pixel gets samples until its error is below a tolerance. Its max_samples replaces
    /// SampleSettings::per_pixel.
    std::optional<display::AdaptiveSettings> adaptive;
    std::optional<SampleLimit> limit;  ///< one number of samples for all pixels, by time or by error
};

/// The light paths to sample, and the method.
struct PathSettings {
    std::optional<SceneEntity> integrator;  ///< type and parameters of the integrator; unset: the scene's
    /// Most scattering events of a path, 0 to 1,000,000. Set: it replaces the integrator's "maxdepth".
    std::optional<std::int64_t> max_depth;
    /// False: without a beauty, the integrator also traces paths that no channel can accept. This measures what
    /// pruning saves.
    bool prune = true;
    /// Set: if the integrator learns a guide, it learns from so many samples of each pixel, and uses it; 0: no guide.
    /// So a render repeats one that a time limit ended (GuideSummary::repeated()).
    std::optional<std::uint32_t> guide_samples;
    /// Not empty: a file with the guide that the integrator learns. If it exists, the render reads it and does not
    /// train; otherwise the render writes it after the training. The image has the same bits (Law 3). The file of
    /// another render, a damaged file and an integrator that learns no guide are Errors.
    std::string guide_file{};
    bool guide_view = false;  ///< if a guide is used, the render also makes RenderStatistics::guide_view
};

/// The conversion of paths to path strings for light path expressions.
struct LabelSettings {
    lpe::LobeSlots lobe_slots{};  ///< the numbers (as in D2 or S4) that lobes get by their names
    /// False: each lobe carries its exact share of the light. True: one lobe, drawn at random, carries all of it.
    bool picked_lobes = false;
    /// Set: each contribution of light keeps its path string, and these rules decide which of them differ. A path atlas
    /// needs this and is one of the sinks.
    std::optional<display::PathStringRules> words;
};

/// The channels of the frame buffer.
struct ChannelSettings {
    bool beauty = true;  ///< false: only paths that `list` can accept are simulated
    /// Not empty: a light path expression in the dialect renderman. The beauty then takes only the paths that it
    /// accepts, and only paths that it or `list` can accept are simulated. The other channels of `list` must accept no
    /// more. The caller has proved that the integrator samples these paths: there are no warnings about those that
    /// omitted_paths() declares.
    std::string takes{};
    /// Light path expressions, rest layers and geometric AOVs, each name once. ChannelDefinition::rest_of holds
    /// positions in this list.
    std::vector<display::ChannelDefinition> list{};
    std::vector<display::RuleRequest> rules{};            ///< how samples of a channel become pixels, by its name
    std::vector<display::LayerRequest> layers{};          ///< further outputs of channels, each by a rule of its own
    std::vector<display::StatisticRequest> statistics{};  ///< statistics of channels; they follow all other channels
    std::vector<SceneEntity> sample_filters{};  ///< change raw samples, in this order, before the pixel filter
};

/// The cryptomattes to make.
struct MatteSettings {
    std::vector<geoaovs::MatteKind> kinds{};  ///< one cryptomatte for each; empty: none
    /// Ids stored in each pixel: an even number from 2 to Cryptomatte::most_ranks.
    int ranks = geoaovs::Cryptomatte::default_ranks;
};

/// Saves a render at intervals, so that it can continue after a crash. render/stages/checkpoint.h has the details.
struct CheckpointSettings {
    /// The file of the checkpoint, which each save replaces as a whole and which the caller removes at the end. A
    /// render in buckets takes it as a folder with one file for each bucket.
    std::string file{};
    /// Wall time in seconds between two saves; `*stop` also saves. Infinity: only finished buckets are saved.
    double seconds = 60;
    bool resume = false;  ///< true: the render continues from `file`, or returns an Error when `file` does not fit
};

/// Renders an image that is larger than memory in buckets, which are bands of its rows. Each finished bucket is saved
/// and its memory is released. The image has the same bits. render/loop/buckets.h has the details and the limits.
struct BucketSettings {
    /// Most memory of the process in bytes, until the image is written; 0: no limit. An image that fits is rendered in
    /// one piece.
    std::uint64_t memory = 0;
    /// Rows of a bucket, at least 0, even where the whole image fits; 0: as many as `memory` allows.
    int rows = 0;
};

struct RenderSettings {
    MachineSettings machine;
    FilmOverrides film;
    SampleSettings samples;
    StopSettings stop;
    PathSettings paths;
    LabelSettings labels;
    ChannelSettings channels;
    MatteSettings mattes;
    /// Names and values, beyond the settings, that identify the render in checkpoints, records of shards and guide
    /// files; files with other values are refused. render() adds the scene when the caller passes its description.
    display::RecordIdentity identity{};
    std::optional<CheckpointSettings> checkpoint;  ///< unset: nothing is saved before the end
    std::optional<BucketSettings> buckets;         ///< set: `checkpoint` must be set too and names the folder
    /// Is called once, before the integrator prepares and a guide is trained; an Error ends the render. The plan has no
    /// warnings of the preparation yet.
    std::function<Status(const RenderPlan&)> before_preparing{};
    /// Is called once, before the render takes memory; an Error ends the render. It may add to `sinks`, which receive
    /// every finished batch beside the frame buffer and must outlive the render.
    std::function<Status(const RenderPlan&, std::vector<display::SampleSink*>& sinks)> before_rendering;
};

}  // namespace raylex::transport
