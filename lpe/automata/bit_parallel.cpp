#include "lpe/automata/bit_parallel.h"

#include <algorithm>
#include <bit>
#include <map>
#include <unordered_map>
#include <utility>

namespace raylex::lpe {

namespace {

/// One automaton and where its bits stand.
struct PackedAutomaton {
    const Group* group = nullptr;
    std::vector<std::uint32_t> codes;  // code -> state
    std::unordered_map<std::uint32_t, std::uint32_t> code_of;
    std::uint32_t width = 0, word = 0, bit = 0;
};

std::uint32_t width_of(std::size_t codes) {
    return codes <= 2 ? 0 : codes <= 4 ? 1 : 2;
}

class BitPacker {
  public:
    BitPacker(const std::vector<Group>& groups, const std::vector<ClassRole>& roles) : roles_(roles) {
        std::array<std::uint32_t, ProgramView::parallel_widths> used{};
        for (const Group& group : groups) {
            PackedAutomaton packed{&group, parallel_codes(group.dfa, roles), {}};
            for (std::uint32_t code = 0; code < packed.codes.size(); ++code) {
                packed.code_of.emplace(packed.codes[code], code);
            }
            packed.width = width_of(packed.codes.size());
            packed.word = used[packed.width] / 32;
            packed.bit = used[packed.width]++ % 32;
            automata_.push_back(std::move(packed));
        }
        for (std::size_t width = 0; width < used.size(); ++width) { tables_.words[width] = (used[width] + 31) / 32; }
        widths_ = ProgramView::widths_of(tables_.words);
        can_die_ = std::all_of(automata_.begin(), automata_.end(),
                               [](const PackedAutomaton& packed) { return packed.codes.front() == 0; });
    }

    BitParallelTables run() {
        write_masks();
        const std::vector<std::uint16_t> terminal_of_class = write_terminals();
        write_phase(terminal_of_class);
        return std::move(tables_);
    }

  private:
    void set_mask(std::vector<std::uint32_t>& masks, const PackedAutomaton& packed, std::uint32_t from,
                  std::uint32_t to) {
        const ProgramView::Width& width = widths_[packed.width];
        for (std::uint32_t bit = 0; bit < width.bits; ++bit) {
            masks[width.masks + std::size_t{from * width.bits + bit} * width.words + packed.word] |= (to >> bit & 1U)
                                                                                                     << packed.bit;
        }
    }

    void write_masks() {
        tables_.masks.assign(roles_.size(), std::vector<std::uint32_t>(widths_.back().masks + 1, 0));
        for (std::size_t k = 0; k < roles_.size(); ++k) {
            if (roles_[k] != ClassRole::camera && roles_[k] != ClassRole::scattering) { continue; }
            tables_.masks[k].back() = can_die_ ? 0 : 1;
            for (const PackedAutomaton& packed : automata_) {
                const Dfa& dfa = packed.group->dfa;
                for (std::uint32_t code = 0; code < packed.codes.size(); ++code) {
                    const std::uint32_t from = roles_[k] == ClassRole::camera ? dfa.start : packed.codes[code];
                    set_mask(tables_.masks[k], packed, code,
                             packed.code_of.at(dfa.step(from, static_cast<EventClass>(k))));
                }
            }
        }
    }

    /// Numbers the terminals that differ in what the automata accept; 0xFFFF where none accepts anything.
    std::vector<std::uint16_t> write_terminals() {
        std::map<std::vector<std::uint32_t>, std::uint16_t> seen;
        std::vector<std::uint16_t> terminal_of_class(roles_.size(), no_terminal);
        for (std::size_t k = 0; k < roles_.size(); ++k) {
            if (roles_[k] != ClassRole::terminal) { continue; }
            std::vector<std::uint32_t> outputs;
            for (const PackedAutomaton& packed : automata_) {
                for (const std::uint32_t state : packed.codes) {
                    outputs.push_back(
                        packed.group->dfa.output[packed.group->dfa.step(state, static_cast<EventClass>(k))]);
                }
            }
            if (std::all_of(outputs.begin(), outputs.end(), [](std::uint32_t output) { return output == 0; })) {
                continue;
            }
            const auto [place, fresh] = seen.emplace(outputs, static_cast<std::uint16_t>(seen.size()));
            if (fresh) { add_terminal(outputs); }
            terminal_of_class[k] = place->second;
            tables_.masks[k] = ended_[place->second];
        }
        terminals_ = seen.size();
        return terminal_of_class;
    }

    /// Automata that accept nothing at a terminal go to code 0, so that words that are all 0 mean a path that none
    /// accepts. Where code 0 itself accepts it changes places with a code that does not; an automaton that accepts in
    /// every code keeps the path alive.
    void add_terminal(const std::vector<std::uint32_t>& outputs) {
        const std::size_t accept = tables_.accept.size(), lists = tables_.lists.size();
        tables_.accept.resize(accept + widths_.back().accept, 0);
        tables_.lists.resize(lists + widths_.back().lists);
        std::vector<std::uint32_t> masks(widths_.back().masks + 1, 0);
        std::size_t first = 0;
        for (const PackedAutomaton& packed : automata_) {
            const std::size_t codes = packed.codes.size();
            const auto rejecting =
                static_cast<std::uint32_t>(std::find(outputs.begin() + static_cast<std::ptrdiff_t>(first),
                                                     outputs.begin() + static_cast<std::ptrdiff_t>(first + codes), 0U) -
                                           outputs.begin() - static_cast<std::ptrdiff_t>(first));
            masks.back() |= rejecting == codes ? 1U : 0U;
            for (std::uint32_t code = 0; code < codes; ++code) {
                const std::uint32_t output = outputs[first + code];
                const std::uint32_t to = output == 0 ? 0 : code == 0 && rejecting < codes ? rejecting : code;
                set_mask(masks, packed, code, to);
                if (output != 0) {
                    const ProgramView::Width& width = widths_[packed.width];
                    const std::size_t word = width.accept + std::size_t{to} * width.words + packed.word;
                    tables_.accept[accept + word] |= 1U << packed.bit;
                    tables_.lists[lists + width.lists + code_limit * (32 * packed.word + packed.bit) + to] =
                        packed.group->lists[output];
                }
            }
            first += codes;
        }
        ended_.push_back(std::move(masks));
    }

    void write_phase(const std::vector<std::uint16_t>& terminal_of_class) {
        constexpr std::uint32_t start = 1, on_the_way = 2;
        Dfa& dfa = tables_.phase.dfa;
        dfa.start = start;
        dfa.columns = 3 + terminals_;  // nothing, camera, scattering, terminals
        dfa.output.assign(BitParallelTables::first_ended + terminals_, 0);
        dfa.next.assign(dfa.output.size() * dfa.columns, 0);
        dfa.next[start * dfa.columns + 1] = on_the_way;
        dfa.next[on_the_way * dfa.columns + 2] = on_the_way;
        for (std::uint32_t t = 0; t < terminals_; ++t) {
            dfa.next[on_the_way * dfa.columns + 3 + t] = BitParallelTables::first_ended + t;
        }
        for (std::size_t k = 0; k < roles_.size(); ++k) {
            const bool ends = terminal_of_class[k] != no_terminal;
            dfa.column_of_class.push_back(static_cast<std::uint16_t>(roles_[k] == ClassRole::camera       ? 1
                                                                     : roles_[k] == ClassRole::scattering ? 2
                                                                     : ends ? 3 + terminal_of_class[k]
                                                                            : 0));
        }
    }

    static constexpr std::uint16_t no_terminal = 0xFFFF;
    const std::vector<ClassRole>& roles_;
    std::vector<PackedAutomaton> automata_;
    ProgramView::Widths widths_{};
    bool can_die_ = false;                           // all words 0 underway: no automaton can accept any more
    std::vector<std::vector<std::uint32_t>> ended_;  // [terminal] masks
    std::size_t terminals_ = 0;
    BitParallelTables tables_;
};

}  // namespace

BitParallelTables pack_bit_parallel(const std::vector<Group>& automata, const std::vector<ClassRole>& roles) {
    return BitPacker(automata, roles).run();
}

std::size_t parallel_word_count(const std::vector<Group>& automata, const std::vector<ClassRole>& roles) {
    std::array<std::size_t, ProgramView::parallel_widths> count{};
    for (const Group& group : automata) { ++count[width_of(parallel_codes(group.dfa, roles).size())]; }
    std::size_t words = 0;
    for (std::size_t width = 0; width < count.size(); ++width) { words += (width + 1) * ((count[width] + 31) / 32); }
    return words;
}

}  // namespace raylex::lpe
