#include "transport/integrators/bdpt.h"

#include <algorithm>
#include <cmath>

#include "transport/integrators/bdpt_state.h"
#include "transport/integrators/first_hits.h"
#include "transport/paths/walk.h"

namespace raylex::transport {

IntegratorTraits Bdpt::traits() const {
    IntegratorTraits traits;
    traits.max_depth = parameters_.max_depth;
    traits.saved_state = SavedState::none;
    traits.raster_splats = true;
    return traits;
}

Status Bdpt::prepare(const IntegratorContext& context) {
    context_ = context;
    view_ = {context.camera, context.width, context.height, context.filter_radius};
    const LightTable& lights = *context.scene.lights;
    can_sample_lights_ = lights.can_sample(LightChoice::mis);
    can_emit_ = parameters_.max_depth > 0 && lights.can_sample(LightChoice::light_sampling) &&
                (context.beauty || context.events->any());
    return success();
}

std::unique_ptr<IntegratorThread> Bdpt::make_thread_state() const {
    LightSubpathOptions options;
    options.max_depth = parameters_.max_depth;
    options.roulette = parameters_.roulette;
    options.words = context_.events->any();
    options.densities = true;
    return std::make_unique<BdptThread>(context_.scene, options, static_cast<std::size_t>(context_.batch_capacity));
}

void Bdpt::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<BdptThread&>(state);
    if (!trace_light(batch, thread, services)) return;
    start_camera(batch, thread, services);
    while (thread.queue.count > 0) {
        if (services.leaving()) return;
        trace_camera(batch, thread, services);
    }
    connect_to_camera(batch, thread, services);  // last: splats cannot be taken back
}

bool Bdpt::trace_light(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const {
    thread.light_vertices.clear();
    thread.invalid_powers.clear();
    std::fill_n(thread.last_vertex.begin(), batch.rays.size(), LightVertex::none);
    if (!can_emit_) return true;
    LightSubpaths& light = thread.light;
    light.begin(batch.samplers, thread.counters);
    while (light.going()) {
        if (services.leaving()) return false;
        light.advance(batch.samplers, thread.counters, services.display);
        keep_light_vertices(thread);
        light.scatter(batch.samplers, thread.counters,
                      [&](std::uint32_t row, const Rgb& power) { thread.invalid_powers.emplace_back(row, power); });
    }
    return true;
}

void Bdpt::keep_light_vertices(BdptThread& thread) const {
    const VertexBatch& v = thread.light.vertices();
    for (std::size_t j = 0; j < v.count; ++j) {
        if (!v.bsdfs[j].has_density()) continue;
        const std::uint32_t row = v.rows[j];
        const LightSubpath& path = thread.light.path(row);
        const auto index = static_cast<std::uint32_t>(thread.light_vertices.size());
        thread.light_vertices.push_back({v.points[j], v.bsdfs[j], v.sources[j].offset, v.sources[j].label, row,
                                         path.light, path.depth,
                                         static_cast<std::uint32_t>(thread.light.word(row).size()),
                                         thread.last_vertex[row], path.power, thread.light.sums(row)});
        thread.last_vertex[row] = index;
    }
}

void Bdpt::start_camera(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const {
    const std::size_t count = batch.rays.size();
    thread.queue.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        CameraSubpath& path = thread.paths[i];
        path = CameraSubpath();
        path.from = batch.rays[i].origin;
        path.sums.join = 1;  // of the first vertex with the camera: t = 1
        thread.trackers[i] = services.lpe.begin(static_cast<int>(i));
        thread.queue.push(row, batch.rays[i]);
    }
    thread.counters.camera_rays += count;
}

void Bdpt::trace_camera(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const {
    VertexBatch& v = thread.vertices;
    trace(*context_.scene.geometry, thread.queue, v, [&](std::uint32_t row, const Ray& ray, const Hit& hit) {
        if (hit.valid()) return true;
        find_environments(thread, services, row, ray);
        thread.counters.count_length(thread.paths[row].depth);
        return false;
    });
    resolve(batch, thread, services);
    if (v.count == 0) return;
    context_.scene.materials->shade(*context_.scene.textures, {v.points.data(), v.count}, {v.bsdfs.data(), v.count},
                                    &services.display);
    write_first_hits(context_, v, {thread.first_entries.data(), thread.first_count}, thread.first_hits,
                     services.display);
    thread.joins.clear();
    thread.shadow_rays.clear();
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        if (!v.bsdfs[j].has_density() || thread.paths[row].depth >= parameters_.max_depth ||
            !services.lpe.live(thread.trackers[row]))
            continue;
        if (can_sample_lights_) sample_light(batch, thread, services, j);
        join_vertices(thread, services, j);
    }
    add_joins(thread, services);
    scatter(batch, thread, services);
}

void Bdpt::resolve(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const {
    VertexBatch& v = thread.vertices;
    const EmbreeScene& geometry = *context_.scene.geometry;
    const bool cutouts = geometry.has_alpha();
    const bool first_hits_count = context_.aovs->inputs() != 0 || context_.pattern_channels;
    std::size_t kept = 0;
    thread.first_count = 0;
    for (std::size_t j = 0; j < v.count; ++j) {
        const ShapeGeometry& shape = geometry.shapes()[v.hits[j].shape];
        const std::uint32_t row = v.rows[j];
        CameraSubpath& path = thread.paths[row];
        SurfacePoint& point = v.points[j];
        const float cosine = std::abs(dot(point.geometric_normal, point.wo));
        const double near = 1 / static_cast<double>(length_squared(point.position - path.from));
        path.sums.arrive(path.depth == 0
                             ? view_.density(context_.camera->importance(point.position, path.from), cosine)
                             : static_cast<double>(path.pdf) * static_cast<double>(cosine) * near,
                         static_cast<double>(path.cosine) * near);
        const bool emits = shape.first_light != Hit::none;
        if (cutouts && shape.alpha >= 0) {
            if (emits && shape.interface) find_light(thread, services, j);  // a light without a surface still shines
            if (passes_cutout(batch, thread, services, j)) continue;
        }
        if (path.depth == 0)
            record_first_hit(geometry, static_cast<int>(row), path.travelled + v.hits[j].t, v.hits[j],
                             services.display);
        if (emits) find_light(thread, services, j);
        const bool worth = (path.depth == 0 && first_hits_count) ||
                           (path.depth < parameters_.max_depth && services.lpe.live(thread.trackers[row]));
        if (!worth) {
            thread.counters.count_length(path.depth);
            continue;
        }
        point.random_key = batch.samplers[row].key(camera_dimension(path, camera_key_dimension));
        point.row = path.depth == 0 ? static_cast<std::int32_t>(row) : -1;
        if (path.depth == 0) thread.first_entries[thread.first_count++] = static_cast<std::uint32_t>(kept);
        v.keep(j, kept++);
    }
    v.count = kept;
}

bool Bdpt::passes_cutout(const CameraBatch& batch, BdptThread& thread, ThreadServices& services, std::size_t j) const {
    const VertexBatch& v = thread.vertices;
    const std::uint32_t row = v.rows[j];
    CameraSubpath& path = thread.paths[row];
    if (!passes_alpha_test(context_.scene, v, j,
                           batch.samplers[row].get_random(camera_cutout_dimensions + path.segment)))
        return false;
    services.lpe.move(thread.trackers[row], context_.events->straight(v.sources[j].label));
    path.travelled += v.hits[j].t;
    // This ray went through, so its own opacity at the cutout is 0: over many rays the mean is the cutout's alpha.
    if (path.depth == 0) services.display.add_sample(static_cast<int>(row), {path.travelled, RgbD(0.0), false});
    ++path.segment;
    thread.queue.push(row, ray_from(v, j, v.rays[j].direction));
    ++(path.depth == 0 ? thread.counters.camera_rays : thread.counters.scattering_rays);
    return true;
}

bool Bdpt::survives_roulette(CameraSubpath& path, const PixelSampler& sampler, std::uint32_t dimension) const {
    if (!parameters_.roulette || path.depth < 2) return true;
    const float keep = path.beta.max() * path.eta_scale;
    if (!(keep < 1)) return true;
    if (sampler.get_random(dimension) >= keep) return false;
    path.beta *= 1 / keep;
    return true;
}

void Bdpt::scatter(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const {
    const VertexBatch& v = thread.vertices;
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        CameraSubpath& path = thread.paths[row];
        display::Tracker& tracker = thread.trackers[row];
        const PixelSampler& sampler = batch.samplers[row];
        const Bsdf& bsdf = v.bsdfs[j];
        const SurfacePoint& point = v.points[j];
        const auto end = [&] { thread.counters.count_length(path.depth); };
        if (path.depth >= parameters_.max_depth) {  // here for its AOVs only
            end();
            continue;
        }
        const float u_lobe =
            bsdf.kind() == Bsdf::Kind::lambert ? 0.0f : sampler.get_1d(camera_dimension(path, camera_lobe_dimension));
        const Scattering s = sample_scattering(TransportMode::radiance, bsdf, point, u_lobe,
                                               sampler.get_2d(camera_dimension(path, camera_scatter_dimension)));
        if (!(s.pdf > 0) || s.weight.is_black()) {
            end();
            continue;
        }
        const std::uint32_t roulette = camera_dimension(path, camera_roulette_dimension);
        path.beta *= s.weight;
        ++path.depth;
        ++path.segment;
        if (s.transmitted) path.eta_scale *= s.eta * s.eta;
        move_by_lobes(tracker, services.lpe, *context_.events, v.sources[j].label, s.lobes);
        if (!is_finite(path.beta)) {
            services.lpe.contribute(path.beta, display::Technique::scattering, tracker);  // counted and logged
            end();
            continue;
        }
        if (!survives_roulette(path, sampler, roulette) || !services.lpe.live(tracker)) {
            end();
            continue;
        }
        path.sums.leave(s.specular, s.specular ? 1.0 : static_cast<double>(bsdf.pdf(s.wi, point.wo)));
        path.pdf = s.specular ? 1.0f : s.pdf;
        path.from = point.position;
        path.cosine = std::abs(dot(point.geometric_normal, s.wi));
        thread.queue.push(row, ray_from(v, j, s.wi));
        ++thread.counters.scattering_rays;
    }
}

Registry<IntegratorFactory>::Entry bdpt_entry() {
    return {"bdpt", "bidirectional path tracing: subpaths from camera and lights, joined at every vertex",
            describe_depth_parameters("end weak subpaths at random from the second bounce"),
            [](const SceneEntity& entity,
               std::optional<std::int64_t> max_depth) -> Result<std::unique_ptr<Integrator>> {
                auto parameters = read_depth_parameters(entity, max_depth);
                if (!parameters) return parameters.error();
                return std::unique_ptr<Integrator>(std::make_unique<Bdpt>(*parameters));
            }};
}

}  // namespace raylex::transport
