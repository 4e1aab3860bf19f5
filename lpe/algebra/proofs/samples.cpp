#include "lpe/algebra/proofs/samples.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace raylex::lpe {

namespace {

/// Walks from the start to an accepting state in a limited number of events, and prefers the least used transitions.
class Walker {
  public:
    Walker(const Dfa& dfa, const std::vector<std::uint32_t>& distance)
        : dfa_(dfa), distance_(distance), uses_(classes(), 0) {}

    std::vector<EventClass> walk(std::size_t longest) {
        std::vector<EventClass> word;
        std::uint32_t state = dfa_.start;
        for (std::size_t left = longest; left > 0 || dfa_.output[state] == 0; --left) {
            std::optional<std::size_t> best;
            for (std::size_t k = 0; k < classes(); ++k) {
                const std::uint32_t next = dfa_.step(state, static_cast<EventClass>(k));
                if (distance_[next] >= left) {  // holds for `unreachable`, too
                    continue;
                }
                if (!best || cost(state, k) < cost(state, *best)) { best = k; }
            }
            if (!best) { break; }
            ++uses_[*best];
            ++turns_[{state, *best}];
            word.push_back(static_cast<EventClass>(*best));
            state = dfa_.step(state, word.back());
        }
        return word;
    }

    /// Counts the transitions of a word that was found otherwise.
    void note(const std::vector<EventClass>& word) {
        std::uint32_t state = dfa_.start;
        for (const EventClass event_class : word) {
            ++uses_[event_class];
            ++turns_[{state, event_class}];
            state = dfa_.step(state, event_class);
        }
    }

  private:
    [[nodiscard]] std::size_t classes() const { return dfa_.column_of_class.size(); }
    [[nodiscard]] std::size_t cost(std::uint32_t state, std::size_t event_class) const {
        const auto turn = turns_.find({state, event_class});
        return 3 * (turn == turns_.end() ? 0 : turn->second) + uses_[event_class];
    }
    const Dfa& dfa_;
    const std::vector<std::uint32_t>& distance_;
    std::vector<std::size_t> uses_;
    std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> turns_;
};

}  // namespace

std::vector<std::uint32_t> events_to_acceptance(const Dfa& dfa) {
    std::vector<std::vector<std::uint32_t>> from(dfa.states());
    for (std::uint32_t state = 0; state < dfa.states(); ++state) {
        for (std::size_t column = 0; column < dfa.columns; ++column) {
            std::vector<std::uint32_t>& list = from[dfa.next[state * dfa.columns + column]];
            if (list.empty() || list.back() != state) { list.push_back(state); }
        }
    }
    std::vector<std::uint32_t> distance(dfa.states(), unreachable);
    std::vector<std::uint32_t> queue;
    for (std::uint32_t state = 0; state < dfa.states(); ++state) {
        if (dfa.output[state] != 0) {
            distance[state] = 0;
            queue.push_back(state);
        }
    }
    for (std::size_t i = 0; i < queue.size(); ++i) {
        for (const std::uint32_t before : from[queue[i]]) {
            if (distance[before] == unreachable) {
                distance[before] = distance[queue[i]] + 1;
                queue.push_back(before);
            }
        }
    }
    return distance;
}

std::vector<std::vector<EventClass>> sample_path_strings(const Dfa& dfa, std::size_t count) {
    std::vector<std::vector<EventClass>> words;
    const auto shortest = shortest_path_string(dfa, [](std::uint32_t output) { return output != 0; });
    if (!shortest || count == 0) { return words; }
    const std::vector<std::uint32_t> distance = events_to_acceptance(dfa);
    Walker walker(dfa, distance);
    words.push_back(*shortest);
    walker.note(*shortest);
    constexpr std::array<std::size_t, 8> longer{0, 1, 2, 1, 3, 2, 4, 0};
    for (std::size_t trial = 0; words.size() < count && trial < 4 * count; ++trial) {
        std::vector<EventClass> word = walker.walk(shortest->size() + longer[trial % longer.size()]);
        if (std::find(words.begin(), words.end(), word) == words.end()) { words.push_back(std::move(word)); }
    }
    const auto shorter = [](const auto& a, const auto& b) { return a.size() < b.size(); };
    std::stable_sort(words.begin() + 1, words.end(), shorter);
    return words;
}

std::vector<std::uint64_t> count_path_strings(const Dfa& dfa, std::size_t longest) {
    std::vector<std::uint64_t> classes_of_column(dfa.columns, 0);
    for (const std::uint16_t column : dfa.column_of_class) { ++classes_of_column[column]; }
    std::vector<std::uint64_t> counts;
    std::vector<std::uint64_t> here(dfa.states(), 0);
    here[dfa.start] = 1;
    for (std::size_t length = 0;; ++length) {
        std::uint64_t accepted = 0;
        for (std::size_t state = 1; state < dfa.states(); ++state) {
            accepted += dfa.output[state] != 0 ? std::min(here[state], most_words - accepted) : 0;
        }
        counts.push_back(accepted);
        if (length == longest) { return counts; }
        std::vector<std::uint64_t> next(dfa.states(), 0);
        for (std::size_t state = 1; state < dfa.states(); ++state) {
            for (std::size_t column = 0; here[state] > 0 && column < dfa.columns; ++column) {
                std::uint64_t& target = next[dfa.next[state * dfa.columns + column]];
                const std::uint64_t width = classes_of_column[column];
                const std::uint64_t more =
                    width > 0 && here[state] > most_words / width ? most_words : here[state] * width;
                target += std::min(more, most_words - target);
            }
        }
        here = std::move(next);
    }
}

std::optional<std::size_t> longest_path_string(const Dfa& dfa) {
    // Finds the longest ways over states that can still accept; a cycle among them means that there is no longest word.
    const std::vector<std::uint32_t> distance = events_to_acceptance(dfa);
    if (distance[dfa.start] == unreachable) { return std::nullopt; }
    // Rounds of relaxation: a way without cycles has fewer events than the automaton has states.
    std::vector<std::size_t> incoming(dfa.states(), 0);
    const auto live_targets = [&](std::uint32_t state) {
        std::vector<std::uint32_t> targets;
        for (std::size_t column = 0; column < dfa.columns; ++column) {
            const std::uint32_t next = dfa.next[state * dfa.columns + column];
            if (distance[next] != unreachable) { targets.push_back(next); }
        }
        std::sort(targets.begin(), targets.end());
        targets.erase(std::unique(targets.begin(), targets.end()), targets.end());
        return targets;
    };
    std::vector<bool> seen(dfa.states(), false);
    std::vector<std::uint32_t> reached{dfa.start};
    seen[dfa.start] = true;
    for (std::size_t i = 0; i < reached.size(); ++i) {
        for (const std::uint32_t next : live_targets(reached[i])) {
            ++incoming[next];
            if (!seen[next]) {
                seen[next] = true;
                reached.push_back(next);
            }
        }
    }
    std::vector<std::size_t> length(dfa.states(), 0);
    std::vector<std::uint32_t> ready;
    if (incoming[dfa.start] == 0) { ready.push_back(dfa.start); }
    std::size_t longest = 0;
    for (std::size_t i = 0; i < ready.size(); ++i) {
        const std::uint32_t state = ready[i];
        longest = dfa.output[state] != 0 ? std::max(longest, length[state]) : longest;
        for (const std::uint32_t next : live_targets(state)) {
            length[next] = std::max(length[next], length[state] + 1);
            if (--incoming[next] == 0) { ready.push_back(next); }
        }
    }
    return ready.size() == reached.size() ? std::optional<std::size_t>(longest) : std::nullopt;
}

}  // namespace raylex::lpe
