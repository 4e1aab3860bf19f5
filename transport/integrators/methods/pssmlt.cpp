#include "transport/integrators/methods/pssmlt.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "display/services/split_mix.h"
#include "lpe/algebra/wording/event_words.h"
#include "transport/integrators/methods/bdpt.h"
#include "transport/integrators/methods/path.h"
#include "transport/integrators/path_contributions.h"
#include "transport/math/sampling.h"
#include "transport/samplers/primary_samples.h"

namespace raylex::transport {
namespace {

struct PssmltParameters {
    DepthParameters depth;
    Real large_step_probability = Real(0.3);  // p
    Real sigma = Real(0.01);                  // standard deviation of a small step, in each number of a path
    std::uint32_t chains = 1000;              // in all; at least one for each tile
    std::uint32_t bootstrap_samples = 100'000;
    bool bidirectional = false;       // chains walk over the paths of bdpt, otherwise over those of path
    std::vector<std::string> target;  // names of channels; empty: beauty, or all channels where there is none
    SourceLocation location;          // of the directive, for errors
};

struct MarkovChain {
    PrimarySamples numbers;  // u, and the mutation of it that is proposed
    PathContribution state;  // F(u)
    double scalar = 0;       // I(u)
    double weight = 0;       // with which the state is still to be splatted
    bool large = false;      // the proposal is a large step
};

/// The chains of one tile: one thread at a time advances them.
struct ChainGroup {
    std::uint64_t tile = 0;
    std::vector<MarkovChain> chains;
    std::size_t next = 0;  // the chain whose turn it is
    bool started = false;
    double large_sum = 0;  // of I over the large steps
    std::uint64_t large_count = 0;
    [[nodiscard]] std::uint64_t number(std::size_t chain) const { return path_number(tile, chains.size(), chain); }
};

struct PssmltThread final : IntegratorThread {
    PssmltThread(const IntegratorContext& context, const Integrator& seen, const Integrator& found,
                 const std::vector<display::ChannelId>& channels)
        : camera(seen.make_thread_state()), paths(context, found, channels), bootstrap(paths.size()) {}
    std::unique_ptr<IntegratorThread> camera;
    PathContributions paths;  // of proposals
    std::vector<PrimarySamples> bootstrap;
};

class Pssmlt final : public Integrator {
  public:
    explicit Pssmlt(const PssmltParameters& parameters);
    [[nodiscard]] IntegratorTraits traits() const override {
        IntegratorTraits traits;
        traits.max_depth = parameters_.depth.max_depth;
        traits.media = traits.first_hits = traits.cutouts = traits.user_events = traits.raster_splats = true;
        traits.reports_path_strings = false;  // chains keep what channels get of a path, and splat that again and again
        return traits;
    }
    Status prepare(const IntegratorContext& context) override;
    [[nodiscard]] std::vector<std::string> cuts() const override { return path_->cuts(); }
    [[nodiscard]] PlanRequest plan_request() const override { return path_->plan_request(); }
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override {
        return std::make_unique<PssmltThread>(context_, *camera_, *path_, channels_);
    }
    [[nodiscard]] bool synchronous() const override { return true; }
    [[nodiscard]] bool starts_up() const override { return true; }
    void end_startup() override;
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;
    void end_iteration(std::uint64_t iteration, std::span<IntegratorThread* const> threads) override;

  private:
    enum Purpose : std::uint64_t { of_bootstrap = 1, of_chain = 2, of_start = 3 };  // of a stream of draws
    enum Choice : std::uint32_t { accept_choice, large_choice };                    // of a chain in each step

    Status find_target();
    void bootstrap(std::uint32_t tile, PssmltThread& thread, ThreadServices& services) const;
    void walk(ChainGroup& group, std::size_t steps, PssmltThread& thread, ThreadServices& services) const;
    void start(ChainGroup& group, PssmltThread& thread, ThreadServices& services) const;
    void step(ChainGroup& group, std::size_t count, PssmltThread& thread, ThreadServices& services) const;
    /// Begins a mutation of `numbers`, and its path. `number` counts chains, or bootstrap paths, over all tiles.
    void propose(PathContributions& paths, std::size_t row, PrimarySamples& numbers, bool large,
                 std::uint64_t number) const {
        numbers.propose(large, parameters_.sigma);
        paths.begin(row, PixelSampler(numbers), sample_number(number, numbers.mutations()));
    }
    [[nodiscard]] double scalar_contribution(const PathContribution& f) const;
    [[nodiscard]] double balance_weight(double expected, double scalar) const {
        return expected / (scalar / b_ + static_cast<double>(parameters_.large_step_probability));
    }
    void splat(ThreadServices& services, display::CameraRow where, double weight, const PathContribution& f) const;
    [[nodiscard]] std::uint64_t stream(Purpose purpose, std::uint64_t number) const {
        return mix_bits(mix_bits(context_.services.seed + purpose * golden_gamma) ^ number);
    }

    PssmltParameters parameters_;
    IntegratorContext context_;
    std::unique_ptr<Integrator> camera_, path_;  // what camera rays see; the paths of the chains
    geoaovs::GeometricAovs no_aovs_{std::span<const display::ChannelDefinition>()};
    std::vector<display::ChannelId> channels_;  // that F is splatted to
    std::vector<std::size_t> target_;           // positions in channels_: those whose light is in I
    double area_share_ = 1;                     // of the raster area that paths are drawn over, over the image
    bool any_light_ = true;                     // some channel takes light that scatters: there are chains
    double b_ = 0;                              // normalisation
    double bootstrap_b_ = 0;                    // its estimate from the bootstrap alone
    std::size_t bootstrap_paths_ = 0;
    mutable std::vector<double> bootstrap_;   // I of each bootstrap path, until the start-up ends; a part for each tile
    mutable std::vector<ChainGroup> groups_;  // [tile]
};

/// Paths are not split: the numbers of a chain make one path.
PathParameters unsplit(const WalkOptions& options) {
    PathParameters parameters{options};
    parameters.splits = false;
    return parameters;
}

Pssmlt::Pssmlt(const PssmltParameters& parameters)
    : parameters_(parameters),
      camera_(make_path_integrator(unsplit({.max_depth = 0}))),
      path_(parameters.bidirectional ? make_bdpt_integrator({.depth = parameters.depth, .first_depth = 1})
                                     : make_path_integrator(unsplit({.max_depth = parameters.depth.max_depth,
                                                                     .roulette_below = parameters.depth.roulette_below,
                                                                     .first_depth = 1}))) {}

Status Pssmlt::prepare(const IntegratorContext& context) {
    context_ = context;
    channels_ = context.services.light_channels();
    if (Status target = find_target(); !target) return target;
    area_share_ = context.view.reached().share;
    any_light_ = parameters_.depth.max_depth > 0 && context.takes_scattered_light();
    const std::size_t tiles = context.tiles;
    bootstrap_paths_ = (parameters_.bootstrap_samples + tiles - 1) / tiles * tiles;
    bootstrap_.assign(bootstrap_paths_, 0);
    groups_ = std::vector<ChainGroup>(tiles);
    for (std::size_t tile = 0; tile < tiles; ++tile) {
        groups_[tile].tile = tile;
        groups_[tile].chains.resize(std::max<std::size_t>(1, (parameters_.chains + tiles / 2) / tiles));
    }
    if (Status camera = camera_->prepare(context); !camera) return camera;
    IntegratorContext of_paths = context;  // chains bring light and nothing else
    of_paths.first_hits.aovs = &no_aovs_;
    of_paths.first_hits.pattern_channels = false;
    return path_->prepare(of_paths);
}

Status Pssmlt::find_target() {
    const bool has_beauty = !context_.services.channels.empty() && context_.services.channels.front().name == "beauty";
    target_.resize(has_beauty ? 1 : channels_.size());  // beauty stands first
    std::iota(target_.begin(), target_.end(), std::size_t{0});
    if (parameters_.target.empty()) return success();
    target_.clear();
    std::vector<std::string> known;
    for (const display::ChannelId id : channels_)
        known.push_back(context_.services.channels[static_cast<std::size_t>(id)].name);
    for (const std::string& name : parameters_.target) {
        const auto found = std::find(known.begin(), known.end(), name);
        if (found == known.end())
            return error_at(parameters_.location,
                            "'target' names the channel '" + name +
                                "', which takes no light here; expected some of: " + lpe::joined_by(known, ", "),
                            near_miss(name, known));
        target_.push_back(static_cast<std::size_t>(found - known.begin()));
    }
    return success();
}

/// (1)
double Pssmlt::scalar_contribution(const PathContribution& f) const {
    double own = 0, splatted = 0;
    for (std::size_t i = 0; i < f.positions.size(); ++i) {
        double sum = 0;
        for (const std::size_t k : target_) {
            const double* value = &f.values[3 * (channels_.size() * i + k)];
            sum += std::abs(value[0]) + std::abs(value[1]) + std::abs(value[2]);
        }
        (i == 0 ? own : splatted) += sum / 3;
    }
    // What lands at a position drawn over the whole area counts area_share_ times; splats land where they do.
    return own + splatted / area_share_;
}

/// (6)
void Pssmlt::splat(ThreadServices& services, display::CameraRow where, double weight, const PathContribution& f) const {
    if (!(weight > 0)) return;
    for (std::size_t i = 0; i < f.positions.size(); ++i) {
        where.screen_x = to_float(f.positions[i].x);
        where.screen_y = to_float(f.positions[i].y);
        services.raster->add(where, i == 0 ? weight * area_share_ : weight, channels_,
                             &f.values[3 * channels_.size() * i]);
    }
}

/// I of the bootstrap paths of a tile.
void Pssmlt::bootstrap(std::uint32_t tile, PssmltThread& thread, ThreadServices& services) const {
    const std::size_t of_tile = bootstrap_paths_ / groups_.size(), end = (tile + 1) * of_tile;
    for (std::size_t first = tile * of_tile, count = 0; first < end; first += count) {
        count = std::min(thread.bootstrap.size(), end - first);
        for (std::size_t i = 0; i < count; ++i) {
            thread.bootstrap[i].restart(stream(of_bootstrap, first + i));
            propose(thread.paths, i, thread.bootstrap[i], true, first + i);
        }
        if (!thread.paths.follow(count, services)) return;
        for (std::size_t i = 0; i < count; ++i) bootstrap_[first + i] = scalar_contribution(thread.paths[i]);
    }
}

/// b, and the bootstrap path that each chain begins with: drawn in proportion to I, stratified over the chains.
void Pssmlt::end_startup() {
    if (!any_light_) return;
    std::vector<double> below = std::exchange(bootstrap_, {});
    std::partial_sum(below.begin(), below.end(), below.begin());
    const double sum = below.back();
    b_ = bootstrap_b_ = sum / static_cast<double>(below.size());  // (2)
    if (!(sum > 0)) return;                                       // nothing is lit: no chain has where to begin
    const auto chains = static_cast<double>(groups_.size() * groups_.front().chains.size());
    for (ChainGroup& group : groups_)
        for (std::size_t i = 0; i < group.chains.size(); ++i) {
            const std::uint64_t number = group.number(i);
            const double u = static_cast<double>(unit_float(mix_bits(stream(of_start, number))));
            const auto path =
                std::upper_bound(below.begin(), below.end() - 1, sum * ((static_cast<double>(number) + u) / chains));
            group.chains[i].numbers.restart(stream(of_bootstrap, static_cast<std::uint64_t>(path - below.begin())));
        }
}

/// The first states of the chains.
void Pssmlt::start(ChainGroup& group, PssmltThread& thread, ThreadServices& services) const {
    group.started = true;
    for (std::size_t first = 0, count = 0; first < group.chains.size(); first += count) {
        count = std::min(thread.paths.size(), group.chains.size() - first);
        for (std::size_t i = 0; i < count; ++i)
            propose(thread.paths, i, group.chains[first + i].numbers, true, group.number(first + i));
        if (!thread.paths.follow(count, services)) return;
        for (std::size_t i = 0; i < count; ++i) {
            MarkovChain& chain = group.chains[first + i];
            chain.numbers.accept();
            chain.numbers.switch_stream(stream(of_chain, (group.tile << 32) + first + i));
            chain.scalar = scalar_contribution(thread.paths[i]);
            std::swap(chain.state, thread.paths[i]);
        }
    }
}

/// One step of `count` chains, from group.next on.
void Pssmlt::step(ChainGroup& group, std::size_t count, PssmltThread& thread, ThreadServices& services) const {
    const auto turn = [&](std::size_t i) { return (group.next + i) % group.chains.size(); };
    for (std::size_t i = 0; i < count; ++i) {
        MarkovChain& chain = group.chains[turn(i)];
        chain.large = chain.numbers.choose(large_choice) < parameters_.large_step_probability;
        propose(thread.paths, i, chain.numbers, chain.large, group.number(turn(i)));
    }
    if (!thread.paths.follow(count, services)) return;
    for (std::size_t i = 0; i < count; ++i) {
        MarkovChain& chain = group.chains[turn(i)];
        PathContribution& proposal = thread.paths[i];
        thread.paths.report_refused(i, services);
        const double scalar = scalar_contribution(proposal);                               // (1)
        if (chain.large) group.large_sum += scalar, ++group.large_count;                   // (2)
        const double a = chain.scalar > 0 ? std::min(1.0, scalar / chain.scalar) : 1.0;    // (3)
        const double proposal_weight = balance_weight(a + (chain.large ? 1 : 0), scalar);  // (4)
        chain.weight += balance_weight(1 - a, chain.scalar);                               // (5)
        if (static_cast<double>(chain.numbers.choose(accept_choice)) < a) {
            splat(services, thread.paths.row(i), chain.weight, chain.state);
            chain.numbers.accept();
            chain.scalar = scalar;
            chain.weight = proposal_weight;
            std::swap(chain.state, proposal);
        } else {
            chain.numbers.reject();
            splat(services, thread.paths.row(i), proposal_weight, proposal);
        }
    }
    group.next = turn(count);
}

/// So many steps, which the chains of a tile take in turn.
void Pssmlt::walk(ChainGroup& group, std::size_t steps, PssmltThread& thread, ThreadServices& services) const {
    if (!group.started && !services.left) start(group, thread, services);
    for (std::size_t count = 0; steps > 0 && !services.left; steps -= count) {
        count = std::min({steps, group.chains.size(), thread.paths.size()});
        step(group, count, thread, services);
    }
    if (services.left) return;
    for (MarkovChain& chain : group.chains)  // whoever looks at the image finds every step in it
        splat(services, {}, std::exchange(chain.weight, 0), chain.state);
}

void Pssmlt::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<PssmltThread&>(state);
    if (batch.startup) {
        services.display.discard_iteration();
        if (any_light_) bootstrap(batch.tile, thread, services);
    } else {
        camera_->integrate(batch, *thread.camera, services);
        if (!any_light_ && parameters_.depth.max_depth > 0 && context_.events->any())
            thread.counters.leave_out_paths(batch.rays.size());
        if (b_ > 0) walk(groups_[batch.tile], batch.rays.size(), thread, services);
    }
    thread.counters.take(thread.camera->counters);
    thread.counters.take(thread.paths.counters());
}

void Pssmlt::end_iteration(std::uint64_t /*iteration*/, std::span<IntegratorThread* const> /*threads*/) {
    double count = static_cast<double>(bootstrap_paths_), sum = bootstrap_b_ * count;
    for (const ChainGroup& group : groups_) {
        sum += group.large_sum;
        count += static_cast<double>(group.large_count);
    }
    b_ = sum / count;  // (2)
}

Result<std::unique_ptr<Integrator>> make_pssmlt(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    IntegratorParameters read(entity);
    PssmltParameters p;
    p.depth = read_depth_parameters(read, max_depth);
    p.large_step_probability = read.fraction("largestepprobability", Real(0.3),
                                             ": without large steps a chain may never leave where it began");
    p.sigma = read.fraction("sigma", Real(0.01));
    p.chains = static_cast<std::uint32_t>(read.integer("chains", 1000, 1, 1'000'000));
    p.bootstrap_samples = static_cast<std::uint32_t>(read.integer("bootstrapsamples", 100'000, 1, 1'000'000'000));
    p.bidirectional = read.choice("integrator", {"path", "bdpt"}, 0) == 1;
    const std::string target = read.string("target", "beauty");
    if (read.error()) return *read.error();
    for (std::size_t begin = 0; begin <= target.size() && target != "beauty";) {
        const std::size_t end = std::min(target.find(',', begin), target.size());
        if (end == begin)
            return error_at(entity.location,
                            "'target' is '" + target + "'; expected beauty, or names of channels between commas");
        p.target.push_back(target.substr(begin, end - begin));
        begin = end + 1;
    }
    p.location = entity.location;
    return std::unique_ptr<Integrator>(std::make_unique<Pssmlt>(p));
}

}  // namespace

Registry<IntegratorFactory>::Entry pssmlt_entry() {
    using T = ParameterType;
    return {"pssmlt",
            "Metropolis light transport in primary sample space, over path or bdpt",
            {describe_max_depth(),
             {"largestepprobability", T::real, "0.3", "share of steps that draw a new path"},
             {"sigma", T::real, "0.01", "standard deviation of the other steps, in each number of the path"},
             {"chains", T::integer, "1000", "Markov chains; at least one is run for each 16 x 16 tile"},
             {"bootstrapsamples", T::integer, "100000",
              "paths drawn before the image, for its brightness and where chains begin"},
             describe_roulette("paths"),
             describe_roulette_threshold(),
             {"integrator", T::string, "path", "whose paths the chains walk over: path or bdpt"},
             {"target", T::string, "beauty",
              "what chains spend their steps on: beauty, or channels of light path expressions between commas"}},
            make_pssmlt};
}

}  // namespace raylex::transport
