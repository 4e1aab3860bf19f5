// Paths through a coarse grid over the image, followed before a render to choose its plan.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "transport/integrators/integrator.h"

namespace raylex::transport {

/// An integrator that follows a plan on trial.
struct PathTrial {
    std::unique_ptr<PathPlan> plan;
    std::unique_ptr<Integrator> integrator;  ///< ready to integrate
};

/// Makes integrators for pilots.
class PathTrials {
  public:
    /// The integrators have the shares and lights of `plan`. The first two references must outlive the object.
    PathTrials(const IntegratorContext& context, const PlanRequest& request, const PathPlan& plan)
        : context_(context), request_(request), shares_(plan.shares), lights_(plan.lights) {}
    /// Paths are bounded by PilotPaths::most_depth.
    [[nodiscard]] PathTrial make(const SplitPlan& splits, bool follows_whole_paths = false) const;

  private:
    const IntegratorContext& context_;
    const PlanRequest& request_;
    const TechniqueShares shares_;
    const std::shared_ptr<const LiveLights> lights_;
};

/// Costs relative to a scattering ray with the shading of its hit, measured on cornell-grey and caustic-ball.
inline constexpr double camera_ray_cost = 1.3, shadow_ray_cost = 0.7;
double pilot_cost(const IntegratorCounters& counters);
inline std::uint64_t pilot_rays(const IntegratorCounters& counters) {
    return counters.camera_rays + counters.scattering_rays + counters.shadow_rays;
}

class PilotPaths {
  public:
    static constexpr std::uint32_t grid = 16;
    static constexpr std::uint32_t most_depth = 16;  ///< bounds what a pilot costs

    explicit PilotPaths(const IntegratorContext& context) : PilotPaths(context, context.services.light_channels()) {}
    /// Receives the light of these channels.
    PilotPaths(const IntegratorContext& context, std::vector<display::ChannelId> channels);
    PilotPaths(const PilotPaths&) = delete;
    PilotPaths& operator=(const PilotPaths&) = delete;

    /// The number of expression channels.
    [[nodiscard]] std::size_t channels() const { return later_.channels().size(); }
    /// Whether some channel takes values without throughput, whose mean depends on how many paths are drawn: each
    /// sample then counts as one path.
    [[nodiscard]] bool count_alike() const { return lpe_.wants_emitter_samples(); }
    /// `most`, or fewer for an image so small that they would exceed 16 samples of each pixel.
    [[nodiscard]] std::uint32_t most_rounds(std::uint32_t most) const;
    /// Draws one path through each pixel of the grid, with numbers of its own for each round.
    void begin(std::uint32_t round);
    /// Draws paths through each of these pixels: samples [first, first + count) of numbers with this seed. Those of a
    /// pixel follow one another. step: takes every step-th pixel of every step-th row.
    void begin_pixels(const display::PixelRegion& pixels, std::uint64_t seed, std::uint64_t first, std::uint32_t count,
                      int step = 1);
    /// From now on paths end early once `leave` is set.
    void leave_when(const std::atomic<bool>& leave) { leave_ = &leave; }
    /// Follows the paths that begin() drew, and calls visit(pixel, path) for each.
    template <class Visit>
    void follow(const Integrator& integrator, IntegratorThread& thread, Visit visit) {
        for (std::size_t first = 0; first < rows_.size(); first += capacity()) {
            const std::size_t count = std::min(capacity(), rows_.size() - first);
            integrate(integrator, thread, first, count);
            later_.end(count, [&](std::size_t row, const LaterRadiance::Path& path) { visit(first + row, path); });
        }
    }

  private:
    void clear();
    /// Draws one path through a rectangle of the image: a square of side 1 at `corner`, times `scale`, in pixels.
    void add(const PixelSampler& numbers, const Vec2& scale, const Vec2& corner, std::uint64_t sample);
    void generate();
    [[nodiscard]] std::size_t capacity() const { return static_cast<std::size_t>(context_.batch_capacity); }
    void integrate(const Integrator& integrator, IntegratorThread& thread, std::size_t first, std::size_t count);

    const IntegratorContext& context_;
    display::SampleTable table_;
    display::DisplayServices display_;
    display::LpeServices lpe_;
    LaterRadiance later_;
    std::vector<display::CameraRow> rows_;
    std::vector<CameraSample> camera_samples_;
    std::vector<Ray> rays_;
    std::vector<Real> weights_;  // of rays_; empty where all count alike
    std::vector<PixelSampler> samplers_;
    const std::atomic<bool>* leave_ = nullptr;
};

}  // namespace raylex::transport
