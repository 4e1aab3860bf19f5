#include "lpe/path_strings.h"

#include <set>
#include <string>

#include "lpe/automata/languages.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

void add_core(CoreSet& cores, EventType type, Scatter scatter, int highest_number) {
    for (int number = 0; number <= highest_number; ++number) {
        cores.set(core_index({type, scatter, static_cast<std::uint8_t>(number), {}}));
    }
}

bool is_labelled(const Event& event) {
    return !event.labels.empty() && !event.labels.front().empty();
}

bool occurs(const PathStrings& words, const Event& event) {
    switch (event.type) {
        case EventType::volume:
            return words.volume;
        case EventType::light:
            return words.unlabelled_lights || is_labelled(event);
        case EventType::background:
            return words.background && (words.unlabelled_lights || is_labelled(event));
        case EventType::emission:
            return words.emission;
        default:
            return words.straight || event.scatter != Scatter::straight;
    }
}

/// The membership of an event in each set, as a text.
std::string signature(const Event& event, std::span<const EventSet> sets) {
    std::string answers;
    answers.reserve(sets.size());
    for (const EventSet& set : sets) { answers += matches(set, event) ? '1' : '0'; }
    return answers;
}

/// The listed events that occur; one representative per combination of the sets in `distinguished`.
EventSet listed(const std::vector<Event>& events, const PathStrings& words, std::span<const EventSet> distinguished) {
    EventSet set;
    std::set<std::string> known;
    for (const Event& event : events) {
        if (!occurs(words, event) ||
            (!distinguished.empty() && !known.insert(signature(event, distinguished)).second)) {
            continue;
        }
        EventPattern pattern;
        pattern.cores.set(core_index(event));
        for (const std::string& label : event.labels) { pattern.labels.push_back({false, {label}, {}}); }
        pattern.missing = Missing::is_empty;
        pattern.extra = Extra::refused;
        set.any_of.push_back(std::move(pattern));
    }
    return set;
}

/// Moves the pass-through events of `scattering` to a set of their own.
void part_straight(PathStringSets& sets) {
    for (EventPattern& pattern : sets.scattering.any_of) {
        EventPattern through = pattern;
        through.cores &= straight_cores();
        pattern.cores &= ~straight_cores();
        if (through.cores.any()) { sets.straight.any_of.push_back(std::move(through)); }
    }
    std::erase_if(sets.scattering.any_of, [](const EventPattern& pattern) { return pattern.cores.none(); });
}

/// A test for labels of the list, and for no label.
LabelTest one_of(const std::vector<std::string>& names) {
    LabelTest test;
    test.add_name({});
    for (const std::string& name : names) { test.add_name(name); }
    return test;
}

PathStringSets uncut_path_string_sets(const PathStrings& words, bool skip_reserved_labels,
                                      std::span<const EventSet> distinguished) {
    LabelTest label = LabelTest::any();
    if (skip_reserved_labels) { label.names = reserved_names(); }
    PathStringSets sets;
    EventPattern camera{{}, {}, Missing::is_empty, Extra::refused};
    add_core(camera.cores, EventType::camera, Scatter::none, 0);
    sets.camera.any_of.push_back(camera);
    if (words.alphabet) {
        sets.scattering = listed(words.alphabet->scattering, words, distinguished);
        sets.terminal = listed(words.alphabet->terminals, words, distinguished);
        return sets;
    }
    const LabelTest object = words.object_labels ? one_of(*words.object_labels) : label;
    EventPattern scattering{{}, {object, label}, Missing::is_empty, Extra::refused};  // slots: object, lobe
    for (const EventType type : {EventType::reflection, EventType::transmission}) {
        add_core(scattering.cores, type, Scatter::diffuse, 4);
        add_core(scattering.cores, type, Scatter::glossy, 8);
        add_core(scattering.cores, type, Scatter::singular, 8);
    }
    if (words.straight) { add_core(scattering.cores, EventType::transmission, Scatter::straight, 0); }
    if (words.volume) { add_core(scattering.cores, EventType::volume, Scatter::none, 0); }
    sets.scattering.any_of.push_back(std::move(scattering));
    const LabelTest any_group = words.light_groups ? one_of(*words.light_groups) : label;
    LabelTest group = any_group;
    if (!words.unlabelled_lights && group.negated) {
        group.add_name({});
    } else if (!words.unlabelled_lights) {
        std::erase(group.names, std::string());
    }
    EventPattern light{{}, {group}, Missing::is_empty, Extra::refused};  // slot: light group
    add_core(light.cores, EventType::light, Scatter::none, 0);
    if (words.background) { add_core(light.cores, EventType::background, Scatter::none, 0); }
    sets.terminal.any_of.push_back(std::move(light));
    if (words.emission) {
        EventPattern emission{{}, {any_group}, Missing::is_empty, Extra::refused};
        add_core(emission.cores, EventType::emission, Scatter::none, 0);
        sets.terminal.any_of.push_back(std::move(emission));
    }
    return sets;
}

}  // namespace

PathStringSets path_string_sets(const PathStrings& words, bool skip_reserved_labels,
                                std::span<const EventSet> distinguished) {
    PathStringSets sets = uncut_path_string_sets(words, skip_reserved_labels, distinguished);
    if (words.max_depth && *words.max_depth >= 0 && *words.max_depth <= limits::path_string_depth) {
        sets.max_depth = words.max_depth;
        part_straight(sets);
    }
    return sets;
}

PathStringSets renderer_path_string_sets() {
    EventPattern camera, scattering, terminal;
    for (std::size_t core = 0; core < core_count; ++core) {
        const Event event = core_event(core);
        const bool scattered = event.scatter != Scatter::none;
        switch (event.type) {
            case EventType::camera:
                camera.cores[core] = !scattered;
                break;
            case EventType::reflection:
            case EventType::transmission:
                scattering.cores[core] = scattered;
                break;
            case EventType::volume:
                scattering.cores[core] = !scattered;
                break;
            case EventType::user:
                scattering.cores[core] = true;
                break;
            case EventType::light:
            case EventType::background:
            case EventType::emission:
                terminal.cores[core] = !scattered;
                break;
        }
    }
    return {{{camera}, {}}, {{scattering}, {}}, {{terminal}, {}}, {}, std::nullopt};
}

}  // namespace raylex::lpe
