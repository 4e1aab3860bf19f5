#include "transport/paths/subpaths/connect.h"

#include <algorithm>
#include <utility>

#include "transport/math/make_at.h"

namespace raylex::transport {

void Connections::clear() {
    pending_.clear();
    blockable_.clear();
    ends_.clear();
    shadow_rays_.clear();
}

void Connections::add_light_sample(const CameraSubpaths& subpaths, std::size_t j, const LightSample& sample,
                                   const BsdfEvaluation& f, Real weight) {
    const VertexBatch& v = subpaths.vertices();
    const std::uint32_t row = v.rows[j];
    const Subpath& path = subpaths.path(row);
    const Record& record = subpaths.record();
    const Rgb throughput = subpaths.throughput(row);
    const Rgb value = throughput * f.value * sample.radiance * (weight / sample.pdf);
    if (record.wants_blocked_light()) {
        const Rgb unweighted = throughput * f.value * sample.radiance * (1 / sample.pdf);
        if (unweighted.is_black()) return;
        blockable_.push_back({scene_.lights->emitted(sample, v.points[j].position), unweighted});
    } else if (value.is_black()) {
        return;
    }
    Pending& pending = pending_.emplace_back();
    pending.row = row;
    pending.light = sample.light;
    pending.label = v.sources[j].label;
    pending.medium = in_media_ ? subpaths.medium_towards(j, sample.wi) : -1;
    pending.end = no_end;
    pending.technique = {1, path.depth + 2};
    pending.value = value;
    pending.lobes = f.lobes;
    if (!record.takes_all(row) && !needs_shadow_ray(record)) return;
    Ray& ray = shadow_rays_.emplace_back();
    make_at(ray, [&] {
        return shadow_ray(v.points[j].position, v.points[j].geometric_normal, v.sources[j].offset.here, sample);
    });
    ray.time = v.hits[j].time;
}

void Connections::add_connection(const CameraSubpaths& subpaths, const VertexConnection& connection) {
    const VertexBatch& v = subpaths.vertices();
    const std::uint32_t row = v.rows[connection.j];
    const Record& record = subpaths.record();
    const Rgb value = connection.unweighted * connection.weight;
    if (record.wants_blocked_light()) blockable_.push_back({Rgb(), connection.unweighted});
    else if (value.is_black()) return;
    ends_.push_back(connection.end);
    Pending& pending = pending_.emplace_back();
    pending.row = row;
    pending.light = no_light;
    pending.label = v.sources[connection.j].label;
    pending.medium = in_media_ ? subpaths.medium_towards(connection.j, connection.shadow_ray.direction) : -1;
    pending.end = static_cast<std::uint32_t>(ends_.size() - 1);
    pending.technique = {connection.light_vertices, subpaths.path(row).depth + 2};
    pending.value = value;
    pending.lobes = connection.f->lobes;
    if (!record.takes_all(row) && !needs_shadow_ray(record)) return;
    shadow_rays_.push_back(connection.shadow_ray);
    shadow_rays_.back().time = v.hits[connection.j].time;
}

bool Connections::needs_shadow_ray(const Record& record) {
    const Pending& p = pending_.back();
    const LightEnd* end = p.end == no_end ? nullptr : &ends_[p.end];
    using Liveness = Record::Liveness;
    const Liveness live =
        record.liveness_of_connection(p.row, p.label, p.lobes, p.light, end, scene_.geometry->has_alpha());
    if (live == Liveness::if_visible || (live == Liveness::if_visible_or_not && scene_.media->any())) return true;
    ++rays_left_out_;
    if (live == Liveness::if_visible_or_not) {
        display::Tracker tracker = record.after(p.row, p.label, p.lobes);
        const Rgb unweighted = blockable_.back().unweighted;
        Arrival arrival{.value = p.value, .unweighted = unweighted, .sampled_too = end != nullptr};
        report_one(record, pending_.size() - 1, arrival, tracker);
    }
    pending_.pop_back();
    if (record.wants_blocked_light()) blockable_.pop_back();
    if (end != nullptr) ends_.pop_back();
    return false;
}

/// `tracker` has moved past everything in between. `arrival` lacks the emitted radiance alone.
void Connections::report_one(const Record& record, std::size_t i, Arrival& arrival, display::Tracker& tracker) const {
    const Pending& p = pending_[i];
    if (p.end == no_end) record.reach_light(tracker, p.light);
    else record.reach(tracker, ends_[p.end]);
    if (record.wants_blocked_light()) arrival.emitted = blockable_[i].emitted;
    record.add(tracker, p.technique, arrival);
}

void Connections::report(CameraSubpaths& subpaths) {
    const std::size_t count = pending_.size();
    IntegratorCounters& counters = subpaths.counters();
    counters.pruned[static_cast<std::size_t>(Pruned::shadow_rays)] += std::exchange(rays_left_out_, 0);
    if (count == 0) return;
    const Record& record = subpaths.record();
    const EmbreeScene& geometry = *scene_.geometry;
    counters.shadow_rays += count;
    blocked_.resize(std::max(blocked_.size(), count));
    geometry.occluded(shadow_rays_, {blocked_.data(), count});
    const bool blockable = record.wants_blocked_light();
    const bool attenuates = scene_.tests_alpha() || in_media_;
    for (std::size_t i = 0; i < count; ++i) {
        if (blocked_[i] && !blockable) continue;
        const Pending& pending = pending_[i];
        display::Tracker tracker = record.after(pending.row, pending.label, pending.lobes);
        Arrival arrival{.value = pending.value,
                        .unweighted = blockable ? blockable_[i].unweighted : Rgb(),
                        .visibility = blocked_[i] ? 0.0f : 1.0f,
                        .sampled_too = pending.end != no_end};
        if (attenuates && (!blocked_[i] || in_media_)) {
            Rgb transmittance(1);
            // Channels of blocked light take what the media let pass, also those behind the surface that blocks it.
            const bool to_the_end = in_media_ && blockable;
            PassThroughRay walk{.scene = scene_, .record = record, .counters = counters, .to_the_end = to_the_end};
            if (in_grids_)
                walk.numbers = FlightNumbers(subpaths.sampler(pending.row)
                                                 .key(subpath_dimensions<TransportMode::radiance>.connections +
                                                      subpaths.path(pending.row).depth),
                                             pending.technique.s);
            arrival.visibility = pass_through_transmittance(walk, shadow_rays_[i], arrival.visibility, pending.medium,
                                                            tracker, transmittance);
            if (!(arrival.visibility > 0) && !blockable) continue;
            arrival.value *= arrival.visibility;
            if (in_media_) {
                arrival.value *= transmittance;
                arrival.unweighted *= transmittance;
            }
        }
        if (!(arrival.visibility > 0)) arrival.value = Rgb();
        report_one(record, i, arrival, tracker);
    }
    clear();
}

}  // namespace raylex::transport
