#include "lpe/language/pattern.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "lpe/language/glob.h"

namespace raylex::lpe {

namespace {

constexpr std::size_t user_base = static_cast<std::size_t>(scene_types) * scatter_kinds * lobe_numbers;
constexpr std::array<char, scene_types + 1> type_letters{'C', 'R', 'T', 'V', 'L', 'B', 'O', '-'};
constexpr std::array<char, scatter_kinds> scatter_letters{'x', 'D', 'G', 'S', 's'};

CoreSet build_straight_cores() {
    CoreSet cores;
    for (std::uint8_t number = 0; number < lobe_numbers; ++number) {
        cores.set(core_index({EventType::transmission, Scatter::straight, number, {}}));
    }
    return cores;
}

CoreSet build_wildcard_cores(Dialect dialect) {
    CoreSet cores;
    for (std::size_t core = 0; core < user_base; ++core) { cores.set(core); }
    return dialect == Dialect::renderman ? cores & ~build_straight_cores() : cores;
}

void append_key(std::string& key, const EventPattern& pattern) {
    key += pattern.cores.to_string();
    key += static_cast<char>('0' + static_cast<int>(pattern.missing));
    key += static_cast<char>('0' + static_cast<int>(pattern.extra));
    const auto append_texts = [&key](const std::vector<std::string>& texts) {
        key += std::to_string(texts.size()) + ":";
        for (const std::string& text : texts) { key += std::to_string(text.size()) + ":" + text; }
    };
    for (const LabelTest& test : pattern.labels) {
        key += test.negated ? '!' : '=';
        append_texts(test.names);
        append_texts(test.globs);
    }
    key += ';';
}

}  // namespace

std::size_t label_count(const Event& event) {
    std::size_t count = event.labels.size();
    while (count > 0 && event.labels[count - 1].empty()) { --count; }
    return count;
}

std::size_t core_index(const Event& event) {
    if (event.type == EventType::user) {
        return user_base + (event.lobe_number < user_numbers ? event.lobe_number : 0U);
    }
    const std::size_t number = event.lobe_number < lobe_numbers ? event.lobe_number : 0U;
    return (static_cast<std::size_t>(event.type) * scatter_kinds + static_cast<std::size_t>(event.scatter)) *
               lobe_numbers +
           number;
}

Event core_event(std::size_t core) {
    Event event;
    if (core >= user_base) {
        event.type = EventType::user;
        event.lobe_number = static_cast<std::uint8_t>(core - user_base);
        return event;
    }
    event.lobe_number = static_cast<std::uint8_t>(core % lobe_numbers);
    event.scatter = static_cast<Scatter>(core / lobe_numbers % scatter_kinds);
    event.type = static_cast<EventType>(core / (static_cast<std::size_t>(lobe_numbers) * scatter_kinds));
    return event;
}

char type_letter(EventType type) {
    return type_letters[static_cast<std::size_t>(type)];
}
char scatter_letter(Scatter scatter) {
    return scatter_letters[static_cast<std::size_t>(scatter)];
}

bool LabelTest::matches(std::string_view label) const {
    const bool named = std::binary_search(names.begin(), names.end(), label);
    const bool listed = named || std::any_of(globs.begin(), globs.end(),
                                             [&](const std::string& glob) { return glob_matches(glob, label); });
    return listed != negated;
}

void LabelTest::add_name(std::string name) {
    const auto place = std::lower_bound(names.begin(), names.end(), name);
    if (place == names.end() || *place != name) { names.insert(place, std::move(name)); }
}

void LabelTest::unite(const LabelTest& other) {
    std::vector<std::string> united;
    if (!negated && !other.negated) {
        std::set_union(names.begin(), names.end(), other.names.begin(), other.names.end(), std::back_inserter(united));
    } else if (negated && other.negated) {
        std::set_intersection(names.begin(), names.end(), other.names.begin(), other.names.end(),
                              std::back_inserter(united));
    } else {
        const auto& excluded = negated ? names : other.names;
        const auto& included = negated ? other.names : names;
        std::set_difference(excluded.begin(), excluded.end(), included.begin(), included.end(),
                            std::back_inserter(united));
        negated = true;
    }
    names = std::move(united);
}

std::string EventSet::key() const {
    std::string key;
    for (const EventPattern& pattern : any_of) { append_key(key, pattern); }
    key += '^';
    for (const EventPattern& pattern : none_of) { append_key(key, pattern); }
    return key;
}

bool matches(const EventPattern& pattern, const Event& event) {
    if (!pattern.cores.test(core_index(event))) { return false; }
    const std::size_t count = label_count(event);
    for (std::size_t slot = 0; slot < pattern.labels.size(); ++slot) {
        if (slot >= count && pattern.missing == Missing::refuses) { return false; }
        if (!pattern.labels[slot].matches(slot < count ? std::string_view(event.labels[slot]) : std::string_view())) {
            return false;
        }
    }
    for (std::size_t slot = pattern.labels.size(); slot < count && pattern.extra != Extra::ignored; ++slot) {
        const auto& reserved = reserved_names();
        if (pattern.extra == Extra::refused ||
            std::binary_search(reserved.begin(), reserved.end(), event.labels[slot])) {
            return false;
        }
    }
    return true;
}

bool matches(const EventSet& set, const Event& event) {
    const auto match_one = [&event](const EventPattern& pattern) { return matches(pattern, event); };
    return std::any_of(set.any_of.begin(), set.any_of.end(), match_one) &&
           std::none_of(set.none_of.begin(), set.none_of.end(), match_one);
}

const std::vector<std::string>& reserved_names() {
    // The texts of OSL's basic symbols. NONE, the unquoted x, equals no text, so a label named x is an ordinary label.
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list{"B", "C", "D", "G", "L", "O", "R", "S", "T", "V", "s"};
        std::sort(list.begin(), list.end());
        return list;
    }();
    return names;
}

const CoreSet& straight_cores() {
    static const CoreSet cores = build_straight_cores();
    return cores;
}

const CoreSet& wildcard_cores(Dialect dialect) {
    static const CoreSet renderman = build_wildcard_cores(Dialect::renderman);
    static const CoreSet osl = build_wildcard_cores(Dialect::osl);
    return dialect == Dialect::renderman ? renderman : osl;
}

}  // namespace raylex::lpe
