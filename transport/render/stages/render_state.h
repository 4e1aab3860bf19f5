// The state of a running render: its position, and the threads' workers. Schedules read it between phases, when no
// samples are in progress. Private to transport/render.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "display/checkpoint/record_file.h"
#include "transport/render/clock.h"
#include "transport/render/render_position.h"
#include "transport/render/schedule.h"
#include "transport/render/stages/render_worker.h"

namespace raylex::transport {

class RenderState {
  public:
    /// All arguments must outlive the state. The state has no position before the first call of seek().
    /// `since_call` measures the time since the call of render().
    RenderState(const PreparedJob& prepared, RenderTarget& target, Schedule& schedule, const Stopwatch& since_call);
    RenderState(const RenderState&) = delete;
    RenderState& operator=(const RenderState&) = delete;

    /// Wall time in seconds, with earlier sessions: seconds() of the loop, and of the whole call of render().
    [[nodiscard]] double seconds() const { return position.statistics.render_seconds + watch_.wall(); }
    [[nodiscard]] double seconds_since_call() const { return position.statistics.render_seconds + since_call_.wall(); }
    /// Wall time of this session's loop.
    [[nodiscard]] double session_seconds() const { return watch_.wall(); }

    /// Sets position and statistics to `from`, for a target that is in that state, and makes new workers.
    void seek(RenderPosition from);
    /// Position and statistics for a record.
    [[nodiscard]] RenderPosition current() const;
    /// The record that go_back_to() needs; throws std::bad_alloc. Not available if the caller has sinks.
    [[nodiscard]] display::RecordFile snapshot() const;
    Status go_back_to(const display::RecordFile& snapshot);
    /// Adds the statistics of all threads and of earlier sessions.
    void collect(RenderStatistics& statistics) const;
    /// After a stop: whether the image contains splats of unfinished light paths.
    [[nodiscard]] bool splats_left_behind() const;
    /// Whether any sample of this session wrote to the channel.
    [[nodiscard]] bool ever_touched(display::ChannelId id) const;
    [[nodiscard]] std::vector<IntegratorThread*> thread_states() const;

    const PreparedJob& prepared;
    RenderTarget& target;
    Schedule& schedule;
    RenderPosition position;
    mutable TileLocks locks;
    std::vector<std::unique_ptr<RenderWorker>> workers;  ///< one per thread
    std::atomic<std::uint64_t> samples_done{0};          ///< camera samples in the frame buffer
    std::atomic<bool> leave{false};                      ///< threads must leave their batches

  private:
    Stopwatch since_call_, watch_;
};

}  // namespace raylex::transport
