// One thread of a render: it draws camera rays, has them followed, and hands what comes of them to the frame buffer.
// Which pixels and samples those are is a Schedule's business. Private to transport/render.
#pragma once

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

#include "transport/render/stages/camera_hits.h"
#include "transport/render/stages/render_target.h"
#include "transport/samplers/sampler_batch.h"

namespace raylex::transport {

/// What a thread did, for statistics.
struct WorkerTotals {
    IntegratorCounters counters;
    std::uint64_t overflow = 0, invalid = 0;
    std::vector<std::uint64_t> invalid_by_channel;
    std::vector<display::InvalidSample> invalid_log;
};

/// One thread's splats on their way to the frame buffer: sorted by tiles, so that a lock serves many.
class SplatGate final : public display::RasterSink {
  public:
    SplatGate(const ResolvedJob& job, TileLocks& locks, RenderTarget& target)
        : grid_(job.grid),
          filter_(*job.sampling.filter),
          sample_filters_(job.channels.filters),
          locks_(locks),
          target_(target) {}
    void take(display::SampleTable& table) override;
    [[nodiscard]] std::uint64_t taken() const { return taken_; }  ///< tables so far

  private:
    const TileGrid& grid_;
    const display::PixelFilter& filter_;
    const display::SampleFilterChain& sample_filters_;
    TileLocks& locks_;
    RenderTarget& target_;
    std::uint64_t taken_ = 0;
    std::vector<std::pair<std::uint64_t, int>> order_;  // tile and whether its neighbours are reached, row
    std::vector<int> rows_;
};

/// One thread's tables and buffers.
class RenderWorker {
  public:
    static constexpr int batch_capacity = 256;  ///< most camera rays of one call of the integrator

    /// Once `leave` is set, batches are left and no more are begun.
    RenderWorker(const PreparedJob& prepared, RenderTarget& target, TileLocks& locks, const std::atomic<bool>& leave);
    RenderWorker(const RenderWorker&) = delete;
    RenderWorker& operator=(const RenderWorker&) = delete;

    /// Begins a task, of which so many first blocks of pixels are in the frame buffer already. A task is of one tile.
    void begin_task(std::uint64_t done) { skip_ = added_ = done_ = done; }
    /// Those blocks, for schedules that look at the frame buffer to know where a task begins.
    [[nodiscard]] std::uint64_t blocks_skipped() const { return skip_; }
    /// Of a task: whose pixels come. The tile's locks are held while the frame buffer takes a batch in.
    void begin_tile(std::uint64_t tile);
    /// Samples [first, first + count) of a pixel of the tile, TileGrid::block_size at most. `block` counts what the
    /// task goes through, whether or not it has samples.
    void add_pixel(int x, int y, std::uint64_t first, int count, std::uint64_t block);
    /// Samples [first, first + count) of each of the tile's pixels.
    void add_tile(std::uint64_t tile, std::uint64_t first, int count);
    /// One call of the integrator for the tile, of no sample of the image.
    void start_up(std::uint64_t tile);
    /// What was added is in the frame buffer after this, or left().
    void end_task() { flush(); }

    /// Whether the last task was left, and how many blocks of pixels of it are in the frame buffer.
    [[nodiscard]] bool left() const { return left_; }
    [[nodiscard]] std::uint64_t done() const { return done_; }
    /// Whether splats of the batch that was left are in the frame buffer: they cannot be taken back.
    [[nodiscard]] bool splats_left_behind() const { return left_ && gate_.taken() != splats_taken_; }

    /// Without the batch that was left.
    [[nodiscard]] const WorkerTotals& totals();
    [[nodiscard]] const display::DisplayServices& display() const { return display_; }
    [[nodiscard]] const display::SampleTable& table() const { return table_; }
    [[nodiscard]] IntegratorThread& state() { return *state_; }
    std::uint64_t samples = 0;            ///< camera samples in the frame buffer
    std::uint64_t discarded_samples = 0;  ///< of iterations that the integrator discarded
    double cpu_seconds = 0;

  private:
    void note_totals();
    [[nodiscard]] std::uint64_t overflow() const;
    void flush();
    void finish_samples(double begin);
    const ResolvedJob& job_;
    const geoaovs::GeometricAovs& aovs_;
    RenderTarget& target_;
    TileLocks& locks_;
    display::SampleTable table_;
    display::DisplayServices display_;
    display::LpeServices lpe_;
    SplatGate gate_;
    std::unique_ptr<display::RasterSplats> raster_;
    std::unique_ptr<CameraHits> camera_hits_;  // null where the integrator reports them
    std::unique_ptr<IntegratorThread> state_;
    std::vector<display::CameraRow> rows_;
    std::vector<CameraSample> camera_samples_;
    std::vector<Ray> rays_;
    std::vector<Real> weights_;      // of `rays_`; empty where all count alike
    geoaovs::RayBatch camera_rays_;  // of `rays_`, when an AOV asks for depth
    std::vector<PixelSampler> samplers_;
    SamplerBatch filter_pairs_;  // of the pixel that is added
    std::size_t count_ = 0;
    std::uint32_t tile_ = 0;
    TileLocks::Group adding_;  // of the tile
    bool startup_ = false;
    const std::atomic<bool>& leave_;
    bool left_ = false;
    std::uint64_t skip_ = 0, added_ = 0, done_ = 0;  // blocks of pixels of the task
    std::uint64_t splats_taken_ = 0;                 // before the batch
    std::uint64_t dropped_overflow_ = 0;             // of discarded iterations
    WorkerTotals totals_;                            // the same
};

}  // namespace raylex::transport
