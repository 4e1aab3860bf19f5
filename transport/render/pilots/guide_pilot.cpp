#include "transport/render/pilots/guide_pilot.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "display/services/processor.h"
#include "display/services/split_mix.h"
#include "display/services/thread_or_none.h"
#include "transport/paths/guide/guide_gains.h"
#include "transport/paths/guide/guide_sums.h"
#include "transport/render/clock.h"
#include "transport/render/pilots/pilot_paths.h"

namespace raylex::transport {
namespace {

constexpr int tile_side = 8;
constexpr std::uint64_t paths_of_training = 1u << 23;  // unless fewer are a quarter of the render
constexpr std::uint64_t fewest_samples = 4;            // of a pixel: fewer do not show what pays
// `auto` decides from the eighth training sample of each pixel on, because the round before has learned how many rays
// leave a vertex. Eight training samples cost as much as 10 to 23 plain ones: at most 4.5 % of a render of 512.
constexpr std::uint64_t shortest_automatic = 512, fewest_automatic = 8;
constexpr std::uint32_t first_deciding_round = 3;
constexpr std::uint64_t most_samples = 4096;    // of a pixel: all samples of a tile and a round are in memory
constexpr std::uint64_t finds_of_region = 600;  // records with light, those of neighbours included
constexpr std::size_t guide_bytes = std::size_t{64} << 20;  // sums of a round and the tree of the next included
// Cost of a vertex whose direction the guide may draw, beside that of its ray, relative to a scattering ray
// (pilot_cost()); measured on glass-fixtures and door-ajar.
constexpr double guide_vertex_cost = 0.6;
// A region's share is chosen as if it were less: most of the cost is spent whether regions use the guide or not.
constexpr double guide_share_cost = 1.02;
// `auto` goes on with these gains at least: after eight samples of each pixel, whose forecasts are often too high,
// after later rounds, and after the last one, when the time of the training is spent.
constexpr double worthwhile_at_first = 1.3, worthwhile = 1, worthwhile_at_last = 0.95;
// It decides in the last rounds, from a sixteenth of the training on. Where a smaller part of the departures than
// rare_finds leads to light, the first rounds find too little for a forecast: there it decides from half of the
// training on. With no find at all, there may be nothing to find.
constexpr std::uint32_t deciding_rounds = 5, deciding_rounds_if_rare = 2;
constexpr double rare_finds = 0.125;
constexpr double most_unlikely = 1e4;

/// Sums over the paths through a tile of the image.
struct GuideTile {
    display::PixelRegion pixels;
    std::vector<double> received;  // [channel] in all rounds
    std::vector<double> weights;   // [channel] of squares: over the square of the mean there
    std::uint64_t paths = 0, guidable = 0,
                  finds = 0;  // guidable: departures in round 0; finds: those that led to light
    // Of one round, in these weights: squares as drawn, as expected without the guide, and of the pixels' means.
    double guided = 0, unguided = 0, of_means = 0;
    LaterLight later;  // of one round
};

struct GuideWorker {
    GuideWorker(const IntegratorContext& context, std::vector<display::ChannelId> channels)
        : paths(context, std::move(channels)) {}
    PilotPaths paths;
    std::unique_ptr<IntegratorThread> plain, guided;
    std::uint64_t departures = 0;  // in this round, from vertices where the guide may draw the direction
    std::vector<double> unguided;  // [vertex] of a path: density of the closure over that of the draw, inverted
    std::vector<double> sums, squares;
};

class GuidePilot {
  public:
    GuidePilot(const IntegratorContext& context, const GuideTraining& training);
    TrainedGuide run();

  private:
    [[nodiscard]] std::unique_ptr<Integrator> make_integrator(const DirectionSampler* directions);
    [[nodiscard]] std::uint32_t last_in_time(std::uint32_t round, std::uint32_t last, double elapsed) const;
    /// False: the render has to end.
    bool follow(std::uint32_t round);
    void follow_tile(GuideTile& tile, GuideWorker& worker);
    void learn(GuideTile& tile, GuideWorker& worker, std::uint64_t row, const LaterRadiance::Path& path);
    void weigh();
    [[nodiscard]] double cost(bool guided) const;
    [[nodiscard]] double gain() const;
    [[nodiscard]] bool learns_gains() const;
    void refine(bool final);
    void summarize(TrainedGuide& trained) const;

    IntegratorContext context_;  // without AOVs
    const GuideTraining& training_;
    geoaovs::GeometricAovs no_aovs_{std::span<const display::ChannelDefinition>()};
    std::unique_ptr<Guide> guide_;
    std::unique_ptr<GuideSums> sums_;
    std::unique_ptr<GainSums> gain_sums_;  // null: gains are not learned
    std::unique_ptr<Integrator> plain_, guided_;
    std::vector<std::unique_ptr<GuideWorker>> workers_;
    std::vector<GuideTile> tiles_;
    IntegratorCounters before_;  // of guided paths in the rounds before
    std::atomic<bool> leave_{false};
    double mean_ = 0;  // of the image, in the first channel
    bool light_is_rare_ = false;
    double finds_of_path_ = 1e-3;                      // records with light for each path of the last round
    std::uint32_t round_ = 0, first_ = 0, count_ = 0;  // samples [first, first + count) of each pixel
};

GuidePilot::GuidePilot(const IntegratorContext& context, const GuideTraining& training)
    : context_(context), training_(training) {
    context_.first_hits.aovs = &no_aovs_;
    context_.first_hits.pattern_channels = false;
    context_.scene.general_code = {};  // the cost of effects that are forced on changes no choice
    guide_ = std::make_unique<Guide>(GuideTree(context.scene.geometry->lit_bounds()));
    guide_->set_training(true);
    plain_ = make_integrator(nullptr);
    guided_ = make_integrator(guide_.get());
    const std::size_t channels = training.channels.size();
    for (int y = 0; y < context.view.height; y += tile_side)
        for (int x = 0; x < context.view.width; x += tile_side) {
            GuideTile& tile = tiles_.emplace_back();
            tile.pixels = {x, y, std::min(x + tile_side, context.view.width),
                           std::min(y + tile_side, context.view.height)};
            tile.received.resize(channels);
            tile.weights.assign(channels, 1);
        }
    for (int i = 0; i < std::max(1, training.threads); ++i) {
        GuideWorker& worker = *workers_.emplace_back(std::make_unique<GuideWorker>(
            context_, std::vector<display::ChannelId>(training.channels.begin(), training.channels.end())));
        worker.paths.leave_when(leave_);
        worker.plain = plain_->make_thread_state();
        worker.guided = guided_->make_thread_state();
    }
}

std::unique_ptr<Integrator> GuidePilot::make_integrator(const DirectionSampler* directions) {
    auto integrator = training_.request.make_trial();
    IntegratorContext context = context_;
    context.directions = directions;
    if (const Status status = integrator->prepare(context); !status) throw std::runtime_error(status.error().message);
    return integrator;
}

/// The weight of a tile is 1 over the square of its mean, but dark tiles do not count more than those of half the
/// image's mean.
void GuidePilot::weigh() {
    if (round_ == 0) {
        double finds = 0, guidable = 0, paths = 0;
        for (const GuideTile& tile : tiles_) {
            finds += static_cast<double>(tile.finds);
            guidable += static_cast<double>(tile.guidable);
            paths += static_cast<double>(tile.paths);
        }
        light_is_rare_ = finds > 0 && finds < rare_finds * guidable;
        finds_of_path_ = std::clamp(finds / paths, 1e-3, 0.125);  // round 1 has few: eight places or more learn each
    }
    for (std::size_t c = 0; c < training_.channels.size(); ++c) {
        double sum = 0, paths = 0;
        for (const GuideTile& tile : tiles_) sum += tile.received[c], paths += static_cast<double>(tile.paths);
        const double mean = sum / paths;
        if (c == 0) mean_ = mean;
        for (GuideTile& tile : tiles_) {
            const double here = tile.received[c] / static_cast<double>(tile.paths);
            const double square = here * here + mean * mean / 4;
            tile.weights[c] = square > 0 ? 1 / square : 0;
        }
    }
}

/// What a path teaches at each of its vertices.
void GuidePilot::learn(GuideTile& tile, GuideWorker& worker, std::uint64_t row, const LaterRadiance::Path& path) {
    double drawn = 0;
    for (std::size_t c = 0; c < path.channels; ++c) {
        tile.received[c] += path.received[c];
        drawn += tile.weights[c] * path.received[c] * path.received[c];
    }
    ++tile.paths;
    if (round_ == 0) {
        for (std::size_t i = 0; i < path.vertices.size(); ++i) {
            if (!path.vertices[i].guidable) continue;
            ++tile.guidable;
            bool found = false;
            for (std::size_t c = 0; c < path.channels; ++c) found = found || path.behind(i, c) > 0;
            tile.finds += found ? 1 : 0;
        }
        return;
    }
    if (gain_sums_) gain_sums_->add(path, tile.later);
    // Without the guide, light found behind vertex i would arrive with the factor R_i, the product of draw over closure
    // up to there, and as often as 1 / R_i. So pairs of finds count with the R of what they have in common.
    double unguided = drawn;
    worker.unguided.assign(path.vertices.size(), 1);
    for (std::size_t i = 0; i < path.vertices.size(); ++i) {
        const PassedVertex& v = path.vertices[i];
        double before = 1;
        for (std::size_t k = i; k-- > 0;)
            if (path.vertices[k].depth < v.depth) {
                before = worker.unguided[k];
                break;
            }
        worker.unguided[i] = before;
        if (!v.guidable) continue;
        ++worker.departures;
        GuideRecord record{
            .position = v.position, .normal = v.normal, .direction = v.direction, .specular = v.specular};
        for (std::size_t c = 0; c < path.channels; ++c)
            record.square += tile.weights[c] * path.behind(i, c) * path.behind(i, c);
        record.density = double{v.pdf};
        record.chance = double{v.chance};
        for (std::size_t k = i; k + 1 < path.vertices.size(); ++k) {
            const PassedVertex& next = path.vertices[k + 1];
            if (next.depth != path.vertices[k].depth + 1) break;
            record.distance += length(next.position - path.vertices[k].position);
            if (!next.specular) break;
        }
        record.key = (row << 8 | round_) * golden_gamma + i;
        const double by_closure = sums_->add(record);
        worker.unguided[i] = std::min(before / std::max(by_closure, 1e-6), most_unlikely);
        unguided += (worker.unguided[i] - before) * record.square;
    }
    tile.guided += drawn;
    tile.unguided += unguided;
}

void GuidePilot::follow_tile(GuideTile& tile, GuideWorker& worker) {
    const std::size_t channels = training_.channels.size();
    tile.guided = tile.unguided = tile.of_means = 0;
    tile.later = {};
    const std::uint64_t seed = mix_bits(~context_.services.seed);  // the guide must not depend on the image's numbers
    worker.paths.begin_pixels(tile.pixels, seed, first_, count_);
    worker.sums.assign(channels, 0);
    worker.squares.assign(channels, 0);
    const auto width = static_cast<std::size_t>(tile.pixels.width());
    worker.paths.follow(round_ == 0 ? *plain_ : *guided_, round_ == 0 ? *worker.plain : *worker.guided,
                        [&](std::size_t row, const LaterRadiance::Path& path) {
                            const std::size_t pixel = row / count_, sample = row % count_;
                            const auto x = static_cast<std::uint64_t>(tile.pixels.x0) + pixel % width,
                                       y = static_cast<std::uint64_t>(tile.pixels.y0) + pixel / width;
                            learn(tile, worker, ((y << 20 | x) << 20) + first_ + sample, path);
                            if (sample + 1 == count_) tile.later.end_pixel(count_);
                            for (std::size_t c = 0; c < channels; ++c) {
                                worker.sums[c] += path.received[c];
                                worker.squares[c] += path.received[c] * path.received[c];
                                if (sample + 1 < count_) continue;
                                // The square of the pixel's mean, from products of different samples alone.
                                if (count_ > 1)
                                    tile.of_means += tile.weights[c] *
                                                     (worker.sums[c] * worker.sums[c] - worker.squares[c]) /
                                                     (count_ - 1.0);
                                worker.sums[c] = worker.squares[c] = 0;
                            }
                        });
}

bool GuidePilot::follow(std::uint32_t round) {
    round_ = round;
    first_ = round == 0 ? 0 : 1u << (round - 1);
    count_ = round == 0 ? 1 : first_;
    // Neighbours help where light is found rarely.
    const int neighbours = static_cast<int>(std::min<double>(GuideSums::most_neighbours, 1 / finds_of_path_));
    for (auto& worker : workers_) {
        before_.add(worker->guided->counters);
        worker->guided = guided_->make_thread_state();  // the tree may plan rays now
        worker->departures = 0;
    }
    if (round > 0) sums_ = std::make_unique<GuideSums>(guide_->tree(), neighbours);
    if (round > 1 && learns_gains()) gain_sums_ = std::make_unique<GainSums>(guide_->tree(), mean_);
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::condition_variable done;
    std::size_t running = 0;
    std::exception_ptr failure;
    const auto work = [&](GuideWorker& worker) {
        display::flush_denormals();
        try {
            while (!leave_.load(std::memory_order_relaxed)) {
                const std::size_t tile = next.fetch_add(1);
                if (tile >= tiles_.size()) break;
                follow_tile(tiles_[tile], worker);
            }
        } catch (...) {
            const std::lock_guard lock(mutex);
            failure = std::current_exception();
        }
    };
    std::vector<std::thread> threads;
    std::unique_lock lock(mutex);
    for (auto& worker : workers_) {
        std::thread thread = display::thread_or_none([&, w = worker.get()] {
            work(*w);
            const std::lock_guard counted(mutex);
            --running;
            done.notify_one();
        });
        if (!thread.joinable()) break;
        threads.push_back(std::move(thread));
        ++running;
    }
    while (!done.wait_for(lock, std::chrono::milliseconds(100), [&] { return running == 0; }))
        if (training_.stopped && training_.stopped()) leave_.store(true);
    lock.unlock();
    if (threads.empty()) work(*workers_.front());
    for (std::thread& thread : threads) thread.join();
    if (failure) std::rethrow_exception(failure);
    return !leave_.load();
}

/// Mean cost of a path in the unit of pilot_cost(): of round 0 without the guide, of the last round with it.
double GuidePilot::cost(bool guided) const {
    // Integers are summed first, so the cost has the same bits however threads shared the tiles.
    IntegratorCounters counters;
    std::uint64_t departures = 0;
    for (const auto& worker : workers_) {
        counters.add(guided ? worker->guided->counters : worker->plain->counters);
        if (guided) departures += worker->departures;
    }
    if (counters.camera_rays == 0) return 1;
    return (pilot_cost(counters) + guide_vertex_cost * static_cast<double>(departures)) /
           static_cast<double>(counters.camera_rays);
}

/// Of the last round: variance x cost without the guide, over the same with it. Both variances have the roulette and
/// splits of the round; the cost without the guide is that of plain paths.
double GuidePilot::gain() const {
    // One path can have most of the variance: a hundredth of the tiles, those with the largest, do not count.
    std::vector<std::pair<double, double>> variances;  // without the guide and with it
    for (const GuideTile& tile : tiles_)
        variances.emplace_back(tile.unguided - tile.of_means, tile.guided - tile.of_means);
    const auto trimmed = variances.begin() + static_cast<std::ptrdiff_t>(tiles_.size() / 100);
    std::nth_element(variances.begin(), trimmed, variances.end(), [](const auto& a, const auto& b) {
        return std::max(a.first, a.second) > std::max(b.first, b.second);
    });
    double guided = 0, unguided = 0;
    for (auto each = trimmed; each != variances.end(); ++each) unguided += each->first, guided += each->second;
    return guided > 0 && unguided > 0 ? unguided * cost(false) / (guided * cost(true)) : 1;
}

/// Gains add up the light of one channel. A plan without beauty has a roulette and splits of its own.
bool GuidePilot::learns_gains() const {
    const PathPlan* plan = context_.plan;
    return training_.request.gain && training_.channels.size() == 1 && mean_ > 0 &&
           (plan == nullptr || !(plan->changes_paths() || plan->shares.any()));
}

void GuidePilot::refine(bool final) {
    constexpr std::size_t bytes_of_node = 2 * sizeof(GuideTree::Node) + 4 * (sizeof(std::uint64_t) + sizeof(float));
    GuideLimits limits;
    limits.finds = finds_of_region;
    limits.nodes = guide_bytes / bytes_of_node;
    limits.final = final;
    limits.cost = guide_share_cost;
    double finds = 0, paths = 0;
    for (const GuideSums::Region& region : sums_->regions()) finds += static_cast<double>(region.guided.load());
    for (const GuideTile& tile : tiles_) paths += double(count_) * tile.pixels.width() * tile.pixels.height();
    if (finds > 0) finds_of_path_ = finds / paths;
    GuideTree tree = refined(*sums_, limits);
    if (gain_sums_) {
        LaterLight later;
        for (const GuideTile& tile : tiles_) later.variance += tile.later.variance, later.rays += tile.later.rays;
        gain_sums_->set_gains(tree, later);
    }
    gain_sums_.reset();
    sums_.reset();
    guide_->set_tree(std::move(tree));
    if (final) guide_->set_training(false);
}

void GuidePilot::summarize(TrainedGuide& trained) const {
    GuideSummary& summary = trained.summary;
    const std::vector<GuideTree::Region>& regions = guide_->tree().regions();
    summary.samples = first_ + count_;
    summary.regions = regions.size();
    summary.bytes = guide_->tree().bytes();
    const auto guided =
        std::count_if(regions.begin(), regions.end(), [](const GuideTree::Region& each) { return each.share > 0; });
    summary.guided = static_cast<double>(guided) / static_cast<double>(regions.size());
    IntegratorCounters counters = before_;
    for (const auto& worker : workers_) {
        counters.add(worker->plain->counters);
        counters.add(worker->guided->counters);
    }
    trained.rays = pilot_rays(counters);
    summary.paths = counters.camera_rays;
}

/// The last round if each takes twice the time of the one before, and the time is limited.
std::uint32_t GuidePilot::last_in_time(std::uint32_t round, std::uint32_t last, double elapsed) const {
    if (!(training_.seconds > 0)) return last;
    for (; round < last && 2 * elapsed <= training_.seconds; elapsed *= 2) ++round;
    return round;
}

TrainedGuide GuidePilot::run() {
    TrainedGuide trained;
    const Stopwatch watch;
    // Rounds after round 0; all rounds together take 2^last samples of each pixel.
    auto last = static_cast<std::uint32_t>(std::bit_width(training_samples(context_, training_)) - 1);
    const bool automatic = training_.request.mode == GuideMode::automatic;
    bool whole = follow(0), pays = true;
    for (std::uint32_t round = 1; whole && pays && round <= last; ++round) {
        weigh();
        whole = follow(round);
        if (!whole) break;
        last = last_in_time(round, last, watch.wall());
        trained.summary.gain = gain();
        if (automatic && round >= std::min(first_deciding_round, last) &&
            last - round < (light_is_rare_ ? deciding_rounds_if_rare : deciding_rounds))
            pays = trained.summary.gain > (round == last                   ? worthwhile_at_last
                                           : round == first_deciding_round ? worthwhile_at_first
                                                                           : worthwhile);
        refine(round == last);
    }
    summarize(trained);
    trained.summary.used = whole && pays && trained.summary.guided > 0;
    trained.summary.cut = !whole;
    if (trained.summary.used) trained.guide = std::move(guide_);
    trained.summary.seconds = watch.wall();
    trained.summary.cpu_seconds = watch.process_cpu();
    return trained;
}

}  // namespace

/// Without a requested number, the training takes at most a quarter of the samples of the whole render.
std::uint32_t training_samples(const IntegratorContext& context, const GuideTraining& training) {
    if (training.request.mode == GuideMode::off || !training.request.make_trial || training.channels.empty() ||
        !context.takes_scattered_light())
        return 0;
    if (training.request.samples > 0) return std::max(2u, std::bit_floor(training.request.samples));
    if (training.request.mode == GuideMode::automatic && training.whole > 0 && training.whole < shortest_automatic)
        return 0;
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(context.view.width) * static_cast<std::uint64_t>(context.view.height);
    const std::uint64_t most = training.whole > 0 ? std::min(training.whole / 4, most_samples) : most_samples;
    const std::uint64_t samples = training.seconds > 0 ? most : (paths_of_training + pixels / 2) / pixels;
    const std::uint64_t fewest = training.request.mode == GuideMode::automatic ? fewest_automatic : fewest_samples;
    return static_cast<std::uint32_t>(std::bit_floor(std::clamp(samples, fewest, std::max(fewest, most))));
}

TrainedGuide train_guide(const IntegratorContext& context, const GuideTraining& training) {
    return training_samples(context, training) > 0 ? GuidePilot(context, training).run() : TrainedGuide();
}

}  // namespace raylex::transport
