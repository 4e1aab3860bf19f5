#include "transport/render/stages/render_worker.h"

#include <algorithm>
#include <cmath>

#include "transport/math/make_at.h"
#include "transport/paths/subpaths/camera_subpaths.h"
#include "transport/render/clock.h"

namespace raylex::transport {

void SplatGate::take(display::SampleTable& table) {
    ++taken_;
    sample_filters_.apply(table);
    const int tile = TileGrid::tile_size;
    // The computed end of a splat's footprint may be off by a rounding; half a pixel more compensates for it.
    const Real reach_x = filter_.radius_x() + 1, reach_y = filter_.radius_y() + 1;
    const std::uint64_t columns = grid_.columns();
    order_.clear();
    for (int row = 0; row < table.camera_row_count(); ++row) {
        const display::CameraRow& splat = table.camera_row(row);
        const int x = std::clamp(static_cast<int>(std::floor(splat.screen_x)), 0, grid_.width - 1) + grid_.padding_x,
                  y = std::clamp(static_cast<int>(std::floor(splat.screen_y)), 0, grid_.height - 1) + grid_.padding_y;
        const Real in_x = static_cast<Real>(x % tile), in_y = static_cast<Real>(y % tile),
                   end = static_cast<Real>(tile) - 1;
        const bool around = in_x < reach_x || in_y < reach_y || in_x > end - reach_x || in_y > end - reach_y;
        const std::uint64_t number =
            static_cast<std::uint64_t>(y / tile) * columns + static_cast<std::uint64_t>(x / tile);
        order_.emplace_back(2 * number + (around ? 1 : 0), row);
    }
    std::sort(order_.begin(), order_.end());
    for (std::size_t begin = 0, end = 0; begin < order_.size(); begin = end) {
        rows_.clear();
        for (; end < order_.size() && order_[end].first == order_[begin].first; ++end)
            rows_.push_back(order_[end].second);
        const std::uint64_t number = order_[begin].first / 2;
        TileLocks::Group adding = locks_.group(number, grid_, order_[begin].first % 2 != 0);
        const std::lock_guard lock(adding);
        target_.frame_buffer.splat(table, rows_);
        for (display::SampleSink* sink : target_.sinks) sink->splat(table, rows_);
    }
}

RenderWorker::RenderWorker(const PreparedJob& prepared, RenderTarget& target, TileLocks& locks,
                           const std::atomic<bool>& leave)
    : job_(prepared.job),
      aovs_(*prepared.aovs),
      target_(target),
      locks_(locks),
      table_(job_.channels.list, batch_capacity, target.splat_sets.get()),
      display_(table_),
      lpe_(*job_.channels.lpe, table_, job_.sampling.seed, job_.channels.attribution),
      gate_(job_, locks, target),
      raster_(job_.raster()
                  ? std::make_unique<display::RasterSplats>(*job_.channels.lpe, job_.channels.list, job_.sampling.seed,
                                                            job_.channels.attribution, gate_, table_)
                  : nullptr),
      camera_hits_(job_.integrator().traits().first_hits ? nullptr : std::make_unique<CameraHits>(prepared)),
      state_(job_.integrator().make_thread_state()),
      rows_(batch_capacity),
      camera_samples_(batch_capacity),
      rays_(batch_capacity),
      weights_(job_.sampling.camera->weighs_rays() ? batch_capacity : 0),
      samplers_(batch_capacity),
      filter_pairs_(batch_capacity),
      leave_(leave) {}

void RenderWorker::begin_tile(std::uint64_t tile) {
    tile_ = static_cast<std::uint32_t>(tile);
    adding_ = locks_.group(tile, job_.grid, job_.sampling.splat);
}

void RenderWorker::add_tile(std::uint64_t tile, std::uint64_t first, int count) {
    begin_tile(tile);
    std::uint64_t block = 0;
    job_.grid.for_each_pixel(tile, [&](int x, int y) { add_pixel(x, y, first, count, block++); });
}

void RenderWorker::start_up(std::uint64_t tile) {
    begin_tile(tile);
    startup_ = true;
    const display::PixelRegion pixels = job_.grid.pixels_of(tile);
    add_pixel(pixels.x0, pixels.y0, 0, 1, 0);
    flush();
    startup_ = false;
}

void RenderWorker::add_pixel(int x, int y, std::uint64_t first, int count, std::uint64_t block) {
    if (block < skip_) return;
    if (count_ + static_cast<std::size_t>(count) > rows_.size()) flush();
    if (left_) return;
    const CameraSampling& from = job_.sampling;
    const bool lens = from.camera->has_lens();
    filter_pairs_.clear();
    for (int k = 0; k < count; ++k) {
        const std::uint64_t sample = first + static_cast<std::uint64_t>(k);
        PixelSampler& sampler = samplers_[count_ + static_cast<std::size_t>(k)];
        make_at(sampler, [&] { return PixelSampler(from.sampler, from.seed, x, y, sample, from.arrangement_bits); });
        filter_pairs_.add(sampler, filter_dimension);
    }
    const bool together = count > 0 && SamplerBatch::takes(samplers_[count_]);
    if (together) filter_pairs_.draw();
    for (int k = 0; k < count; ++k) {
        const std::uint64_t sample = first + static_cast<std::uint64_t>(k);
        const PixelSampler& sampler = samplers_[count_];
        const Vec2 u = together ? filter_pairs_[static_cast<std::size_t>(k)] : sampler.get_2d(filter_dimension);
        const display::FilterSample offset = from.splat
                                                 ? display::FilterSample{to_float(u.x) - 0.5f, to_float(u.y) - 0.5f, 1}
                                                 : from.filter->sample(to_float(u.x), to_float(u.y));
        display::CameraRow& row = rows_[count_];
        row.pixel_x = x;
        row.pixel_y = y;
        row.screen_x = static_cast<float>(x) + 0.5f + offset.dx;
        row.screen_y = static_cast<float>(y) + 0.5f + offset.dy;
        row.filter_weight = offset.weight;
        const Real time = from.times ? sample_time(job_.scene.view(), sampler) : 0;
        row.shutter_time = to_float(time);
        row.sample = sample;
        camera_samples_[count_] = {row.screen_x, row.screen_y, lens ? sampler.get_2d(lens_dimension) : Vec2{0, 0},
                                   time};
        ++count_;
    }
    added_ = block + 1;
    if (aovs_.wants_time()) flush();  // so that every pixel is timed separately
}

void RenderWorker::flush() {
    if (count_ == 0) return;
    note_totals();
    if (leave_.load(std::memory_order_relaxed)) {  // also if the integrator never checks it
        left_ = true;
        count_ = 0;
        return;
    }
    const Camera& camera = *job_.sampling.camera;
    const std::span<Real> weights(weights_.data(), weights_.empty() ? 0 : count_);
    if (!weights.empty()) camera.generate_weighed({camera_samples_.data(), count_}, {rays_.data(), count_}, weights);
    else if (job_.sampling.times) camera.generate_in_time({camera_samples_.data(), count_}, {rays_.data(), count_});
    else camera.generate({camera_samples_.data(), count_}, {rays_.data(), count_});
    if (job_.sampling.cones)
        for (std::size_t i = 0; i < count_; ++i) rays_[i].cone = cone_of_sample(rays_[i].cone, rows_[i].sample);
    table_.begin({rows_.data(), count_});
    const double begin = aovs_.wants_time() ? thread_cpu_seconds() : 0;
    const std::uint64_t overflow_before = overflow();
    ThreadServices services{display_, lpe_, raster_.get(), &leave_};
    const CameraBatch batch{
        {rays_.data(), count_}, {samplers_.data(), count_}, {rows_.data(), count_}, tile_, startup_, weights};
    job_.integrator().integrate(batch, *state_, services);
    if (services.left) {
        if (raster_) raster_->discard();
        left_ = true;
        count_ = 0;
        return;
    }
    if (raster_) raster_->finish();
    if (table_.discarded()) {
        dropped_overflow_ += overflow() - overflow_before;
        if (!startup_) discarded_samples += count_;
    } else {
        if (camera_hits_) camera_hits_->supply(batch, table_);
        if (raster_) target_.frame_buffer.count_light_paths(count_);
        finish_samples(begin);
        const std::lock_guard lock(adding_);
        target_.frame_buffer.accumulate(table_);
        for (display::SampleSink* sink : target_.sinks) sink->accumulate(table_);
        if (!startup_) samples += count_;
    }
    count_ = 0;
    done_ = added_;
}

/// The number of moves that had to collapse branches, including those of discarded iterations.
std::uint64_t RenderWorker::overflow() const {
    return lpe_.overflow_count() + (raster_ ? raster_->lpe().overflow_count() : 0);
}

void RenderWorker::note_totals() {
    totals_.counters = state_->counters;
    totals_.overflow = overflow() - dropped_overflow_;
    std::uint64_t invalid = table_.invalid_total();
    if (raster_) invalid += raster_->table().invalid_total();
    splats_taken_ = gate_.taken();
    if (invalid == totals_.invalid && !totals_.invalid_by_channel.empty()) return;
    totals_.invalid = invalid;
    totals_.invalid_by_channel.assign(job_.channels.list.size(), 0);
    totals_.invalid_log.clear();
    const auto add = [&](const display::SampleTable& table) {
        for (std::size_t i = 0; i < job_.channels.list.size(); ++i)
            totals_.invalid_by_channel[i] += table.invalid_by_channel()[i];
        totals_.invalid_log.insert(totals_.invalid_log.end(), table.invalid_log().begin(), table.invalid_log().end());
    };
    add(table_);
    if (raster_) add(raster_->table());
}

const WorkerTotals& RenderWorker::totals() {
    if (!left_) note_totals();
    return totals_;
}

/// Processes samples between the integrator and the frame buffer.
void RenderWorker::finish_samples(double begin) {
    if (aovs_.wants_rays()) {
        camera_rays_.origin_z.resize(count_);
        camera_rays_.direction_z.resize(count_);
        Real m[3][4];
        job_.sampling.camera->rigid_world_to_camera(m);
        const Vec3 axis{m[2][0], m[2][1], m[2][2]};
        for (std::size_t i = 0; i < count_; ++i) {
            camera_rays_.origin_z[i] = to_float(dot(axis, rays_[i].origin) + m[2][3]);
            camera_rays_.direction_z[i] = to_float(dot(axis, rays_[i].direction));
        }
        aovs_.write_rays(camera_rays_, table_, display_);
    }
    job_.channels.filters.apply(table_);
    if (aovs_.wants_samples())
        aovs_.write_samples(aovs_.wants_time() ? thread_cpu_seconds() - begin : 0, table_, display_);
}

}  // namespace raylex::transport
