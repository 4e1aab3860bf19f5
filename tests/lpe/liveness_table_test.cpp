// The fixpoint of liveness against a search through every path of small random automata.
#include "lpe/automata/liveness_table.h"

#include <catch2/catch.hpp>

#include <array>

#include "oracle.h"

using namespace raylex::lpe;

namespace {

constexpr State states = 7;
constexpr EventClass classes = 3;
using Steps = std::array<std::array<State, classes>, states>;

/// [state] whether some word over these events leads there from `from`, of one event or more.
std::array<bool, states> reachable(const Steps& steps, const std::vector<EventClass>& events, State from) {
    std::array<bool, states> seen{};
    std::vector<State> open{from};
    while (!open.empty()) {
        const State state = open.back();
        open.pop_back();
        for (const EventClass event : events) {
            const State to = steps[state][event];
            if (to == 0 || seen[to]) { continue; }
            seen[to] = true;
            open.push_back(to);
        }
    }
    return seen;
}

}  // namespace

TEST_CASE("a liveness table finds what states lead to and what leads to them", "[liveness]") {
    oracle::Random random(3);
    std::size_t some = 0;
    for (int round = 0; round < 200; ++round) {
        Steps steps{};  // state 0 is dead
        for (State state = 1; state < states; ++state) {
            for (State& to : steps[state]) { to = static_cast<State>(random.below(states)); }
        }
        std::vector<EventClass> events;
        for (EventClass event = 0; event < classes; ++event) {
            if (random.below(3) != 0) { events.push_back(event); }
        }
        StateSets sets(states);
        for (State state = 1; state < states; ++state) { sets[state] = random.below(3) == 0 ? 1U << state : 0U; }
        const LivenessTable table(states, [&](State from, EventClass event) { return steps[from][event]; });
        StateSets before(states), eventually = sets, reached = sets;
        for (State from = 1; from < states; ++from) {
            for (const EventClass event : events) { before[from] |= sets[steps[from][event]]; }
            const std::array<bool, states> leads_to = reachable(steps, events, from);
            for (State to = 1; to < states; ++to) {
                if (!leads_to[to]) { continue; }
                eventually[from] |= sets[to];
                reached[to] |= sets[from];
                ++some;
            }
        }
        REQUIRE(table.before(events, sets) == before);
        REQUIRE(table.eventually(events, sets) == eventually);
        REQUIRE(table.reached(events, sets) == reached);
    }
    CHECK(some > 1000);
    CHECK(all_classes(3) == std::vector<EventClass>{0, 1, 2});
}
