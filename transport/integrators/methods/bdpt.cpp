#include "transport/integrators/methods/bdpt.h"

#include <algorithm>

#include "transport/integrators/first_hits.h"
#include "transport/integrators/methods/bdpt_state.h"
#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {

IntegratorTraits Bdpt::traits() const {
    IntegratorTraits traits;
    traits.emitter_samples = true;
    traits.light_samples = true;
    traits.holdouts = true;
    traits.user_events = true;
    traits.max_depth = std::uint64_t{parameters_.max_depth} * (count_mirrors_ ? 1 : 2);  // as many mirrors first
    traits.media = true;
    traits.first_hits = traits.cutouts = true;
    traits.saved_state = SavedState::none;
    traits.raster_splats = true;
    traits.pixel_samples = true;
    return traits;
}

Status Bdpt::prepare(const IntegratorContext& context) {
    context_ = context;
    most_scatterings_ = static_cast<std::uint32_t>(
        light_vertices_budget / (static_cast<std::size_t>(context.batch_capacity) * sizeof(LightVertex)));
    view_ = {context.camera, context.width, context.height, context.filter_radius};
    const EventTable& events = *context.events;
    if (events.any()) language_.emplace(*context.lpe, events);
    const LightLanguage* const language = language_ ? &*language_ : nullptr;
    using Ahead = display::LightForesight::Ahead;
    emitters_ = choose_live_lights(context.scene, events, language, LightChoice::light_sampling, &Ahead::goes_on);
    sampled_ = choose_live_lights(context.scene, events, language, LightChoice::mis, &Ahead::joins);
    sampled_terminals_ = 0;
    for (std::uint32_t light = 0; light < context.scene.lights->lights().size(); ++light)
        if (sampled_.probability(Vec3(), light) > 0)
            sampled_terminals_ |= events.foresight().bit_of(events.terminal(light));
    can_sample_lights_ = !sampled_.empty();
    none_joins_ = !can_sample_lights_ && !LightChooser(context.scene.lights->lights(), LightChoice::mis, {}).empty();
    can_emit_ = parameters_.max_depth > 0 && !emitters_.empty() && (context.beauty || events.any());
    not_begun_ = !can_emit_ && parameters_.max_depth > 0 && !context.scene.lights->lights().empty();
    if (can_emit_) media_of_lights_ = media_of_lights(context.scene, camera_position(context));
    return success();
}

std::unique_ptr<IntegratorThread> Bdpt::make_thread_state() const {
    WalkOptions walk{parameters_.max_depth, parameters_.roulette_below, true};
    walk.counts_first_specular = count_mirrors_;
    LightSubpathOptions of_light;
    of_light.walk = walk;
    of_light.most_scatterings = most_scatterings_;
    of_light.language = language_ ? &*language_ : nullptr;
    of_light.emitters = &emitters_;
    of_light.sampled = &sampled_;
    of_light.media_of_lights = media_of_lights_;
    CameraSubpathOptions of_camera = camera_subpath_options(context_, walk);
    of_camera.first_depth = first_depth_;
    return std::make_unique<BdptThread>(context_.scene, *context_.events, of_camera, of_light,
                                        static_cast<std::size_t>(context_.batch_capacity));
}

void Bdpt::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<BdptThread&>(state);
    if (!trace_light(batch, thread, services)) return;
    CameraSubpaths& camera = thread.camera;
    Ends ends{{}, *this, camera};
    camera.begin(batch.rays, batch.samplers, services.lpe, thread.counters);
    while (camera.going()) {
        if (services.leaving()) return;
        camera.advance(services.display, ends);
        write_first_hits(context_, camera.vertices(), camera.first_entries(), thread.first_hits, services.display);
        const VertexBatch& v = camera.vertices();
        if (can_sample_lights_) camera.draw_light_pairs();
        for (std::size_t j = 0; j < v.count; ++j) {
            if (!camera.can_connect(j)) continue;
            const display::Foresight::Ahead ahead =
                camera.record().ahead(v.rows[j], v.sources[j].label, v.points[j].material);
            if (!ahead.anything) continue;
            if (can_sample_lights_) sample_light(thread, j, ahead);
            else if (none_joins_) thread.counters.count(Pruned::light_samples);
            join_vertices(thread, j);
        }
        thread.joins.report(camera, thread.counters);
        camera.scatter();
    }
    connect_to_camera(batch, thread, services);  // last: splats cannot be taken back
}

bool Bdpt::trace_light(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const {
    thread.light_vertices.clear();
    thread.invalid_powers.clear();
    std::fill_n(thread.last_vertex.begin(), batch.rays.size(), LightVertex::none);
    if (!can_emit_) {
        thread.counters.count(Pruned::light_paths, not_begun_ ? batch.rays.size() : 0);
        return true;
    }
    LightSubpaths& light = thread.light;
    light.begin(batch.rays, batch.samplers, services.lpe, thread.counters);
    while (light.going()) {
        if (services.leaving()) return false;
        light.advance(services.display);
        keep_light_vertices(thread);
        light.scatter([&](std::uint32_t row, const Rgb& power) { thread.invalid_powers.emplace_back(row, power); });
    }
    if (const std::uint64_t cut = light.take_cut(); cut > 0) cut_light_paths_ += cut;
    return true;
}

std::vector<std::string> Bdpt::cuts() const {
    const std::uint64_t cut = cut_light_paths_;
    if (cut == 0) return {};
    return {std::to_string(cut) + " light subpaths were cut after " + std::to_string(most_scatterings_) +
            " scatterings, since bdpt keeps their vertices: light of longer ones is missing"};
}

void Bdpt::keep_light_vertices(BdptThread& thread) const {
    const VertexBatch& v = thread.light.vertices();
    const EmbreeScene& geometry = *context_.scene.geometry;
    for (std::size_t j = 0; j < v.count; ++j) {
        if (!v.bsdfs[j].has_density()) continue;
        const display::LightForesight::Ahead ahead = thread.light.ahead(j);
        const std::uint32_t row = v.rows[j];
        const Subpath& path = thread.light.path(row);
        const auto index = static_cast<std::uint32_t>(thread.light_vertices.size());
        const bool holdout = j < v.surfaces && geometry.has_holdouts() && geometry.is_holdout(v.hits[j]);
        thread.light_vertices.push_back({v.points[j], v.bsdfs[j], v.sources[j].offset, row, path.depth,
                                         thread.light.vertex_depth(j), thread.light.end(j), thread.last_vertex[row],
                                         ahead, holdout, path.one_wavelength, path.beta, thread.light.sums(row)});
        if (ahead.joins) thread.last_vertex[row] = index;
    }
}

std::unique_ptr<Integrator> make_bdpt_integrator(const BdptParameters& parameters) {
    return std::make_unique<Bdpt>(parameters);
}

Registry<IntegratorFactory>::Entry bdpt_entry() {
    std::vector<ParameterDescription> described = describe_depth_parameters("subpaths");
    described.push_back({"countmirrors", ParameterType::boolean, "true",
                         "false: ideal mirrors and glass that the camera sees first do not count towards maxdepth, so "
                         "that a mirror shows what is seen without it (pbrt's sppm)"});
    return {
        "bdpt", "bidirectional path tracing: subpaths from camera and lights, joined at every vertex",
        std::move(described),
        [](const SceneEntity& entity, std::optional<std::int64_t> max_depth) -> Result<std::unique_ptr<Integrator>> {
            auto parameters = read_depth_parameters(entity, max_depth);
            if (!parameters) return parameters.error();
            auto count_mirrors = entity.parameters.boolean_or("countmirrors", true);
            if (!count_mirrors) return count_mirrors.error();
            return make_bdpt_integrator({*parameters, 0, *count_mirrors});
        }};
}

}  // namespace raylex::transport
