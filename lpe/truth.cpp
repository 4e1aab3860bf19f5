#include "lpe/truth.h"

#include <cmath>
#include <cstddef>
#include <string>
#include <unordered_map>

#include "lpe/failure.h"

namespace raylex::lpe {

namespace {

/// The automaton as paths of the enclosure walk through it.
struct Chain {
    struct Step {
        std::size_t to;
        double weight;
    };
    std::vector<std::vector<Step>> steps;  // [state]
    std::vector<double> ending;            // [state] what paths that end here give
};

Chain chain_of(const Program& program, const Enclosure& enclosure) {
    std::vector<std::pair<EventClass, double>> scattering, terminals;
    for (const WeightedEvent& each : enclosure.scattering) {
        scattering.emplace_back(program.classify(each.event), each.weight);
    }
    for (const WeightedEvent& each : enclosure.terminals) {
        terminals.emplace_back(program.classify(each.event), each.weight);
    }
    Chain chain;
    std::unordered_map<State, std::size_t> number;
    std::vector<State> states;
    const auto number_of = [&](State state) {
        const auto [place, fresh] = number.emplace(state, states.size());
        if (fresh) { states.push_back(state); }
        return place->second;
    };
    const State start = program.next(program.starts()[0], program.classify(Event{}));
    if (start == Program::dead) { return chain; }
    number_of(start);
    for (std::size_t i = 0; i < states.size(); ++i) {
        const State state = states[i];
        std::vector<Chain::Step>& steps = chain.steps.emplace_back();
        for (const auto& [event, weight] : scattering) {
            if (const State to = program.next(state, event); to != Program::dead && weight > 0) {
                steps.push_back({number_of(to), weight});
            }
        }
        double& ending = chain.ending.emplace_back(0);
        for (const auto& [event, weight] : terminals) {
            if (program.accepts_any(program.next(state, event))) { ending += weight; }
        }
    }
    return chain;
}

/// x = ending + M x by Gaussian elimination. Rows of I - M are diagonally dominant where albedos sum to less than 1, so
/// that no pivoting is called for (Golub and Van Loan, Matrix Computations, section 3.4.10).
double solve(const Chain& chain) {
    const std::size_t n = chain.steps.size();
    std::vector<double> matrix(n * n, 0), x = chain.ending;
    for (std::size_t row = 0; row < n; ++row) {
        matrix[row * n + row] = 1;
        for (const Chain::Step& step : chain.steps[row]) { matrix[row * n + step.to] -= step.weight; }
    }
    for (std::size_t pivot = n; pivot-- > 1;) {  // upwards: the start, state 0, is what is asked for
        for (std::size_t row = 0; row < pivot; ++row) {
            const double factor = matrix[row * n + pivot] / matrix[pivot * n + pivot];
            if (factor == 0) { continue; }
            for (std::size_t column = 0; column < pivot; ++column) {
                matrix[row * n + column] -= factor * matrix[pivot * n + column];
            }
            x[row] -= factor * x[pivot];
        }
    }
    return x[0] / matrix[0];
}

/// What paths of each number of scattering events give, until nothing is left or `visit` has enough.
template <class Visit>
void walk(const Chain& chain, Visit visit) {
    std::vector<double> here(chain.steps.size(), 0), next;
    here[0] = 1;
    for (std::uint64_t depth = 0;; ++depth) {
        double value = 0, left = 0;
        next.assign(here.size(), 0);
        for (std::size_t state = 0; state < here.size(); ++state) {
            if (here[state] == 0) { continue; }
            value += here[state] * chain.ending[state];
            for (const Chain::Step& step : chain.steps[state]) {
                next[step.to] += here[state] * step.weight;
                left += here[state] * step.weight;
            }
        }
        if (!visit(depth, value) || left == 0) { return; }
        here.swap(next);
    }
}

}  // namespace

Result<EnclosureTruth> enclosure_truth(const ChannelSource& expression, const Enclosure& enclosure,
                                       std::size_t depths_shown) {
    constexpr std::size_t most_states = 3000;
    const Result<Program> program = Program::compile({&expression, 1});
    if (!program) { return program.error(); }
    return guarded([&] {
        double albedo = 0;
        for (const WeightedEvent& each : enclosure.scattering) { albedo += each.weight; }
        if (!enclosure.max_depth && !(albedo < 1)) {
            fail("the enclosure's albedos sum to " + std::to_string(albedo) +
                     ", so that its light has no bound; expected less than 1",
                 "paths of a limited depth have one: give a largest depth");
        }
        EnclosureTruth truth;
        truth.by_depth.assign(depths_shown, 0);
        const Chain chain = chain_of(*program, enclosure);
        if (chain.steps.empty()) { return truth; }
        if (!enclosure.max_depth && chain.steps.size() > most_states) {
            fail("the expression has " + std::to_string(chain.steps.size()) +
                     " states that paths of the enclosure reach; expected at most " + std::to_string(most_states),
                 "give a largest depth, which needs no system of equations");
        }
        if (!enclosure.max_depth) { truth.value = solve(chain); }
        walk(chain, [&](std::uint64_t depth, double value) {
            if (enclosure.max_depth) { truth.value += value; }
            if (depth < depths_shown) { truth.by_depth[depth] = value; }
            return enclosure.max_depth ? depth < *enclosure.max_depth : depth + 1 < depths_shown;
        });
        return truth;
    });
}

}  // namespace raylex::lpe
