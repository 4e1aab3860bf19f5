#include "transport/integrators/path_contributions.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "transport/cameras/camera.h"
#include "transport/paths/subpaths/camera_subpaths.h"

namespace raylex::transport {

PathContributions::PathContributions(const IntegratorContext& context, const Integrator& integrator,
                                     const std::vector<display::ChannelId>& channels)
    : context_(context),
      integrator_(integrator),
      channels_(channels),
      table_(context.services.channels, context.batch_capacity),
      display_(table_),
      lpe_(context.services.on(table_)),
      raster_(*context.services.lpe, context.services.channels, context.services.seed, context.services.attribution,
              *this, table_),
      thread_(integrator.make_thread_state()),
      rows_(static_cast<std::size_t>(context.batch_capacity)),
      rays_(rows_.size()),
      samplers_(rows_.size()),
      contributions_(rows_.size()) {}

void PathContributions::begin(std::size_t row, const PixelSampler& numbers, std::uint64_t sample) {
    const RasterArea area = context_.view.reached();
    const Vec2 u = numbers.get_2d(filter_dimension);
    display::CameraRow& at = rows_[row] = display::CameraRow();
    at.screen_x = to_float(area.corner.x + area.size.x * u.x);
    at.screen_y = to_float(area.corner.y + area.size.y * u.y);
    at.pixel_x = static_cast<std::int32_t>(std::floor(at.screen_x));
    at.pixel_y = static_cast<std::int32_t>(std::floor(at.screen_y));
    at.sample = sample;
    const Real time = sample_time(context_.scene, numbers);
    at.shutter_time = to_float(time);
    const Camera& camera = *context_.view.camera;
    const Vec2 lens = camera.has_lens() ? numbers.get_2d(lens_dimension) : Vec2{0, 0};
    rays_[row] = camera.generate({at.screen_x, at.screen_y, lens, time});
    if (context_.scene.materials->filters_images())  // a path may stand for many samples of a pixel
        rays_[row].cone = cone_of_sample(rays_[row].cone, ~std::uint64_t{0});
    samplers_[row] = numbers;
}

bool PathContributions::follow(std::size_t count, ThreadServices& services) {
    table_.begin({rows_.data(), count});
    row_of_.clear();
    for (std::size_t i = 0; i < count; ++i) {
        contributions_[i].positions.assign(1, {rows_[i].screen_x, rows_[i].screen_y});
        contributions_[i].values.resize(3 * channels_.size());
        contributions_[i].refused = 0;
    }
    ThreadServices own{.display = display_, .lpe = lpe_, .raster = &raster_, .leave = services.leave};
    integrator_.integrate({{rays_.data(), count}, {samplers_.data(), count}, {rows_.data(), count}}, *thread_, own);
    services.left = own.left;
    if (own.left) {
        raster_.discard();
        return false;
    }
    raster_.finish();
    for (std::size_t i = 0; i < count; ++i) {
        contributions_[i].refused += table_.invalid_count(static_cast<int>(i));
        for (std::size_t k = 0; k < channels_.size(); ++k)
            std::copy_n(table_.values(channels_[k]) + 3 * i, 3, &contributions_[i].values[3 * k]);
    }
    return true;
}

void PathContributions::report_refused(std::size_t row, ThreadServices& services) const {
    for (std::uint32_t i = 0; i < contributions_[row].refused; ++i) {
        const display::Tracker tracker = services.raster->begin(rows_[row].screen_x, rows_[row].screen_y, rows_[row]);
        services.raster->lpe().contribute(raylex::Rgb(std::numeric_limits<float>::quiet_NaN()), {}, tracker);
    }
}

/// Splats of the paths, behind what their rows bring.
void PathContributions::take(display::SampleTable& splats) {
    for (std::size_t i = row_of_.size(); i < static_cast<std::size_t>(table_.camera_row_count()); ++i)
        row_of_[rows_[i].sample] = i;
    for (int splat = 0; splat < splats.camera_row_count(); ++splat) {
        const display::CameraRow& where = splats.camera_row(splat);
        PathContribution& path = contributions_[row_of_.at(where.sample)];
        path.refused += splats.invalid_count(splat);
        path.positions.push_back({where.screen_x, where.screen_y});
        for (const display::ChannelId id : channels_) {
            const double* value = splats.values(id) + 3 * static_cast<std::size_t>(splat);
            path.values.insert(path.values.end(), value, value + 3);
        }
    }
}

}  // namespace raylex::transport
