#include "transport/render/stages/render_state.h"

#include <algorithm>
#include <tuple>

#include "transport/render/stages/checkpoint.h"

namespace raylex::transport {
namespace {

/// Sorts in the order of tasks and keeps the first. Every thread takes its tasks in that order, so the first samples of
/// all threads are among the first of each, whatever the number of threads.
void keep_first(const TileGrid& grid, std::vector<display::InvalidSample>& log) {
    const auto task_of = [&](const display::InvalidSample& each) {
        return std::tuple(each.sample / TileGrid::block_size, (each.pixel_y + grid.padding_y) / TileGrid::tile_size,
                          (each.pixel_x + grid.padding_x) / TileGrid::tile_size);
    };
    std::stable_sort(log.begin(), log.end(), [&](const auto& a, const auto& b) { return task_of(a) < task_of(b); });
    if (log.size() > display::SampleTable::invalid_samples_kept) log.resize(display::SampleTable::invalid_samples_kept);
}

}  // namespace

RenderState::RenderState(const PreparedJob& of, RenderTarget& into, Schedule& by, const Stopwatch& since_call)
    : prepared(of), target(into), schedule(by), since_call_(since_call) {}

void RenderState::seek(RenderPosition from) {
    position = std::move(from);
    samples_done.store(position.statistics.camera_samples);
    if (target.splat_sets) target.frame_buffer.expect(*target.splat_sets);
    workers.clear();
    for (int i = 0; i < prepared.job.threads; ++i)
        workers.push_back(std::make_unique<RenderWorker>(prepared, target, locks, leave));
}

RenderPosition RenderState::current() const {
    RenderPosition now{position.phase, position.task, position.unfinished, {}};
    collect(now.statistics);
    return now;
}

display::RecordFile RenderState::snapshot() const {
    return make_checkpoint({}, current(), *this);
}

Status RenderState::go_back_to(const display::RecordFile& record) {
    auto restored = restore_record(record, {}, *this);
    if (!restored) return restored.error();
    seek(*std::move(restored));
    return success();
}

bool RenderState::splats_left_behind() const {
    return std::any_of(workers.begin(), workers.end(), [](const auto& worker) { return worker->splats_left_behind(); });
}

bool RenderState::ever_touched(display::ChannelId id) const {
    return std::any_of(workers.begin(), workers.end(),
                       [&](const auto& worker) { return worker->table().ever_touched(id); });
}

std::vector<IntegratorThread*> RenderState::thread_states() const {
    std::vector<IntegratorThread*> states;
    for (const auto& worker : workers) states.push_back(&worker->state());
    return states;
}

void RenderState::collect(RenderStatistics& statistics) const {
    const RenderStatistics& earlier = position.statistics;
    IntegratorCounters counters;
    counters.camera_rays = earlier.camera_rays;
    counters.scattering_rays = earlier.scattering_rays;
    counters.shadow_rays = earlier.shadow_rays;
    counters.branches = earlier.branches;
    counters.pruned = earlier.pruned;
    counters.path_lengths = earlier.path_length_histogram;
    statistics.render_seconds += earlier.render_seconds;
    statistics.render_cpu_seconds += earlier.render_cpu_seconds;
    statistics.camera_samples += earlier.camera_samples;
    statistics.discarded_samples += earlier.discarded_samples;
    statistics.attribution_overflow += earlier.attribution_overflow;
    statistics.invalid_samples += earlier.invalid_samples;
    statistics.invalid_by_channel = earlier.invalid_by_channel;
    statistics.refused_services_calls += earlier.refused_services_calls;
    statistics.refusals = earlier.refusals;
    statistics.invalid_log = earlier.invalid_log;
    const std::size_t channels = prepared.job.channels.list.size();
    for (const auto& worker : workers) {
        const WorkerTotals& totals = worker->totals();
        counters.add(totals.counters);
        statistics.camera_samples += worker->samples;
        statistics.discarded_samples += worker->discarded_samples;
        statistics.render_cpu_seconds += worker->cpu_seconds;
        statistics.attribution_overflow += totals.overflow;
        statistics.invalid_samples += totals.invalid;
        statistics.invalid_by_channel.resize(channels);
        for (std::size_t i = 0; i < channels; ++i) statistics.invalid_by_channel[i] += totals.invalid_by_channel[i];
        statistics.invalid_log.insert(statistics.invalid_log.end(), totals.invalid_log.begin(),
                                      totals.invalid_log.end());
        const std::span<const display::RefusalCounts> refusals = worker->display().refusals();
        statistics.refusals.resize(refusals.size());
        for (std::size_t i = 0; i < refusals.size(); ++i) {
            statistics.refusals[i].add(refusals[i]);
            statistics.refused_services_calls += refusals[i].total();
        }
    }
    keep_first(prepared.job.grid, statistics.invalid_log);
    statistics.camera_rays = counters.camera_rays;
    statistics.scattering_rays = counters.scattering_rays;
    statistics.shadow_rays = counters.shadow_rays;
    statistics.branches = counters.branches;
    statistics.pruned = counters.pruned;
    statistics.path_length_histogram = counters.path_lengths;
}

}  // namespace raylex::transport
