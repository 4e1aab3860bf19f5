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

/// One way to follow paths.
struct SplitTrial {
    PathTrial path;
    std::unique_ptr<IntegratorThread> thread;
    [[nodiscard]] double cost() const { return pilot_cost(thread->counters); }
    [[nodiscard]] std::uint64_t rays() const { return pilot_rays(thread->counters); }
};

/// Sums of one channel, over rounds and in the end over pixels.
struct Sums {
    std::vector<double> pixel, pixel_squares;  // of a round's mean of two rays
    double both = 0, difference = 0;           // products and squared differences of two rays
    std::uint32_t finds = 0;
};

/// Variances of all channels, each relative to its mean.
struct Variances {
    double before = 0, behind = 0;
};

/// Costs of a path up to its split, and of each ray behind it.
struct Costs {
    double before = 0, behind = 0;
    [[nodiscard]] double of(std::uint8_t rays) const { return before + rays * behind; }
};

class SplitPilot {
  public:
    SplitPilot(const IntegratorContext& context, const PathTrials& trials) : trials_(trials), paths_(context) {}

    /// Whether values count paths as they are drawn: then splits must not change their number.
    [[nodiscard]] bool counts_paths() const { return paths_.count_alike(); }
    void run();
    /// Of a plan with so many rays, after run().
    [[nodiscard]] double cost_times_variance(std::uint8_t rays) const { return costs_.of(rays) * variance(rays); }
    [[nodiscard]] double variance(std::uint8_t rays) const { return variances_.before + variances_.behind / rays; }
    /// Costs where both lobes of up to `both_lobes` specular vertices are followed.
    [[nodiscard]] Costs costs(std::uint8_t both_lobes);
    [[nodiscard]] const Costs& costs() const { return costs_; }
    /// Number of rays traced so far.
    [[nodiscard]] std::uint64_t rays() const { return rays_; }

  private:
    [[nodiscard]] SplitTrial make(std::uint8_t both_lobes, SplitPlan::Only only) const;
    template <class Visit>
    void follow(SplitTrial& trial, Visit visit) {
        paths_.follow(*trial.path.integrator, *trial.thread, visit);
    }
    void add(std::size_t pixel, const LaterRadiance::Path& path);
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
    trial.path = trials_.make({.rays = 2, .both_lobes = both_lobes, .only = only});
    trial.thread = trial.path.integrator->make_thread_state();
    return trial;
}

/// What two rays bring that a path was split into: each as if it were alone, with all that lies behind.
void SplitPilot::add(std::size_t pixel, const LaterRadiance::Path& path) {
    std::size_t split = 0;
    while (split < path.vertices.size() && !path.vertices[split].split) ++split;
    for (std::size_t c = 0; c < paths_.channels(); ++c) {
        const double before = split < path.vertices.size() ? path.before(split, c) : path.received[c];
        std::array<double, 2> found{before, before};
        std::size_t ray = 0;
        for (std::size_t i = split; i < path.vertices.size(); ++i)
            if (path.vertices[i].depth == path.vertices[split].depth)
                found[ray++] += 2 * path.behind(i, c);  // each ray carries half of what lies behind
        const auto [a, b] = found;
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
    SplitTrial none = make(0, SplitPlan::Only::none), both = make(0, SplitPlan::Only::all);
    sums_.assign(paths_.channels(), Sums{std::vector<double>(grid * grid), std::vector<double>(grid * grid)});
    const std::uint32_t most = std::max(paths_.most_rounds(most_rounds), fewest_rounds);
    for (rounds_ = 0; rounds_ < most; ++rounds_) {
        const std::uint64_t rays = 2 * none.rays() + both.rays();  // as if each of the two were followed alone
        if (rounds_ >= fewest_rounds && (finds() >= enough_finds || rays >= most_pilot_rays)) break;
        paths_.begin(rounds_);
        follow(none, [](std::size_t, const LaterRadiance::Path&) {});
        follow(both, [&](std::size_t pixel, const LaterRadiance::Path& path) { add(pixel, path); });
    }
    rays_ = none.rays() + both.rays();
    const double paths = double{grid} * grid * rounds_;
    costs_.before = none.cost() / paths;
    costs_.behind = (both.cost() - none.cost()) / (2 * paths);
    find_variances();
}

Costs SplitPilot::costs(std::uint8_t both_lobes) {
    SplitTrial trial = make(both_lobes, SplitPlan::Only::first);
    for (std::uint32_t round = 0; round < fewest_rounds; ++round) {
        paths_.begin(round);
        follow(trial, [](std::size_t, const LaterRadiance::Path&) {});
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
