#include "transport/paths/event_table.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "transport/materials/bsdf/lobes.h"

namespace raylex::transport {
namespace {

bool has_density(LobeId lobe) {
    return lobe_kinds()[lobe].scatter != lpe::Scatter::singular;
}

}  // namespace

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

void append_lobes(const Material& material, bool regularizes, std::vector<LobeId>& lobes) {
    const std::size_t begin = lobes.size();
    material.append_lobes(lobes);
    for (std::size_t i = begin, end = lobes.size(); regularizes && i < end; ++i)
        lobes.push_back(lobes::regularized(lobes[i]));
}

std::vector<lpe::Event> scene_events(const SceneView& scene, const lpe::LobeSlots& slots, bool regularizes) {
    std::vector<LobeId> lobes;
    for (std::size_t m = 0; m < scene.materials->size(); ++m)
        append_lobes(*scene.materials->material(m), regularizes, lobes);
    std::sort(lobes.begin(), lobes.end());
    lobes.erase(std::unique(lobes.begin(), lobes.end()), lobes.end());
    std::vector<lpe::Event> events;
    for (const std::string& label : scene.geometry->object_labels()) {
        for (const LobeId lobe : lobes) events.push_back(scattering_event(label, lobe_kinds()[lobe], slots));
        events.push_back(straight_event(label));
        for (std::size_t i = 0; i < user_lobes.size(); ++i)
            events.push_back(user_event(label, static_cast<UserLobe>(i), slots));
    }
    for (const std::string& medium : scene.media->names()) events.push_back(phase_event(medium));
    events.push_back(emission_event());
    events.push_back(terminal_event(false, ""));
    for (const Light& light : scene.lights->lights())
        events.push_back(
            terminal_event(light.is_environment(), scene.lights->groups()[static_cast<std::size_t>(light.group)]));
    return events;
}

EventTable::EventTable(const display::LpeSetup& setup, const SceneView& scene, const lpe::LobeSlots& slots, bool prunes,
                       bool regularizes)
    : prunes_(prunes) {
    any_ = setup.reads_path_strings();
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
    first_medium_label_ = static_cast<std::int32_t>(scene.geometry->object_labels().size());
    for (const std::string& medium : scene.media->names())
        scatter_.insert(scatter_.end(), lobe_count_, setup.classify(phase_event(medium)));
    emission_ = setup.classify(emission_event());
    user_terminal_ = setup.classify(terminal_event(false, ""));
    for (const Light& light : scene.lights->lights())
        terminal_.push_back(setup.classify(
            terminal_event(light.is_environment(), scene.lights->groups()[static_cast<std::size_t>(light.group)])));
    if (!prunes_) return;
    passes_cutouts_ = scene.geometry->has_alpha();
    find_scatterings(*scene.materials, scene.media->names().size(), regularizes);
    find_scatterings_in_use(*scene.geometry, *scene.media);
    emits_ = scene.media->any_emits();
    liveness_ = display::Liveness(setup, alphabet());
}

display::Liveness::Alphabet EventTable::alphabet() const {
    display::Liveness::Alphabet alphabet;
    alphabet.scatterings = in_use_;
    alphabet.with_density = in_use_with_density_;
    if (passes_cutouts_) alphabet.straight = straight_;
    alphabet.terminals = terminal_;
    if (emits_) alphabet.terminals.push_back(emission_);
    if (wants_user()) alphabet.user = user_;
    alphabet.user_terminal = user_terminal_;
    return alphabet;
}

void EventTable::find_scatterings(const MaterialTable& materials, std::size_t media, bool regularizes) {
    std::vector<std::vector<LobeId>> kinds(1);
    std::map<std::string, std::uint32_t> known;  // a lobe a character
    kind_of_.push_back(0);
    for (std::size_t m = 0; m < materials.size(); ++m) {
        std::vector<LobeId> found;
        append_lobes(*materials.material(m), regularizes, found);
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        std::stable_partition(found.begin(), found.end(), has_density);
        const auto [kind, added] =
            known.emplace(std::string(found.begin(), found.end()), static_cast<std::uint32_t>(kinds.size()));
        if (added) kinds.push_back(std::move(found));
        kind_of_.push_back(kind->second);
    }
    kinds_ = kinds.size();
    const std::size_t labels = static_cast<std::size_t>(first_medium_label_) + media;
    for (std::size_t label = 0; label < labels; ++label)
        for (std::size_t kind = 0; kind < kinds_; ++kind) {
            const auto begin = static_cast<std::uint32_t>(by_kind_.size());
            const auto at = static_cast<std::int32_t>(label);
            std::ptrdiff_t with_density = 0;
            if (at < first_medium_label_) {
                for (const LobeId lobe : kinds[kind]) by_kind_.push_back(scatter(at, lobe));
                with_density = std::count_if(kinds[kind].begin(), kinds[kind].end(), has_density);
            } else if (kind == 0) {
                by_kind_.push_back(scatter(at, 0));
                with_density = 1;
            }
            rows_.push_back(
                {begin, static_cast<std::uint32_t>(by_kind_.size()) - begin, static_cast<std::uint32_t>(with_density)});
        }
}

void EventTable::find_scatterings_in_use(const EmbreeScene& geometry, const MediumTable& media) {
    std::set<std::pair<std::int32_t, std::int32_t>> used;  // label, material
    std::set<std::int32_t> given_to_instances;
    for (const ShapeInstance& instance : geometry.instances())
        if (instance.label >= 0) given_to_instances.insert(instance.label);
    for (const ShapeGeometry& shape : geometry.shapes()) {
        used.emplace(shape.label, shape.material);
        // Not restricted to the shapes that the instance places: other materials may be added in vain.
        for (const std::int32_t label : given_to_instances) used.emplace(label, shape.material);
    }
    const auto use = [&](std::int32_t label, std::int32_t material) {
        const auto all = scatterings(label, material), dense = with_density(label, material);
        in_use_.insert(in_use_.end(), all.begin(), all.end());
        in_use_with_density_.insert(in_use_with_density_.end(), dense.begin(), dense.end());
    };
    for (const auto& [label, material] : used) use(label, material);
    for (std::size_t i = 0; i < media.size(); ++i)
        if (const auto medium = static_cast<std::int32_t>(i); media[medium].scatters)
            use(medium_label(medium), SurfacePoint::no_material);
    in_use_ = display::Liveness::distinct(std::move(in_use_));
    in_use_with_density_ = display::Liveness::distinct(std::move(in_use_with_density_));
}

}  // namespace raylex::transport
