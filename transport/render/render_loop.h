// The loop over blocks of samples and tiles of pixels: private to render.cpp.
//
// A task is one block of samples (16, aligned) of one tile (16 x 16 pixels). Tasks are numbered block by block, each
// block over the whole image, and threads take the next number; so an interrupted render has an even image, and which
// thread took which task cannot be seen in the result: samples are counter-based and the frame buffer adds exactly.
//
// A phase is a run of tasks that the threads go through without meeting: the whole render, or one block of the image for an
// integrator with iterations, or what an adaptive sampler wants before its next decision; there, a task is as many blocks
// of the pixels of a tile that are open.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "display/buffer/pixel_filter.h"
#include "display/services/sample_filter.h"
#include "transport/render/built_scene.h"
#include "transport/render/camera.h"
#include "transport/render/checkpoint.h"
#include "transport/render/clock.h"
#include "transport/render/sample_limit.h"
#include "transport/samplers/sampler.h"

namespace raylex::transport {

/// A render's settings resolved against its scene. Read by all threads.
struct RenderJob {
    FilmSettings film;
    std::unique_ptr<PerspectiveCamera> camera;
    std::unique_ptr<display::PixelFilter> filter;
    SamplerKind sampler = SamplerKind::sobol;
    std::uint64_t seed = 0, samples_per_pixel = 0, first_sample = 0;
    const SampleLimit* limit = nullptr;   ///< null: samples_per_pixel is the end
    double seconds_before_loop = 0;       ///< that count for the limit
    int threads = 1;
    std::optional<SampleChoice> only;
    display::PixelRegion region;  ///< the pixels that get samples; with padding around it when nothing is cropped
    bool splat = false;
    bool raster = false;                ///< the integrator splats at raster positions of its own
    int padding_x = 0, padding_y = 0;   ///< pixels around the image whose samples reach into it
    std::vector<display::ChannelDefinition> channels;
    display::ChannelId beauty = display::invalid_channel;
    std::unique_ptr<display::LpeSetup> lpe;
    std::unique_ptr<display::SplatSets> splat_sets;   // null: something looks at the samples of every channel
    display::LpeServices::Attribution attribution = display::LpeServices::Attribution::exact;
    display::SampleFilterChain sample_filters;
    const geoaovs::GeometricAovs* aovs = nullptr;
    std::vector<geoaovs::Cryptomatte> cryptomatte;
    std::vector<display::SampleSink*> sinks;
    std::unique_ptr<display::AdaptiveSampler> adaptive;   // null: samples_per_pixel everywhere
    Integrator* integrator = nullptr;
    bool has_extra_rows = false;  ///< camera rays may pass cutouts or media
};

/// Tiles whose pixels are being added: two threads may hold different blocks of one tile, and the frame buffer wants one
/// caller a pixel. Striped by tile; taken once a batch, and hardly ever contended on images of many tiles. In splat mode a
/// batch adds to the tiles around its own too, and takes them all.
class TileLocks {
  public:
    /// Locks its mutexes in one order for all groups, so that no two wait for each other.
    class Group {
      public:
        void lock() {
            for (std::size_t i = 0; i < count_; ++i) locks_->mutexes_[indices_[i]].lock();
        }
        void unlock() {
            for (std::size_t i = count_; i-- > 0;) locks_->mutexes_[indices_[i]].unlock();
        }

      private:
        friend class TileLocks;
        TileLocks* locks_ = nullptr;
        std::array<std::size_t, 9> indices_{};
        std::size_t count_ = 0;
    };

    [[nodiscard]] std::mutex& of(std::uint64_t tile) { return mutexes_[tile % mutexes_.size()]; }
    /// The tile at (x, y) of `tiles_x` in a row, and with `around` those next to it.
    [[nodiscard]] Group group(std::uint64_t x, std::uint64_t y, std::uint64_t tiles_x, bool around);

  private:
    std::array<std::mutex, 256> mutexes_;
};

/// Tiles of an image with padding around it.
struct TileGrid {
    int padding_x = 0, padding_y = 0;
    std::uint64_t columns = 0, rows = 0;
    [[nodiscard]] std::uint64_t count() const { return columns * rows; }
};

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
    SplatGate(const RenderJob& job, const TileGrid& grid, TileLocks& locks, display::FrameBuffer& frame_buffer)
        : job_(job), grid_(grid), locks_(locks), frame_buffer_(frame_buffer) {}
    void take(const display::SampleTable& table) override;
    [[nodiscard]] std::uint64_t taken() const { return taken_; }   ///< tables so far

  private:
    const RenderJob& job_;
    TileGrid grid_;
    TileLocks& locks_;
    display::FrameBuffer& frame_buffer_;
    std::uint64_t taken_ = 0;
    std::vector<std::pair<std::uint64_t, int>> order_;   // tile and whether its neighbours are reached, row
    std::vector<int> rows_;
};

/// One thread's tables and buffers.
class RenderWorker {
  public:
    /// Once `leave` is set, batches are left and no more are begun.
    RenderWorker(const RenderJob& job, const TileGrid& grid, TileLocks& locks, display::FrameBuffer& frame_buffer,
                 const std::atomic<bool>& leave);
    RenderWorker(const RenderWorker&) = delete;
    RenderWorker& operator=(const RenderWorker&) = delete;

    /// The next call goes on with a task of which so many first blocks of pixels are in the frame buffer.
    void go_on_from(std::uint64_t done) { skip_ = done_ = done; }
    /// Whether the last call left its task, and how many blocks of pixels of it are in the frame buffer.
    [[nodiscard]] bool left() const { return left_; }
    [[nodiscard]] std::uint64_t done() const { return done_; }
    /// Whether splats of the batch that was left are in the frame buffer: they cannot be taken back.
    [[nodiscard]] bool splats_left_behind() const { return left_ && gate_.taken() != splats_taken_; }

    /// Renders samples [first, first + count) of the tile with pixels [x0, x1) x [y0, y1). `adding` is held while the
    /// frame buffer takes a batch in.
    void render_tile(int x0, int y0, int x1, int y1, std::uint64_t first, int count, TileLocks::Group& adding);
    /// One call of the integrator for the tile, of no sample of the image.
    void start_up(int x0, int y0, std::uint32_t tile, TileLocks::Group& adding);
    /// Renders the next `blocks` blocks of each open pixel of that tile, up to the adaptive sampler's maximum. No other
    /// thread may add to these pixels meanwhile.
    void render_open_pixels(int x0, int y0, int x1, int y1, std::uint64_t blocks, TileLocks::Group& adding);

    void render_sample(const SampleChoice& choice, TileLocks::Group& adding) {
        add_pixel(choice.x, choice.y, choice.sample, 1, 0, adding);
        flush(adding);
    }

    /// Without the batch that was left.
    [[nodiscard]] const WorkerTotals& totals();
    [[nodiscard]] const display::DisplayServices& display() const { return display_; }
    [[nodiscard]] IntegratorThread& state() { return *state_; }
    std::uint64_t samples = 0;
    double cpu_seconds = 0;
    std::uint32_t tile = 0;   ///< whose pixels come next

  private:
    /// Block number `block` of those that the task goes through.
    void add_pixel(int x, int y, std::uint64_t first, int count, std::uint64_t block, TileLocks::Group& adding);
    void note_totals();
    void flush(TileLocks::Group& adding);
    void finish_samples(double begin);
    const RenderJob& job_;
    display::FrameBuffer& frame_buffer_;
    display::SampleTable table_;
    display::DisplayServices display_;
    display::LpeServices lpe_;
    SplatGate gate_;
    std::unique_ptr<display::RasterSplats> raster_;
    std::unique_ptr<IntegratorThread> state_;
    std::vector<display::CameraRow> rows_;
    std::vector<Ray> rays_;
    geoaovs::RayBatch camera_rays_;          // of `rays_`, when an AOV asks for depth
    std::vector<PixelSampler> samplers_;
    std::size_t count_ = 0;
    bool startup_ = false;
    const std::atomic<bool>& leave_;
    bool left_ = false;
    std::uint64_t skip_ = 0, added_ = 0, done_ = 0;   // blocks of pixels of the task
    std::uint64_t splats_taken_ = 0;                  // before the batch
    WorkerTotals totals_;                             // the same
};

class RenderLoop : public LiveImage {
  public:
    static constexpr int batch_capacity = 256, tile_size = 16, block_size = 16;

    RenderLoop(RenderJob& job, display::FrameBuffer& frame_buffer);
    /// Before run(): go on from here, with the frame buffer as it was then.
    void resume(RenderPosition position);
    /// Before run(): save the render while it goes on.
    void save_to(const CheckpointSettings& settings, display::RecordIdentity identity);
    /// Returns when the budget is spent, the time is over, `*stop` was seen, or a thread ran out of memory (an Error). After
    /// `*stop` threads finish their tasks; a batch that takes them longer than a moment is left.
    Status run(const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop);

    [[nodiscard]] std::vector<double> resolve(display::ChannelId id, const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_alpha(const display::PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_variance_of_mean(display::ChannelId id,
                                                               const display::PixelRegion& region) const override;

    [[nodiscard]] bool complete() const { return complete_; }
    /// After a stop: whether splats of light paths that were not finished are in the image.
    [[nodiscard]] bool splats_left_behind() const;
    /// After run(): the budget, or what a limited render came to.
    [[nodiscard]] std::uint64_t samples_per_pixel() const { return samples_per_pixel_; }
    /// Of adaptive sampling, or of a limit by error.
    [[nodiscard]] std::optional<display::AdaptiveProgress> error() const;
    /// Adds what all threads did, and what earlier sessions did.
    void collect(RenderStatistics& statistics) const;
    /// After run(): records that could not be written.
    [[nodiscard]] std::vector<Error> checkpoint_failures() const {
        return writer_ ? writer_->failures() : std::vector<Error>();
    }

  private:
    Status start_up(const std::function<void()>& report);
    void begin_phase();
    /// Limited renders: where the next pass ends.
    void choose_pass();
    [[nodiscard]] double seconds() const { return position_.statistics.render_seconds + watch_.wall(); }
    /// Whether phases are passes over the image, between which alone a checkpoint is whole.
    [[nodiscard]] bool by_passes() const { return limited_ != nullptr || job_.integrator->synchronous(); }
    Status run_phase(const std::function<void()>& report);
    void end_phase();
    [[nodiscard]] bool finished() const;
    Status run_tasks(const std::function<void()>& report);
    void work(RenderWorker& worker, std::uint64_t last);
    void render_task(RenderWorker& worker, std::uint64_t task);
    /// Raises leave_ where threads must not be waited for any longer; called while they run.
    void watch_threads();
    void take_unfinished();
    [[nodiscard]] double time_left() const;   ///< infinite without a limit
    [[nodiscard]] double pass_share_done() const;
    [[nodiscard]] bool pass_is_too_long() const;
    void make_workers();
    /// After the time was over amid a pass: the image as it was before the pass.
    Status take_back_pass();
    [[nodiscard]] bool can_take_back() const;
    [[nodiscard]] bool ending() const { return stopped() || leave_.load(std::memory_order_relaxed); }
    [[nodiscard]] bool whole_phase() const { return position_.task >= tasks_ && position_.unfinished.empty(); }
    [[nodiscard]] bool stopped() const { return stop_ != nullptr && stop_->load(std::memory_order_relaxed); }
    [[nodiscard]] bool checkpoint_due() const;
    void save_checkpoint();
    template <class Read>
    [[nodiscard]] std::vector<double> by_tiles(const display::PixelRegion& region, std::size_t components,
                                               Read read) const;
    RenderJob& job_;
    std::atomic<bool> leave_{false};
    std::vector<std::unique_ptr<RenderWorker>> workers_;
    display::FrameBuffer& frame_buffer_;
    mutable TileLocks locks_;
    std::uint64_t tiles_x_ = 0, tiles_ = 0, rounds_ = 0, phases_ = 1;   // the padding is tiled too
    std::uint64_t samples_per_pixel_ = 0;
    std::unique_ptr<LimitedPasses> limited_;
    std::uint64_t pass_begin_ = 0, pass_end_ = 0;   // samples per pixel before and after the pass, when limited
    bool limit_reached_ = false;
    RenderPosition position_;                 // its statistics are those of earlier sessions
    std::uint64_t tasks_ = 0;                 // of this phase
    std::vector<std::uint32_t> open_tiles_;   // of this phase, when sampling is adaptive
    std::atomic<std::uint64_t> next_{0}, next_unfinished_{0}, samples_done_{0};
    std::vector<UnfinishedTask> left_tasks_;  // by threads that had to leave, under failure_mutex_
    std::optional<double> stop_seen_;         // seconds()
    std::optional<display::RecordFile> before_pass_;   // the whole render, when the time may be over amid a pass
    bool first_pass_ = false;                 // of a session: nobody knows how long a sample takes
    double pass_begin_seconds_ = 0;
    std::uint64_t pass_begin_samples_ = 0;    // samples_done_
    const std::atomic<bool>* stop_ = nullptr;
    std::atomic<bool> failed_{false}, pause_{false};
    std::mutex failure_mutex_;
    std::string failure_;
    bool complete_ = true, starting_ = false;
    Stopwatch watch_;
    const CheckpointSettings* checkpoint_ = nullptr;
    display::RecordIdentity identity_;
    std::unique_ptr<CheckpointWriter> writer_;
    double last_checkpoint_ = 0, stall_seconds_ = 0;
};

}  // namespace raylex::transport
