// What a scattering by several lobes does to the branches of a tracker, worked out once and looked up from then on.
//
// The states that a tracker holds and the events of the lobes decide which branches there are afterwards, which of them
// merge, and which lobe's fraction each share is multiplied by; only the numbers differ from path to path. Paths meet the
// same few hundred such combinations over and over, so each is kept as a plan. A plan depends on nothing but states and
// events, never on what was asked before: results are the same on any number of threads (Law 3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "lpe/program.h"

namespace raylex::display {

class SplitPlans {
  public:
    static constexpr std::size_t most_lobes = 4;
    static constexpr std::size_t first_lobe = 2;  ///< factors before those of the lobes
    static constexpr std::uint32_t unknown_set = 0;
    static constexpr std::size_t fixed_copy = 8;  ///< states that may be read from any plan's, whatever it has

    /// A share or fraction: nothing, red, green, blue, so that it is moved as a whole. As a LobePart has them.
    struct alignas(32) Share {
        double nothing, r, g, b;
    };

    /// share[from[0]] * factor[0] + share[from[1]] * factor[1], for each colour. Factors are 1, 0, then those of the lobes.
    /// The first `count` rows of a plan are the shares afterwards, one each; any more are added to the share `to`.
    /// All five stand in one word, as offsets in bytes from the first share and the first factor: what applies a row is
    /// held up by the number of its loads.
    class Row {
      public:
        struct Term {
            std::size_t from, factor;  ///< indices
        };
        Row(Term first, Term second, std::size_t to)
            : bits_(field(first.from, 0) | field(first.factor, 1) | field(second.from, 2) | field(second.factor, 3) | field(to, 4)) {}
        [[nodiscard]] std::size_t from(unsigned term) const { return bits_ >> 2 * term * width & mask; }
        [[nodiscard]] std::size_t factor(unsigned term) const { return bits_ >> (2 * term + 1) * width & mask; }
        [[nodiscard]] std::size_t to() const { return bits_ >> 4 * width; }

      private:
        static constexpr unsigned width = 12;
        static constexpr std::uint64_t mask = (std::uint64_t{1} << width) - 1;
        static constexpr std::uint64_t field(std::size_t index, unsigned place) {
            return std::uint64_t{index * sizeof(Share)} << place * width;
        }
        std::uint64_t bits_;
    };
    /// An entry of the table of plans, found by what it is a plan for: the states before and the events.
    struct alignas(32) Plan {
        std::uint64_t events = 0;             ///< 16 bits a lobe
        std::uint32_t before = unknown_set;   ///< the states before; unknown_set marks an entry as free
        std::uint32_t set = unknown_set;      ///< the states afterwards
        std::uint32_t first_row = 0;
        std::uint32_t first_word = 0;         ///< of the states afterwards
        std::uint8_t lobes = 0, rows = 0;
        std::uint8_t count = 0;               ///< branches afterwards
        bool splits = false;                  ///< some branch is shared out among the lobes
        bool fits = false;                    ///< no more branches than asked for; else nothing but this is known
    };
    static_assert(sizeof(Plan) == 32);

    /// Branches of `program` with up to `capacity` of them in one tracker. The program must outlive this.
    SplitPlans(const lpe::Program& program, std::size_t capacity, std::size_t most_plans = 1 << 15);

    /// The set of these states ([branch][word]), which may have been forgotten since: sets and plans are dropped, all of
    /// them, when they take more than some MiB.
    std::uint32_t set_of(const lpe::State* states, std::size_t count);
    [[nodiscard]] bool knows(std::uint32_t set) const { return set >= first_set_; }
    /// What two to most_lobes events do to the branches of a known set. The reference lasts until the next call.
    const Plan& plan(std::uint32_t set, std::span<const lpe::EventClass> events) {
        std::uint64_t key = 0;
        for (const lpe::EventClass event : events) key = add_event(key, event);
        return plan(set, key, events.size());
    }
    /// The same of events added to a key, from 0, one after another.
    const Plan& plan(std::uint32_t set, std::uint64_t events, std::size_t lobes);
    static constexpr std::uint64_t add_event(std::uint64_t key, lpe::EventClass event) { return key << 16 | event; }

    [[nodiscard]] const Row* rows(const Plan& plan) const { return rows_.data() + plan.first_row; }
    [[nodiscard]] const lpe::State* states(const Plan& plan) const { return words_.data() + plan.first_word; }

  private:
    struct Set {
        std::uint32_t first_word = 0, count = 0;
    };
    struct Draft;
    std::uint32_t find_set(const lpe::State* states, std::size_t count);
    const Plan& make(std::uint32_t set, std::uint64_t key, std::size_t lobes);
    [[nodiscard]] std::size_t slot_of(std::uint32_t set, std::uint64_t events) const;
    Plan& insert(const Plan& plan);
    void forget();

    const lpe::ProgramView& program_;
    std::size_t capacity_ = 0, most_plans_ = 0;
    std::uint32_t first_set_ = 1;                  // sets are numbered on and on, those before this are forgotten
    std::vector<Set> sets_;
    std::vector<std::uint32_t> set_of_state_;      // [state] of one branch of one word: most paths start so
    std::unordered_multimap<std::uint64_t, std::uint32_t> set_index_;   // hash of states -> set
    std::vector<lpe::State> words_;
    std::vector<Row> rows_;
    std::vector<Plan> plans_;                      // open addressing; the number of entries is a power of two
    std::size_t plan_count_ = 0, plan_mask_ = 0;
};

}  // namespace raylex::display

#include "display/services/split_plans_inl.h"
