#include "lpe/language/parser/osl_events.h"

#include <optional>
#include <string>
#include <utility>

namespace raylex::lpe {
namespace {

std::string symbol_of(Scatter scatter) {
    return scatter == Scatter::none ? std::string(none_symbol) : std::string(1, scatter_letter(scatter));
}

/// Adds the events that registered names denote: event names in the first slot, lobe names in the second. Wildcards and
/// [^...] match none of them.
void add_registered(CoreSet& cores, const LabelTest& type, const LabelTest& scatter, const Vocabulary& vocabulary) {
    if (!type.negated && scatter.matches(none_symbol)) {
        for (const std::string& name : type.names) {
            if (vocabulary.is_event(name)) { cores |= *vocabulary.cores(name); }
        }
    }
    if (scatter.negated) { return; }
    for (const std::string& name : scatter.names) {
        const std::optional<CoreSet> named = vocabulary.is_event(name) ? std::nullopt : vocabulary.cores(name);
        for (std::size_t core = 0; named && core < core_count - user_numbers; ++core) {
            const char letter = type_letter(core_event(core).type);
            if (named->test(core) && type.matches({&letter, 1})) { cores.set(core); }
        }
    }
}

void add_scatterings(CoreSet& cores, EventType type, const LabelTest& test) {
    for (int scatter = 0; scatter < scatter_kinds; ++scatter) {
        if (test.matches(symbol_of(static_cast<Scatter>(scatter)))) {
            const std::size_t first = core_index({type, static_cast<Scatter>(scatter), 0, {}});
            for (std::size_t number = 0; number < lobe_numbers; ++number) { cores.set(first + number); }
        }
    }
}

}  // namespace

void add_alternatives(SymbolSequences& list, SymbolSequences more) {
    for (SymbolSequence& sequence : more) {
        if (sequence.size() == 1 && !list.empty() && list.front().size() == 1) {
            list.front().front().unite(sequence.front());
        } else if (sequence.size() == 1) {
            list.insert(list.begin(), std::move(sequence));
        } else {
            list.push_back(std::move(sequence));
        }
    }
}

EventSet osl_events(const SymbolSequences& sequences, bool open, const Vocabulary* vocabulary) {
    EventSet set;
    for (const SymbolSequence& symbols : sequences) {
        EventPattern pattern;
        for (int type = 0; type < scene_types; ++type) {
            const char letter = type_letter(static_cast<EventType>(type));
            if (symbols[0].matches({&letter, 1})) {
                add_scatterings(pattern.cores, static_cast<EventType>(type), symbols[1]);
            }
        }
        if (vocabulary != nullptr) { add_registered(pattern.cores, symbols[0], symbols[1], *vocabulary); }
        pattern.labels.assign(symbols.begin() + 2, symbols.end());
        for (LabelTest& label : pattern.labels) {
            std::erase(label.names, none_symbol);  // an existing label never equals NONE
        }
        pattern.missing = Missing::refuses;
        pattern.extra = open ? Extra::unreserved : Extra::refused;
        set.any_of.push_back(std::move(pattern));
    }
    return set;
}

}  // namespace raylex::lpe
