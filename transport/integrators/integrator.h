// What an integrator is, and all it sees of the rest.
//
// The engine hands camera rays over in batches; row i of the batch is row i of the thread's sample table. An integrator
// answers through the services only: it moves a tracker along each path, reports every contribution once, and writes
// distance, opacity, surface and (when asked for) geometric AOVs of first hits. It never learns which light path
// expressions exist.
//
// Life of an integrator:
//
//   factory(parameters)          typed, located parameters; an Error here names file and line
//   prepare(context)             once, single-threaded, before any ray: tables of its own, channel ids to cache
//   make_thread_state()          once per thread
//   start-up                     if starts_up(): one integrate() per tile with CameraBatch::startup, whose samples must
//   be
//                                discarded (display.discard_iteration()); then end_startup(), single-threaded
//   begin_iteration(i)           single-threaded; photon maps, guiding structures, chains are shared state made here
//     integrate(batch, ...)      many threads at once; const: shared state is read-only while rays fly. A loop that has
//     no
//                                bound of its own asks services.leaving() and returns when told so
//   end_iteration(i)             single-threaded: take in what the threads' states gathered
//   save_state, restore_state    for checkpoints, when traits() says that there is state to save
//
// An integrator that is not `synchronous()` gets the whole budget as iteration 0. A synchronous one gets one iteration
// per block of samples of the whole image, all threads waiting for one another in between.
//
// Randomness comes from the batch's samplers, keyed by named dimensions; pick dimensions from first_free_dimension up.
// An integrator whose light paths land on any pixel (light tracing, Metropolis) says so in its traits and reports them
// through ThreadServices::raster. A batch of n camera rays then is n light paths too, whatever each of them brings.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/registry.h"
#include "display/services/samples/display_services.h"
#include "display/services/samples/lpe_services.h"
#include "display/services/samples/raster_splats.h"
#include "geoaovs/geoaovs.h"
#include "transport/paths/counters.h"
#include "transport/paths/event_table.h"
#include "transport/paths/subpath.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

class Camera;

/// What prepare() gets; the pointers live as long as the render.
struct IntegratorContext {
    SceneView scene;
    const EventTable* events = nullptr;
    const geoaovs::GeometricAovs* aovs = nullptr;
    std::span<const display::ChannelDefinition> channels;
    bool pattern_channels = false;    ///< some channel is written by patterns or materials: first hits must be shaded
    Real world_to_camera[3][4] = {};  ///< rigid part, for geoaovs::ShadingBatch
    Vec2 pixel_size;                  ///< of a pixel on the plane at distance 1 before the camera
    bool beauty = true;               ///< false: what no channel can accept need not be simulated (Law 4)
    int batch_capacity = 0;           ///< most rays of one batch
    const Camera* camera = nullptr;
    int width = 0, height = 0;  ///< of the image
    Vec2 filter_radius;         ///< how far around the image light still counts, in pixels
    std::uint32_t tiles = 1;    ///< that CameraBatch::tile counts
    std::uint64_t seed = 0;
    const display::LpeSetup* lpe = nullptr;  ///< for LPE services of its own, on a table of its own
    display::LpeServices::Attribution attribution = display::LpeServices::Attribution::exact;
};

/// Camera rays of one call. ray i belongs to row i and draws from samplers[i].
struct CameraBatch {
    std::span<const Ray> rays;
    std::span<const PixelSampler> samplers;
    std::span<const display::CameraRow> rows;
    /// Whose pixels they are. Within an iteration of a synchronous integrator, no two threads hold batches of one tile.
    std::uint32_t tile = 0;
    bool startup = false;  ///< not of the image: see Integrator::starts_up
    /// What light along each ray counts for; empty where all count alike. Integrators with the trait camera_weights.
    std::span<const Real> weights{};
};

struct ThreadServices {
    display::DisplayServices& display;
    display::LpeServices& lpe;
    display::RasterSplats* raster = nullptr;   ///< for integrators with the trait raster_splats; else null
    const std::atomic<bool>* leave = nullptr;  ///< set when the render ends without waiting for batches; null: never
    bool left = false;                         ///< this batch is not finished: the engine drops what came of it

    /// Whether to leave the batch as it is and return at once. To be asked in every loop that scenes can make endless:
    /// once for each scattering event of a batch costs nothing that can be measured.
    [[nodiscard]] bool leaving() {
        left = left || (leave != nullptr && leave->load(std::memory_order_relaxed));
        return left;
    }
};

/// Base of an integrator's per-thread state.
struct IntegratorThread {
    virtual ~IntegratorThread() = default;
    IntegratorCounters counters;
};

/// What becomes of an integrator's shared state when a render is interrupted and resumed.
enum class SavedState : std::uint8_t {
    unknown,  ///< it does not say: renders with checkpoints are refused
    none,     ///< nothing lives longer than a batch: samples are functions of their numbers
    saved     ///< save_state() and restore_state(), between the iterations of a synchronous() integrator
};

/// What an integrator can answer for. Channels that ask for more are refused before the render.
struct IntegratorTraits {
    bool emitter_samples = false;           ///< reports emitters with an EmitterSample: prefix nothruput
    bool light_samples = false;             ///< samples lights, and blocked ones too: prefixes unoccluded and shadows
    bool holdouts = false;                  ///< holds out paths whose first hit is a holdout
    bool user_events = false;               ///< reports UserLobe events
    std::optional<std::int64_t> max_depth;  ///< scattering events of a path at most
    bool media = false;                     ///< takes paths through participating media
    /// Writes distance, opacity, surface and the geometric AOVs of first hits itself, for every camera ray. False: the
    /// renderer supplies them wherever the integrator reported nothing for a ray, by tracing the camera rays again.
    bool first_hits = false;
    /// Rays pass through cutouts and interfaces, in proportion to what these let pass. False: a scene that has some
    /// gets a warning.
    bool cutouts = false;
    SavedState saved_state = SavedState::unknown;
    /// Every contribution comes with its word: what a path atlas needs. False of those that sum them up by channels.
    bool tells_words = true;
    /// Light lands at raster positions of its own (ThreadServices::raster). What needs samples that belong to a pixel
    /// is refused then: layers of statistics, adaptive sampling, sample filters, deep images, other rules than the
    /// pixel filter for light. Moments (ChannelDefinition::statistics) are not kept.
    bool raster_splats = false;
    /// Beside its splats it finds light by camera samples: layers of variance and adaptive sampling may be asked for,
    /// and are of that part. (Moments are kept for these alone.)
    bool pixel_samples = false;
    /// Closures are regularized: what is specular by its material may scatter by the glossy lobe of the same name.
    bool regularizes = false;
    /// Takes CameraBatch::weights: cameras whose rays count differently (Camera::weighs_rays) are refused otherwise.
    bool camera_weights = false;
};

class Integrator {
  public:
    virtual ~Integrator() = default;
    [[nodiscard]] virtual IntegratorTraits traits() const { return {}; }
    virtual Status prepare(const IntegratorContext& context) = 0;
    /// After prepare(): what of this scene the integrator does not find, as warnings for the user.
    [[nodiscard]] virtual std::vector<std::string> omissions() const { return {}; }
    /// After the render: which paths were cut for their length, and how many, as warnings for the user.
    [[nodiscard]] virtual std::vector<std::string> cuts() const { return {}; }
    /// The rays that prepare() traced to learn what the render had better do; none of them is of the image.
    [[nodiscard]] virtual std::uint64_t pilot_rays() const { return 0; }
    [[nodiscard]] virtual std::unique_ptr<IntegratorThread> make_thread_state() const {
        return std::make_unique<IntegratorThread>();
    }
    [[nodiscard]] virtual bool synchronous() const { return false; }
    /// Whether there are samples to take before the image: a Metropolis integrator's bootstrap.
    [[nodiscard]] virtual bool starts_up() const { return false; }
    virtual void end_startup() {}
    virtual void begin_iteration(std::uint64_t /*iteration*/) {}
    virtual void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const = 0;
    virtual void end_iteration(std::uint64_t /*iteration*/, std::span<IntegratorThread* const> /*threads*/) {}

    /// SavedState::saved only. Appends to `bytes` all that iterations so far left behind in this object, and takes it
    /// back after prepare(): what follows must be the same bits as if the render had never been interrupted.
    virtual void save_state(std::string& /*bytes*/) const {}
    virtual Status restore_state(std::string_view /*bytes*/) { return success(); }
};

/// `max_depth` overrides the entity's "maxdepth".
using IntegratorFactory =
    std::function<Result<std::unique_ptr<Integrator>>(const SceneEntity&, std::optional<std::int64_t> max_depth)>;

/// path (volpath is another name for it), lighttracer, bdpt, pssmlt; plugins add theirs.
Registry<IntegratorFactory>& integrator_registry();

/// A light subpath's power is no number: counted and logged (Law 6) as a splat of `row`'s.
void reject_power(ThreadServices& services, const display::CameraRow& row, const Rgb& power);
/// Where the camera stands: the middle of its lens.
[[nodiscard]] Vec3 camera_position(const IntegratorContext& context);

/// The parameter "maxdepth" of in-tree integrators, `max_depth` first; 5 without, at most a million.
Result<std::uint32_t> read_max_depth(const SceneEntity& entity, std::optional<std::int64_t> max_depth);

/// The parameters "roulette" and "rrthreshold": the throughput below which paths end at random, 0 where none does.
Result<Real> read_roulette(const SceneEntity& entity);
/// What the registry says of them; `who` ends: "paths", "subpaths".
ParameterDescription describe_roulette(const std::string& who);
ParameterDescription describe_roulette_threshold();

/// The parameters "maxdepth", "roulette" and "rrthreshold", for integrators that have no others.
struct DepthParameters {
    std::uint32_t max_depth = 5;  ///< scattering events at most
    Real roulette_below = default_roulette_below;
};
Result<DepthParameters> read_depth_parameters(const SceneEntity& entity, std::optional<std::int64_t> max_depth);
std::vector<ParameterDescription> describe_depth_parameters(const std::string& who);

/// The integrator that `asked` names, with the scene's parameters that both have and `asked` does not give: "maxdepth"
/// most of all. Without `asked`, the scene's own.
SceneEntity integrator_for(const std::optional<SceneEntity>& asked, const SceneEntity& of_scene);

struct ChosenIntegrator {
    std::unique_ptr<Integrator> integrator;
    std::string name;
    std::vector<Error> warnings;
    std::optional<std::uint64_t> samples_per_pixel;  ///< that a scene's integrator asks for itself (mlt)
};
/// pbrt's integrators of other names are ours, or `path`, with a warning that says how they differ; `volpath` means
/// `path`, which takes media as they come; a name nobody knows is an Error. An empty type means `path`.
Result<ChosenIntegrator> choose_integrator(const SceneEntity& entity, std::optional<std::int64_t> max_depth);

}  // namespace raylex::transport
