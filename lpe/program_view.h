// A compiled program as plain data: pointers to integer arrays, and their sizes. A GPU kernel, a vector unit or another
// language needs no more to follow paths: upload the arrays and reimplement the few functions below.
//
// The state of a path is `word_count` States. Words [0, table_count) are each a row of one transition table; row 0 is
// dead. Where channels would multiply in one table (`C.*X.*` with many labels X) they are bit-parallel automata instead
// (Baeza-Yates and Gonnet 1992; Navarro and Raffinot 2002): the last table word is then the phase of the path (before
// the camera, underway, ended by terminal t), and the words after it hold 32 automata each, one in every bit. An
// automaton has 2, 4 or 8 states, numbered by codes of 1, 2 or 3 bits; its width is the number of bits less 1, and bit
// b of the codes of 32 automata is one word. One event moves all automata of a word at once:
//
//     bit b of the next code = OR over codes c of (automata in code c) AND mask[event class][width][c][b][word]
//
// all of it 0 where the phase is dead. A terminal event moves automata to codes that stand for what they accept. Where
// all their words become 0 and the word after the masks is 0 too, no such automaton can accept any more.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace raylex::lpe {

using State = std::uint32_t;
using EventClass = std::uint16_t;

struct ProgramView {
    static constexpr State dead = 0;
    static constexpr std::uint32_t parallel_widths = 3;

    std::uint32_t word_count = 0;   ///< States of one path
    std::uint32_t table_count = 0;  ///< words that are table rows, the phase included
    std::uint32_t class_count = 1;
    std::uint32_t state_count = 0;  ///< rows of all tables together; all share row 0, the dead one
    std::uint32_t channel_count = 0;

    const State* starts = nullptr;                ///< [word_count] before the camera event
    const State* next_state = nullptr;            ///< [state_count][class_count]
    const std::uint32_t* accept_begin = nullptr;  ///< [state_count + 1] into accept_lists
    const std::uint16_t* accept_lists = nullptr;  ///< channels, ascending in each list

    /// Bit-parallel automata of one width, and where these begin in a path's words behind the phase, in the masks of an
    /// event class, and in the masks and lists of a terminal.
    struct Width {
        std::uint32_t bits = 0, codes = 0, words = 0;
        std::uint32_t state = 0, masks = 0, accept = 0, lists = 0;
    };
    using Widths = std::array<Width, parallel_widths + 1>;  // the last has no words: it is where the others end
    [[nodiscard]] static Widths widths_of(const std::array<std::uint32_t, parallel_widths>& words) noexcept {
        Widths all;
        Width at;
        for (std::uint32_t w = 0; w < all.size(); ++w) {
            const std::uint32_t bits = w + 1, codes = 2U << w, count = w < words.size() ? words[w] : 0;
            all[w] = {bits, codes, count, at.state, at.masks, at.accept, at.lists};
            at.state += bits * count;
            at.masks += codes * bits * count;
            at.accept += codes * count;
            at.lists += 256 * count;
        }
        return all;
    }

    // Bit-parallel automata; no words when word_count == table_count.
    Widths widths{};
    std::uint32_t mask_stride = 0;    ///< words of `parallel_masks` per event class
    std::uint32_t accept_stride = 0;  ///< words of `parallel_accept` per terminal
    State first_ended = 0;            ///< phase: row of the first terminal; others follow
    /// [class_count][width][code][bit][word], then three words: 1 where automata whose words are all 0 may still accept
    /// something; the phase that the event needs, and the one that it leads to (as in the table, but readable before
    /// the phase is known).
    const std::uint32_t* parallel_masks = nullptr;
    static constexpr std::uint32_t mask_tail = 3;
    const std::uint32_t* parallel_accept = nullptr;  ///< [terminal][width][code][word]: automata that accept there
    const std::uint32_t* parallel_lists = nullptr;  ///< [terminal][automaton][8 codes], and one more: into accept_lists

    /// One table word. Words of bit-parallel automata move together: see advance().
    [[nodiscard]] State next(State state, EventClass event) const noexcept {
        return next_state[static_cast<std::size_t>(state) * class_count + event];
    }
    [[nodiscard]] std::span<const std::uint16_t> accepted(State state) const noexcept {
        return {accept_lists + accept_begin[state], accept_lists + accept_begin[state + 1]};
    }
    [[nodiscard]] bool has_parallel() const noexcept { return word_count != table_count; }

    /// Moves one path along one event; `to` can be `from`. Returns false when no channel can accept the path now or
    /// after further events.
    bool advance(const State* from, EventClass event, State* to) const noexcept {
        State alive = 0;
        const bool parallel = has_parallel();
        const std::uint32_t tables = table_count - (parallel ? 1 : 0);
        for (std::uint32_t g = 0; g < tables; ++g) {
            to[g] = next(from[g], event);
            alive |= to[g];
        }
        if (parallel) { alive |= static_cast<State>(advance_parallel(from + tables, event, to + tables)); }
        return alive != 0;
    }

    /// Calls visit(channel) once, in no particular order, for every channel that accepts the path so far.
    template <class Visit>
    void for_each_accepted(const State* states, Visit&& visit) const {
        for (std::uint32_t g = 0; g < table_count; ++g) {
            for (const std::uint16_t channel : accepted(states[g])) { visit(channel); }
        }
        for_each_accepted_parallel(states, visit);
    }
    /// Calls visit(channel) for the accepting packed channels, which no table row lists.
    template <class Visit>
    void for_each_accepted_parallel(const State* states, Visit&& visit) const {
        if (has_parallel() && states[table_count - 1] >= first_ended) { visit_ended(states + table_count - 1, visit); }
    }
    [[nodiscard]] bool accepts_any(const State* states) const noexcept {
        for (std::uint32_t g = 0; g < table_count; ++g) {
            if (accept_begin[states[g]] != accept_begin[states[g] + 1]) { return true; }
        }
        bool any = false;
        if (has_parallel() && states[table_count - 1] >= first_ended) {
            visit_ended(states + table_count - 1, [&any](std::uint16_t) { any = true; });
        }
        return any;
    }

    /// Moves the machine words `from` by `masks` (laid out as one class of parallel_masks, of which the tail is not
    /// read), restricted to `mask`. Returns the OR of the results.
    std::uint32_t move_parallel(const std::uint32_t* from, const std::uint32_t* masks, std::uint32_t mask,
                                std::uint32_t* to) const noexcept {
        const std::uint32_t ones = widths[0].words;
        std::uint32_t any = 0, w = 0;
        // Four words at a time, then one; all that is read of them is read before any is written.
        FourWords any_four{};
        const FourWords mask_four = FourWords{} + mask;
        for (; w + 4 <= ones; w += 4) {
            const FourWords stay = load_four(masks + w);
            const FourWords moved = (stay ^ (load_four(from + w) & (stay ^ load_four(masks + ones + w)))) & mask_four;
            std::memcpy(to + w, &moved, sizeof moved);
            any_four |= moved;
        }
        for (; w < ones; ++w) {
            const std::uint32_t stay = masks[w];
            const std::uint32_t moved = (stay ^ (from[w] & (stay ^ masks[ones + w]))) & mask;
            to[w] = moved;
            any |= moved;
        }
        any |= any_four[0] | any_four[1] | any_four[2] | any_four[3];
        if (mask_stride == 2 * ones + mask_tail) { return any; }
        const auto& [one, two, three, end] = widths;
        any |= move_width<2>(from + two.state, masks + two.masks, two.words, mask, to + two.state);
        return any | move_width<3>(from + three.state, masks + three.masks, three.words, mask, to + three.state);
    }
    /// Composes two maps, that of an event (`masks`) followed by `after`, both laid out as one class of parallel_masks
    /// without its tail; `to` may be `after`.
    void compose_parallel(const std::uint32_t* after, const std::uint32_t* masks, std::uint32_t* to) const noexcept {
        const auto& [one, two, three, end] = widths;
        compose_width<1>(after, masks, one.words, to);
        compose_width<2>(after + two.masks, masks + two.masks, two.words, to + two.masks);
        compose_width<3>(after + three.masks, masks + three.masks, three.words, to + three.masks);
    }
    /// Calls visit(channel) for the accepting packed channels. `states` must begin with a phase that has ended.
    template <class Visit>
    void visit_ended(const State* states, Visit&& visit) const {
        visit_parallel(states + 1, states[0] - first_ended, visit);
    }
    /// Whether some automaton is in a code for which `masks` (laid out as one terminal of parallel_accept) contains it.
    /// `state`: the words behind the phase.
    [[nodiscard]] bool any_parallel_in(const State* state, const std::uint32_t* masks) const noexcept {
        const auto& [one, two, three, end] = widths;
        return any_of_width<1>(state, masks, one.words) ||
               any_of_width<2>(state + two.state, masks + two.accept, two.words) ||
               any_of_width<3>(state + three.state, masks + three.accept, three.words);
    }

  private:
    /// It has no branch, and the phase does not depend on the automata: otherwise each event would wait for the one
    /// before.
    bool advance_parallel(const State* from, EventClass event, State* to) const noexcept {
        const std::uint32_t* masks = parallel_masks + std::size_t{event} * mask_stride;
        const std::uint32_t* tail = masks + mask_stride - mask_tail;
        const std::uint32_t mask = from[0] == tail[1] ? ~0U : 0U;
        const State phase = tail[2] & mask;
        const std::uint32_t any = move_parallel(from + 1, masks, mask, to + 1) | (tail[0] & mask);
        to[0] = phase;
        return any != 0;
    }

    using FourWords [[gnu::vector_size(16)]] = std::uint32_t;
    static FourWords load_four(const std::uint32_t* words) noexcept {
        FourWords four{};
        std::memcpy(&four, words, sizeof four);
        return four;
    }

    template <std::uint32_t bits>
    static std::uint32_t move_width(const std::uint32_t* from, const std::uint32_t* masks, std::uint32_t words,
                                    std::uint32_t mask, std::uint32_t* to) noexcept {
        std::uint32_t any = 0;
        for (std::uint32_t w = 0; w < words; ++w) {
            std::array<std::uint32_t, bits> bit, moved{};
            for (std::uint32_t b = 0; b < bits; ++b) { bit[b] = from[b * words + w]; }
            for (std::uint32_t code = 0; code < (1U << bits); ++code) {
                std::uint32_t automata = ~0U;
                for (std::uint32_t b = 0; b < bits; ++b) { automata &= (code >> b & 1U) != 0 ? bit[b] : ~bit[b]; }
                for (std::uint32_t b = 0; b < bits; ++b) {
                    moved[b] |= automata & masks[(code * bits + b) * words + w];
                }
            }
            for (std::uint32_t b = 0; b < bits; ++b) {
                to[b * words + w] = moved[b] & mask;
                any |= moved[b] & mask;
            }
        }
        return any;
    }

    template <std::uint32_t bits>
    static void compose_width(const std::uint32_t* after, const std::uint32_t* masks, std::uint32_t words,
                              std::uint32_t* to) noexcept {
        constexpr std::uint32_t codes = 1U << bits;
        for (std::uint32_t w = 0; w < words; ++w) {
            std::array<std::uint32_t, codes * bits> map;
            for (std::uint32_t i = 0; i < codes * bits; ++i) { map[i] = after[i * words + w]; }
            for (std::uint32_t from = 0; from < codes; ++from) {
                std::array<std::uint32_t, bits> moved{};
                for (std::uint32_t code = 0; code < codes; ++code) {
                    std::uint32_t automata = ~0U;
                    for (std::uint32_t b = 0; b < bits; ++b) {
                        const std::uint32_t bit = masks[(from * bits + b) * words + w];
                        automata &= (code >> b & 1U) != 0 ? bit : ~bit;
                    }
                    for (std::uint32_t b = 0; b < bits; ++b) { moved[b] |= automata & map[code * bits + b]; }
                }
                for (std::uint32_t b = 0; b < bits; ++b) { to[(from * bits + b) * words + w] = moved[b]; }
            }
        }
    }

    template <class Visit>
    void visit_parallel(const State* state, std::uint32_t terminal, Visit&& visit) const {
        const std::uint32_t* accept = parallel_accept + std::size_t{terminal} * accept_stride;
        const auto& [one, two, three, end] = widths;
        const std::uint32_t* lists = parallel_lists + std::size_t{terminal} * end.lists;
        visit_width<1>(state, accept, lists, one.words, visit);
        visit_width<2>(state + two.state, accept + two.accept, lists + two.lists, two.words, visit);
        visit_width<3>(state + three.state, accept + three.accept, lists + three.lists, three.words, visit);
    }
    /// The automata of machine word w whose code is in `masks`.
    template <std::uint32_t bits>
    static std::uint32_t automata_in(const State* state, const std::uint32_t* masks, std::uint32_t words,
                                     std::uint32_t w) noexcept {
        std::uint32_t found = 0;
        for (std::uint32_t code = 0; code < (1U << bits); ++code) {
            std::uint32_t automata = masks[code * words + w];
            for (std::uint32_t b = 0; b < bits; ++b) {
                const State bit = state[b * words + w];
                automata &= (code >> b & 1U) != 0 ? bit : ~bit;
            }
            found |= automata;
        }
        return found;
    }
    template <std::uint32_t bits>
    static bool any_of_width(const State* state, const std::uint32_t* masks, std::uint32_t words) noexcept {
        std::uint32_t found = 0;
        for (std::uint32_t w = 0; w < words; ++w) { found |= automata_in<bits>(state, masks, words, w); }
        return found != 0;
    }
    /// The automata of one width; `lists`: 8 for each of the 32 automata of a word.
    template <std::uint32_t bits, class Visit>
    void visit_width(const State* state, const std::uint32_t* accept, const std::uint32_t* lists, std::uint32_t words,
                     Visit&& visit) const {
        for (std::uint32_t w = 0; w < words; ++w, lists += 256) {
            for (std::uint32_t accepting = automata_in<bits>(state, accept, words, w); accepting != 0;
                 accepting &= accepting - 1) {
                const auto automaton = static_cast<std::uint32_t>(std::countr_zero(accepting));
                std::uint32_t code = 0;
                for (std::uint32_t b = 0; b < bits; ++b) { code |= (state[b * words + w] >> automaton & 1U) << b; }
                for (std::uint32_t i = lists[8 * automaton + code]; i < lists[8 * automaton + code + 1]; ++i) {
                    visit(accept_lists[i]);
                }
            }
        }
    }
};

}  // namespace raylex::lpe
