#include "display/services/liveness/suffix_liveness.h"

#include "lpe/automata/liveness_table.h"

namespace raylex::display {

using lpe::EventClass;
using lpe::State;
using lpe::StateSets;

SuffixLiveness::SuffixLiveness(const LpeSetup& setup, const lpe::ReversedProgram* reversed,
                               const Liveness::Alphabet& alphabet) {
    const lpe::ProgramView& program = setup.main();
    if (reversed == nullptr || program.has_parallel() || program.word_count == 0) return;
    program_ = &program;
    reversed_ = reversed;
    cutouts_ = !alphabet.straight.empty();
    const std::vector<EventClass> straight = Liveness::distinct(alphabet.straight),
                                  with_density = Liveness::distinct(alphabet.with_density);
    std::vector<EventClass> steps = Liveness::distinct(alphabet.scatterings);
    steps.insert(steps.end(), straight.begin(), straight.end());
    for (std::size_t word = 0; word < reversed->word_count(); ++word) {
        const State camera = setup.first_states_.empty() ? State{0} : setup.first_states_[word];
        const std::size_t count = reversed->state_count(word);
        const lpe::LivenessTable table(
            count, [&](State from, EventClass event) { return reversed->before(word, event, from); });
        StateSets accepted(count);
        for (State state = 1; state < count; ++state) accepted[state] = reversed->accepts(word, camera, state);
        const StateSets seen = table.eventually(straight, std::move(accepted));
        const StateSets connects =
            table.eventually(straight, table.before(with_density, table.eventually(steps, seen)));
        StateSets meets = seen;
        for (State state = 0; state < count; ++state) meets[state] |= connects[state];
        const StateSets goes_on = table.eventually(steps, table.before(with_density, meets));
        std::vector<LiveSet>& live = states_.emplace_back();
        for (State state = 0; state < count; ++state)
            live.push_back({seen[state] != 0, connects[state] != 0, goes_on[state] != 0});
    }
}

SuffixLiveness::LiveSet SuffixLiveness::before(std::span<const State> state, EventClass event) const {
    LiveSet live{false, false, false};
    for (std::size_t word = 0; word < states_.size(); ++word)
        join(live, states_[word][reversed_->before(word, event, state[word])]);
    return live;
}

SuffixLiveness::LiveSet SuffixLiveness::of(EventClass terminal) const {
    if (states_.empty()) return {};
    return before(reversed_->starts(), terminal);
}

SuffixLiveness::LiveSet SuffixLiveness::of(const PathSuffixes& pool, const PathSuffix& suffix) const {
    if (states_.empty()) return {suffix.live(), suffix.live(), suffix.live()};
    LiveSet live{false, false, false};
    const State* state = pool.states(suffix);
    for (std::size_t branch = 0; branch < suffix.branches_; ++branch)
        for (const std::vector<LiveSet>& of_path_string : states_) join(live, of_path_string[*state++]);
    return live;
}

SuffixLiveness::LiveSet SuffixLiveness::after(const PathSuffixes& pool, const PathSuffix& suffix,
                                              std::span<const EventClass> scatterings, std::size_t with_density) const {
    if (states_.empty()) return {suffix.live(), suffix.live(), suffix.live()};
    LiveSet live{false, false, false};
    for (std::size_t branch = 0; branch < suffix.branches_; ++branch) {
        const std::span<const State> state{pool.states(suffix) + branch * states_.size(), states_.size()};
        for (std::size_t i = 0; i < scatterings.size(); ++i) {
            const LiveSet behind = before(state, scatterings[i]);
            if (i < with_density) join(live, behind);
            else live.goes_on |= behind.goes_on;
        }
    }
    return live;
}

bool SuffixLiveness::connects(const Tracker& camera, std::span<const EventClass> here, const PathSuffixes& pool,
                              const PathSuffix& suffix, std::span<const EventClass> there) const {
    if (states_.empty() || cutouts_) return true;  // cutouts in between leave events that only a ray finds
    const std::size_t groups = states_.size();
    const auto in_group = [&](std::size_t group, State of_camera, State of_light) {
        for (const EventClass event : there) {
            const State end = reversed_->before(group, event, of_light);
            for (const EventClass first : here)
                if (reversed_->accepts(group, program_->next(of_camera, first), end)) return true;
        }
        return false;
    };
    for (std::size_t i = 0; i < camera.count_ * groups; ++i)
        for (std::size_t branch = 0; branch < suffix.branches_; ++branch)
            if (in_group(i % groups, camera.state_[i], pool.states(suffix)[branch * groups + i % groups])) return true;
    return false;
}

}  // namespace raylex::display
