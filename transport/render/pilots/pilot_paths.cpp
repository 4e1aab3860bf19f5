#include "transport/render/pilots/pilot_paths.h"

#include <algorithm>
#include <stdexcept>

#include "transport/cameras/camera.h"
#include "transport/paths/subpaths/camera_subpaths.h"

namespace raylex::transport {

PathTrial PathTrials::make(const SplitPlan& splits, bool follows_whole_paths) const {
    PathTrial trial{std::make_unique<PathPlan>(), request_.make_trial()};
    trial.plan->shares = shares_;
    trial.plan->lights = lights_;
    trial.plan->splits = splits;
    trial.plan->follows_whole_paths = follows_whole_paths;
    trial.plan->most_depth = PilotPaths::most_depth;
    IntegratorContext context = context_;
    context.scene.general_code = {};  // the cost of effects that are forced on changes no choice, as it changes no bit
    context.plan = trial.plan.get();
    if (const Status status = trial.integrator->prepare(context); !status)
        throw std::runtime_error(status.error().message);
    return trial;
}

double pilot_cost(const IntegratorCounters& counters) {
    return camera_ray_cost * static_cast<double>(counters.camera_rays) + static_cast<double>(counters.scattering_rays) +
           shadow_ray_cost * static_cast<double>(counters.shadow_rays);
}

PilotPaths::PilotPaths(const IntegratorContext& context, std::vector<display::ChannelId> channels)
    : context_(context),
      table_(context.services.channels, context.batch_capacity),
      display_(table_),
      lpe_(context.services.on(table_)),
      later_(table_, std::move(channels)) {}

std::uint32_t PilotPaths::most_rounds(std::uint32_t most) const {
    constexpr std::uint64_t samples_of_image = 16;  // of each pixel
    const std::uint64_t pixels = std::uint64_t(context_.view.width) * static_cast<std::uint64_t>(context_.view.height);
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(most, samples_of_image * pixels / (grid * grid)));
}

void PilotPaths::clear() {
    rows_.clear();
    camera_samples_.clear();
    samplers_.clear();
}

void PilotPaths::add(const PixelSampler& numbers, const Vec2& scale, const Vec2& corner, std::uint64_t sample) {
    const Vec2 at = numbers.get_2d(filter_dimension);
    display::CameraRow& row = rows_.emplace_back();
    row.screen_x = to_float((corner.x + at.x) * scale.x);
    row.screen_y = to_float((corner.y + at.y) * scale.y);
    row.pixel_x = static_cast<std::int32_t>(row.screen_x);
    row.pixel_y = static_cast<std::int32_t>(row.screen_y);
    row.sample = sample;
    const Real time = sample_time(context_.scene, numbers);
    row.shutter_time = to_float(time);
    camera_samples_.push_back({row.screen_x, row.screen_y, numbers.get_2d(lens_dimension), time});
    samplers_.push_back(numbers);
}

void PilotPaths::begin(std::uint32_t round) {
    clear();
    const Vec2 scale{static_cast<Real>(context_.view.width) / grid, static_cast<Real>(context_.view.height) / grid};
    for (std::uint32_t y = 0; y < grid; ++y)
        for (std::uint32_t x = 0; x < grid; ++x)
            // Other numbers than the image's: the plan must not depend on those.
            add(PixelSampler(SamplerKind::sobol, ~context_.services.seed, static_cast<std::int32_t>(x),
                             static_cast<std::int32_t>(y), round),
                scale, {static_cast<Real>(x), static_cast<Real>(y)}, round);
    generate();
}

void PilotPaths::begin_pixels(const display::PixelRegion& pixels, std::uint64_t seed, std::uint64_t first,
                              std::uint32_t count, int step) {
    clear();
    for (int y = pixels.y0; y < pixels.y1; y += step)
        for (int x = pixels.x0; x < pixels.x1; x += step)
            for (std::uint64_t sample = first; sample < first + count; ++sample)
                add(PixelSampler(SamplerKind::sobol, seed, x, y, sample), {1, 1},
                    {static_cast<Real>(x), static_cast<Real>(y)}, sample);
    generate();
}

void PilotPaths::generate() {
    rays_.resize(rows_.size());
    if (context_.view.camera->weighs_rays()) {
        weights_.resize(rows_.size());
        context_.view.camera->generate_weighed(camera_samples_, rays_, weights_);
    } else {
        context_.view.camera->generate_in_time(camera_samples_, rays_);
    }
}

void PilotPaths::integrate(const Integrator& integrator, IntegratorThread& thread, std::size_t first,
                           std::size_t count) {
    const std::span<const display::CameraRow> rows{rows_.data() + first, count};
    table_.begin(rows);
    ThreadServices services{display_, lpe_, nullptr, leave_};
    later_.begin();
    services.later = &later_;
    CameraBatch batch{{rays_.data() + first, count}, {samplers_.data() + first, count}, rows};
    if (!weights_.empty()) batch.weights = {weights_.data() + first, count};
    integrator.integrate(batch, thread, services);
}

}  // namespace raylex::transport
