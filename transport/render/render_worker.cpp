// One thread of a render: it draws camera rays, has them followed, and hands what comes of them to the frame buffer.
#include "transport/render/render_loop.h"

#include <algorithm>
#include <cmath>

#include "transport/render/clock.h"

namespace raylex::transport {
namespace {

/// Pixel m of a tile along the Morton curve: batches cover compact squares, whose rays stay together.
void morton_pixel(int m, int& x, int& y) {
    x = y = 0;
    for (int bit = 0; (1 << bit) < RenderLoop::tile_size; ++bit) {
        x |= ((m >> (2 * bit)) & 1) << bit;
        y |= ((m >> (2 * bit + 1)) & 1) << bit;
    }
}

}  // namespace

TileLocks::Group TileLocks::group(std::uint64_t x, std::uint64_t y, std::uint64_t tiles_x, bool around) {
    Group group;
    group.locks_ = this;
    const std::uint64_t reach = around ? 1 : 0;
    for (std::uint64_t ty = y - std::min(y, reach); ty <= y + reach; ++ty)
        for (std::uint64_t tx = x - std::min(x, reach); tx <= std::min(x + reach, tiles_x - 1); ++tx)
            group.indices_[group.count_++] = (ty * tiles_x + tx) % mutexes_.size();
    const auto end = group.indices_.begin() + static_cast<std::ptrdiff_t>(group.count_);
    std::sort(group.indices_.begin(), end);
    group.count_ = static_cast<std::size_t>(std::unique(group.indices_.begin(), end) - group.indices_.begin());
    return group;
}

void SplatGate::take(const display::SampleTable& table) {
    ++taken_;
    const int tile = RenderLoop::tile_size;
    // Where a splat's footprint ends may be off by a rounding; half a pixel more makes up for it.
    const Real reach_x = job_.filter->radius_x() + 1, reach_y = job_.filter->radius_y() + 1;
    order_.clear();
    for (int row = 0; row < table.camera_row_count(); ++row) {
        const display::CameraRow& splat = table.camera_row(row);
        const int x = std::clamp(static_cast<int>(std::floor(splat.screen_x)), 0, job_.film.width - 1) + grid_.padding_x,
                  y = std::clamp(static_cast<int>(std::floor(splat.screen_y)), 0, job_.film.height - 1) + grid_.padding_y;
        const Real in_x = static_cast<Real>(x % tile), in_y = static_cast<Real>(y % tile),
                   end = static_cast<Real>(tile) - 1;
        const bool around = in_x < reach_x || in_y < reach_y || in_x > end - reach_x || in_y > end - reach_y;
        const std::uint64_t number = static_cast<std::uint64_t>(y / tile) * grid_.columns + static_cast<std::uint64_t>(x / tile);
        order_.emplace_back(2 * number + (around ? 1 : 0), row);
    }
    std::sort(order_.begin(), order_.end());
    for (std::size_t begin = 0, end = 0; begin < order_.size(); begin = end) {
        rows_.clear();
        for (; end < order_.size() && order_[end].first == order_[begin].first; ++end) rows_.push_back(order_[end].second);
        const std::uint64_t number = order_[begin].first / 2;
        TileLocks::Group adding =
            locks_.group(number % grid_.columns, number / grid_.columns, grid_.columns, order_[begin].first % 2 != 0);
        const std::lock_guard lock(adding);
        frame_buffer_.splat(table, rows_);
    }
}

RenderWorker::RenderWorker(const RenderJob& job, const TileGrid& grid, TileLocks& locks, display::FrameBuffer& frame_buffer,
                           const std::atomic<bool>& leave)
    : job_(job),
      frame_buffer_(frame_buffer),
      table_(job.channels, RenderLoop::batch_capacity, job.has_extra_rows ? 4 * RenderLoop::batch_capacity : 0,
             job.splat_sets.get()),
      display_(table_),
      lpe_(*job.lpe, table_, job.seed, job.attribution),
      gate_(job, grid, locks, frame_buffer),
      raster_(job.raster ? std::make_unique<display::RasterSplats>(*job.lpe, job.channels, job.seed, job.attribution, gate_)
                         : nullptr),
      state_(job.integrator->make_thread_state()),
      rows_(RenderLoop::batch_capacity),
      rays_(RenderLoop::batch_capacity),
      samplers_(RenderLoop::batch_capacity),
      leave_(leave) {}

void RenderWorker::render_tile(int x0, int y0, int x1, int y1, std::uint64_t first, int count, TileLocks::Group& adding) {
    std::uint64_t block = 0;
    for (int m = 0; m < RenderLoop::tile_size * RenderLoop::tile_size; ++m) {
        int dx, dy;
        morton_pixel(m, dx, dy);
        const int x = x0 + dx, y = y0 + dy;
        if (x < x1 && y < y1 && x >= job_.region.x0 && y >= job_.region.y0)
            add_pixel(x, y, first, count, block++, adding);
    }
    flush(adding);
}

void RenderWorker::start_up(int x0, int y0, std::uint32_t of, TileLocks::Group& adding) {
    tile = of;
    startup_ = true;
    add_pixel(x0, y0, 0, 1, 0, adding);
    flush(adding);
    startup_ = false;
}

void RenderWorker::render_open_pixels(int x0, int y0, int x1, int y1, std::uint64_t blocks, TileLocks::Group& adding) {
    const display::AdaptiveSampler& adaptive = *job_.adaptive;
    struct OpenPixel {
        int x, y;
        std::uint64_t first;
    };
    std::array<OpenPixel, RenderLoop::tile_size * RenderLoop::tile_size> pixels;
    std::size_t open = 0;
    for (int m = 0; m < RenderLoop::tile_size * RenderLoop::tile_size; ++m) {
        int dx, dy;
        morton_pixel(m, dx, dy);
        const int x = x0 + dx, y = y0 + dy;
        if (x < x1 && y < y1 && adaptive.open(x, y)) pixels[open++] = {x, y, frame_buffer_.sample_count(x, y)};
    }
    // What the frame buffer has of a task that was left is not of its beginning.
    for (std::size_t i = 0; i < open; ++i)
        pixels[i].first -= std::min(pixels[i].first, (skip_ / open + (i < skip_ % open ? 1 : 0)) * RenderLoop::block_size);
    for (std::uint64_t block = 0; block < blocks; ++block)
        for (std::size_t i = 0; i < open; ++i) {
            const std::uint64_t first = pixels[i].first + block * RenderLoop::block_size;
            if (first >= adaptive.max_samples()) continue;
            const auto count = std::min<std::uint64_t>(RenderLoop::block_size, adaptive.max_samples() - first);
            add_pixel(pixels[i].x, pixels[i].y, first, static_cast<int>(count), block * open + i, adding);
        }
    flush(adding);
}

void RenderWorker::add_pixel(int x, int y, std::uint64_t first, int count, std::uint64_t block, TileLocks::Group& adding) {
    if (block < skip_) return;
    if (count_ + static_cast<std::size_t>(count) > rows_.size()) flush(adding);
    if (left_) return;
    for (int k = 0; k < count; ++k) {
        const std::uint64_t sample = first + static_cast<std::uint64_t>(k);
        const PixelSampler sampler(job_.sampler, job_.seed, x, y, sample);
        const Vec2 u = sampler.get_2d(filter_dimension);
        const display::FilterSample offset =
            job_.splat ? display::FilterSample{to_float(u.x) - 0.5f, to_float(u.y) - 0.5f, 1}
                       : job_.filter->sample(to_float(u.x), to_float(u.y));
        display::CameraRow& row = rows_[count_];
        row.pixel_x = x;
        row.pixel_y = y;
        row.screen_x = static_cast<float>(x) + 0.5f + offset.dx;
        row.screen_y = static_cast<float>(y) + 0.5f + offset.dy;
        row.filter_weight = offset.weight;
        row.shutter_time = 0;
        row.sample = sample;
        rays_[count_] = job_.camera->generate(row.screen_x, row.screen_y,
                                              job_.camera->has_lens() ? sampler.get_2d(lens_dimension) : Vec2{0, 0});
        samplers_[count_] = sampler;
        ++count_;
    }
    added_ = block + 1;
    if (job_.aovs->wants_time()) flush(adding);  // so that every pixel is timed by itself
}

void RenderWorker::flush(TileLocks::Group& adding) {
    if (count_ == 0) return;
    note_totals();
    if (leave_.load(std::memory_order_relaxed)) {  // also where the integrator never asks
        left_ = true;
        count_ = 0;
        return;
    }
    table_.begin({rows_.data(), count_});
    const double begin = job_.aovs->wants_time() ? thread_cpu_seconds() : 0;
    ThreadServices services{display_, lpe_, raster_.get(), &leave_};
    job_.integrator->integrate({{rays_.data(), count_}, {samplers_.data(), count_}, {rows_.data(), count_}, tile, startup_},
                               *state_, services);
    if (services.left) {
        left_ = true;
        count_ = 0;
        return;
    }
    if (raster_ && table_.discarded()) raster_->discard();
    if (!table_.discarded()) {
        if (raster_) {
            raster_->flush();
            frame_buffer_.count_light_paths(count_);
        }
        finish_samples(begin);
        const std::lock_guard lock(adding);
        frame_buffer_.accumulate(table_);
        for (display::SampleSink* sink : job_.sinks) sink->accumulate(table_);
    }
    if (!startup_) samples += count_;
    count_ = 0;
    done_ = added_;
}

void RenderWorker::note_totals() {
    totals_.counters = state_->counters;
    totals_.overflow = lpe_.overflow_count();
    std::uint64_t invalid = table_.invalid_total();
    if (raster_) {
        totals_.overflow += raster_->lpe().overflow_count();
        invalid += raster_->table().invalid_total();
    }
    splats_taken_ = gate_.taken();
    if (invalid == totals_.invalid && !totals_.invalid_by_channel.empty()) return;
    totals_.invalid = invalid;
    totals_.invalid_by_channel.assign(job_.channels.size(), 0);
    totals_.invalid_log.clear();
    const auto add = [&](const display::SampleTable& table) {
        for (std::size_t i = 0; i < job_.channels.size(); ++i) totals_.invalid_by_channel[i] += table.invalid_by_channel()[i];
        totals_.invalid_log.insert(totals_.invalid_log.end(), table.invalid_log().begin(), table.invalid_log().end());
    };
    add(table_);
    if (raster_) add(raster_->table());
}

const WorkerTotals& RenderWorker::totals() {
    if (!left_) note_totals();
    return totals_;
}

/// What happens to samples between the integrator and the frame buffer.
void RenderWorker::finish_samples(double begin) {
    if (job_.aovs->wants_rays()) {
        camera_rays_.origin_z.resize(count_);
        camera_rays_.direction_z.resize(count_);
        Real m[3][4];
        job_.camera->rigid_world_to_camera(m);
        const Vec3 axis{m[2][0], m[2][1], m[2][2]};
        for (std::size_t i = 0; i < count_; ++i) {
            camera_rays_.origin_z[i] = to_float(dot(axis, rays_[i].origin) + m[2][3]);
            camera_rays_.direction_z[i] = to_float(dot(axis, rays_[i].direction));
        }
        job_.aovs->write_rays(camera_rays_, table_, display_);
    }
    job_.sample_filters.apply(table_);
    if (job_.aovs->wants_samples())
        job_.aovs->write_samples(job_.aovs->wants_time() ? thread_cpu_seconds() - begin : 0, table_, display_);
}

}  // namespace raylex::transport
