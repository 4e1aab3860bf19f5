#include "transport/integrators/integrator.h"

#include <algorithm>

#include "transport/integrators/light_tracer.h"
#include "transport/integrators/path.h"
#include "transport/integrators/pssmlt.h"

namespace raylex::transport {

lpe::Event scattering_event(const std::string& object_label, const LobeKind& lobe, const lpe::LobeSlots& slots) {
    lpe::Event event;
    event.type = lobe.type;
    event.scatter = lobe.scatter;
    event.lobe_number = slots.number(lobe.scatter, lobe.name);
    event.labels = {object_label, lobe.name};
    return event;
}

lpe::Event straight_event(const std::string& object_label) {
    lpe::Event event;
    event.type = lpe::EventType::transmission;
    event.scatter = lpe::Scatter::straight;
    event.labels = {object_label, ""};
    return event;
}

lpe::Event phase_event(const std::string& medium_name) {
    lpe::Event event;
    event.type = lpe::EventType::volume;
    event.labels = {medium_name, ""};
    return event;
}

lpe::Event emission_event() {
    lpe::Event event;
    event.type = lpe::EventType::emission;
    event.labels = {""};
    return event;
}

lpe::Event terminal_event(bool infinite, const std::string& light_group) {
    lpe::Event event;
    event.type = infinite ? lpe::EventType::background : lpe::EventType::light;
    event.labels = {light_group};
    return event;
}

lpe::Event user_event(const std::string& object_label, UserLobe lobe, const lpe::LobeSlots& slots) {
    const char* name = user_lobes[static_cast<std::size_t>(lobe)];
    lpe::Event event;
    event.type = lpe::EventType::user;
    event.lobe_number = slots.user_number(name);
    event.labels = {object_label, name};
    return event;
}

EventTable::EventTable(const display::LpeSetup& setup, const SceneView& scene, const lpe::LobeSlots& slots) {
    any_ = setup.program().group_count() > 0;
    const std::span<const LobeKind> kinds = lobe_kinds();
    lobe_count_ = kinds.size();
    for (const std::string& label : scene.geometry->object_labels()) {
        for (const LobeKind& kind : kinds) scatter_.push_back(setup.classify(scattering_event(label, kind, slots)));
        straight_.push_back(setup.classify(straight_event(label)));
        for (std::size_t i = 0; i < user_lobes.size(); ++i) {
            user_.push_back(setup.classify(user_event(label, static_cast<UserLobe>(i), slots)));
            wants_user_[i] = wants_user_[i] || setup.follows(user_.back());
        }
    }
    for (const std::string& medium : scene.media->names()) phase_.push_back(setup.classify(phase_event(medium)));
    emission_ = setup.classify(emission_event());
    user_terminal_ = setup.classify(terminal_event(false, ""));
    for (const Light& light : scene.lights->lights())
        terminal_.push_back(setup.classify(
            terminal_event(light.is_environment(), scene.lights->groups()[static_cast<std::size_t>(light.group)])));
}

void IntegratorCounters::add(const IntegratorCounters& other) {
    camera_rays += other.camera_rays;
    scattering_rays += other.scattering_rays;
    shadow_rays += other.shadow_rays;
    if (path_lengths.size() < other.path_lengths.size()) path_lengths.resize(other.path_lengths.size());
    for (std::size_t i = 0; i < other.path_lengths.size(); ++i) path_lengths[i] += other.path_lengths[i];
}

Registry<IntegratorFactory>& integrator_registry() {
    static Registry<IntegratorFactory> registry = [] {
        Registry<IntegratorFactory> r("integrator");
        r.add(path_integrator_entry());
        auto media_too = path_integrator_entry();
        media_too.name = "volpath";
        media_too.help = "another name for path, which takes participating media as they come";
        r.add(media_too);
        r.add(light_tracer_entry());
        r.add(pssmlt_entry());
        return r;
    }();
    return registry;
}

Result<std::uint32_t> read_max_depth(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    auto depth = entity.parameters.integer_or("maxdepth", 5);
    if (!depth) return depth.error();
    if (max_depth) *depth = *max_depth;
    if (*depth < 0)
        return error_at(entity.location,
                        "'maxdepth' is " + std::to_string(*depth) + "; expected 0 or more scattering events");
    return static_cast<std::uint32_t>(std::min<std::int64_t>(*depth, 1'000'000));
}

SceneEntity integrator_for(const std::optional<SceneEntity>& asked, const SceneEntity& of_scene) {
    if (!asked) return of_scene;
    SceneEntity entity = *asked;
    const auto* entry = integrator_registry().find(entity.type.empty() ? "path" : entity.type);
    if (entry == nullptr) return entity;
    for (const Parameter& each : of_scene.parameters.parameters) {
        const auto named = [&](const auto& other) { return other.name == each.name; };
        const std::vector<ParameterDescription>& known = entry->parameters;
        const std::vector<Parameter>& given = entity.parameters.parameters;
        if (std::any_of(known.begin(), known.end(), named) && std::none_of(given.begin(), given.end(), named))
            entity.parameters.parameters.push_back(each);
        else each.used = true;  // of the scene's integrator, which is not asked for
    }
    return entity;
}

Result<ChosenIntegrator> choose_integrator(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    ChosenIntegrator chosen;
    SceneEntity asked = entity;
    if (asked.type.empty()) asked.type = "path";
    static const std::vector<std::string> of_pbrt = {
        "ambientocclusion", "bdpt",       "function",      "lightpath", "mlt",
        "randomwalk",       "simplepath", "simplevolpath", "sppm"};
    if (!integrator_registry().find(asked.type) &&
        std::find(of_pbrt.begin(), of_pbrt.end(), asked.type) != of_pbrt.end()) {
        chosen.warnings.push_back(
            error_at(asked.location, "integrator '" + asked.type + "' is not available; rendering with 'path'"));
        for (const Parameter& p : entity.parameters.parameters) p.used = true;
        std::erase_if(asked.parameters.parameters, [](const Parameter& p) { return p.name != "maxdepth"; });
        asked.type = "path";
    }
    auto entry = integrator_registry().require(asked.type, asked.location);
    if (!entry) return entry.error();
    auto made = (*entry)->factory(asked, max_depth);
    if (!made) return made.error();
    for (const Parameter* p : asked.parameters.unused()) {
        std::vector<std::string> names;
        for (const ParameterDescription& each : (*entry)->parameters) names.push_back(each.name);
        const std::string near = nearest_name(p->name, names);
        chosen.warnings.push_back(error_at(p->location,
                                           "integrator '" + asked.type + "' has no parameter '" + p->name + "'",
                                           near.empty() ? "" : "did you mean '" + near + "'?"));
    }
    for (const Parameter& p : entity.parameters.parameters) p.used = true;
    chosen.integrator = std::move(*made);
    chosen.name = asked.type;
    return chosen;
}

}  // namespace raylex::transport
