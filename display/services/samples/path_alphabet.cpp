#include "display/services/samples/path_alphabet.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "display/services/samples/branches.h"
#include "display/services/split_mix.h"

namespace raylex::display {
namespace {

struct RuleName {
    const char* name;
    bool PathStringRules::*kept;
};
constexpr RuleName rule_names[] = {{"label", &PathStringRules::labels},
                                   {"lobe", &PathStringRules::lobes},
                                   {"group", &PathStringRules::groups},
                                   {"straight", &PathStringRules::straight},
                                   {"technique", &PathStringRules::techniques}};

PathAlphabet::Kind kind_of(const lpe::Event& event) {
    switch (event.type) {
        case lpe::EventType::light:
        case lpe::EventType::background:
        case lpe::EventType::emission:
            return PathAlphabet::Kind::terminal;
        default:
            return event.scatter == lpe::Scatter::straight ? PathAlphabet::Kind::straight
                                                           : PathAlphabet::Kind::scattering;
    }
}

/// A unique key of an event, because no label contains a zero byte.
std::string key_of(const lpe::Event& event) {
    std::string key{static_cast<char>(event.type), static_cast<char>(event.scatter),
                    static_cast<char>(event.lobe_number)};
    for (const std::string& label : event.labels) key += label + '\0';
    return key;
}

/// The event reduced to the parts that the rules keep.
lpe::Event projected(lpe::Event event, const PathStringRules& rules) {
    if (kind_of(event) == PathAlphabet::Kind::terminal) {
        if (!rules.groups) event.labels.clear();
        return event;
    }
    if (!rules.lobes) event.lobe_number = 0;
    if (!rules.labels && !event.labels.empty()) event.labels[0].clear();
    if (!rules.lobes && event.labels.size() > 1) event.labels[1].clear();
    return event;
}

}  // namespace

Result<PathStringRules> parse_path_string_rules(const std::string& text, const SourceLocation& where) {
    PathStringRules rules{false, false, false, false, false};
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) {
        bool known = false;
        std::vector<std::string> names;
        for (const RuleName& each : rule_names) {
            names.emplace_back(each.name);
            if (word != each.name) continue;
            rules.*each.kept = true;
            known = true;
        }
        if (known) continue;
        return error_at(where,
                        "'" + word +
                            "' does not distinguish words; expected label, lobe, group, "
                            "straight or technique, or several separated by commas",
                        near_miss(word, names));
    }
    return rules;
}

std::string to_string(const PathStringRules& rules) {
    std::string text;
    for (const RuleName& each : rule_names)
        if (rules.*each.kept) text += (text.empty() ? "" : ",") + std::string(each.name);
    return text;
}

Result<PathAlphabet> PathAlphabet::build(std::span<const lpe::Event> events, const PathStringRules& rules) {
    PathAlphabet alphabet;
    alphabet.rules_ = rules;
    alphabet.events_.emplace_back();
    alphabet.letters_.push_back(open);
    alphabet.kinds_.push_back(Kind::scattering);
    std::map<std::string, Letter> letter_of;
    constexpr std::size_t most = first_technique;
    for (const lpe::Event& event : events) {
        const auto column = static_cast<lpe::EventClass>(alphabet.events_.size());
        if (!alphabet.columns_.emplace(key_of(event), column).second) continue;
        if (column == most)
            return error_at({}, "the scene has more than " + std::to_string(most - 1) +
                                    " kinds of events, the maximum for a path atlas; expected fewer labels");
        const auto next = static_cast<Letter>(letter_of.size());
        alphabet.events_.push_back(event);
        alphabet.kinds_.push_back(kind_of(event));
        alphabet.letters_.push_back(letter_of.emplace(key_of(projected(event, rules)), next).first->second);
    }
    alphabet.letter_count_ = letter_of.size();
    return alphabet;
}

lpe::EventClass PathAlphabet::column(const lpe::Event& event) const {
    const auto found = columns_.find(key_of(event));
    return found == columns_.end() ? lpe::EventClass{0} : found->second;
}

PathStringTree::PathStringTree() : nodes_(1), slots_(64) {}

std::size_t PathStringTree::slot_of(std::uint32_t parent, Letter letter) const {
    const std::size_t mask = slots_.size() - 1;
    // Words with the same parent are adjacent: most look-ups follow one of a sibling, and then hit the cache.
    std::size_t at = (mix_bits(parent) + letter) & mask;
    const auto is_other = [&](const Slot& slot) { return slot.parent != parent || slot.letter != letter; };
    while (slots_[at].word != root && is_other(slots_[at])) at = (at + 1) & mask;
    return at;
}

std::uint32_t PathStringTree::child(std::uint32_t parent, Letter letter) {
    Slot& slot = slots_[slot_of(parent, letter)];
    if (slot.word != root) return slot.word;
    const auto word = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({parent, letter, static_cast<std::uint16_t>(letters_in(parent))});
    slot = {parent, word, letter};
    if (2 * nodes_.size() > slots_.size()) grow();
    return word;
}

void PathStringTree::grow() {
    slots_.assign(2 * slots_.size(), {});
    for (std::uint32_t word = 1; word < nodes_.size(); ++word)
        slots_[slot_of(nodes_[word].parent, nodes_[word].letter)] = {nodes_[word].parent, word, nodes_[word].letter};
}

std::vector<PathStringTree::Letter> PathStringTree::letters(std::uint32_t word) const {
    std::vector<Letter> letters;
    for (; word != root; word = nodes_[word].parent) letters.push_back(nodes_[word].letter);
    std::reverse(letters.begin(), letters.end());
    return letters;
}

}  // namespace raylex::display
