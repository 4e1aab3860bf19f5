#include "transport/render/schedules/limited_schedule.h"

#include <algorithm>
#include <limits>
#include <new>

#include "transport/render/schedules/plain_schedule.h"
#include "transport/render/stages/render_state.h"

namespace raylex::transport {
namespace {

/// The time for which threads may continue a pass after the limit. Threads are checked every 0.2 s: a render ends at
/// most half a second after its time.
constexpr double time_grace_seconds = 0.4;

}  // namespace

LimitedSchedule::LimitedSchedule(const ResolvedJob& job, const display::FrameBuffer& frame_buffer)
    : grid_(job.grid),
      tiles_(job.grid.region_count()),
      first_sample_(job.budget.first_sample),
      most_(job.budget.samples_per_pixel),
      limit_(*job.budget.limit),
      synchronous_(job.integrator().synchronous()),
      passes_(limit_, most_, TileGrid::block_size, synchronous_, job.channels.list, job.channels.beauty,
              frame_buffer.layout()) {}

RenderPosition LimitedSchedule::beginning() const {
    RenderPosition position;
    const std::uint64_t block = first_sample_ / TileGrid::block_size;
    position.task = block * tiles_;
    if (synchronous_) position.phase = block;  // the passes are single blocks
    return position;
}

std::uint64_t LimitedSchedule::begin_phase(RenderPosition& /*position*/) {
    return TileGrid::blocks_for(end_) * tiles_;
}

void LimitedSchedule::render(std::uint64_t task, RenderWorker& worker) const {
    render_block(task, grid_, end_, worker);
}

void LimitedSchedule::end_phase(RenderState& state) {
    ++state.position.phase;
    choose_pass(state);
}

double LimitedSchedule::time_left(const RenderState& state) const {
    if (limit_.seconds <= 0) return std::numeric_limits<double>::infinity();
    return limit_.seconds - state.seconds_since_call();
}

/// The share of the pass's tasks that are finished now.
double LimitedSchedule::share_done(const RenderState& state) const {
    const double pixels = static_cast<double>(grid_.width + 2 * grid_.padding_x) *
                          static_cast<double>(grid_.height + 2 * grid_.padding_y);
    return static_cast<double>(state.samples_done.load() - begin_samples_) /
           (pixels * static_cast<double>(end_ - begin_));
}

/// The length of a first pass is chosen before the time of a sample is known. Half of the time is enough to measure it.
bool LimitedSchedule::pass_is_too_long(const RenderState& state) const {
    if (!first_pass_ || synchronous_ || !before_) return false;
    if (end_ - begin_ <= 1 || time_left(state) > 0.5 * limit_.seconds) return false;
    const double share = share_done(state);
    return (state.seconds_since_call() - begin_seconds_) * (1 - share) > time_left(state) * share;
}

bool LimitedSchedule::overdue(const RenderState& state) const {
    return time_left(state) < -time_grace_seconds || pass_is_too_long(state);
}

void LimitedSchedule::choose_pass(const RenderState& state) {
    const std::uint64_t done = pass_chosen_ ? end_ : state.position.task / tiles_ * TileGrid::block_size;
    first_pass_ = !pass_chosen_ && limit_.seconds_per_sample <= 0;
    pass_chosen_ = true;
    end_ = passes_.next_end(done, state.seconds_since_call(), state.target.frame_buffer);
    reached_ = end_ == done;
    begin_ = done;
    begin_seconds_ = state.seconds_since_call();
    begin_samples_ = state.samples_done.load();
    before_.reset();
    if (reached_ || limit_.seconds <= 0 || state.target.has_sinks_of_others()) return;
    try {
        before_ = state.snapshot();
    } catch (const std::bad_alloc&) {  // this pass cannot be undone then, which does not end the render
        before_.reset();
    }
}

Status LimitedSchedule::after_overdue(RenderState& state) {
    if (!before_) return success();
    const double left = time_left(state), share = share_done(state),
                 passed = state.seconds_since_call() - begin_seconds_;
    const bool again = first_pass_ && left > 0;
    if (!again && begin_ == 0) return success();
    if (Status s = state.go_back_to(*before_); !s) return s;
    if (!again) {
        end_ = begin_;
        reached_ = true;
        return success();
    }
    const double samples = static_cast<double>(end_ - begin_), in_time = 0.9 * left / passed * share * samples;
    end_ = begin_ + static_cast<std::uint64_t>(std::clamp(in_time, 1.0, samples - 1));
    begin_seconds_ = state.seconds_since_call();
    first_pass_ = false;
    state.leave.store(false);
    return success();
}

display::Forecast LimitedSchedule::expected_samples(std::uint64_t done, const RenderState& state) const {
    return passes_.predicted(done, state.seconds_since_call());
}

}  // namespace raylex::transport
