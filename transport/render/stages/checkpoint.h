// Saves a render while it runs, and continues it after a crash. Private to transport/render. CheckpointSettings
// (render.h) contains the settings.
//
// A checkpoint is taken between tasks. The threads stop at the end of their tasks, so the frame buffer contains exactly
// the complete tasks [0, position) of the phase. Nothing else about the order needs to be stored, except tasks that
// were left within their batches because the render had to end at once. The record is copied while the threads wait. A
// separate thread checks, writes and syncs it while they continue.
//
// Sections of the record (display/checkpoint/record_file.h): "progress", "frame buffer", the schedule's and
// "integrator" if they exist, and one for each set of mattes.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "display/checkpoint/record_file.h"
#include "transport/render/pilots/guide_pilot.h"
#include "transport/render/render_position.h"
#include "transport/render/resolve/resolved_job.h"

namespace raylex::transport {

class RenderState;

inline constexpr const char* guide_section = "guide";  ///< TrainedGuide::record()

/// The fields that a record must match for this render to continue from it: the caller's fields, then the render's own.
display::RecordIdentity render_identity(const ResolvedJob& job);

/// Checks that this render can be saved; an Error names what cannot.
Status check_checkpoint(const CheckpointSettings& settings, const RenderState& state);

display::RecordFile make_checkpoint(const display::RecordIdentity& identity, const RenderPosition& position,
                                    const RenderState& state);

/// Fills the state's target, schedule and integrator from a record of this render, and returns its position. `file` is
/// for errors.
Result<RenderPosition> restore_record(const display::RecordFile& record, const std::string& file, RenderState& state);

/// Reads the guide of the checkpoint from which a render continues; nothing if there is none.
Result<std::optional<TrainedGuide>> saved_guide(const ResolvedJob& job);

/// Reads the settings' file and calls restore_record(). Errors: no such file, damage, a file of another render (with
/// all differences).
Result<RenderPosition> restore_checkpoint(const CheckpointSettings& settings, const display::RecordIdentity& identity,
                                          RenderState& state);

/// Writes one record at a time while the render continues.
class CheckpointWriter {
  public:
    explicit CheckpointWriter(std::string file) : file_(std::move(file)) {}
    ~CheckpointWriter() { wait(); }
    CheckpointWriter(const CheckpointWriter&) = delete;
    CheckpointWriter& operator=(const CheckpointWriter&) = delete;

    [[nodiscard]] bool busy() const { return busy_.load(); }
    /// Starts writing `record`; must not be called while busy().
    void start(display::RecordFile record);
    void wait();
    /// Records an error for a record that could not be made.
    void fail(Error error);
    /// After wait(): whether the last record passed to start() is on disk.
    [[nodiscard]] bool last_written() const { return last_written_; }
    /// After wait(): the number of records on disk. Errors of other records are reported once per reason.
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
