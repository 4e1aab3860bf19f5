// Saving a render while it goes on, and going on after a crash: private to transport/render. What a render
// is asked for stands in CheckpointSettings (render.h).
//
// A checkpoint is taken between tasks: the threads stop at the end of the task they are in, so the frame buffer holds
// tasks [0, position) of the phase, whole, and no others; which is all that has to be remembered of the order, but for
// the tasks that were left amid their batches when the render had to end at once. The record is copied while the
// threads stand still, and checked, written and synced by a thread of its own while they go on.
//
// Sections of the record (display/checkpoint/record_file.h): "progress", "frame buffer", that of the schedule and
// "integrator" when there is such a thing, and one for each set of mattes.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "display/checkpoint/record_file.h"
#include "transport/render/render_position.h"
#include "transport/render/resolve/resolved_job.h"

namespace raylex::transport {

class RenderState;

/// What a record must say for this render to go on from it: the caller's fields, then the render's own.
display::RecordIdentity render_identity(const ResolvedJob& job);

/// Whether this render can be saved at all; an Error names what cannot.
Status check_checkpoint(const CheckpointSettings& settings, const RenderState& state);

display::RecordFile make_checkpoint(const display::RecordIdentity& identity, const RenderPosition& position,
                                    const RenderState& state);

/// Fills the state's target, schedule and integrator from a record of this very render, and returns where it stood.
/// `file` is for errors.
Result<RenderPosition> restore_record(const display::RecordFile& record, const std::string& file, RenderState& state);

/// As restore_record(), from the settings' file. Errors: no such file, damaged, of another render (all that differs is
/// named).
Result<RenderPosition> restore_checkpoint(const CheckpointSettings& settings, const display::RecordIdentity& identity,
                                          RenderState& state);

/// Writes one record at a time beside the render.
class CheckpointWriter {
  public:
    explicit CheckpointWriter(std::string file) : file_(std::move(file)) {}
    ~CheckpointWriter() { wait(); }
    CheckpointWriter(const CheckpointWriter&) = delete;
    CheckpointWriter& operator=(const CheckpointWriter&) = delete;

    [[nodiscard]] bool busy() const { return busy_.load(); }
    /// Not while busy().
    void start(display::RecordFile record);
    void wait();
    /// Takes note of a record that could not even be made.
    void fail(Error error);
    /// After wait(): whether the last record that start() was given is safe on disk.
    [[nodiscard]] bool last_written() const { return last_written_; }
    /// After wait(): records that are safe on disk, and what went wrong with the others, said once for each reason.
    [[nodiscard]] std::uint64_t written() const { return written_.load(); }
    [[nodiscard]] const std::vector<Error>& failures() const { return failures_; }

  private:
    std::string file_;
    std::thread thread_;
    std::atomic<bool> busy_{false};
    std::atomic<std::uint64_t> written_{0};
    std::vector<Error> failures_;
    bool last_written_ = false;
};

}  // namespace raylex::transport
