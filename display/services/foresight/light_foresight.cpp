#include "display/services/foresight/light_foresight.h"

#include <algorithm>

#include "display/services/foresight/state_steps.h"

namespace raylex::display {

using lpe::EventClass;
using lpe::State;

/// Works on one word's reversed automaton: state 0 is dead.
struct LightForesight::Maker {
    const lpe::ReversedProgram& language;
    std::size_t word;
    State camera;  // where words of the camera begin
    std::size_t count = language.state_count(word);

    template <class Visit>
    void for_each_step(std::span<const EventClass> events, Visit visit) const {
        for (State from = 1; from < count; ++from)
            for (const EventClass event : events)
                if (const State to = language.before(word, event, from); to != 0) visit(from, to);
    }

    [[nodiscard]] std::vector<Ahead> run(const Foresight::Alphabet& alphabet) const {
        const auto straight = [&](auto visit) { for_each_step(alphabet.straight, visit); };
        std::vector<std::uint8_t> seen(count), joins(count), goes_on(count);
        for (State state = 1; state < count; ++state) seen[state] = language.accepts(word, camera, state);
        mark_backwards(seen, straight);
        std::vector<std::uint8_t> anything = seen;
        mark_backwards(anything, [&](auto visit) {
            for_each_step(alphabet.scatterings, visit);
            straight(visit);
        });
        for_each_step(alphabet.with_density, [&](State from, State to) { joins[from] |= anything[to]; });
        mark_backwards(joins, straight);
        for_each_step(alphabet.with_density,
                      [&](State from, State to) { goes_on[from] = goes_on[from] || seen[to] || joins[to]; });
        mark_backwards(goes_on, [&](auto visit) {
            for_each_step(alphabet.scatterings, visit);
            straight(visit);
        });
        std::vector<Ahead> states;
        for (State state = 0; state < count; ++state)
            states.push_back({seen[state] != 0, joins[state] != 0, goes_on[state] != 0});
        return states;
    }
};

LightForesight::LightForesight(const LpeSetup& setup, const lpe::ReversedProgram* language,
                               const Foresight::Alphabet& alphabet) {
    const lpe::ProgramView& program = setup.program().view();
    if (language == nullptr || program.has_lanes() || program.word_count == 0) return;
    program_ = &program;
    language_ = language;
    cutouts_ = !alphabet.straight.empty();
    Foresight::Alphabet events;
    events.scatterings = Foresight::distinct(alphabet.scatterings);
    events.straight = Foresight::distinct(alphabet.straight);
    events.with_density = Foresight::distinct(alphabet.with_density);
    for (std::size_t word = 0; word < language->word_count(); ++word)
        states_.push_back(
            Maker{*language, word, setup.first_states_.empty() ? State{0} : setup.first_states_[word]}.run(events));
}

LightForesight::Ahead LightForesight::before(std::span<const State> state, EventClass event) const {
    Ahead ahead{false, false, false};
    for (std::size_t word = 0; word < states_.size(); ++word)
        unite(ahead, states_[word][language_->before(word, event, state[word])]);
    return ahead;
}

LightForesight::Ahead LightForesight::of(EventClass terminal) const {
    if (states_.empty()) return {};
    return before(language_->starts(), terminal);
}

LightForesight::Ahead LightForesight::of(const LightWords& words, const LightWord& word) const {
    if (states_.empty()) return {word.live(), word.live(), word.live()};
    Ahead ahead{false, false, false};
    const State* state = words.states(word);
    for (std::size_t branch = 0; branch < word.branches_; ++branch)
        for (const std::vector<Ahead>& of_word : states_) unite(ahead, of_word[*state++]);
    return ahead;
}

LightForesight::Ahead LightForesight::after(const LightWords& words, const LightWord& word,
                                            std::span<const EventClass> scatterings, std::size_t with_density) const {
    if (states_.empty()) return {word.live(), word.live(), word.live()};
    Ahead ahead{false, false, false};
    for (std::size_t branch = 0; branch < word.branches_; ++branch) {
        const std::span<const State> state{words.states(word) + branch * states_.size(), states_.size()};
        for (std::size_t i = 0; i < scatterings.size(); ++i) {
            const Ahead behind = before(state, scatterings[i]);
            if (i < with_density) unite(ahead, behind);
            else ahead.goes_on |= behind.goes_on;
        }
    }
    return ahead;
}

bool LightForesight::joins(const Tracker& camera, std::span<const EventClass> here, const LightWords& words,
                           const LightWord& word, std::span<const EventClass> there) const {
    if (states_.empty() || cutouts_) return true;  // cutouts in between leave events that only a ray finds
    const std::size_t groups = states_.size();
    const auto in_group = [&](std::size_t group, State of_camera, State of_light) {
        for (const EventClass event : there) {
            const State end = language_->before(group, event, of_light);
            for (const EventClass first : here)
                if (language_->accepts(group, program_->next(of_camera, first), end)) return true;
        }
        return false;
    };
    for (std::size_t i = 0; i < camera.count_ * groups; ++i)
        for (std::size_t branch = 0; branch < word.branches_; ++branch)
            if (in_group(i % groups, camera.state_[i], words.states(word)[branch * groups + i % groups])) return true;
    return false;
}

}  // namespace raylex::display
