// The interface of integrators.
//
// The engine passes camera rays in batches. Row i of the batch is row i of the thread's sample table. An integrator
// returns its results through the services only: it moves a tracker along each path, reports every contribution once,
// and writes distance, opacity, surface and geometric AOVs of first hits. No light path expression reaches an
// integrator.
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
//   end_iteration(i)            single-threaded: collects the results in the states of threads.
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
#include "transport/integrators/guide_request.h"
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
    /// For paths of at most `max_depth` scattering events. The histogram counts paths of more than 1,024 in its last
    /// slot.
    explicit IntegratorThread(std::uint32_t max_depth) {
        counters.path_lengths.assign(std::min(max_depth, 1024u) + 1, 0);
    }
    virtual ~IntegratorThread() = default;
    IntegratorCounters counters;
};

/// Whether an integrator has shared state that a resumed render needs.
enum class SavedState : std::uint8_t {
    unknown,  ///< not declared: renders with checkpoints are refused
    none,     ///< nothing lives longer than a batch: samples are functions of their numbers
    saved     ///< save_state() and restore_state(), between the iterations of a synchronous() integrator
};

/// The features that an integrator supports. A channel that needs a feature without support is refused before the
/// render.
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
    /// Every contribution is reported with its path string, as a path atlas needs. False: contributions are sums by
    /// channel.
    bool reports_path_strings = true;
    /// Light lands at raster positions of its own (ThreadServices::raster). Features that need samples of one pixel are
    /// then refused: layers of statistics, adaptive sampling, sample filters, deep images, and for light all rules but
    /// the pixel filter. Moments (ChannelDefinition::statistics) are not kept.
    bool raster_splats = false;
    /// With raster_splats: the integrator also finds light by camera samples. Layers of variance and adaptive sampling
    /// are then allowed. They describe this light alone, and moments are kept for it.
    bool pixel_samples = false;
    /// Closures are regularized: a specular material may scatter by the glossy lobe of the same name.
    bool regularizes = false;
    /// The integrator uses CameraBatch::weights. Without this trait, cameras whose rays have weights are refused
    /// (Camera::weighs_rays).
    bool camera_weights = false;
};

class Integrator;

/// A warning for the user about light that an integrator does not find, or finds otherwise than other integrators.
struct Omission {
    std::string text;
    bool is_declared = false;  ///< omitted_paths() has these paths
};

/// How the paths of an integrator may be planned where channels alone decide how rays are spent (path_plan.h).
struct PlanRequest {
    /// Makes an integrator for trial renders, which traces only the camera subpaths that are planned. Empty: nothing is
    /// planned.
    std::function<std::unique_ptr<Integrator>()> make_trial;
    LightChoice light_choice = LightChoice::mis;
    bool lights_by_receiver = true;  ///< LightChooser::by_receiver()
    bool splits = false;             ///< paths may be split
    bool roulette = false;           ///< roulette may use the light that channels may still receive
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
    /// After prepare(): returns warnings for the user about light of this scene that the integrator does not find.
    [[nodiscard]] virtual std::vector<Omission> omissions() const { return {}; }
    /// After the render: returns warnings for the user about paths that were cut for their length, with their number.
    [[nodiscard]] virtual std::vector<std::string> cuts() const { return {}; }
    /// Before prepare(): returns what the render may plan for the integrator's camera subpaths. By default nothing.
    [[nodiscard]] virtual PlanRequest plan_request() const { return {}; }
    /// Before prepare(): whether the render may learn the directions of the integrator's camera subpaths. By default
    /// not.
    [[nodiscard]] virtual GuideRequest guide_request() const { return {}; }
    [[nodiscard]] virtual std::unique_ptr<IntegratorThread> make_thread_state() const {
        return std::make_unique<IntegratorThread>();
    }
    [[nodiscard]] virtual bool synchronous() const { return false; }
    /// Whether the integrator takes samples before the image, such as the bootstrap of a Metropolis integrator.
    [[nodiscard]] virtual bool starts_up() const { return false; }
    virtual void end_startup() {}
    virtual void begin_iteration(std::uint64_t /*iteration*/) {}
    virtual void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const = 0;
    virtual void end_iteration(std::uint64_t /*iteration*/, std::span<IntegratorThread* const> /*threads*/) {}

    /// Only for SavedState::saved. save_state() appends to `bytes` all results of earlier iterations that this object
    /// holds. restore_state() reads them back after prepare(); the render then continues to the same bits as without
    /// interruption.
    virtual void save_state(std::string& /*bytes*/) const {}
    virtual Status restore_state(std::string_view /*bytes*/) { return success(); }
};

/// `max_depth` overrides the entity's "maxdepth".
using IntegratorFactory =
    std::function<Result<std::unique_ptr<Integrator>>(const SceneEntity&, std::optional<std::int64_t> max_depth)>;

/// The registry of integrators: path (also called volpath), lighttracer, bdpt, pssmlt, and those of plugins.
Registry<IntegratorFactory>& integrator_registry();

/// Counts and logs (Law 6) the power of a light subpath that is not finite, as a splat of `row`.
void reject_power(ThreadServices& services, const display::CameraRow& row, const Rgb& power);
/// The integrator of a render: `asked`, with each parameter of the scene's integrator that both types have and that
/// `asked` does not set, such as "maxdepth". Without `asked`, the scene's integrator.
SceneEntity integrator_for(const std::optional<SceneEntity>& asked, const SceneEntity& of_scene);

struct ChosenIntegrator {
    std::unique_ptr<Integrator> integrator;
    std::string name;
    std::vector<Error> warnings;
    std::optional<std::uint64_t> samples_per_pixel;  ///< number that the scene's integrator requests itself (mlt)
};
/// Chooses the integrator for an entity. If raylex has pbrt's integrator under another name, that one is chosen;
/// otherwise `path` is, and a warning states the difference. `volpath` means `path`, which supports media. An empty
/// type means `path`. An unknown name is an Error.
Result<ChosenIntegrator> choose_integrator(const SceneEntity& entity, std::optional<std::int64_t> max_depth);

}  // namespace raylex::transport
