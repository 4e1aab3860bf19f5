// What is ahead of channels that are packed into lanes: each lane is an automaton of a few codes, small enough to be
// looked at one by one before the render. While rendering all of them are asked at once, by masks.
#include <map>

#include "display/services/foresight/foresight.h"

namespace raylex::display {

using lpe::EventClass;
using lpe::ProgramView;
using lpe::State;

struct Foresight::LaneMaker {
    const ProgramView& program;
    const Foresight& foresight;
    const Alphabet& alphabet;
    const std::vector<EventClass> scatterings = distinct(alphabet.scatterings), straight = distinct(alphabet.straight),
                                  terminals = distinct(alphabet.terminals), user = distinct(alphabet.user);

    /// Lanes of one kind: where their words begin in a state's planes, in lane_image and in lane_accept.
    struct Kind {
        std::uint32_t bits, codes, words;
        std::size_t planes, image, accept;
    };
    struct Lane {
        const Kind& kind;
        std::uint32_t word, bit;
        [[nodiscard]] bool among(const std::uint32_t* words) const { return (words[word] >> bit & 1U) != 0; }
    };
    struct Place {
        State phase;
        std::uint32_t code;
    };

    [[nodiscard]] Place next(const Lane& lane, Place from, EventClass event) const {
        const std::uint32_t* image = program.lane_image + std::size_t{event} * program.image_stride;
        const std::uint32_t* tail = image + program.image_stride - ProgramView::image_tail;
        if (from.phase != tail[1]) return {ProgramView::dead, 0};
        Place to{tail[2], 0};
        const Kind& kind = lane.kind;
        for (std::uint32_t p = 0; p < kind.bits; ++p)
            if (lane.among(image + kind.image + (std::size_t{from.code} * kind.bits + p) * kind.words))
                to.code |= 1U << p;
        return to;
    }
    [[nodiscard]] bool accepts(const Lane& lane, Place at) const {
        if (at.phase < program.first_ended) return false;
        const std::uint32_t* accept =
            program.lane_accept + std::size_t{at.phase - program.first_ended} * program.accept_stride;
        return lane.among(accept + lane.kind.accept + std::size_t{at.code} * lane.kind.words);
    }

    struct Code {
        Ahead ahead = {0, false, false};
        bool reached = false;  // by paths of the scene
    };
    using Codes = std::array<Code, 8>;

    /// By the rules that Foresight::Foresight has for the states of tables.
    [[nodiscard]] Codes run(const Lane& lane, const State* first) const {
        Codes codes;
        const auto for_each_step = [&](const std::vector<EventClass>& events, auto visit) {
            for (std::uint32_t code = 0; code < lane.kind.codes; ++code)
                for (const EventClass event : events) {
                    const Place to = next(lane, {foresight.underway_, code}, event);
                    if (to.phase == foresight.underway_) visit(codes[code], codes[to.code]);
                }
        };
        std::uint32_t begin = 0;
        for (std::uint32_t p = 0; p < lane.kind.bits; ++p)
            if (lane.among(first + lane.kind.planes + std::size_t{p} * lane.kind.words)) begin |= 1U << p;
        codes[begin].reached = true;
        for (std::uint32_t code = 0; code < lane.kind.codes; ++code) {
            const Place here{foresight.underway_, code};
            Ahead& ahead = codes[code].ahead;
            for (const EventClass terminal : terminals)
                if (accepts(lane, next(lane, here, terminal))) ahead.terminals |= foresight.bit_of(terminal);
            ahead.anything = ahead.terminals != 0;
            for (const EventClass event : user)
                ahead.anything |= accepts(lane, next(lane, next(lane, here, event), alphabet.user_terminal));
        }
        // As often as there are codes is enough for whatever leads from one to another.
        for (std::uint32_t round = 0; round < lane.kind.codes; ++round)
            for (const std::vector<EventClass>* events : {&scatterings, &straight})
                for_each_step(*events, [](Code& from, Code& to) {
                    from.ahead.anything |= to.ahead.anything;
                    to.reached |= from.reached;
                });
        for_each_step(scatterings, [](Code& from, Code& to) { from.ahead.scatters |= to.ahead.anything; });
        for (std::uint32_t round = 0; round < lane.kind.codes; ++round)
            for_each_step(straight, [](Code& from, Code& to) { join(from.ahead, to.ahead); });
        return codes;
    }
};

void Foresight::foresee_lanes(const Alphabet& alphabet, const State* first) {
    const ProgramView& program = *program_;
    const LaneMaker make{program, *this, alphabet};
    using Masks = std::vector<std::uint32_t>;
    std::size_t planes = 0, image = 0, accept = 0;
    std::array<LaneMaker::Kind, ProgramView::lane_kinds> kinds;
    for (std::uint32_t k = 0; k < ProgramView::lane_kinds; ++k) {
        kinds[k] = {k + 1, 2U << k, program.lane_words[k], planes, image, accept};
        planes += std::size_t{kinds[k].bits} * kinds[k].words;
        image += std::size_t{kinds[k].codes} * kinds[k].bits * kinds[k].words;
        accept += std::size_t{kinds[k].codes} * kinds[k].words;
    }
    Masks anything(accept), scatters(accept);
    std::array<Masks, 64> by_terminal;
    by_terminal.fill(Masks(accept));
    for (const LaneMaker::Kind& kind : kinds)
        for (std::uint32_t word = 0; word < kind.words; ++word)
            for (std::uint32_t bit = 0; bit < 32; ++bit) {
                const LaneMaker::Codes codes = make.run({kind, word, bit}, first);
                for (std::uint32_t code = 0; code < kind.codes; ++code) {
                    const Ahead& ahead = codes[code].ahead;
                    const auto mark = [&](Masks& masks, bool is) {
                        masks[kind.accept + std::size_t{code} * kind.words + word] |= std::uint32_t{is} << bit;
                    };
                    mark(anything, ahead.anything);
                    mark(scatters, ahead.scatters);
                    for (std::size_t t = 0; t < by_terminal.size(); ++t)
                        mark(by_terminal[t], (ahead.terminals >> t & 1U) != 0);
                    if (codes[code].reached) add_set(sets_, ahead.terminals);
                }
            }
    lanes_.push_back({{0, true, false}, std::move(anything)});
    lanes_.push_back({{0, false, true}, std::move(scatters)});
    std::map<Masks, std::uint64_t> terminals;  // those of the same lanes are asked together
    for (std::size_t t = 0; t < by_terminal.size(); ++t) terminals[by_terminal[t]] |= std::uint64_t{1} << t;
    terminals.erase(Masks(accept));
    for (const auto& [masks, bits] : terminals) lanes_.push_back({{bits, false, false}, masks});
}

}  // namespace raylex::display
