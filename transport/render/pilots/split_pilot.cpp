#include "transport/render/pilots/split_pilot.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "transport/render/pilots/pilot_paths.h"

namespace raylex::transport {
namespace {

constexpr std::uint32_t grid = PilotPaths::grid, fewest_rounds = 16, most_rounds = 128;
constexpr std::uint64_t most_pilot_rays = 250'000;
constexpr std::uint32_t enough_finds = 128;
constexpr std::array<std::uint8_t, 5> ray_counts{1, 2, 4, 8, 16};
constexpr std::uint8_t most_both_lobes = 2;
constexpr double dearest_lobes = 1.15;  // than one of each pair

/// What one way to follow paths brings: [channel][pixel of the grid] of the last round.
struct SplitTrial {
    PathTrial path;
    std::unique_ptr<IntegratorThread> thread;
    std::vector<double> found;
    [[nodiscard]] double cost() const { return pilot_cost(thread->counters); }
    [[nodiscard]] std::uint64_t rays() const { return pilot_rays(thread->counters); }
};

/// Of one channel: sums over rounds, and over pixels in the end.
struct Sums {
    std::vector<double> pixel, pixel_squares;  // of a round's mean of two rays
    double both = 0, difference = 0;           // products and squared differences of two rays
    std::uint32_t finds = 0;
};

/// Of all channels, each relative to its mean.
struct Variances {
    double before = 0, behind = 0;
};

/// Of a path, before its split and of each ray behind it.
struct Costs {
    double before = 0, behind = 0;
    [[nodiscard]] double of(std::uint8_t rays) const { return before + rays * behind; }
};

class SplitPilot {
  public:
    SplitPilot(const IntegratorContext& context, const PathTrials& trials) : trials_(trials), paths_(context) {}

    /// Values without throughput count paths as they are drawn: one of each sample.
    [[nodiscard]] bool counts_paths() const { return paths_.count_alike(); }
    void run();
    /// Of n rays, after run().
    [[nodiscard]] double cost_times_variance(std::uint8_t rays) const { return costs_.of(rays) * variance(rays); }
    [[nodiscard]] double variance(std::uint8_t rays) const { return variances_.before + variances_.behind / rays; }
    /// Where `both_lobes` specular vertices reflect and transmit.
    [[nodiscard]] Costs costs(std::uint8_t both_lobes);
    [[nodiscard]] const Costs& costs() const { return costs_; }
    /// That were traced so far.
    [[nodiscard]] std::uint64_t rays() const { return rays_; }

  private:
    [[nodiscard]] SplitTrial make(std::uint8_t both_lobes, SplitPlan::Only only) const;
    void follow(SplitTrial& trial);
    void add(const SplitTrial& none, const SplitTrial& first, const SplitTrial& second);
    [[nodiscard]] std::uint32_t finds() const;
    void find_variances();

    const PathTrials& trials_;
    PilotPaths paths_;
    std::vector<Sums> sums_;  // [channel]
    std::uint32_t rounds_ = 0;
    Variances variances_;
    Costs costs_;
    std::uint64_t rays_ = 0;
};

SplitTrial SplitPilot::make(std::uint8_t both_lobes, SplitPlan::Only only) const {
    SplitTrial trial;
    trial.path = trials_.make({2, both_lobes, only});
    trial.thread = trial.path.integrator->make_thread_state();
    trial.found.resize(paths_.channels().size() * grid * grid);
    return trial;
}

void SplitPilot::follow(SplitTrial& trial) {
    paths_.follow(*trial.path.integrator, *trial.thread, [&](std::size_t first, std::size_t count) {
        for (std::size_t c = 0; c < paths_.channels().size(); ++c)
            for (std::size_t i = 0; i < count; ++i) trial.found[c * grid * grid + first + i] = paths_.value(c, i);
    });
}

void SplitPilot::add(const SplitTrial& none, const SplitTrial& first, const SplitTrial& second) {
    for (std::size_t c = 0; c < paths_.channels().size(); ++c)
        for (std::size_t pixel = 0; pixel < std::size_t{grid} * grid; ++pixel) {
            const std::size_t at = c * grid * grid + pixel;
            // Each ray carries half of what lies behind.
            const double before = none.found[at], a = 2 * first.found[at] - before, b = 2 * second.found[at] - before;
            Sums& sums = sums_[c];
            sums.finds += a != before ? 1 : 0;
            sums.finds += b != before ? 1 : 0;
            sums.both += a * b;
            sums.difference += (a - b) * (a - b);
            const double mean = (a + b) / 2;
            sums.pixel[pixel] += mean;
            sums.pixel_squares[pixel] += mean * mean;
        }
}

std::uint32_t SplitPilot::finds() const {
    std::uint32_t fewest = ~0u;
    for (const Sums& sums : sums_)
        if (sums.finds > 0) fewest = std::min(fewest, sums.finds);
    return fewest == ~0u ? 0 : fewest;
}

void SplitPilot::run() {
    SplitTrial none = make(0, SplitPlan::Only::none), first = make(0, SplitPlan::Only::first),
               second = make(0, SplitPlan::Only::second);
    sums_.assign(paths_.channels().size(), Sums{std::vector<double>(grid * grid), std::vector<double>(grid * grid)});
    const std::uint32_t most = std::max(paths_.most_rounds(most_rounds), fewest_rounds);
    for (rounds_ = 0; rounds_ < most; ++rounds_) {
        const std::uint64_t rays = none.rays() + first.rays() + second.rays();
        if (rounds_ >= fewest_rounds && (finds() >= enough_finds || rays >= most_pilot_rays)) break;
        paths_.begin(rounds_);
        for (SplitTrial* each : {&none, &first, &second}) follow(*each);
        add(none, first, second);
    }
    for (const SplitTrial* each : {&none, &first, &second}) rays_ += each->rays();
    const double paths = double{grid} * grid * rounds_;
    costs_.before = none.cost() / paths;
    costs_.behind = (first.cost() + second.cost()) / (2 * paths) - costs_.before;
    find_variances();
}

Costs SplitPilot::costs(std::uint8_t both_lobes) {
    SplitTrial trial = make(both_lobes, SplitPlan::Only::first);
    for (std::uint32_t round = 0; round < fewest_rounds; ++round) {
        paths_.begin(round);
        follow(trial);
    }
    rays_ += trial.rays();
    return {costs_.before, trial.cost() / (double{grid} * grid * fewest_rounds) - costs_.before};
}

void SplitPilot::find_variances() {
    variances_ = {};
    const double rounds = rounds_, paths = double{grid} * grid * rounds;
    for (const Sums& sums : sums_) {
        double total = 0, squared_means = 0;
        for (std::size_t pixel = 0; pixel < sums.pixel.size(); ++pixel) {
            total += sums.pixel[pixel];
            // Without bias: of different paths only.
            squared_means +=
                (sums.pixel[pixel] * sums.pixel[pixel] - sums.pixel_squares[pixel]) / (rounds * (rounds - 1));
        }
        const double mean = total / paths;
        if (!(mean > 0)) continue;
        const double scale = 1 / (mean * mean);
        variances_.behind += sums.difference / (2 * paths) * scale;
        // Two rays of one path that both find something are rarer still than what they find: as if there had been one.
        const double before = std::max(sums.both / paths - squared_means / (double{grid} * grid),
                                       sums.difference / (2 * paths) / sums.finds);
        variances_.before += before * scale;
    }
}

SplitChoice choose(SplitPilot& pilot) {
    SplitChoice choice;
    SplitPlan& best = choice.plan;
    if (pilot.counts_paths()) return choice;
    pilot.run();
    if (!(pilot.costs().behind > 0)) return choice;  // nothing is split
    double least = pilot.cost_times_variance(1);
    for (const std::uint8_t count : ray_counts) {
        const double product = pilot.cost_times_variance(count);
        if (!(product < 0.9 * least)) continue;
        least = product;
        best.rays = count;
    }
    choice.noise = pilot.variance(best.rays) / pilot.variance(1);
    // Both lobes are never noisier than one of them. What the rarer one brings is too rare for a pilot to weigh.
    double spent = pilot.costs().of(best.rays), behind = pilot.costs().behind;
    for (std::uint8_t lobes = 1; lobes <= most_both_lobes; ++lobes) {
        const Costs costs = pilot.costs(lobes);
        if (!(costs.behind > behind) || costs.of(best.rays) > dearest_lobes * spent) break;
        spent = costs.of(best.rays);
        behind = costs.behind;
        best.both_lobes = lobes;
    }
    return choice;
}

}  // namespace

SplitChoice choose_splits(const IntegratorContext& context, const PathTrials& trials, std::uint64_t& rays) {
    SplitPilot pilot(context, trials);
    const SplitChoice choice = choose(pilot);
    rays += pilot.rays();
    return choice;
}

}  // namespace raylex::transport
