// How a render ends before its budget: after a stop and by the clock, without waiting for batches that may never end.
#include <algorithm>
#include <limits>
#include <new>

#include "transport/render/render_loop.h"

namespace raylex::transport {
namespace {

/// How long threads may go on with their batches after a stop, and with a pass after the time was over. Threads are looked
/// at every 0.2 s: together that leaves a render half a second to end in.
constexpr double stop_grace_seconds = 0.15, time_grace_seconds = 0.4;

}  // namespace

void RenderLoop::watch_threads() {
    const double now = seconds();
    if (stopped() && !stop_seen_) stop_seen_ = now;
    if ((stop_seen_ && now - *stop_seen_ > stop_grace_seconds) || time_left() < -time_grace_seconds || pass_is_too_long())
        leave_.store(true, std::memory_order_relaxed);
}

double RenderLoop::time_left() const {
    if (!limited_ || job_.limit->seconds <= 0) return std::numeric_limits<double>::infinity();
    return job_.limit->seconds - job_.seconds_before_loop - seconds();
}

/// By now, of what the pass has to do: tasks that are finished.
double RenderLoop::pass_share_done() const {
    const double pixels = static_cast<double>(job_.film.width + 2 * job_.padding_x) *
                          static_cast<double>(job_.film.height + 2 * job_.padding_y);
    return static_cast<double>(samples_done_.load() - pass_begin_samples_) /
           (pixels * static_cast<double>(pass_end_ - pass_begin_));
}

/// A first pass is as long as it is before anybody knows how long a sample takes. Half of the time shows.
bool RenderLoop::pass_is_too_long() const {
    if (!first_pass_ || starting_ || job_.integrator->synchronous() || !before_pass_) return false;
    if (pass_end_ - pass_begin_ <= 1 || time_left() > 0.5 * job_.limit->seconds) return false;
    const double share = pass_share_done();
    return (seconds() - pass_begin_seconds_) * (1 - share) > time_left() * share;
}

/// Tasks are taken in order: those before the next are in the frame buffer but for what threads had to leave, no others.
void RenderLoop::take_unfinished() {
    position_.task = std::min(next_.load(), tasks_);
    std::vector<UnfinishedTask>& unfinished = position_.unfinished;
    const auto taken = std::min<std::uint64_t>(next_unfinished_.load(), unfinished.size());
    unfinished.erase(unfinished.begin(), unfinished.begin() + static_cast<std::ptrdiff_t>(taken));
    unfinished.insert(unfinished.end(), left_tasks_.begin(), left_tasks_.end());
    left_tasks_.clear();
    std::sort(unfinished.begin(), unfinished.end(), [](const auto& a, const auto& b) { return a.task < b.task; });
}

bool RenderLoop::splats_left_behind() const {
    return std::any_of(workers_.begin(), workers_.end(), [](const auto& worker) { return worker->splats_left_behind(); });
}

void RenderLoop::choose_pass() {
    const std::uint64_t done = pass_end_ > 0 ? pass_end_ : position_.task / tiles_ * block_size;  // 0: the session begins
    first_pass_ = pass_end_ == 0 && job_.limit->seconds_per_sample <= 0;
    pass_end_ = limited_->next_end(done, job_.seconds_before_loop + seconds(), frame_buffer_);
    limit_reached_ = pass_end_ == done;
    samples_per_pixel_ = pass_end_;
    pass_begin_ = done;
    pass_begin_seconds_ = seconds();
    pass_begin_samples_ = samples_done_.load();
    before_pass_.reset();
    if (limit_reached_ || job_.limit->seconds <= 0 || !can_take_back()) return;
    RenderPosition position{position_.phase, position_.task, {}, {}};
    collect(position.statistics);
    try {
        before_pass_ = make_checkpoint({}, position, job_, frame_buffer_);
    } catch (const std::bad_alloc&) {  // then this pass cannot be taken back: no reason to give up the render
        before_pass_.reset();
    }
}

/// What takes in raw samples beside the image keeps them.
bool RenderLoop::can_take_back() const {
    return std::all_of(job_.sinks.begin(), job_.sinks.end(), [&](const display::SampleSink* sink) {
        return std::any_of(job_.cryptomatte.begin(), job_.cryptomatte.end(),
                           [&](const geoaovs::Cryptomatte& each) { return &each.coverage() == sink; });
    });
}

/// A pass that cannot end in time gives up its samples, so that all pixels have as many and the same number asked for gives
/// the same bits. A first pass is begun again with fewer, if there is time for that; when even one sample of all pixels
/// takes too long, there is nothing whole to go back to: what there is stays, as after a stop.
Status RenderLoop::take_back_pass() {
    if (!before_pass_) return success();
    const double left = time_left(), share = pass_share_done(), passed = seconds() - pass_begin_seconds_;
    const bool again = first_pass_ && left > 0;
    if (!again && pass_begin_ == 0) return success();
    auto restored = restore_record(*before_pass_, {}, job_, frame_buffer_);
    if (!restored) return restored.error();
    position_ = *std::move(restored);
    samples_done_.store(position_.statistics.camera_samples);
    if (job_.splat_sets) frame_buffer_.expect(*job_.splat_sets);
    make_workers();
    if (!again) {
        samples_per_pixel_ = pass_end_ = pass_begin_;
        limit_reached_ = true;
        return success();
    }
    const double samples = static_cast<double>(pass_end_ - pass_begin_), in_time = 0.9 * left / passed * share * samples;
    const auto fitting = static_cast<std::uint64_t>(std::clamp(in_time, 1.0, samples - 1));
    samples_per_pixel_ = pass_end_ = pass_begin_ + fitting;
    pass_begin_seconds_ = seconds();
    first_pass_ = false;
    leave_.store(false);
    return success();
}

}  // namespace raylex::transport
