#include "transport/render/pilots/roulette_pilot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace raylex::transport {
namespace {

constexpr std::size_t cells = std::size_t{PilotPaths::grid} * PilotPaths::grid;

/// A path that leaves a vertex.
struct Departure {
    std::uint32_t state = 0;  // its number
    double throughput = 0;
    bool split = false;
    std::size_t behind = 0;  // in values_: what channels received from then on
};

/// Sums over all departures in one state.
struct StateSums {
    double squares = 0, departures_behind = 0;
    std::uint32_t departures = 0, finds = 0;
    [[nodiscard]] double square() const { return squares / departures; }
    [[nodiscard]] double root_of_gain() const { return std::sqrt(square() * departures / departures_behind); }
};

struct Product {
    double cost = 0, variance = 0;  // the variance that roulette adds
};

class RoulettePilot {
  public:
    RoulettePilot(const IntegratorContext& context, const PathTrials& trials, const SplitChoice& splits, Real below)
        : paths_(context),
          trial_(trials.make({}, true)),
          thread_(trial_.integrator->make_thread_state()),
          rays_(splits.plan.rays),
          noise_(splits.noise),
          below_(static_cast<double>(below)),
          channels_(paths_.channels()) {}

    [[nodiscard]] RouletteTable run();
    [[nodiscard]] std::uint64_t rays() const { return pilot_rays(thread_->counters); }

  private:
    static constexpr std::uint32_t first_rounds = 8, most_rounds = 32;
    static constexpr std::uint64_t most_rays = 80'000;
    static constexpr std::size_t most_values = std::size_t{1} << 21;  // 16 MB
    /// After so many finds a mean square is known to a third.
    static constexpr std::uint32_t enough_finds = 32;
    static constexpr double promising = 0.95, worthwhile = 0.9;
    /// Of the strength that is best where what roulette adds to the variance is little.
    static constexpr std::array<double, 6> scales{0.5, 1, 2, 4, 8, 16};
    /// How much of a pilot's variance an image has: a cell of the pilot is larger than a pixel, and a pixel's samples
    /// are one sequence. A rule has to pay at both ends.
    static constexpr std::array<double, 2> shares_of_variance{1, 0.25};

    struct Path {
        std::size_t first, count;  // of departures_
        std::size_t cell, values;  // values: in values_, what channels received of it
    };
    [[nodiscard]] bool dear_enough() const { return rays() >= most_rays || values_.size() >= most_values; }
    void follow(std::uint32_t round);
    void keep(std::size_t cell, const LaterRadiance::Path& path);
    void weigh();
    void find_states();
    [[nodiscard]] Product follow_by(double strength) const;
    [[nodiscard]] double chance(const Departure& departure, double throughput, std::size_t depth,
                                double strength) const;
    /// The strength with the least products of cost and variance; 0: throughput alone does as well.
    [[nodiscard]] double find_best();

    PilotPaths paths_;
    PathTrial trial_;
    std::unique_ptr<IntegratorThread> thread_;
    const double rays_, noise_, below_;
    const std::size_t channels_;
    std::map<std::uint64_t, std::uint32_t> numbers_;  // of states
    std::vector<Departure> departures_;               // path after path
    std::vector<double> values_;
    std::vector<Path> followed_;
    std::vector<double> weights_;  // [channel][cell], of squares
    double variance_ = 0;          // of paths that do not end at random, as weighed
    std::vector<StateSums> states_;
    bool promises_ = false;  // some rule looks so good that more paths are worth following
};

void RoulettePilot::follow(std::uint32_t round) {
    paths_.begin(round);
    paths_.follow(*trial_.integrator, *thread_,
                  [&](std::size_t cell, const LaterRadiance::Path& path) { keep(cell, path); });
}

void RoulettePilot::keep(std::size_t cell, const LaterRadiance::Path& path) {
    const std::size_t first = departures_.size();
    for (std::size_t i = 0; i < path.vertices.size(); ++i) {
        const PassedVertex& vertex = path.vertices[i];
        const auto number = static_cast<std::uint32_t>(numbers_.size());
        departures_.push_back({numbers_.try_emplace(vertex.state, number).first->second,
                               static_cast<double>(vertex.strength), vertex.split, values_.size()});
        for (std::size_t c = 0; c < channels_; ++c) values_.push_back(path.behind(i, c));
    }
    followed_.push_back({first, path.vertices.size(), cell, values_.size()});
    values_.insert(values_.end(), path.received, path.received + channels_);
}

/// Squares count relative to the mean of their cell, where that is more than the image's: few paths know a dim cell.
void RoulettePilot::weigh() {
    weights_.assign(channels_ * cells, 0);
    variance_ = 0;
    const double paths = static_cast<double>(followed_.size()), rounds = paths / cells;
    for (std::size_t c = 0; c < channels_; ++c) {
        std::array<double, cells> sums{}, squares{};
        double mean = 0;
        for (const Path& path : followed_) {
            const double value = values_[path.values + c];
            sums[path.cell] += value;
            squares[path.cell] += value * value;
            mean += value / paths;
        }
        if (!(mean > 0)) continue;
        for (std::size_t cell = 0; cell < cells; ++cell) {
            const double of_cell = sums[cell] / rounds, weight = 1 / (of_cell * of_cell + mean * mean);
            weights_[c * cells + cell] = weight;
            variance_ += weight * (squares[cell] - sums[cell] * of_cell) / (rounds - 1) / cells;
        }
    }
}

void RoulettePilot::find_states() {
    states_.assign(numbers_.size(), {});
    for (const Path& path : followed_)
        for (std::size_t i = 0; i < path.count; ++i) {
            const Departure& departure = departures_[path.first + i];
            double square = 0;
            for (std::size_t c = 0; c < channels_; ++c) {
                const double behind = values_[departure.behind + c] / departure.throughput;
                square += weights_[c * cells + path.cell] * behind * behind;
            }
            StateSums& state = states_[departure.state];
            state.squares += square;
            state.departures_behind += static_cast<double>(path.count - i);
            ++state.departures;
            state.finds += square > 0 ? 1 : 0;
        }
}

double RoulettePilot::chance(const Departure& departure, double throughput, std::size_t depth, double strength) const {
    const StateSums& state = states_[departure.state];
    if (strength > 0 && state.finds >= enough_finds)
        return std::clamp(strength * state.root_of_gain() * throughput / (departure.split ? rays_ : 1),
                          static_cast<double>(RouletteTable::least_chance), 1.0);
    return depth < 2 ? 1 : std::min(1.0, throughput / below_);
}

/// `strength` 0: plain roulette.
Product RoulettePilot::follow_by(double strength) const {
    Product sums;
    const double paths = static_cast<double>(followed_.size());
    const double departure_cost =
        (pilot_cost(thread_->counters) - camera_ray_cost * paths) / static_cast<double>(departures_.size());
    for (const Path& path : followed_) {
        double reached = 1;
        for (std::size_t i = 0; i < path.count; ++i) {
            const Departure& departure = departures_[path.first + i];
            const double rays = departure.split ? rays_ : 1;
            const double throughput = departure.throughput / reached;  // of survivors
            const double goes_on = chance(departure, throughput, i + 1, strength);
            sums.variance +=
                reached * throughput * throughput * states_[departure.state].square() * (1 / goes_on - 1) / rays;
            reached *= goes_on;
            sums.cost += departure_cost * rays * reached;
        }
    }
    return {camera_ray_cost + sums.cost / paths, sums.variance / paths};
}

double RoulettePilot::find_best() {
    weigh();
    find_states();
    const double variance = noise_ * variance_;
    if (departures_.empty() || !(variance > 0)) return 0;
    const Product plain = follow_by(0);
    double least = 1, best = 0;
    promises_ = false;
    for (const double scale : scales) {
        const double strength = scale * std::sqrt(plain.cost / variance);
        const Product product = follow_by(strength);
        double both = 1, worst = 0;
        for (const double share : shares_of_variance) {
            const double saved = product.cost * (share * variance + product.variance) /
                                 (plain.cost * (share * variance + plain.variance));
            both *= saved;
            worst = std::max(worst, saved);
        }
        promises_ = promises_ || worst < promising;
        if (worst < worthwhile && both < least) least = both, best = strength;
    }
    return best;
}

RouletteTable RoulettePilot::run() {
    double strength = 0;
    const std::uint32_t most = std::max(paths_.most_rounds(most_rounds), first_rounds);
    for (std::uint32_t round = 0, enough = first_rounds; round < most;) {
        for (; round < std::min(enough, most) && !dear_enough(); ++round) follow(round);
        strength = find_best();
        if (!promises_ || round < std::min(enough, most)) break;
        enough *= 2;
    }
    RouletteTable table;
    if (!(strength > 0)) return table;
    for (const auto& [state, number] : numbers_)
        if (states_[number].finds >= enough_finds)
            table.add(state, static_cast<Real>(strength * states_[number].root_of_gain()));
    return table;
}

}  // namespace

RouletteTable choose_roulette(const IntegratorContext& context, const PathTrials& trials, const SplitChoice& splits,
                              Real below, std::uint64_t& rays) {
    if (!context.events->liveness().is_known() || context.events->wants_user()) return {};
    RoulettePilot pilot(context, trials, splits, below);
    RouletteTable table = pilot.run();
    rays += pilot.rays();
    return table;
}

}  // namespace raylex::transport
