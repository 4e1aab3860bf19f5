// A light path accumulator in the shape that renderers built on Open Shading Language know (begin, move, push, pop,
// end, accum into AOVs), on a raylex program instead of OSL's automaton. What a renderer with such calls needs to
// change is the classes below; the rest checks their answers against raylex::lpe::match.
//
// Where it differs from OSL: an event is one symbol and not a word of symbols, so move() takes whole events; their
// classes are asked for once (EventCache) and a move is one look-up however many expressions there are. Writing to an
// AOV happens at once, there is no flush.
#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "lpe/match.h"
#include "lpe/program.h"

using raylex::lpe::ChannelSource;
using raylex::lpe::Dialect;
using raylex::lpe::Event;
using raylex::lpe::EventClass;
using raylex::lpe::EventType;
using raylex::lpe::Program;
using raylex::lpe::Scatter;
using raylex::lpe::State;

namespace {

struct Color {
    float r = 0, g = 0, b = 0;
};

/// Where an expression's light goes: the renderer's frame buffer.
class Aov {
  public:
    void write(const Color& color) {
        value_.r += color.r;
        value_.g += color.g;
        value_.b += color.b;
    }
    [[nodiscard]] const Color& value() const { return value_; }

  private:
    Color value_;
};

/// The rules, compiled once and shared by all threads. An output may have several rules.
class AccumulatorRules {
  public:
    void add_rule(const std::string& expression, std::size_t output) {
        ChannelSource source;
        source.name = expression;
        source.expression = expression;
        source.dialect = Dialect::osl;
        sources_.push_back(source);
        outputs_.push_back(output);
    }
    bool compile() {
        auto program = Program::compile(sources_);
        if (!program) {
            std::fprintf(stderr, "%s\n", program.error().to_string().c_str());
            return false;
        }
        program_ = std::move(*program);
        return true;
    }
    [[nodiscard]] const Program& program() const { return program_; }
    [[nodiscard]] std::size_t output(std::size_t rule) const { return outputs_[rule]; }

  private:
    std::vector<ChannelSource> sources_;
    std::vector<std::size_t> outputs_;
    Program program_;
};

/// Event classes by what a renderer knows of a closure: a renderer asks once per material and light, here on first use.
class EventCache {
  public:
    explicit EventCache(const Program& program) : program_(program) {}
    EventClass operator()(EventType type, Scatter scatter, const std::string& label) {
        const auto key = std::make_tuple(type, scatter, label);
        const auto known = classes_.find(key);
        if (known != classes_.end()) { return known->second; }
        return classes_.emplace(key, program_.classify({type, scatter, 0, {label}})).first->second;
    }

  private:
    const Program& program_;
    std::map<std::tuple<EventType, Scatter, std::string>, EventClass> classes_;
};

/// One per thread.
class Accumulator {
  public:
    Accumulator(const AccumulatorRules& rules, std::vector<Aov>& aovs) : rules_(rules), aovs_(aovs) {}

    /// Starts a path before its camera event.
    void begin() {
        const auto starts = rules_.program().starts();
        stack_.assign(starts.begin(), starts.end());
    }
    /// False when no rule can accept any more: the path may end.
    bool move(EventClass event) {
        const std::size_t words = rules_.program().word_count();
        State* top = stack_.data() + stack_.size() - words;
        return rules_.program().advance(top, event, top);
    }
    /// Keeps the state to come back to, as before a light sample.
    void push_state() {
        const std::size_t words = rules_.program().word_count(), size = stack_.size();
        stack_.resize(size + words);
        std::copy_n(stack_.data() + size - words, words, stack_.data() + size);
    }
    void pop_state() { stack_.resize(stack_.size() - rules_.program().word_count()); }
    /// Adds the colour to the output of every rule that accepts the path.
    void accum(const Color& color) {
        const State* top = stack_.data() + stack_.size() - rules_.program().word_count();
        rules_.program().for_each_accepted(top, [&](std::uint16_t rule) { aovs_[rules_.output(rule)].write(color); });
    }
    void end() { stack_.clear(); }

  private:
    const AccumulatorRules& rules_;
    std::vector<Aov>& aovs_;
    std::vector<State> stack_;
};

}  // namespace

int main() {
    const std::vector<std::string> expressions{
        "C.*",        "C<RD>L",          "C<RD>.+L",         "C<R[GS]'car'>.*L", "C<..'car'>[DS]*<L.'key'>",
        "C[^D]*D.*L", "C<T[GS]>+.*[LO]", "C.*<RD'floor'>.*", "C.*<RD'wall'>.*",  "C[GS]*D[GS]*L"};
    AccumulatorRules rules;
    for (std::size_t k = 0; k < expressions.size(); ++k) { rules.add_rule(expressions[k], k); }
    if (!rules.compile()) { return 1; }
    std::vector<Aov> aovs(expressions.size());
    std::vector<float> expected(expressions.size(), 0);
    EventCache event_class(rules.program());
    Accumulator accumulator(rules, aovs);

    const std::vector<std::string> objects{"car", "floor", "wall", ""};
    unsigned random = 1;
    const auto below = [&random](unsigned bound) {
        random = random * 1664525U + 1013904223U;  // Numerical Recipes
        return (random >> 16) % bound;
    };
    for (int path = 0; path < 200; ++path) {
        std::vector<Event> word{{EventType::camera, Scatter::none, 0, {}}};
        accumulator.begin();
        accumulator.move(event_class(EventType::camera, Scatter::none, ""));
        for (unsigned bounce = below(5) + 1; bounce > 0; --bounce) {
            const auto type = below(3) == 0 ? EventType::transmission : EventType::reflection;
            const auto scatter = static_cast<Scatter>(1 + below(3));
            const std::string& object = objects[below(4)];
            word.push_back({type, scatter, 0, {object}});
            accumulator.move(event_class(type, scatter, object));
            // A light sample at every vertex, as renderers do: the path's state is kept meanwhile.
            word.push_back({EventType::light, Scatter::none, 0, {below(2) == 0 ? "key" : "fill"}});
            accumulator.push_state();
            accumulator.move(event_class(EventType::light, Scatter::none, word.back().labels[0]));
            accumulator.accum({1, 1, 1});
            accumulator.pop_state();
            for (std::size_t k = 0; k < expressions.size(); ++k) {
                expected[k] += *raylex::lpe::match(expressions[k], word, Dialect::osl) ? 1.0F : 0.0F;
            }
            word.pop_back();
        }
        accumulator.end();
    }
    bool right = true;
    for (std::size_t k = 0; k < expressions.size(); ++k) {
        right = right && aovs[k].value().r == expected[k] && expected[k] > 0;
        std::printf("%-24s %5g contributions, %g expected\n", expressions[k].c_str(),
                    static_cast<double>(aovs[k].value().r), static_cast<double>(expected[k]));
    }
    return right ? 0 : 1;
}
