#include "transport/render/loop/render_saver.h"

#include <new>

namespace raylex::transport {

Result<RenderSaver> RenderSaver::make(const RenderState& state) {
    RenderSaver saver;
    const ResolvedJob& job = state.prepared.job;
    if (!job.checkpoint || job.budget.only) return saver;  // a single sample needs no checkpoint
    if (Status s = check_checkpoint(*job.checkpoint, state); !s) return s.error();
    saver.settings_ = &*job.checkpoint;
    saver.identity_ = render_identity(job);
    saver.writer_ = std::make_unique<CheckpointWriter>(saver.settings_->file);
    return saver;
}

Status RenderSaver::start(RenderState& state, const RenderStatistics& earlier) const {
    RenderPosition position = state.schedule.beginning();
    position.statistics = earlier;
    if (enabled() && settings_->resume) {
        auto restored = restore_checkpoint(*settings_, identity_, state);
        if (!restored) return restored.error();
        position = *std::move(restored);
    }
    state.seek(std::move(position));
    return success();
}

bool RenderSaver::due(const RenderState& state) const {
    return enabled() && !writer_->busy() && state.session_seconds() - last_ >= settings_->seconds;
}

void RenderSaver::save(const RenderState& state) {
    const double begin = state.session_seconds();
    RenderPosition position = state.current();
    position.statistics.render_seconds = state.seconds();
    writer_->wait();
    try {
        display::RecordFile record = make_checkpoint(identity_, position, state);
        const TrainedGuide& guide = state.prepared.guide;
        if (!state.prepared.job.bucket && guide.summary.samples > 0) record.add(guide_section) = guide.record();
        writer_->start(std::move(record));
    } catch (const std::bad_alloc&) {
        writer_->fail(error_at({}, "not enough memory to copy the record for a checkpoint"));
    }
    last_ = state.session_seconds();
    stall_ += last_ - begin;
}

Status RenderSaver::keep(const RenderState& state) {
    save(state);
    writer_->wait();
    if (writer_->last_written()) return success();
    Error error = writer_->failures().back();
    error.message = "a finished bucket could not be saved: " + error.message;
    error.hint = "the previous buckets are saved: free disk space and continue with --resume";
    return error;
}

void RenderSaver::finish(RenderStatistics& statistics, std::vector<Error>& warnings) {
    if (!enabled()) return;
    writer_->wait();
    statistics.checkpoints = writer_->written();
    statistics.checkpoint_stall_seconds = stall_;
    for (Error error : writer_->failures()) {
        error.message = "a checkpoint could not be saved: " + error.message;
        warnings.push_back(std::move(error));
    }
}

}  // namespace raylex::transport
