// One thread of a render: it draws camera rays, calls the integrator, and adds the results to the frame buffer. A
// Schedule chooses the pixels and samples. Private to transport/render.
#pragma once

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

#include "transport/render/stages/camera_hits.h"
#include "transport/render/stages/render_target.h"
#include "transport/samplers/sampler_batch.h"

namespace raylex::transport {

/// The statistics of one thread.
struct WorkerTotals {
    IntegratorCounters counters;
    std::uint64_t overflow = 0, invalid = 0;
    std::vector<std::uint64_t> invalid_by_channel;
    std::vector<display::InvalidSample> invalid_log;
};

/// Buffers one thread's splats before the frame buffer adds them, sorted by tile, so that one lock serves many.
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
    std::vector<std::pair<std::uint64_t, int>> order_;  // the tile and whether its neighbours are reached, the row
    std::vector<int> rows_;
};

/// The tables and buffers of one thread.
class RenderWorker {
  public:
    static constexpr int batch_capacity = 256;  ///< most camera rays in one call of the integrator

    /// Once `leave` is set, the worker leaves its batch and begins no other.
    RenderWorker(const PreparedJob& prepared, RenderTarget& target, TileLocks& locks, const std::atomic<bool>& leave);
    RenderWorker(const RenderWorker&) = delete;
    RenderWorker& operator=(const RenderWorker&) = delete;

    /// Begins a task of one tile. The first `done` blocks of pixels of the task are already in the frame buffer.
    void begin_task(std::uint64_t done) { skip_ = added_ = done_ = done; }
    /// The number of blocks to skip, for schedules that read the frame buffer to find where a task begins.
    [[nodiscard]] std::uint64_t blocks_skipped() const { return skip_; }
    /// Begins the pixels of a tile. The tile's locks are held while the frame buffer adds a batch.
    void begin_tile(std::uint64_t tile);
    /// Adds samples [first, first + count) of a pixel of the tile, at most TileGrid::block_size. `block` counts the
    /// task's blocks, with or without samples.
    void add_pixel(int x, int y, std::uint64_t first, int count, std::uint64_t block);
    /// Adds samples [first, first + count) of each of the tile's pixels.
    void add_tile(std::uint64_t tile, std::uint64_t first, int count);
    /// Calls the integrator once for the tile, with no sample of the image.
    void start_up(std::uint64_t tile);
    /// Ends the task. Afterwards its samples are in the frame buffer, unless left().
    void end_task() { flush(); }

    /// Whether the last task was left, and the number of its blocks of pixels in the frame buffer.
    [[nodiscard]] bool left() const { return left_; }
    [[nodiscard]] std::uint64_t done() const { return done_; }
    /// Whether splats of the batch that was left are in the frame buffer: they cannot be undone.
    [[nodiscard]] bool splats_left_behind() const { return left_ && gate_.taken() != splats_taken_; }

    /// The statistics without the batch that was left.
    [[nodiscard]] const WorkerTotals& totals();
    [[nodiscard]] const display::DisplayServices& display() const { return display_; }
    [[nodiscard]] const display::SampleTable& table() const { return table_; }
    [[nodiscard]] IntegratorThread& state() { return *state_; }
    std::uint64_t samples = 0;            ///< camera samples in the frame buffer
    std::uint64_t discarded_samples = 0;  ///< in iterations that the integrator discarded
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
    std::unique_ptr<CameraHits> camera_hits_;  // null if the integrator reports them
    std::unique_ptr<IntegratorThread> state_;
    std::vector<display::CameraRow> rows_;
    std::vector<CameraSample> camera_samples_;
    std::vector<Ray> rays_;
    std::vector<Real> weights_;      // of `rays_`; empty if all weights are 1
    geoaovs::RayBatch camera_rays_;  // of `rays_`, if an AOV needs depth
    std::vector<PixelSampler> samplers_;
    SamplerBatch filter_pairs_;  // of the current pixel
    std::size_t count_ = 0;
    std::uint32_t tile_ = 0;
    TileLocks::Group adding_;  // of the current tile
    bool startup_ = false;
    const std::atomic<bool>& leave_;
    bool left_ = false;
    std::uint64_t skip_ = 0, added_ = 0, done_ = 0;  // blocks of pixels of the task
    std::uint64_t splats_taken_ = 0;                 // before the batch
    std::uint64_t dropped_overflow_ = 0;             // of discarded iterations
    WorkerTotals totals_;                            // also of discarded iterations
};

}  // namespace raylex::transport
