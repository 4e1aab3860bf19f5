#include "experiments/atlas/path_string_answers.h"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "lpe/match.h"

namespace raylex::experiments {
namespace {

using display::PathAlphabet;
using Letter = display::PathStringTable::Letter;
using States = std::vector<lpe::State>;  // automaton states of one path
using StateSet = std::uint32_t;          // index of a set of states

bool is_scattering(const lpe::Event& event) {
    return event.type == lpe::EventType::reflection || event.type == lpe::EventType::transmission ||
           event.type == lpe::EventType::volume;
}

/// Moves sets of states along letters. There are few sets, whatever the words, so each move is computed only once.
class SetWalk {
  public:
    SetWalk(const display::PathStringTable& table, const lpe::Program& program) : program_(program) {
        std::set<lpe::EventClass> any;
        for (std::size_t i = 0; i < table.events.size(); ++i) {
            const lpe::EventClass event = program.classify(table.events[i]);
            classes_[table.letters[i]].insert(event);
            if (is_scattering(table.events[i])) any.insert(event);
        }
        classes_[PathAlphabet::open] = any;
        States first(program.word_count());
        program.advance(program.starts().data(), program.classify(lpe::Event{}), first.data());
        first_ = number_of({first});
    }
    [[nodiscard]] StateSet first() const { return first_; }
    [[nodiscard]] const std::vector<States>& states(StateSet set) const { return *sets_[set]; }

    /// Moves a set along a letter. Dead states stay in the set: they accept nothing, so "all states accept" remains
    /// correct for all paths of the word.
    StateSet move(StateSet from, Letter letter) {
        const auto [place, fresh] = moves_.try_emplace(std::uint64_t{from} << 16 | letter);
        return fresh ? place->second = number_of(moved(states(from), letter)) : place->second;
    }

  private:
    StateSet number_of(std::vector<States> set) {
        const auto [place, fresh] = numbers_.try_emplace(std::move(set), static_cast<StateSet>(sets_.size()));
        if (fresh) sets_.push_back(&place->first);
        return place->second;
    }
    std::vector<States> moved(const std::vector<States>& from, Letter letter) {
        std::set<States> to;
        for (const States& each : from) {
            if (letter == PathAlphabet::open) {
                const std::vector<States>& reached = beyond(each);
                to.insert(reached.begin(), reached.end());
            } else {
                step(each, letter, to);
            }
        }
        return {to.begin(), to.end()};
    }
    void step(const States& from, Letter letter, std::set<States>& to) const {
        States next(from.size());
        for (const lpe::EventClass event : classes_.at(letter)) {
            program_.advance(from.data(), event, next.data());
            to.insert(next);
        }
    }
    /// Returns the states reached from `from` by one or more scattering events.
    const std::vector<States>& beyond(const States& from) {
        const auto [place, fresh] = beyond_.try_emplace(from);
        if (!fresh) return place->second;
        std::set<States> reached;
        step(from, PathAlphabet::open, reached);
        std::vector<States> queue(reached.begin(), reached.end());
        for (std::size_t i = 0; i < queue.size(); ++i) {
            std::set<States> next;
            step(queue[i], PathAlphabet::open, next);
            for (const States& each : next)
                if (reached.insert(each).second) queue.push_back(each);
        }
        return place->second = std::move(queue);
    }

    const lpe::Program& program_;
    std::map<Letter, std::set<lpe::EventClass>> classes_;
    std::map<States, std::vector<States>> beyond_;
    std::map<std::vector<States>, StateSet> numbers_;
    std::vector<const std::vector<States>*> sets_;
    std::unordered_map<std::uint64_t, StateSet> moves_;  // [set, letter]
    StateSet first_ = 0;
};

enum class Answer { none, some, all };

/// Returns whether the number of vertices is `wanted`. Counts are exact only below PathAlphabet::most_vertices.
Answer is_count(std::uint32_t wanted, std::uint32_t found) {
    if (found < PathAlphabet::most_vertices) return found == wanted ? Answer::all : Answer::none;
    return wanted < PathAlphabet::most_vertices ? Answer::none : Answer::some;
}

Answer takes(const lpe::TechniquePrefix& wanted, const display::Technique& found) {
    if (wanted.t != 0) return std::min(is_count(wanted.s, found.s), is_count(wanted.t, found.t));
    if (found.s + found.t > wanted.beyond) return Answer::all;
    return std::max(found.s, found.t) < PathAlphabet::most_vertices ? Answer::none : Answer::some;
}

/// The channels that all states accept, and those that only some accept.
struct Acceptance {
    std::vector<std::uint16_t> all, some;

    Acceptance(const lpe::Program& program, const std::vector<States>& states) {
        std::map<std::uint16_t, std::size_t> count;
        for (const States& each : states)
            program.for_each_accepted(each.data(), [&](std::uint16_t channel) { ++count[channel]; });
        for (const auto& [channel, times] : count) (times == states.size() ? all : some).push_back(channel);
    }
    /// Removes channels whose techniques did not find this light.
    void keep(const PathStringAnswers::Techniques& wanted, const display::Technique& found) {
        const auto answer = [&](std::uint16_t channel) {
            return wanted[channel] ? takes(*wanted[channel], found) : Answer::all;
        };
        std::erase_if(some, [&](std::uint16_t channel) { return answer(channel) == Answer::none; });
        for (const std::uint16_t channel : all)
            if (answer(channel) == Answer::some) some.push_back(channel);
        std::erase_if(all, [&](std::uint16_t channel) { return answer(channel) != Answer::all; });
        std::sort(some.begin(), some.end());
    }
};

}  // namespace

PathStringAnswers::PathStringAnswers(const display::PathStringTable& table, const lpe::Program& program,
                                     const Techniques& techniques)
    : undecided_(program.channel_count(), -1) {
    SetWalk walk(table, program);
    std::map<StateSet, Acceptance> of_set;
    for (std::size_t word = 0; word < table.words.size(); ++word) {
        StateSet set = walk.first();
        for (const Letter letter : table.words[word]) set = walk.move(set, letter);
        Acceptance accepted = of_set.try_emplace(set, program, walk.states(set)).first->second;
        if (!techniques.empty() && !table.techniques.empty()) accepted.keep(techniques, table.techniques[word]);
        all_.insert(all_.end(), accepted.all.begin(), accepted.all.end());
        some_.insert(some_.end(), accepted.some.begin(), accepted.some.end());
        all_begin_.push_back(static_cast<std::uint32_t>(all_.size()));
        some_begin_.push_back(static_cast<std::uint32_t>(some_.size()));
        for (const std::uint16_t channel : accepted.some)
            if (undecided_[channel] < 0) undecided_[channel] = static_cast<std::int64_t>(word);
    }
}

std::string path_string_text(const display::PathStringTable& table, std::uint32_t word) {
    std::string text = "C";
    for (const Letter letter : table.words[word]) {
        text += ' ';
        if (letter == PathAlphabet::open) {
            text += "...";
            continue;
        }
        bool first = true;
        for (std::size_t i = 0; i < table.events.size(); ++i) {
            if (table.letters[i] != letter) continue;
            text += (first ? "" : "/") + lpe::to_text(table.events[i]);
            first = false;
        }
    }
    if (!table.techniques.empty()) text += " (" + to_string(table.techniques[word]) + ")";
    return text;
}

}  // namespace raylex::experiments
