// What an integrator is, and all it sees of the rest.
//
// The engine hands over camera rays in batches. Row i of the batch is row i of the thread's sample table. An integrator
// answers through the services only: it moves a tracker along each path, reports every contribution once, and writes
// distance, opacity, surface and geometric AOVs of first hits. It never learns which light path expressions exist.
//
// The calls, in their order:
//
//   factory(parameters)         reads typed, located parameters; an Error names file and line.
//   plan_request()              states what the render may plan for its camera subpaths.
//   prepare(context)            once, single-threaded, before any ray of the image: its own tables, channel ids.
//   omissions()                 names what the integrator does not find in this scene.
//   make_thread_state()         once for each thread.
//   integrate(), end_startup()  if starts_up(): one call for each tile with CameraBatch::startup. Each call ends in
//                               display.discard_iteration(), so none of its samples reaches the image.
//   begin_iteration(i)          single-threaded. Photon maps, guiding structures and chains are shared state made here.
//   integrate(batch, ...)       many threads at once. It is const: shared state is read-only while rays are traced. A
//                               loop without a bound of its own calls services.leaving() and returns when that is
//                               true.
//   end_iteration(i)            single-threaded: takes in what the states of threads gathered.
//   save_state, restore_state   for checkpoints, when traits() declares state to save.
//   cuts()                      after the render: names paths that were cut for their length.
//
// An integrator that is not `synchronous()` gets the whole budget as iteration 0. A synchronous integrator gets one
// iteration for each block of samples of the whole image; all threads wait for one another between iterations.
//
// Random numbers come from the batch's samplers, keyed by named dimensions; use dimensions from first_free_dimension
// on. An integrator whose light paths land on any pixel (light tracing, Metropolis) declares the trait raster_splats
// and reports them through ThreadServices::raster. A batch of n camera rays then is n light paths too.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "display/services/registry.h"
#include "transport/integrators/integrator_parameters.h"
#include "transport/paths/counters.h"
#include "transport/paths/path_context.h"
#include "transport/paths/subpath.h"

namespace raylex::transport {

/// What prepare() gets; the pointers live as long as the render.
struct IntegratorContext : PathContext {
    std::uint32_t tiles = 1;  ///< number of tiles of the image; CameraBatch::tile is below it
};

/// Base of an integrator's per-thread state.
struct IntegratorThread {
    IntegratorThread() = default;
    /// For paths of at most `max_depth` scattering events; longer paths than 1,024 share the histogram's last slot.
    explicit IntegratorThread(std::uint32_t max_depth) {
        counters.path_lengths.assign(std::min(max_depth, 1024u) + 1, 0);
    }
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

class Integrator;

/// How the paths of an integrator may be planned where channels alone decide how rays are spent (path_plan.h).
struct PlanRequest {
    /// Makes an integrator that traces only the camera subpaths to be planned, for trials; empty: nothing is planned.
    std::function<std::unique_ptr<Integrator>()> make_trial;
    LightChoice light_choice = LightChoice::mis;
    bool lights_by_receiver = true;  ///< LightChooser::by_receiver()
    bool splits = false;             ///< paths may be split
    bool roulette = false;           ///< roulette may be played by what channels still expect
    Real roulette_below = 0;         ///< WalkOptions::roulette_below; 0: no ray may be left out at random
};

class Integrator {
  public:
    Integrator() = default;
    Integrator(const Integrator&) = delete;  // parts of an integrator point to its context
    Integrator& operator=(const Integrator&) = delete;
    virtual ~Integrator() = default;
    [[nodiscard]] virtual IntegratorTraits traits() const { return {}; }
    virtual Status prepare(const IntegratorContext& context) = 0;
    /// After prepare(): what of this scene the integrator does not find, as warnings for the user.
    [[nodiscard]] virtual std::vector<std::string> omissions() const { return {}; }
    /// After the render: which paths were cut for their length, and how many, as warnings for the user.
    [[nodiscard]] virtual std::vector<std::string> cuts() const { return {}; }
    /// Before prepare(): what the render may plan for the integrator's camera subpaths. By default nothing.
    [[nodiscard]] virtual PlanRequest plan_request() const { return {}; }
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
