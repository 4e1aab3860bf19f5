#include "lpe/algebra/proofs/overview.h"

#include <algorithm>
#include <array>
#include <map>
#include <unordered_set>
#include <utility>

#include "lpe/algebra/proofs/question.h"
#include "lpe/failure.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

/// Limit on the transitions visited for all pairs together; this takes about a quarter of a second.
constexpr std::size_t most_pair_steps = 60'000'000;

/// A channel restricted to W, and the classes with which its words begin and end.
struct Cut {
    Dfa dfa;
    ClassSet first, last;
};

Cut cut_of(const Dfa& channel, const Dfa& words) {
    Cut cut{intersection(words, channel), ClassSet(channel.column_of_class.size(), false), {}};
    cut.last = cut.first;
    std::vector<bool> last(cut.dfa.columns, false), first(cut.dfa.columns, false);
    for (std::uint32_t state = 1; state < cut.dfa.states(); ++state) {
        for (std::size_t column = 0; column < cut.dfa.columns; ++column) {
            const std::uint32_t target = cut.dfa.next[state * cut.dfa.columns + column];
            last[column] = last[column] || cut.dfa.output[target] != 0;
            if (state == cut.dfa.start && target != 0) {
                for (std::size_t next = 0; next < cut.dfa.columns; ++next) {
                    first[next] = first[next] || cut.dfa.next[target * cut.dfa.columns + next] != 0;
                }
            }
        }
    }
    for (std::size_t k = 0; k < cut.first.size(); ++k) {
        cut.first[k] = first[cut.dfa.column_of_class[k]];
        cut.last[k] = last[cut.dfa.column_of_class[k]];
    }
    return cut;
}

bool meet(const ClassSet& a, const ClassSet& b) {
    for (std::size_t k = 0; k < a.size(); ++k) {
        if (a[k] && b[k]) { return true; }
    }
    return false;
}

/// The shortest word that both accept; ties go to the lowest classes. Adds the visited transitions to `steps`.
std::optional<std::vector<EventClass>> shared_path_string(const Dfa& a, const Dfa& b, std::size_t& steps) {
    struct Reached {
        std::uint32_t in_a, in_b;
        std::size_t from;
        EventClass by;
    };
    std::vector<Reached> queue{{a.start, b.start, 0, 0}};
    std::unordered_set<std::uint64_t> seen;
    for (std::size_t i = 0; i < queue.size(); ++i) {
        for (std::size_t k = 0; k < a.column_of_class.size(); ++k) {
            const auto by = static_cast<EventClass>(k);
            const std::uint32_t to_a = a.step(queue[i].in_a, by), to_b = b.step(queue[i].in_b, by);
            if (to_a == 0 || to_b == 0 || !seen.insert(static_cast<std::uint64_t>(to_a) << 32 | to_b).second) {
                continue;
            }
            queue.push_back({to_a, to_b, i, by});
            if (a.output[to_a] == 0 || b.output[to_b] == 0) { continue; }
            std::vector<EventClass> word;
            for (std::size_t at = queue.size() - 1; at != 0; at = queue[at].from) { word.push_back(queue[at].by); }
            std::reverse(word.begin(), word.end());
            return word;
        }
        steps += a.column_of_class.size();
        if (queue.size() > limits::boolean_states) {
            fail("two channels need more than " + std::to_string(limits::boolean_states) + " states side by side");
        }
    }
    return std::nullopt;
}

void find_overlaps(const std::vector<Cut>& cuts, const EventClasses& classes, Overview& overview) {
    std::size_t steps = 0;
    for (std::size_t a = 0; a < cuts.size(); ++a) {
        for (std::size_t b = a + 1; b < cuts.size(); ++b) {
            if (!meet(cuts[a].first, cuts[b].first) || !meet(cuts[a].last, cuts[b].last)) { continue; }
            if (steps > most_pair_steps) {
                ++overview.pairs_left;
            } else if (const auto word = shared_path_string(cuts[a].dfa, cuts[b].dfa, steps)) {
                overview.overlaps.push_back({a, b, witness_of(*word, classes)});
            }
        }
    }
}

/// The kind of a missed path by its first event. In renderman glossy and singular lobes are both "specular".
std::string kind_of(const Event& event, bool osl) {
    if (event.type == EventType::light || event.type == EventType::background || event.type == EventType::emission) {
        return "seen directly";
    }
    if (event.type == EventType::volume) { return "first a scattering in a medium"; }
    if (event.scatter == Scatter::straight) { return "first straight through"; }
    const std::string way = event.type == EventType::reflection ? "reflection" : "transmission";
    switch (event.scatter) {
        case Scatter::diffuse:
            return "first a diffuse " + way;
        case Scatter::glossy:
            return osl ? "first a glossy " + way : "first a specular " + way;
        case Scatter::singular:
            return osl ? "first a singular " + way : "first a specular " + way;
        default:
            return "first another " + way;
    }
}

constexpr std::array<EventType, 3> terminals{EventType::light, EventType::background, EventType::emission};

/// For each kind of terminal the shortest word of `missed` that ends there and whose second event is in `seconds`.
std::array<std::optional<std::vector<EventClass>>, 3> shortest_by_terminal(const Dfa& missed,
                                                                           const EventClasses& classes,
                                                                           EventClass camera, const ClassSet& seconds) {
    struct Reached {
        std::uint32_t state;
        std::size_t from;
        EventClass by;
    };
    std::array<std::optional<std::vector<EventClass>>, 3> found;
    std::vector<Reached> queue{{missed.start, 0, 0}, {missed.step(missed.start, camera), 0, camera}};
    std::vector<bool> seen(missed.states(), false);
    for (std::size_t i = 1; i < queue.size(); ++i) {
        for (std::size_t k = 0; k < missed.column_of_class.size(); ++k) {
            const auto by = static_cast<EventClass>(k);
            const std::uint32_t target = missed.step(queue[i].state, by);
            if (target == 0 || (i == 1 && !seconds[k])) { continue; }
            const auto kind = std::find(terminals.begin(), terminals.end(), classes.example(by).type);
            if (kind == terminals.end()) {
                if (!seen[target]) {
                    seen[target] = true;
                    queue.push_back({target, i, by});
                }
                continue;
            }
            auto& word = found[static_cast<std::size_t>(kind - terminals.begin())];
            if (missed.output[target] == 0 || word) { continue; }
            word.emplace(1, by);
            for (std::size_t at = i; at != 0; at = queue[at].from) { word->push_back(queue[at].by); }
            std::reverse(word->begin(), word->end());
        }
    }
    return found;
}

void find_holes(const Dfa& missed, const EventClasses& classes, bool osl, Overview& overview) {
    std::vector<std::pair<std::string, ClassSet>> kinds;
    EventClass camera = 0;
    const std::size_t count = missed.column_of_class.size();
    for (std::size_t c = 0; c < count; ++c) {
        if (missed.step(missed.start, static_cast<EventClass>(c)) != 0) { camera = static_cast<EventClass>(c); }
    }
    const std::uint32_t after = missed.step(missed.start, camera);
    for (std::size_t k = 0; k < count && after != 0; ++k) {
        if (missed.step(after, static_cast<EventClass>(k)) == 0) { continue; }
        const std::string kind = kind_of(classes.example(static_cast<EventClass>(k)), osl);
        auto place = std::find_if(kinds.begin(), kinds.end(), [&](const auto& each) { return each.first == kind; });
        if (place == kinds.end()) { place = kinds.insert(kinds.end(), {kind, ClassSet(count, false)}); }
        place->second[k] = true;
    }
    for (const auto& [kind, seconds] : kinds) {
        std::vector<Witness> witnesses;
        for (const auto& word : shortest_by_terminal(missed, classes, camera, seconds)) {
            if (word) { witnesses.push_back(witness_of(*word, classes)); }
        }
        std::stable_sort(witnesses.begin(), witnesses.end(),
                         [](const Witness& a, const Witness& b) { return a.events.size() < b.events.size(); });
        if (!witnesses.empty()) {
            Hole hole{kind, witnesses.front(), {witnesses.begin() + 1, witnesses.end()}};
            overview.holes.push_back(std::move(hole));
        }
    }
}

Overview overview_of(std::span<const ChannelSource> channels, const std::optional<ChannelSource>& beauty,
                     const PathStrings& words) {
    std::vector<ChannelSource> all(channels.begin(), channels.end());
    if (beauty) { all.push_back(*beauty); }
    Overview overview;
    const PathStrings world = path_strings_for(all, words);
    auto posed = guarded([&] { return pose(all, world, "a partition", true); });
    if (!posed) {  // labels times letters can give too many classes; comparing pairs needs no letters
        overview.holes_unknown = posed.error().message;
        posed = pose(all, world, "a partition", false);
    }
    const Languages& languages = posed->languages;
    std::vector<Cut> cuts;
    std::vector<const Dfa*> members;
    for (std::size_t k = 0; k < channels.size(); ++k) {
        cuts.push_back(cut_of(languages.channels[k], *languages.words));
    }
    for (const Cut& cut : cuts) { members.push_back(&cut.dfa); }
    const Dfa whole = beauty ? intersection(*languages.words, languages.channels.back()) : *languages.words;
    for (std::size_t k = 0; k < cuts.size(); ++k) {
        if (cuts[k].dfa.start == 0) {
            overview.empty.push_back(k);
        } else if (beauty) {
            if (const auto word = shortest_path_string(difference(cuts[k].dfa, whole), is_set)) {
                overview.outside.push_back({k, witness_of(*word, *languages.classes)});
            }
        }
    }
    find_overlaps(cuts, *languages.classes, overview);
    if (!overview.holes_unknown.empty()) { return overview; }
    const bool osl =
        std::any_of(all.begin(), all.end(), [](const ChannelSource& c) { return c.dialect == Dialect::osl; });
    try {
        const Dfa any = joined(members, union_of(), limits::boolean_states, languages.classes->count(),
                               "the channels of this proof");
        find_holes(difference(whole, any), *languages.classes, osl, overview);
    } catch (Failure& failure) {  // pairs are small even where all channels together are too large
        overview.holes_unknown = std::move(failure.error.message);
    }
    return overview;
}

}  // namespace

Result<Overview> look_over(std::span<const ChannelSource> channels, const std::optional<ChannelSource>& beauty,
                           const PathStrings& words) {
    return guarded([&] { return overview_of(channels, beauty, words); });
}

}  // namespace raylex::lpe
