#include "transport/render/loop/render_loop.h"

#include "display/services/channel_prefixes.h"
#include "transport/render/clock.h"
#include "transport/render/schedules/start_up_schedule.h"

namespace raylex::transport {

Result<std::unique_ptr<RenderLoop>> RenderLoop::begin(const PreparedJob& prepared, RenderTarget& target,
                                                      const Stopwatch& since_call, const RenderStatistics& earlier) {
    std::unique_ptr<RenderLoop> loop(new RenderLoop(prepared, target, make_schedule(prepared, target), since_call));
    auto saver = RenderSaver::make(loop->state_);
    if (!saver) return saver.error();
    loop->saver_ = *std::move(saver);
    if (Status s = loop->saver_->start(loop->state_, earlier); !s) return s.error();
    loop->resumed_samples_ = loop->state_.position.statistics.camera_samples;
    loop->untraced_before_ = prepared.job.scene.view().geometry->untraced_rays();
    return loop;
}

Status RenderLoop::start_up(TaskRunner& runner, const std::function<void()>& report) {
    Integrator& integrator = state_.prepared.job.integrator();
    const RenderPosition then = state_.position;
    state_.position.task = 0;
    state_.position.unfinished.clear();
    StartUpSchedule first(state_.prepared.job.grid, *schedule_);
    const auto meanwhile = [&] {
        report();
        return false;
    };
    const Status status = runner.run(first, first.begin_phase(state_.position), saver_->interval(), meanwhile);
    state_.position = then;
    if (status && !runner.ending()) integrator.end_startup();
    return status;
}

Result<bool> RenderLoop::run_phase(TaskRunner& runner, const std::function<void()>& report) {
    Integrator& integrator = state_.prepared.job.integrator();
    const RenderPosition& position = state_.position;
    const std::uint64_t end = schedule_->begin_phase(state_.position);
    const auto whole = [&] { return position.task >= end && position.unfinished.empty(); };
    const auto meanwhile = [&] {
        report();
        return schedule_->can_save_amid_phase() && saver_->due(state_);
    };
    integrator.begin_iteration(position.phase);
    for (;;) {
        if (Status s = runner.run(*schedule_, end, saver_->interval(), meanwhile); !s) return s.error();
        if (whole() || runner.ending()) break;
        saver_->save(state_);
    }
    integrator.end_iteration(position.phase, state_.thread_states());
    return whole();
}

Status RenderLoop::run_phases(TaskRunner& runner, const std::function<void()>& report) {
    while (!schedule_->finished(state_.position)) {
        auto whole = run_phase(runner, report);
        if (!whole) return whole.error();
        if (*whole) schedule_->end_phase(state_);
        for (display::SampleSink* sink : state_.target.sinks) sink->end_phase();
        if (!*whole && !runner.stopped() && runner.ending()) {
            if (Status s = schedule_->after_overdue(state_); !s) return s;
            if (runner.ending()) break;
            continue;
        }
        const bool more = !schedule_->finished(state_.position);
        if (runner.stopped()) {
            // Within an iteration there is no consistent state to save: the last checkpoint remains.
            if (saver_->enabled() && more && (*whole || schedule_->can_save_amid_phase()) &&
                state_.samples_done.load() > 0 && !state_.splats_left_behind())
                saver_->save(state_);
            break;
        }
        if (more && saver_->due(state_)) saver_->save(state_);
    }
    return success();
}

Result<FinishedLoop> RenderLoop::run(const std::function<void(const RenderProgress&)>& progress,
                                     const std::atomic<bool>* stop) {
    TaskRunner runner(state_, stop);
    const TiledImage image(state_);
    const auto report = [&] {
        if (!progress) return;
        const std::uint64_t done = state_.samples_done.load(std::memory_order_relaxed);
        const display::Forecast forecast = schedule_->expected_samples(done, state_);
        progress({done, static_cast<std::uint64_t>(forecast.expected), state_.seconds(), schedule_->error(), &image,
                  static_cast<std::uint64_t>(forecast.least)});
    };
    const bool starts_up = state_.prepared.job.integrator().starts_up();
    if (starts_up) {
        const Stopwatch watch;
        if (Status s = start_up(runner, report); !s) return s.error();
        start_up_seconds_ = watch.wall();
        for (const auto& worker : state_.workers) start_up_cpu_seconds_ += worker->cpu_seconds;
    }
    if (!runner.ending()) schedule_->begin_session(state_);
    if (!starts_up || !runner.ending())
        if (Status s = run_phases(runner, report); !s) return s.error();
    FinishedLoop finished = finish();
    if (const std::size_t threads = runner.fewest_threads(); threads < state_.workers.size())
        finished.warnings.push_back(error_at(
            {},
            std::to_string(threads) + " of " + std::to_string(state_.workers.size()) +
                " threads rendered the image, with the same bits: the system cannot start more",
            "its limit of processes or of address space is reached: expected --threads " + std::to_string(threads)));
    report();
    return finished;
}

FinishedLoop RenderLoop::finish() {
    const ResolvedJob& job = state_.prepared.job;
    FinishedLoop finished;
    finished.samples = {.complete = schedule_->finished(state_.position),
                        .per_pixel = schedule_->samples_per_pixel(),
                        .resumed = resumed_samples_,
                        .adaptive = std::nullopt,
                        .unconverged_pixels = schedule_->unconverged()};
    if (schedule_->error() != nullptr) finished.samples.adaptive = *schedule_->error();
    RenderStatistics& statistics = finished.statistics;
    std::vector<Error>& warnings = finished.warnings;
    saver_->finish(statistics, warnings);
    if (const std::uint64_t untraced = job.scene.view().geometry->untraced_rays() - untraced_before_; untraced > 0)
        warnings.push_back(error_at({},
                                    std::to_string(untraced) +
                                        " rays began or pointed beyond what can be traced (1e18, less where "
                                        "instances shrink), or contained NaN, and were treated as misses",
                                    "another unit of length, or a smaller scene, brings rays into range"));
    const display::FrameBuffer& frame_buffer = state_.target.frame_buffer;
    statistics.build_seconds = job.scene.build_seconds;
    statistics.build_cpu_seconds = job.scene.build_cpu_seconds;
    statistics.prepare_seconds = state_.prepared.seconds + start_up_seconds_;
    statistics.pilot_rays = state_.prepared.paths->rays + state_.prepared.guide.rays;
    statistics.guide = state_.prepared.guide.summary;
    statistics.guide_view = state_.prepared.guide_view;
    statistics.prepare_cpu_seconds = state_.prepared.cpu_seconds + start_up_cpu_seconds_;
    statistics.render_seconds = state_.session_seconds() - start_up_seconds_;
    state_.collect(statistics);
    statistics.render_cpu_seconds -= start_up_cpu_seconds_;
    statistics.invalid_samples += frame_buffer.rejected_count();
    for (std::size_t i = 0; i < job.channels.list.size(); ++i)
        statistics.invalid_by_channel[i] += frame_buffer.rejected_count(static_cast<display::ChannelId>(i));
    for (std::size_t i = 0; i < job.channels.list.size() && resumed_samples_ == 0 && !job.bucket; ++i)
        if (const display::ChannelDefinition& channel = job.channels.list[i];
            channel.declared && statistics.camera_samples > 0 &&
            !state_.ever_touched(static_cast<display::ChannelId>(i)))
            warnings.push_back(
                error_at(display::location_of(channel),
                         "channel '" + channel.name + "' is empty: no plugin, pattern or integrator wrote to it",
                         "'raylex plugins FILE.so' lists the channels that a plugin declares"));
    for (std::string& cut : job.integrator().cuts()) warnings.push_back(error_at({}, std::move(cut)));
    for (std::string& refused : display::refusal_warnings(job.channels.list, statistics.refusals))
        warnings.push_back(error_at({}, std::move(refused)));
    return finished;
}

}  // namespace raylex::transport
