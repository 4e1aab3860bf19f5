#include "transport/integrators/split_pilot.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "transport/cameras/camera.h"
#include "transport/paths/camera_subpaths.h"

namespace raylex::transport {
namespace {

constexpr std::uint32_t grid = 16, fewest_rounds = 16, most_rounds = 128;
constexpr std::uint32_t pilot_depth = 16;  // bounds what a pilot costs
constexpr std::uint64_t most_pilot_rays = 250'000;
constexpr std::uint32_t enough_finds = 128;
constexpr std::uint32_t samples_of_image = 16;  // of each pixel: no more paths than that
constexpr std::array<std::uint8_t, 5> ray_counts{1, 2, 4, 8, 16};
constexpr std::uint8_t most_both_lobes = 2;
constexpr double dearest_lobes = 1.15;  // than one of each pair

/// In scattering rays with what is done where they hit, as measured on cornell-grey and caustic-ball.
double cost(const IntegratorCounters& counters) {
    return 1.3 * static_cast<double>(counters.camera_rays) + static_cast<double>(counters.scattering_rays) +
           0.7 * static_cast<double>(counters.shadow_rays);
}

/// What one way to follow paths brings: [channel][pixel of the grid] of the last round.
struct Trial {
    std::unique_ptr<Integrator> integrator;
    std::unique_ptr<IntegratorThread> thread;
    std::vector<double> found;
    [[nodiscard]] double cost() const { return transport::cost(thread->counters); }
    [[nodiscard]] std::uint64_t rays() const {
        const IntegratorCounters& c = thread->counters;
        return c.camera_rays + c.scattering_rays + c.shadow_rays;
    }
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
    SplitPilot(const IntegratorContext& context, const SplitTrials& trials)
        : context_(context),
          trials_(trials),
          table_(context.channels, context.batch_capacity, 0),
          display_(table_),
          lpe_(*context.lpe, table_, context.seed, context.attribution) {
        for (std::size_t i = 0; i < context.channels.size(); ++i)
            if (context.channels[i].style == display::ChannelStyle::expression &&
                display::takes_samples(context.channels[i]))
                channels_.push_back(static_cast<display::ChannelId>(i));
    }

    void run();
    /// Of n rays, after run().
    [[nodiscard]] double cost_times_variance(std::uint8_t rays) const {
        return costs_.of(rays) * (variances_.before + variances_.behind / rays);
    }
    /// Where `both_lobes` specular vertices reflect and transmit.
    [[nodiscard]] Costs costs(std::uint8_t both_lobes);
    [[nodiscard]] const Costs& costs() const { return costs_; }

  private:
    [[nodiscard]] Trial make(std::uint8_t both_lobes, SplitPlan::Only only) const;
    void make_rays(std::uint32_t round);
    void follow(Trial& trial);
    void add(const Trial& none, const Trial& first, const Trial& second);
    [[nodiscard]] std::uint32_t finds() const;
    void find_variances();

    const IntegratorContext& context_;
    const SplitTrials& trials_;
    display::SampleTable table_;
    display::DisplayServices display_;
    display::LpeServices lpe_;
    std::vector<display::ChannelId> channels_;
    std::vector<display::CameraRow> rows_;
    std::vector<CameraSample> camera_samples_;
    std::vector<Ray> rays_;
    std::vector<Real> weights_;  // of rays_; empty where all count alike
    std::vector<PixelSampler> samplers_;
    std::vector<Sums> sums_;  // [channel]
    std::uint32_t rounds_ = 0;
    Variances variances_;
    Costs costs_;
};

Trial SplitPilot::make(std::uint8_t both_lobes, SplitPlan::Only only) const {
    Trial trial;
    trial.integrator = trials_.trial({2, both_lobes, only}, pilot_depth);
    trial.thread = trial.integrator->make_thread_state();
    trial.found.resize(channels_.size() * grid * grid);
    return trial;
}

/// One path through each pixel of a coarse grid over the image.
void SplitPilot::make_rays(std::uint32_t round) {
    rows_.clear();
    camera_samples_.clear();
    samplers_.clear();
    for (std::uint32_t y = 0; y < grid; ++y)
        for (std::uint32_t x = 0; x < grid; ++x) {
            // Not the image's own numbers: what is chosen must not depend on them.
            const PixelSampler numbers(SamplerKind::sobol, ~context_.seed, static_cast<std::int32_t>(x),
                                       static_cast<std::int32_t>(y), round);
            const Vec2 at = numbers.get_2d(filter_dimension);
            display::CameraRow& row = rows_.emplace_back();
            row.screen_x = to_float((static_cast<Real>(x) + at.x) * static_cast<Real>(context_.width) / grid);
            row.screen_y = to_float((static_cast<Real>(y) + at.y) * static_cast<Real>(context_.height) / grid);
            row.pixel_x = static_cast<std::int32_t>(row.screen_x);
            row.pixel_y = static_cast<std::int32_t>(row.screen_y);
            row.sample = round;
            const Real time = sample_time(context_.scene, numbers);
            row.shutter_time = to_float(time);
            camera_samples_.push_back({row.screen_x, row.screen_y, numbers.get_2d(lens_dimension), time});
            samplers_.push_back(numbers);
        }
    rays_.resize(rows_.size());
    if (context_.camera->weighs_rays()) {
        weights_.resize(rows_.size());
        context_.camera->generate_weighed(camera_samples_, rays_, weights_);
    } else {
        context_.camera->generate_in_time(camera_samples_, rays_);
    }
}

void SplitPilot::follow(Trial& trial) {
    const auto capacity = static_cast<std::size_t>(context_.batch_capacity);
    for (std::size_t first = 0; first < rows_.size(); first += capacity) {
        const std::size_t count = std::min(capacity, rows_.size() - first);
        const std::span<const display::CameraRow> rows{rows_.data() + first, count};
        table_.begin(rows);
        ThreadServices services{display_, lpe_};
        CameraBatch batch{{rays_.data() + first, count}, {samplers_.data() + first, count}, rows};
        if (!weights_.empty()) batch.weights = {weights_.data() + first, count};
        trial.integrator->integrate(batch, *trial.thread, services);
        for (std::size_t c = 0; c < channels_.size(); ++c) {
            const double* values = table_.touched(channels_[c]) ? table_.values(channels_[c]) : nullptr;
            for (std::size_t i = 0; i < count; ++i) {
                double& found = trial.found[c * grid * grid + first + i];
                found = values == nullptr ? 0 : (values[3 * i] + values[3 * i + 1] + values[3 * i + 2]) / 3;
            }
        }
    }
}

void SplitPilot::add(const Trial& none, const Trial& first, const Trial& second) {
    for (std::size_t c = 0; c < channels_.size(); ++c)
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
    Trial none = make(0, SplitPlan::Only::none), first = make(0, SplitPlan::Only::first),
          second = make(0, SplitPlan::Only::second);
    sums_.assign(channels_.size(), Sums{std::vector<double>(grid * grid), std::vector<double>(grid * grid)});
    const std::uint64_t pixels = std::uint64_t(context_.width) * static_cast<std::uint64_t>(context_.height);
    const std::uint64_t most = std::min<std::uint64_t>(most_rounds, samples_of_image * pixels / (grid * grid));
    for (rounds_ = 0; rounds_ < std::max<std::uint64_t>(most, fewest_rounds); ++rounds_) {
        const std::uint64_t rays = none.rays() + first.rays() + second.rays();
        if (rounds_ >= fewest_rounds && (finds() >= enough_finds || rays >= most_pilot_rays)) break;
        make_rays(rounds_);
        for (Trial* each : {&none, &first, &second}) follow(*each);
        add(none, first, second);
    }
    const double paths = double{grid} * grid * rounds_;
    costs_.before = none.cost() / paths;
    costs_.behind = (first.cost() + second.cost()) / (2 * paths) - costs_.before;
    find_variances();
}

Costs SplitPilot::costs(std::uint8_t both_lobes) {
    Trial trial = make(both_lobes, SplitPlan::Only::first);
    for (std::uint32_t round = 0; round < fewest_rounds; ++round) {
        make_rays(round);
        follow(trial);
    }
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

}  // namespace

SplitPlan choose_splits(const IntegratorContext& context, const SplitTrials& trials) {
    SplitPilot pilot(context, trials);
    pilot.run();
    SplitPlan best;
    if (!(pilot.costs().behind > 0)) return best;  // nothing is split
    double least = pilot.cost_times_variance(1);
    for (const std::uint8_t rays : ray_counts) {
        const double product = pilot.cost_times_variance(rays);
        if (!(product < 0.9 * least)) continue;
        least = product;
        best.rays = rays;
    }
    // Both lobes are never noisier than one of them. What the rarer one brings is too rare for a pilot to weigh.
    double spent = pilot.costs().of(best.rays), behind = pilot.costs().behind;
    for (std::uint8_t lobes = 1; lobes <= most_both_lobes; ++lobes) {
        const Costs costs = pilot.costs(lobes);
        if (!(costs.behind > behind) || costs.of(best.rays) > dearest_lobes * spent) break;
        spent = costs.of(best.rays);
        behind = costs.behind;
        best.both_lobes = lobes;
    }
    return best;
}

}  // namespace raylex::transport
