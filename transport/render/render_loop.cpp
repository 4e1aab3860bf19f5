#include "transport/render/render_loop.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <new>
#include <thread>
#include <tuple>

#include "transport/render/clock.h"

namespace raylex::transport {
RenderLoop::RenderLoop(RenderJob& job, display::FrameBuffer& frame_buffer) : job_(job), frame_buffer_(frame_buffer) {
    tiles_x_ = static_cast<std::uint64_t>((job.film.width + 2 * job.padding_x + tile_size - 1) / tile_size);
    tiles_ = tiles_x_ * static_cast<std::uint64_t>((job.film.height + 2 * job.padding_y + tile_size - 1) / tile_size);
    rounds_ = (job.samples_per_pixel + block_size - 1) / block_size;
    samples_per_pixel_ = job.samples_per_pixel;
    // One iteration per block of the image when threads must meet in between, else one for everything.
    phases_ = job.integrator->synchronous() ? rounds_ : 1;
    position_.task = job.first_sample / block_size * tiles_;
    if (job.integrator->synchronous()) position_.phase = job.first_sample / block_size;
    if (job.limit != nullptr)
        limited_ = std::make_unique<LimitedPasses>(*job.limit, job.samples_per_pixel, block_size, job.integrator->synchronous(),
                                                   job.channels, job.beauty, frame_buffer.layout());
    make_workers();
}

void RenderLoop::make_workers() {
    const TileGrid grid{job_.padding_x, job_.padding_y, tiles_x_, tiles_ / tiles_x_};
    workers_.clear();
    for (int i = 0; i < job_.threads; ++i)
        workers_.push_back(std::make_unique<RenderWorker>(job_, grid, locks_, frame_buffer_, leave_));
}

void RenderLoop::resume(RenderPosition position) {
    position_ = std::move(position);
    samples_done_.store(position_.statistics.camera_samples);
}

void RenderLoop::save_to(const CheckpointSettings& settings, display::RecordIdentity identity) {
    checkpoint_ = &settings;
    identity_ = std::move(identity);
    writer_ = std::make_unique<CheckpointWriter>(settings.file);
}

void RenderLoop::render_task(RenderWorker& worker, std::uint64_t task) {
    const std::uint64_t tile = job_.adaptive ? open_tiles_[task] : task % tiles_;
    const int x0 = static_cast<int>(tile % tiles_x_) * tile_size - job_.padding_x,
              y0 = static_cast<int>(tile / tiles_x_) * tile_size - job_.padding_y;
    const int x1 = std::min(x0 + tile_size, job_.region.x1), y1 = std::min(y0 + tile_size, job_.region.y1);
    TileLocks::Group adding = locks_.group(tile % tiles_x_, tile / tiles_x_, tiles_x_, job_.splat);
    if (starting_) {
        worker.start_up(x0, y0, static_cast<std::uint32_t>(tile), adding);
        return;
    }
    worker.tile = static_cast<std::uint32_t>(tile);
    if (job_.adaptive) {
        worker.render_open_pixels(x0, y0, x1, y1, job_.adaptive->blocks(), adding);
        return;
    }
    const std::uint64_t first = task / tiles_ * block_size;
    const std::uint64_t end = limited_ ? pass_end_ : job_.samples_per_pixel;
    const auto count = static_cast<int>(std::min<std::uint64_t>(block_size, end - first));
    worker.render_tile(x0, y0, x1, y1, first, count, adding);
}

void RenderLoop::work(RenderWorker& worker, std::uint64_t last) {
    flush_denormals();
    const double begin = thread_cpu_seconds();
    try {
        while (!failed_.load(std::memory_order_relaxed)) {
            if (ending() || pause_.load(std::memory_order_relaxed)) break;
            UnfinishedTask part;
            if (const std::uint64_t k = next_unfinished_.fetch_add(1); k < position_.unfinished.size()) {
                part = position_.unfinished[k];
            } else {
                part.task = next_.fetch_add(1, std::memory_order_relaxed);
                if (part.task >= last) break;
            }
            const std::uint64_t before = worker.samples;
            worker.go_on_from(part.done);
            render_task(worker, part.task);
            samples_done_.fetch_add(worker.samples - before, std::memory_order_relaxed);
            if (!worker.left()) continue;
            const std::lock_guard lock(failure_mutex_);
            left_tasks_.push_back({part.task, worker.done()});
            break;
        }
    } catch (const std::exception& e) {
        const std::lock_guard lock(failure_mutex_);
        if (failure_.empty()) failure_ = e.what();
        failed_.store(true);
    }
    worker.cpu_seconds += thread_cpu_seconds() - begin;
}

Status RenderLoop::run_tasks(const std::function<void()>& report) {
    next_.store(position_.task);
    next_unfinished_.store(0);
    pause_.store(false);
    std::mutex mutex;
    std::condition_variable done;
    std::size_t running = workers_.size();
    std::vector<std::thread> threads;
    for (auto& worker : workers_)
        threads.emplace_back([&, w = worker.get()] {
            work(*w, tasks_);
            const std::lock_guard lock(mutex);
            --running;
            done.notify_one();
        });
    {
        const auto longest = std::chrono::duration<double>(checkpoint_ ? std::min(0.2, checkpoint_->seconds) : 0.2);
        std::unique_lock lock(mutex);
        while (!done.wait_for(lock, longest, [&] { return running == 0; })) {
            lock.unlock();
            watch_threads();
            report();
            if (!by_passes() && checkpoint_due()) pause_.store(true, std::memory_order_relaxed);
            lock.lock();
        }
    }
    for (std::thread& thread : threads) thread.join();
    if (failed_.load()) return error_at({}, "a render thread failed: " + failure_);
    take_unfinished();
    return success();
}

/// Tile by tile under the tile's lock, so that no thread waits long.
template <class Read>
std::vector<double> RenderLoop::by_tiles(const display::PixelRegion& region, std::size_t components, Read read) const {
    std::vector<double> result(static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height()) *
                               components);
    const int px = job_.padding_x, py = job_.padding_y;
    for (int y = (region.y0 + py) / tile_size; y * tile_size - py < region.y1; ++y)
        for (int x = (region.x0 + px) / tile_size; x * tile_size - px < region.x1; ++x) {
            const display::PixelRegion part{std::max(region.x0, x * tile_size - px), std::max(region.y0, y * tile_size - py),
                                            std::min(region.x1, (x + 1) * tile_size - px),
                                            std::min(region.y1, (y + 1) * tile_size - py)};
            std::vector<double> values;
            {
                const std::lock_guard lock(
                    locks_.of(static_cast<std::uint64_t>(y) * tiles_x_ + static_cast<std::uint64_t>(x)));
                values = read(part);
            }
            const std::size_t row = static_cast<std::size_t>(part.width()) * components;
            for (int line = 0; line < part.height(); ++line)
                std::copy_n(values.data() + static_cast<std::size_t>(line) * row, row,
                            result.data() + (static_cast<std::size_t>(part.y0 - region.y0 + line) *
                                                 static_cast<std::size_t>(region.width()) +
                                             static_cast<std::size_t>(part.x0 - region.x0)) *
                                                components);
        }
    return result;
}

std::vector<double> RenderLoop::resolve(display::ChannelId id, const display::PixelRegion& region) const {
    const auto type = job_.channels[static_cast<std::size_t>(id)].type;
    return by_tiles(region, static_cast<std::size_t>(display::component_count(type)),
                    [&](const display::PixelRegion& part) { return frame_buffer_.resolve(id, part); });
}

std::vector<double> RenderLoop::resolve_alpha(const display::PixelRegion& region) const {
    return by_tiles(region, 1, [&](const display::PixelRegion& part) { return frame_buffer_.resolve_alpha(part); });
}

std::vector<double> RenderLoop::resolve_variance_of_mean(display::ChannelId id, const display::PixelRegion& region) const {
    const display::ChannelDefinition& channel = job_.channels[static_cast<std::size_t>(id)];
    if (!channel.statistics) return {};
    return by_tiles(region, static_cast<std::size_t>(display::component_count(channel.type)),
                    [&](const display::PixelRegion& part) { return frame_buffer_.resolve_variance_of_mean(id, part); });
}

std::optional<display::AdaptiveProgress> RenderLoop::error() const {
    if (job_.adaptive) return job_.adaptive->progress();
    if (limited_ && limited_->error() != nullptr) return *limited_->error();
    return std::nullopt;
}

Status RenderLoop::start_up(const std::function<void()>& report) {
    const RenderPosition begin = position_;
    position_.task = 0;
    position_.unfinished.clear();
    tasks_ = tiles_;
    starting_ = true;
    const Status status = run_tasks(report);
    starting_ = false;
    position_ = begin;
    if (status && !ending()) job_.integrator->end_startup();
    return status;
}

bool RenderLoop::finished() const {
    if (limited_) return limit_reached_;
    return job_.adaptive ? job_.adaptive->done() : position_.phase >= phases_;
}

void RenderLoop::begin_phase() {
    tasks_ = rounds_ * tiles_;
    if (job_.integrator->synchronous()) {  // its phases are parts of one numbering of tasks
        position_.task = position_.phase * tiles_;
        tasks_ = position_.task + tiles_;
    }
    if (limited_) tasks_ = (pass_end_ + block_size - 1) / block_size * tiles_;
    if (!job_.adaptive) return;
    open_tiles_.clear();
    for (std::uint64_t tile = 0; tile < tiles_; ++tile) {
        const int x0 = static_cast<int>(tile % tiles_x_) * tile_size, y0 = static_cast<int>(tile / tiles_x_) * tile_size;
        const int x1 = std::min(x0 + tile_size, job_.film.width), y1 = std::min(y0 + tile_size, job_.film.height);
        bool open = false;
        for (int y = y0; y < y1 && !open; ++y)
            for (int x = x0; x < x1 && !open; ++x) open = job_.adaptive->open(x, y);
        if (open) open_tiles_.push_back(static_cast<std::uint32_t>(tile));
    }
    tasks_ = open_tiles_.size();
}

Status RenderLoop::run_phase(const std::function<void()>& report) {
    for (;;) {
        if (Status s = run_tasks(report); !s) return s;
        if (whole_phase() || ending()) return success();
        save_checkpoint();
    }
}

void RenderLoop::end_phase() {
    if (job_.adaptive) job_.adaptive->decide(frame_buffer_);
    ++position_.phase;
    if (limited_) choose_pass();
    else position_.task = 0;
}

Status RenderLoop::run(const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop) {
    stop_ = stop;
    watch_ = Stopwatch();
    if (job_.only) {
        flush_denormals();
        job_.integrator->begin_iteration(0);
        TileLocks::Group adding = locks_.group(0, 0, 1, false);
        workers_.front()->render_sample(*job_.only, adding);
        return success();
    }
    // Splatting takes samples from around the image too.
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(job_.region.width()) * static_cast<std::uint64_t>(job_.region.height());
    const auto report = [&] {
        if (!progress) return;
        const std::uint64_t done = samples_done_.load(std::memory_order_relaxed);
        const display::AdaptiveProgress* error = limited_ ? limited_->error() : nullptr;
        if (job_.adaptive) error = &job_.adaptive->progress();
        std::uint64_t total = pixels * (job_.samples_per_pixel - job_.first_sample);
        std::uint64_t least = 0;
        if (limited_) {
            const display::Forecast forecast = limited_->predicted(done, job_.seconds_before_loop + seconds());
            total = static_cast<std::uint64_t>(forecast.expected);
            least = static_cast<std::uint64_t>(forecast.least);
        } else if (job_.adaptive) {
            total = std::max(error->predicted_samples, done);
            least = error->least_samples;
        }
        progress({done, total, seconds(), error, this, least});
    };
    if (job_.integrator->starts_up())
        if (Status s = start_up(report); !s) return s;
    if (limited_ && !ending()) choose_pass();
    while (!finished() && !(job_.integrator->starts_up() && ending())) {
        begin_phase();
        job_.integrator->begin_iteration(position_.phase);
        if (Status s = run_phase(report); !s) return s;
        std::vector<IntegratorThread*> states;
        for (auto& worker : workers_) states.push_back(&worker->state());
        job_.integrator->end_iteration(position_.phase, states);
        const bool whole = whole_phase();
        if (whole) end_phase();
        if (!whole && !stopped() && ending()) {
            if (Status s = take_back_pass(); !s) return s;
            if (!finished() && !ending()) continue;
            break;
        }
        if (stopped()) {
            // Amid an iteration there is nothing consistent to save: the last checkpoint stays.
            if (checkpoint_ && (whole || !by_passes()) && !finished() && samples_done_.load() > 0 && !splats_left_behind())
                save_checkpoint();
            break;
        }
        if (checkpoint_due() && !finished()) save_checkpoint();
    }
    complete_ = finished();
    if (writer_) writer_->wait();
    report();
    return success();
}

bool RenderLoop::checkpoint_due() const {
    return checkpoint_ != nullptr && !writer_->busy() && watch_.wall() - last_checkpoint_ >= checkpoint_->seconds;
}

void RenderLoop::save_checkpoint() {
    const double begin = watch_.wall();
    RenderPosition position{position_.phase, position_.task, position_.unfinished, {}};
    collect(position.statistics);
    position.statistics.render_seconds = position_.statistics.render_seconds + begin;
    writer_->wait();
    try {
        writer_->start(make_checkpoint(identity_, position, job_, frame_buffer_));
    } catch (const std::bad_alloc&) {  // no reason to give up the render
        writer_->fail(error_at({}, "not enough memory to copy the record for a checkpoint"));
    }
    last_checkpoint_ = watch_.wall();
    stall_seconds_ += last_checkpoint_ - begin;
}

void RenderLoop::collect(RenderStatistics& statistics) const {
    const RenderStatistics& earlier = position_.statistics;
    IntegratorCounters counters;
    counters.camera_rays = earlier.camera_rays;
    counters.scattering_rays = earlier.scattering_rays;
    counters.shadow_rays = earlier.shadow_rays;
    counters.path_lengths = earlier.path_length_histogram;
    statistics.render_seconds += earlier.render_seconds;
    statistics.render_cpu_seconds += earlier.render_cpu_seconds;
    statistics.camera_samples += earlier.camera_samples;
    statistics.attribution_overflow += earlier.attribution_overflow;
    statistics.invalid_samples += earlier.invalid_samples;
    statistics.invalid_by_channel = earlier.invalid_by_channel;
    statistics.refused_services_calls += earlier.refused_services_calls;
    statistics.refusals = earlier.refusals;
    statistics.invalid_log = earlier.invalid_log;
    statistics.checkpoints = writer_ ? writer_->written() : 0;
    statistics.checkpoint_stall_seconds = stall_seconds_;
    for (const auto& worker : workers_) {
        const WorkerTotals& totals = worker->totals();
        counters.add(totals.counters);
        statistics.camera_samples += worker->samples;
        statistics.render_cpu_seconds += worker->cpu_seconds;
        statistics.attribution_overflow += totals.overflow;
        statistics.invalid_samples += totals.invalid;
        statistics.invalid_by_channel.resize(job_.channels.size());
        for (std::size_t i = 0; i < job_.channels.size(); ++i)
            statistics.invalid_by_channel[i] += totals.invalid_by_channel[i];
        statistics.invalid_log.insert(statistics.invalid_log.end(), totals.invalid_log.begin(), totals.invalid_log.end());
        const std::span<const display::RefusalCounts> refusals = worker->display().refusals();
        statistics.refusals.resize(refusals.size());
        for (std::size_t i = 0; i < refusals.size(); ++i) {
            statistics.refusals[i].add(refusals[i]);
            statistics.refused_services_calls += refusals[i].total();
        }
    }
    // In the order of tasks. Every thread takes its tasks in that order, so the first ones of all threads are among the
    // first ones of each, whatever their number.
    const auto task_of = [&](const display::InvalidSample& each) {
        return std::tuple(each.sample / block_size, (each.pixel_y + job_.padding_y) / tile_size,
                          (each.pixel_x + job_.padding_x) / tile_size);
    };
    std::stable_sort(statistics.invalid_log.begin(), statistics.invalid_log.end(),
                     [&](const auto& a, const auto& b) { return task_of(a) < task_of(b); });
    if (statistics.invalid_log.size() > display::SampleTable::invalid_samples_kept)
        statistics.invalid_log.resize(display::SampleTable::invalid_samples_kept);
    statistics.camera_rays = counters.camera_rays;
    statistics.scattering_rays = counters.scattering_rays;
    statistics.shadow_rays = counters.shadow_rays;
    statistics.path_length_histogram = counters.path_lengths;
}

}  // namespace raylex::transport
