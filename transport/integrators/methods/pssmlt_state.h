// Chains and per-thread state of the Metropolis integrator: private to pssmlt*.cpp.
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "display/services/samples/raster_splats.h"
#include "transport/integrators/methods/path.h"
#include "transport/integrators/methods/pssmlt.h"
#include "transport/samplers/primary_samples.h"

namespace raylex::transport {

/// What a state brings, position by position: its own first, then those that its light subpath was splatted to.
struct StateSplats {
    std::vector<Vec2> positions;  // on the raster
    std::vector<double> values;   // of every channel that takes splats, three numbers each, position by position

    void clear() { positions.clear(), values.clear(); }
};

/// One chain and the state that it is in.
struct MarkovChain {
    PrimarySamples numbers;
    StateSplats splats;  // of the state
    double f = 0;        // its scalar contribution
    double weight = 0;   // with which it is still to be splatted
    bool large = false;  // the proposal at hand
};

/// Takes in what bidirectional proposals splat, to be looked at before it is splatted itself.
class ProposalSplats final : public display::RasterSink {
  public:
    ProposalSplats(std::span<const display::ChannelId> channels, std::span<const display::ChannelId> target)
        : channels_(channels), target_(target) {}

    /// Of other proposals than these nothing is known: they have no splats.
    void begin(std::span<const display::CameraRow> proposals);
    void take(display::SampleTable& table) override;
    /// Of one proposal: its splats so far, their scalar contribution, and how many were refused.
    [[nodiscard]] const StateSplats& of(std::size_t proposal) const {
        return proposal < splats_.size() ? splats_[proposal] : none_;
    }
    [[nodiscard]] double scalar_contribution(std::size_t proposal) const {
        return proposal < contributions_.size() ? contributions_[proposal] : 0;
    }
    [[nodiscard]] std::uint32_t refused(std::size_t proposal) const {
        return proposal < refused_.size() ? refused_[proposal] : 0;
    }

  private:
    std::span<const display::ChannelId> channels_, target_;
    std::unordered_map<std::uint64_t, std::size_t> proposal_of_;  // CameraRow::sample
    const StateSplats none_;
    std::vector<StateSplats> splats_;
    std::vector<double> contributions_;
    std::vector<std::uint32_t> refused_;
};

/// The chains of one tile: advanced by one thread at a time.
struct ChainGroup {
    std::vector<MarkovChain> chains;
    std::vector<double> bootstrap;  // f of its bootstrap paths
    double large_sum = 0;           // of f over large steps
    std::uint64_t large_count = 0;
    std::size_t next = 0;  // chain whose turn it is
    bool started = false;
};

struct PssmltThread final : IntegratorThread {
    PssmltThread(const IntegratorContext& context, const Integrator& camera_part, const Integrator& path_part,
                 std::span<const display::ChannelId> channels, std::span<const display::ChannelId> target)
        : table(context.services.channels, context.batch_capacity),
          display(table),
          lpe(context.services.on(table)),
          proposal_splats(channels, target),
          raster(*context.services.lpe, context.services.channels, context.services.seed, context.services.attribution,
                 proposal_splats, table),
          camera(camera_part.make_thread_state()),
          path(path_part.make_thread_state()),
          rows(static_cast<std::size_t>(context.batch_capacity)),
          rays(rows.size()),
          samplers(rows.size()),
          bootstrap_numbers(rows.size()) {}

    /// Adds the counts of its parts.
    void take_counters() {
        counters.take(camera->counters);
        counters.take(path->counters);
    }

    // Paths of the chains on trial: they reach the image by splats only.
    display::SampleTable table;
    display::DisplayServices display;
    display::LpeServices lpe;
    ProposalSplats proposal_splats;
    display::RasterSplats raster;
    std::unique_ptr<IntegratorThread> camera, path;
    std::vector<display::CameraRow> rows;
    std::vector<Ray> rays;
    std::vector<PixelSampler> samplers;
    std::vector<PrimarySamples> bootstrap_numbers;
    StateSplats proposal;  // one that was not accepted
};

class Pssmlt final : public Integrator {
  public:
    explicit Pssmlt(const PssmltParameters& parameters);
    [[nodiscard]] IntegratorTraits traits() const override;
    Status prepare(const IntegratorContext& context) override;
    [[nodiscard]] std::vector<std::string> cuts() const override { return path_->cuts(); }
    [[nodiscard]] PlanRequest plan_request() const override { return path_->plan_request(); }
    [[nodiscard]] std::unique_ptr<IntegratorThread> make_thread_state() const override;
    [[nodiscard]] bool synchronous() const override { return true; }
    [[nodiscard]] bool starts_up() const override { return true; }
    void end_startup() override;
    void integrate(const CameraBatch& batch, IntegratorThread& thread, ThreadServices& services) const override;
    void end_iteration(std::uint64_t iteration, std::span<IntegratorThread* const> threads) override;

  private:
    void bootstrap(ChainGroup& group, std::uint32_t tile, PssmltThread& thread, ThreadServices& services) const;
    /// The first state of each chain of the group.
    void start(ChainGroup& group, std::uint32_t tile, PssmltThread& thread, ThreadServices& services) const;
    /// One step of `count` chains from group.next on.
    void step(ChainGroup& group, std::uint32_t tile, std::size_t count, PssmltThread& thread,
              ThreadServices& services) const;
    /// Puts the path of `numbers` into a row of the thread's table. `number`: of the chain, or of the bootstrap path,
    /// over all tiles; it makes the sample number unique.
    void begin_path(PssmltThread& thread, std::size_t row, PrimarySamples& numbers, std::uint64_t number) const;
    /// False when `services` say to leave: the paths are not whole then.
    [[nodiscard]] bool trace(PssmltThread& thread, std::size_t count, ThreadServices& services) const;
    /// The scalar contribution function of row i (Kelemen et al. 2002, I): mean size of the target's three colours.
    [[nodiscard]] double scalar_contribution(const PssmltThread& thread, std::size_t row) const;
    void copy_splats(const PssmltThread& thread, std::size_t row, StateSplats& splats) const;
    void splat(display::RasterSplats& raster, display::CameraRow where, double weight, const StateSplats& splats) const;
    [[nodiscard]] std::uint64_t stream(std::uint64_t purpose, std::uint64_t number) const;
    [[nodiscard]] std::size_t bootstrap_paths_of_tile() const;

    PssmltParameters parameters_;
    IntegratorContext context_;
    std::unique_ptr<Integrator> camera_, path_;
    std::vector<display::ChannelId> splatted_;  // expression channels
    std::vector<display::ChannelId> target_;
    geoaovs::GeometricAovs no_aovs_{std::span<const display::ChannelDefinition>()};
    Real left_ = 0, top_ = 0, across_ = 0, down_ = 0;  // of the raster where light still counts
    double area_share_ = 1;                            // of it over the image
    bool chains_ = true;                               // are run
    double mean_ = 0, bootstrap_mean_ = 0;             // b, and what the bootstrap alone made of it
    mutable std::vector<ChainGroup> groups_;           // [tile]; each has one thread at a time
};

}  // namespace raylex::transport
