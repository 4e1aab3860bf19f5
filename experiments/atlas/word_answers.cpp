#include "experiments/atlas/word_answers.h"

#include <algorithm>
#include <map>
#include <set>

#include "lpe/match.h"

namespace raylex::experiments {
namespace {

using display::WordAlphabet;
using Letter = display::WordTable::Letter;
using States = std::vector<lpe::State>;  // of one path

bool is_scattering(const lpe::Event& event) {
    return event.type == lpe::EventType::reflection || event.type == lpe::EventType::transmission ||
           event.type == lpe::EventType::volume;
}

/// Moves sets of states along letters.
class SetWalk {
  public:
    SetWalk(const display::WordTable& table, const lpe::Program& program) : program_(program) {
        std::set<lpe::EventClass> any;
        for (std::size_t i = 0; i < table.events.size(); ++i) {
            const lpe::EventClass event = program.classify(table.events[i]);
            classes_[table.letters[i]].insert(event);
            if (is_scattering(table.events[i])) any.insert(event);
        }
        classes_[WordAlphabet::open] = any;
        States first(program.word_count());
        program.advance(program.starts().data(), program.classify(lpe::Event{}), first.data());
        first_.push_back(first);
    }
    [[nodiscard]] const std::vector<States>& first() const { return first_; }

    /// Dead paths stay among the states, for they accept nothing: what all states accept is what all paths do.
    std::vector<States> move(const std::vector<States>& from, Letter letter) {
        std::set<States> to;
        for (const States& each : from) {
            if (letter == WordAlphabet::open) {
                const std::vector<States>& reached = beyond(each);
                to.insert(reached.begin(), reached.end());
            } else {
                step(each, letter, to);
            }
        }
        return {to.begin(), to.end()};
    }

  private:
    void step(const States& from, Letter letter, std::set<States>& to) const {
        States next(from.size());
        for (const lpe::EventClass event : classes_.at(letter)) {
            program_.advance(from.data(), event, next.data());
            to.insert(next);
        }
    }
    /// All that one scattering or more lead to.
    const std::vector<States>& beyond(const States& from) {
        const auto [place, fresh] = beyond_.try_emplace(from);
        if (!fresh) return place->second;
        std::set<States> reached;
        step(from, WordAlphabet::open, reached);
        std::vector<States> queue(reached.begin(), reached.end());
        for (std::size_t i = 0; i < queue.size(); ++i) {
            std::set<States> next;
            step(queue[i], WordAlphabet::open, next);
            for (const States& each : next)
                if (reached.insert(each).second) queue.push_back(each);
        }
        return place->second = std::move(queue);
    }

    const lpe::Program& program_;
    std::map<Letter, std::set<lpe::EventClass>> classes_;
    std::map<States, std::vector<States>> beyond_;
    std::vector<States> first_;
};

/// Channels by how many of the states accept.
struct Acceptance {
    std::vector<std::uint16_t> all, some;

    Acceptance(const lpe::Program& program, const std::vector<States>& states) {
        std::map<std::uint16_t, std::size_t> count;
        for (const States& each : states)
            program.for_each_accepted(each.data(), [&](std::uint16_t channel) { ++count[channel]; });
        for (const auto& [channel, times] : count) (times == states.size() ? all : some).push_back(channel);
    }
};

}  // namespace

WordAnswers::WordAnswers(const display::WordTable& table, const lpe::Program& program)
    : undecided_(program.channel_count(), -1) {
    SetWalk walk(table, program);
    // Words share their beginnings: states behind each are worked out once.
    std::map<std::vector<Letter>, std::vector<States>> behind{{{}, walk.first()}};
    for (std::size_t word = 0; word < table.words.size(); ++word) {
        const std::vector<Letter>& letters = table.words[word];
        std::vector<Letter> prefix;
        const std::vector<States>* states = &behind.at({});
        for (std::size_t i = 0; i + 1 < letters.size(); ++i) {
            prefix.push_back(letters[i]);
            const auto [place, fresh] = behind.try_emplace(prefix);
            if (fresh) place->second = walk.move(*states, letters[i]);
            states = &place->second;
        }
        const Acceptance accepted(program, walk.move(*states, letters.back()));
        all_.insert(all_.end(), accepted.all.begin(), accepted.all.end());
        some_.insert(some_.end(), accepted.some.begin(), accepted.some.end());
        all_begin_.push_back(static_cast<std::uint32_t>(all_.size()));
        some_begin_.push_back(static_cast<std::uint32_t>(some_.size()));
        for (const std::uint16_t channel : accepted.some)
            if (undecided_[channel] < 0) undecided_[channel] = static_cast<std::int64_t>(word);
    }
}

std::string word_text(const display::WordTable& table, std::uint32_t word) {
    std::string text = "C";
    for (const Letter letter : table.words[word]) {
        text += ' ';
        if (letter == WordAlphabet::open) {
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
    return text;
}

}  // namespace raylex::experiments
