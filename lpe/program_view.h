// A compiled program as plain data: pointers to integer arrays, and their sizes. A GPU kernel, a vector unit or another
// language needs no more to follow paths: upload the arrays and reimplement the few functions below.
//
// The state of a path is `word_count` States. Words [0, table_count) are each a row of one transition table; row 0 is
// dead. Where channels would multiply in one table (`C.*X.*` with many labels X) they are packed into lanes instead:
// the last table word is then the phase of the path (before the camera, underway, ended by terminal t), and the words
// after it hold the lanes, 32 to a word. A lane is an automaton of 2, 4 or 8 codes: kind 0, 1 or 2, with kind + 1 bits
// a lane, bit p of the codes of 32 lanes in the word of plane p. One event moves all of a word's lanes at once:
//
//     plane p of the next code = OR over codes c of (lanes in code c) AND image[event class][kind][c][p][word]
//
// all of it 0 where the phase is dead. A terminal event moves lanes to codes that say what they accept. Where all words
// of the lanes become 0 and the word after the image is 0 too, no lane can accept any more.
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
    static constexpr std::uint32_t lane_kinds = 3;

    std::uint32_t word_count = 0;   ///< States of one path
    std::uint32_t table_count = 0;  ///< words that are table rows, the phase included
    std::uint32_t class_count = 1;
    std::uint32_t state_count = 0;  ///< rows of all tables together; all share row 0, the dead one
    std::uint32_t channel_count = 0;

    const State* starts = nullptr;                ///< [word_count] before the camera event
    const State* next_state = nullptr;            ///< [state_count][class_count]
    const std::uint32_t* accept_begin = nullptr;  ///< [state_count + 1] into accept_lists
    const std::uint16_t* accept_lists = nullptr;  ///< channels, ascending in each list

    // Lanes; all zero when word_count == table_count.
    std::uint32_t lane_count = 0;                        ///< bits in all lane words of plane 0, unused ones included
    std::array<std::uint32_t, lane_kinds> lane_words{};  ///< words of one plane, by kind
    std::uint32_t image_stride = 0;                      ///< words of `lane_image` per event class
    std::uint32_t accept_stride = 0;                     ///< words of `lane_accept` per terminal
    State first_ended = 0;                               ///< phase: row of the first terminal; others follow
    /// [class_count][kind][code][plane][word], then three words: 1 where lanes whose words are all 0 may still accept
    /// something; the phase that the event needs, and the one that it leads to (the same as the table says, in a form
    /// that does not wait for the phase).
    const std::uint32_t* lane_image = nullptr;
    static constexpr std::uint32_t image_tail = 3;
    const std::uint32_t* lane_accept = nullptr;  ///< [terminal][kind][code][word]: lanes that accept in that code
    const std::uint32_t* lane_lists = nullptr;   ///< [terminal][lane][8 codes], and one more: into accept_lists

    /// One table word. Lane words have no meaning on their own: see advance().
    [[nodiscard]] State next(State state, EventClass event) const noexcept {
        return next_state[static_cast<std::size_t>(state) * class_count + event];
    }
    [[nodiscard]] std::span<const std::uint16_t> accepted(State state) const noexcept {
        return {accept_lists + accept_begin[state], accept_lists + accept_begin[state + 1]};
    }
    [[nodiscard]] bool has_lanes() const noexcept { return word_count != table_count; }

    /// Moves one path along one event; `to` can be `from`. Returns false when no channel can accept the path now or
    /// after further events.
    bool advance(const State* from, EventClass event, State* to) const noexcept {
        State alive = 0;
        const bool lanes = has_lanes();
        const std::uint32_t tables = table_count - (lanes ? 1 : 0);
        for (std::uint32_t g = 0; g < tables; ++g) {
            to[g] = next(from[g], event);
            alive |= to[g];
        }
        if (lanes) { alive |= static_cast<State>(advance_lanes(from + tables, event, to + tables)); }
        return alive != 0;
    }

    /// Calls visit(channel) once, in no particular order, for every channel that accepts the path so far.
    template <class Visit>
    void for_each_accepted(const State* states, Visit&& visit) const {
        for (std::uint32_t g = 0; g < table_count; ++g) {
            for (const std::uint16_t channel : accepted(states[g])) { visit(channel); }
        }
        for_each_accepted_lane(states, visit);
    }
    /// Calls visit(channel) for the accepting packed channels, which no table row lists.
    template <class Visit>
    void for_each_accepted_lane(const State* states, Visit&& visit) const {
        if (has_lanes() && states[table_count - 1] >= first_ended) { visit_ended(states + table_count - 1, visit); }
    }
    [[nodiscard]] bool accepts_any(const State* states) const noexcept {
        for (std::uint32_t g = 0; g < table_count; ++g) {
            if (accept_begin[states[g]] != accept_begin[states[g] + 1]) { return true; }
        }
        bool any = false;
        if (has_lanes() && states[table_count - 1] >= first_ended) {
            visit_ended(states + table_count - 1, [&any](std::uint16_t) { any = true; });
        }
        return any;
    }

    /// Lane words after `images` (laid out as one class of lane_image, its tail unread) act on `from`, cut to `mask`;
    /// the OR of the result.
    std::uint32_t move_lanes(const std::uint32_t* from, const std::uint32_t* images, std::uint32_t mask,
                             std::uint32_t* to) const noexcept {
        const std::uint32_t ones = lane_words[0];
        std::uint32_t any = 0, w = 0;
        // Four words at a time, then one; all that is read of them is read before any is written.
        Lanes any_four{};
        const Lanes mask_four = Lanes{} + mask;
        for (; w + 4 <= ones; w += 4) {
            const Lanes stay = load_four(images + w);
            const Lanes moved = (stay ^ (load_four(from + w) & (stay ^ load_four(images + ones + w)))) & mask_four;
            std::memcpy(to + w, &moved, sizeof moved);
            any_four |= moved;
        }
        for (; w < ones; ++w) {
            const std::uint32_t stay = images[w];
            const std::uint32_t moved = (stay ^ (from[w] & (stay ^ images[ones + w]))) & mask;
            to[w] = moved;
            any |= moved;
        }
        any |= any_four[0] | any_four[1] | any_four[2] | any_four[3];
        if (image_stride == 2 * ones + image_tail) { return any; }
        if (lane_words[1] != 0) { any |= move_kind<2>(from + ones, images + 2 * ones, lane_words[1], mask, to + ones); }
        if (lane_words[2] != 0) {
            const std::uint32_t skipped = ones + 2 * lane_words[1];
            any |=
                move_kind<3>(from + skipped, images + 2 * ones + 8 * lane_words[1], lane_words[2], mask, to + skipped);
        }
        return any;
    }
    /// The map of an event (`images`) followed by the map `after`, both laid out as one class of lane_image without its
    /// tail; `to` may be `after`.
    void compose_lanes(const std::uint32_t* after, const std::uint32_t* images, std::uint32_t* to) const noexcept {
        if (lane_words[0] != 0) { compose_kind<1>(after, images, lane_words[0], to); }
        if (lane_words[1] != 0) {
            const std::uint32_t skipped = 2 * lane_words[0];
            compose_kind<2>(after + skipped, images + skipped, lane_words[1], to + skipped);
        }
        if (lane_words[2] != 0) {
            const std::uint32_t skipped = 2 * lane_words[0] + 8 * lane_words[1];
            compose_kind<3>(after + skipped, images + skipped, lane_words[2], to + skipped);
        }
    }
    /// Calls visit(channel) for the accepting packed channels. `states` must begin with a phase that has ended.
    template <class Visit>
    void visit_ended(const State* states, Visit&& visit) const {
        visit_lanes(states + 1, states[0] - first_ended, visit);
    }
    /// Whether some lane is in a code for which `masks` (laid out as one terminal of lane_accept) has it. `planes`: the
    /// words behind the phase.
    [[nodiscard]] bool any_lane_in(const State* planes, const std::uint32_t* masks) const noexcept {
        const std::uint32_t ones = lane_words[0], twos = lane_words[1];
        return any_of_kind<1>(planes, masks, ones) || any_of_kind<2>(planes + ones, masks + 2 * ones, twos) ||
               any_of_kind<3>(planes + ones + 2 * twos, masks + 2 * ones + 4 * twos, lane_words[2]);
    }

  private:
    /// No branch, and no way from the lanes to the phase: both would make each event wait for the last.
    bool advance_lanes(const State* from, EventClass event, State* to) const noexcept {
        const std::uint32_t* image = lane_image + std::size_t{event} * image_stride;
        const std::uint32_t* tail = image + image_stride - image_tail;
        const std::uint32_t mask = from[0] == tail[1] ? ~0U : 0U;
        const State phase = tail[2] & mask;
        const std::uint32_t any = move_lanes(from + 1, image, mask, to + 1) | (tail[0] & mask);
        to[0] = phase;
        return any != 0;
    }

    using Lanes [[gnu::vector_size(16)]] = std::uint32_t;
    static Lanes load_four(const std::uint32_t* words) noexcept {
        Lanes four{};
        std::memcpy(&four, words, sizeof four);
        return four;
    }

    template <std::uint32_t bits>
    static std::uint32_t move_kind(const std::uint32_t* from, const std::uint32_t* images, std::uint32_t words,
                                   std::uint32_t mask, std::uint32_t* to) noexcept {
        std::uint32_t any = 0;
        for (std::uint32_t w = 0; w < words; ++w) {
            std::array<std::uint32_t, bits> plane, moved{};
            for (std::uint32_t p = 0; p < bits; ++p) { plane[p] = from[p * words + w]; }
            for (std::uint32_t code = 0; code < (1U << bits); ++code) {
                std::uint32_t lanes = ~0U;
                for (std::uint32_t p = 0; p < bits; ++p) { lanes &= (code >> p & 1U) != 0 ? plane[p] : ~plane[p]; }
                for (std::uint32_t p = 0; p < bits; ++p) { moved[p] |= lanes & images[(code * bits + p) * words + w]; }
            }
            for (std::uint32_t p = 0; p < bits; ++p) {
                to[p * words + w] = moved[p] & mask;
                any |= moved[p] & mask;
            }
        }
        return any;
    }

    template <std::uint32_t bits>
    static void compose_kind(const std::uint32_t* after, const std::uint32_t* images, std::uint32_t words,
                             std::uint32_t* to) noexcept {
        constexpr std::uint32_t codes = 1U << bits;
        for (std::uint32_t w = 0; w < words; ++w) {
            std::array<std::uint32_t, codes * bits> map;
            for (std::uint32_t i = 0; i < codes * bits; ++i) { map[i] = after[i * words + w]; }
            for (std::uint32_t from = 0; from < codes; ++from) {
                std::array<std::uint32_t, bits> moved{};
                for (std::uint32_t code = 0; code < codes; ++code) {
                    std::uint32_t lanes = ~0U;
                    for (std::uint32_t p = 0; p < bits; ++p) {
                        const std::uint32_t plane = images[(from * bits + p) * words + w];
                        lanes &= (code >> p & 1U) != 0 ? plane : ~plane;
                    }
                    for (std::uint32_t p = 0; p < bits; ++p) { moved[p] |= lanes & map[code * bits + p]; }
                }
                for (std::uint32_t p = 0; p < bits; ++p) { to[(from * bits + p) * words + w] = moved[p]; }
            }
        }
    }

    template <class Visit>
    void visit_lanes(const State* planes, std::uint32_t terminal, Visit&& visit) const {
        const std::uint32_t* accept = lane_accept + std::size_t{terminal} * accept_stride;
        const std::uint32_t* lists = lane_lists + std::size_t{terminal} * lane_count * 8;
        visit_kind<1>(planes, accept, lists, lane_words[0], visit);
        if (lane_words[1] != 0) {
            visit_kind<2>(planes + lane_words[0], accept + 2 * lane_words[0], lists + 256 * lane_words[0],
                          lane_words[1], visit);
        }
        if (lane_words[2] != 0) {
            visit_kind<3>(planes + lane_words[0] + 2 * lane_words[1], accept + 2 * lane_words[0] + 4 * lane_words[1],
                          lists + 256 * (lane_words[0] + lane_words[1]), lane_words[2], visit);
        }
    }
    /// Those lanes of word w that are in a code for which `masks` has them.
    template <std::uint32_t bits>
    static std::uint32_t lanes_in(const State* planes, const std::uint32_t* masks, std::uint32_t words,
                                  std::uint32_t w) noexcept {
        std::uint32_t found = 0;
        for (std::uint32_t code = 0; code < (1U << bits); ++code) {
            std::uint32_t lanes = masks[code * words + w];
            for (std::uint32_t p = 0; p < bits; ++p) {
                const State plane = planes[p * words + w];
                lanes &= (code >> p & 1U) != 0 ? plane : ~plane;
            }
            found |= lanes;
        }
        return found;
    }
    template <std::uint32_t bits>
    static bool any_of_kind(const State* planes, const std::uint32_t* masks, std::uint32_t words) noexcept {
        std::uint32_t found = 0;
        for (std::uint32_t w = 0; w < words; ++w) { found |= lanes_in<bits>(planes, masks, words, w); }
        return found != 0;
    }
    /// Lanes of one width, from their planes, what they accept and their lists (8 for each of 32 lanes a word).
    template <std::uint32_t bits, class Visit>
    void visit_kind(const State* planes, const std::uint32_t* accept, const std::uint32_t* lists, std::uint32_t words,
                    Visit&& visit) const {
        for (std::uint32_t w = 0; w < words; ++w, lists += 256) {
            for (std::uint32_t accepting = lanes_in<bits>(planes, accept, words, w); accepting != 0;
                 accepting &= accepting - 1) {
                const auto lane = static_cast<std::uint32_t>(std::countr_zero(accepting));
                std::uint32_t code = 0;
                for (std::uint32_t p = 0; p < bits; ++p) { code |= (planes[p * words + w] >> lane & 1U) << p; }
                for (std::uint32_t i = lists[8 * lane + code]; i < lists[8 * lane + code + 1]; ++i) {
                    visit(accept_lists[i]);
                }
            }
        }
    }
};

}  // namespace raylex::lpe
