// Plans depend on states and events alone, not on what was asked before or had to be forgotten.
#include "display/services/split_plans.h"

#include <array>

#include <catch2/catch.hpp>

#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::build_setup;
using test::Classes;
using test::Random;

struct Outcome {
    bool fits = false, splits = false;
    std::vector<lpe::State> states;
    std::vector<std::size_t> rows;
    bool operator==(const Outcome&) const = default;
};

Outcome outcome_of(SplitPlans& plans, const std::vector<lpe::State>& states, std::span<const lpe::EventClass> events,
                   std::size_t words) {
    const std::uint32_t set = plans.set_of(states.data(), states.size() / words);
    CHECK(plans.knows(set));
    CHECK_FALSE(plans.knows(SplitPlans::unknown_set));
    const SplitPlans::Plan& plan = plans.plan(set, events);
    Outcome outcome{plan.fits, plan.splits, {}, {}};
    if (!plan.fits) return outcome;
    outcome.states.assign(plans.states(plan), plans.states(plan) + plan.count * words);
    for (std::size_t i = 0; i < plan.rows; ++i) {
        const SplitPlans::Row& row = plans.rows(plan)[i];
        for (const std::size_t number : {row.from(0), row.from(1), row.factor(0), row.factor(1), row.to()})
            outcome.rows.push_back(number);
    }
    return outcome;
}

TEST_CASE("plans that were forgotten are made again as they were", "[lpe_services][law3]") {
    const LpeSetup setup = build_setup(test::count_diffuse(12), 0);
    const Classes classes(setup);
    const lpe::Program& program = setup.program();
    const std::size_t words = program.word_count();
    SplitPlans kept(program, 24), forgetful(program, 24, 5);
    std::vector<lpe::State> first(words);
    program.advance(program.starts().data(), setup.classify(lpe::Event{}), first.data());
    Random random(8);
    int too_many = 0, split = 0;
    for (int path = 0; path < 300; ++path) {
        std::vector<lpe::State> states = first;
        for (int depth = 0; depth < 12 && !states.empty(); ++depth) {
            std::array<lpe::EventClass, 4> events;
            for (auto& event : events) event = classes.scattering[static_cast<std::size_t>(random.below(6))];
            const auto lobes = std::span(events).first(static_cast<std::size_t>(2 + random.below(3)));
            const Outcome outcome = outcome_of(kept, states, lobes, words);
            REQUIRE(outcome_of(forgetful, states, lobes, words) == outcome);
            split += outcome.splits;
            too_many += !outcome.fits;
            if (!outcome.fits) break;
            states = outcome.states;
        }
    }
    CHECK(split > 300);
    SplitPlans narrow(program, 3);
    std::vector<lpe::State> states = first;
    const std::array<lpe::EventClass, 2> both{classes.diffuse, classes.glossy};
    bool fits = true;
    for (int depth = 0; depth < 8 && fits; ++depth) {
        const Outcome outcome = outcome_of(narrow, states, both, words);
        fits = outcome.fits;
        if (fits) states = outcome.states;
    }
    CHECK_FALSE(fits);
    CHECK(states.size() == 3 * words);
}

}  // namespace
}  // namespace raylex::display
