#include "transport/render/stages/camera_hits.h"

#include <algorithm>
#include <stdexcept>

#include "transport/integrators/methods/path.h"

namespace raylex::transport {
namespace {

std::unique_ptr<Integrator> path_of_camera_rays() {
    PathParameters parameters;
    parameters.max_depth = 0;
    return make_path_integrator(parameters);
}

void copy_row(const display::SampleTable& from, int row, display::SampleTable& to, int to_row) {
    const auto i = static_cast<std::size_t>(row), j = static_cast<std::size_t>(to_row);
    to.depth[j] = from.depth[i];
    to.is_volume[j] = from.is_volume[i];
    to.opacity[j] = from.opacity[i];
    to.surface[j] = from.surface[i];
}

}  // namespace

CameraHits::CameraHits(const PreparedJob& prepared)
    : events_(no_channels_, prepared.job.scene.view(), prepared.job.settings.labels.lobe_slots),
      path_(path_of_camera_rays()),
      seen_(prepared.job.channels.list, prepared.context().batch_capacity),
      display_(seen_),
      lpe_(no_channels_, seen_, prepared.job.sampling.seed) {
    IntegratorContext context = prepared.context();
    context.events = &events_;
    context.services.lpe = &no_channels_;
    context.beauty = false;
    context.plan = nullptr;
    if (const Status status = path_->prepare(context); !status) throw std::runtime_error(status.error().message);
    thread_ = path_->make_thread_state();
}

void CameraHits::supply(const CameraBatch& batch, display::SampleTable& table) {
    const int rays = table.camera_row_count();
    const auto reported = [&](int row) { return table.reported[static_cast<std::size_t>(row)] != 0; };
    seen_.begin(batch.rows);
    ThreadServices services{display_, lpe_};
    path_->integrate(batch, *thread_, services);
    for (int row = 0; row < seen_.row_count(); ++row) {
        const int ray = seen_.original(row);
        if (reported(ray)) continue;
        if (const int to = row < rays ? row : table.add_row(ray); to >= 0) copy_row(seen_, row, table, to);
    }
    using RowState = display::SampleTable::RowState;
    for (display::ChannelId id = 0; id < table.channel_count(); ++id) {
        if (table.channel(id).style != display::ChannelStyle::name || !seen_.touched(id)) continue;
        const auto components = static_cast<std::size_t>(display::component_count(table.channel(id).type));
        for (int row = 0; row < rays; ++row) {
            if (!seen_.written(id, row) || table.written(id, row)) continue;
            std::copy_n(seen_.values(id) + static_cast<std::size_t>(row) * components, components,
                        table.edit(id, row).data());
            if (seen_.row_state(id, row) == RowState::splatted) table.set_row_state(id, row, RowState::splatted);
        }
    }
}

}  // namespace raylex::transport
