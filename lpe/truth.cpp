#include "lpe/truth.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <unordered_map>

#include "lpe/failure.h"

namespace raylex::lpe {

namespace {

/// The automaton as a Markov chain for paths in the enclosure.
struct Chain {
    struct Step {
        std::size_t to;
        double weight;
    };
    std::vector<std::vector<Step>> steps;  // [node]
    std::vector<double> ending;            // [node] light of the paths that end here
};

/// The position of a path: the state of the automaton, the number of sheets that the current flight crosses in total
/// (the widest first), and the number of crossings that remain before the wall.
struct Node {
    State state;
    std::size_t sheets, ahead;
    bool operator==(const Node&) const = default;
};
struct NodeHash {
    std::size_t operator()(const Node& node) const {
        return (node.state * std::size_t{0x9e3779b97f4a7c15} + node.sheets) * std::size_t{0x9e3779b97f4a7c15} +
               node.ahead;
    }
};

/// The fractions of a Lambert lobe's flights that cross exactly 0, 1, 2, ... sheets.
std::vector<double> shares_of_sheets(std::vector<double> radii) {
    std::sort(radii.begin(), radii.end(), std::greater<>());
    std::vector<double> shares;
    double wider = 1;
    for (const double radius : radii) {
        shares.push_back(wider - radius * radius);
        wider = radius * radius;
    }
    shares.push_back(wider);
    return shares;
}

class ChainMaker {
  public:
    ChainMaker(const Program& program, const Enclosure& enclosure)
        : program_(program),
          enclosure_(enclosure),
          shares_(shares_of_sheets(enclosure.sheets.radii)),
          crossing_(program.classify(enclosure.sheets.crossing.event)) {}

    Chain make() {
        const State start = program_.next(program_.starts()[0], program_.classify(Event{}));
        if (start == Program::dead) { return {}; }
        const std::size_t sheets = shares_.size() - 1;
        number_of({start, sheets, sheets});
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            const Node node = nodes_[i];
            steps_ = &chain_.steps.emplace_back();
            chain_.ending.push_back(0);
            if (node.ahead > 0) {
                add(enclosure_.sheets.crossing.weight, program_.next(node.state, crossing_), node.sheets,
                    node.ahead - 1);
            } else {
                leave_wall(node);
            }
            steps_ = nullptr;
        }
        return std::move(chain_);
    }

  private:
    std::size_t number_of(const Node& node) {
        const auto [place, fresh] = number_.emplace(node, nodes_.size());
        if (fresh) { nodes_.push_back(node); }
        return place->second;
    }
    void add(double weight, State to, std::size_t sheets, std::size_t ahead) {
        if (to != Program::dead && weight > 0) { steps_->push_back({number_of({to, sheets, ahead}), weight}); }
    }
    void leave_wall(const Node& node) {
        for (const WeightedEvent& each : enclosure_.scattering) {
            const State to = program_.next(node.state, program_.classify(each.event));
            if (each.event.scatter == Scatter::singular) {
                add(each.weight, to, node.sheets, 2 * node.sheets);
                continue;
            }
            for (std::size_t sheets = 0; sheets < shares_.size(); ++sheets) {
                add(each.weight * shares_[sheets], to, sheets, 2 * sheets);
            }
        }
        for (const WeightedEvent& each : enclosure_.terminals) {
            if (program_.accepts_any(program_.next(node.state, program_.classify(each.event)))) {
                chain_.ending.back() += each.weight;
            }
        }
    }

    const Program& program_;
    const Enclosure& enclosure_;
    std::vector<double> shares_;
    EventClass crossing_;
    Chain chain_;
    std::unordered_map<Node, std::size_t, NodeHash> number_;
    std::vector<Node> nodes_;
    std::vector<Chain::Step>* steps_ = nullptr;  // steps of the node under construction
};

void check_sheets(const Enclosure& enclosure) {
    for (const double radius : enclosure.sheets.radii) {
        if (!(radius > 0 && radius < 1)) {
            fail("a sheet's radius is " + std::to_string(radius) + " of the room's; expected more than 0, less than 1");
        }
    }
    for (const WeightedEvent& each : enclosure.scattering) {
        if (!enclosure.sheets.radii.empty() && each.event.type != EventType::reflection && each.weight > 0) {
            fail("walls let light through, and there are sheets within; expected walls that only reflect");
        }
    }
}

/// Solves x = ending + M x by Gaussian elimination. Rows of I - M are diagonally dominant when albedos sum to less than
/// 1, so no pivoting is needed (Golub and Van Loan, Matrix Computations, section 3.4.10).
double solve(const Chain& chain) {
    const std::size_t n = chain.steps.size();
    std::vector<double> matrix(n * n, 0), x = chain.ending;
    for (std::size_t row = 0; row < n; ++row) {
        matrix[row * n + row] = 1;
        for (const Chain::Step& step : chain.steps[row]) { matrix[row * n + step.to] -= step.weight; }
    }
    for (std::size_t pivot = n; pivot-- > 1;) {  // upwards, because only the value of the start, state 0, is needed
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

/// Sums the light of paths by their number of scattering events, until nothing is left or `visit` returns false.
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
        check_sheets(enclosure);
        double albedo = 0;
        for (const WeightedEvent& each : enclosure.scattering) { albedo += each.weight; }
        if (!enclosure.max_depth && !(albedo < 1)) {
            fail("the albedos of the enclosure sum to " + std::to_string(albedo) +
                     ", so its light is unbounded; expected less than 1",
                 "set a largest depth");
        }
        EnclosureTruth truth;
        truth.by_depth.assign(depths_shown, 0);
        const Chain chain = ChainMaker(*program, enclosure).make();
        if (chain.steps.empty()) { return truth; }
        if (!enclosure.max_depth && chain.steps.size() > most_states) {
            fail("the expression has " + std::to_string(chain.steps.size()) +
                     " states that paths of the enclosure reach; expected at most " + std::to_string(most_states),
                 "set a largest depth; the sum then needs no system of equations");
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
