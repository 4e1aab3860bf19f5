#include "lpe/words.h"

#include "lpe/languages.h"

namespace raylex::lpe {

namespace {

void add_core(CoreSet& cores, EventType type, Scatter scatter, int highest_number) {
    for (int number = 0; number <= highest_number; ++number) {
        cores.set(core_index({type, scatter, static_cast<std::uint8_t>(number), {}}));
    }
}

bool occurs(const Words& words, const Event& event) {
    switch (event.type) {
        case EventType::volume: return words.volume;
        case EventType::background: return words.background;
        case EventType::emission: return words.emission;
        default: return words.straight || event.scatter != Scatter::straight;
    }
}

/// Exactly the events of the list that occur.
EventSet listed(const std::vector<Event>& events, const Words& words) {
    EventSet set;
    for (const Event& event : events) {
        if (!occurs(words, event)) {
            continue;
        }
        EventPattern pattern;
        pattern.cores.set(core_index(event));
        for (const std::string& label : event.labels) {
            pattern.labels.push_back({false, {label}, {}});
        }
        pattern.missing = Missing::is_empty;
        pattern.extra = Extra::refused;
        set.any_of.push_back(std::move(pattern));
    }
    return set;
}

}  // namespace

WordSets word_sets(const Words& words, bool skip_reserved_labels) {
    LabelTest label = LabelTest::any();
    if (skip_reserved_labels) {
        label.names = reserved_names();
    }
    WordSets sets;
    EventPattern camera{{}, {}, Missing::is_empty, Extra::refused};
    add_core(camera.cores, EventType::camera, Scatter::none, 0);
    sets.camera.any_of.push_back(camera);
    if (words.alphabet) {
        sets.scattering = listed(words.alphabet->scattering, words);
        sets.terminal = listed(words.alphabet->terminals, words);
        return sets;
    }
    EventPattern scattering{{}, {label, label}, Missing::is_empty, Extra::refused};  // slots: object, lobe
    for (const EventType type : {EventType::reflection, EventType::transmission}) {
        add_core(scattering.cores, type, Scatter::diffuse, 4);
        add_core(scattering.cores, type, Scatter::glossy, 8);
        add_core(scattering.cores, type, Scatter::singular, 8);
    }
    if (words.straight) {
        add_core(scattering.cores, EventType::transmission, Scatter::straight, 0);
    }
    if (words.volume) {
        add_core(scattering.cores, EventType::volume, Scatter::none, 0);
    }
    sets.scattering.any_of.push_back(std::move(scattering));
    EventPattern terminal{{}, {label}, Missing::is_empty, Extra::refused};  // slot: light group
    add_core(terminal.cores, EventType::light, Scatter::none, 0);
    if (words.background) {
        add_core(terminal.cores, EventType::background, Scatter::none, 0);
    }
    if (words.emission) {
        add_core(terminal.cores, EventType::emission, Scatter::none, 0);
    }
    sets.terminal.any_of.push_back(std::move(terminal));
    return sets;
}

WordSets renderer_word_sets() {
    EventPattern camera, scattering, terminal;
    for (std::size_t core = 0; core < core_count; ++core) {
        const Event event = core_event(core);
        const bool scattered = event.scatter != Scatter::none;
        switch (event.type) {
            case EventType::camera: camera.cores[core] = !scattered; break;
            case EventType::reflection:
            case EventType::transmission: scattering.cores[core] = scattered; break;
            case EventType::volume: scattering.cores[core] = !scattered; break;
            case EventType::user: scattering.cores[core] = true; break;
            case EventType::light:
            case EventType::background:
            case EventType::emission: terminal.cores[core] = !scattered; break;
        }
    }
    return {{{camera}, {}}, {{scattering}, {}}, {{terminal}, {}}};
}

}  // namespace raylex::lpe
