#include "transport/render/schedule.h"

#include <algorithm>

#include "transport/render/schedules/adaptive_schedule.h"
#include "transport/render/schedules/limited_schedule.h"
#include "transport/render/schedules/plain_schedule.h"
#include "transport/render/schedules/replay_schedule.h"
#include "transport/render/schedules/synchronous_schedule.h"
#include "transport/render/stages/render_state.h"

namespace raylex::transport {

void Schedule::end_phase(RenderState& state) {
    ++state.position.phase;
    state.position.task = 0;
}

std::unique_ptr<Schedule> make_schedule(const PreparedJob& prepared, const RenderTarget& target) {
    const ResolvedJob& job = prepared.job;
    if (job.budget.only) return std::make_unique<ReplaySchedule>(job);
    if (job.budget.adaptive) return std::make_unique<AdaptiveSchedule>(job, target.frame_buffer);
    if (job.budget.limit) return std::make_unique<LimitedSchedule>(job, target.frame_buffer);
    const auto wants_phases = [](const display::SampleSink* sink) { return sink->wants_phases(); };
    if (job.integrator().synchronous() || std::any_of(target.sinks.begin(), target.sinks.end(), wants_phases))
        return std::make_unique<SynchronousSchedule>(job);
    return std::make_unique<PlainSchedule>(job);
}

}  // namespace raylex::transport
