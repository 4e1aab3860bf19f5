// Computes what channels can still take of a path (Law 4): anything at all, anything after another scattering, and
// which lights without another scattering. The result depends on the states of the path's tracker and on the events
// that a scene can produce.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/samples/lpe_services.h"

namespace raylex::display {

class Liveness {
  public:
    /// The event classes of a scene. A list may hold a class several times.
    struct Alphabet {
        std::vector<lpe::EventClass> scatterings;
        std::vector<lpe::EventClass> straight;  ///< passing through cutouts
        std::vector<lpe::EventClass> terminals;
        std::vector<lpe::EventClass> user;  ///< user events of surfaces, each followed by `user_terminal`
        lpe::EventClass user_terminal = 0;
        /// The scatterings that have a density: camera and light subpaths can be joined there.
        std::vector<lpe::EventClass> with_density = {};
    };
    /// The classes in ascending order, each once.
    static std::vector<lpe::EventClass> distinct(std::vector<lpe::EventClass> classes);
    /// What is live in one state, or in any of several states.
    struct LiveSet {
        std::uint64_t terminals = ~std::uint64_t{0};  ///< bits by bit_of(): counts without a scattering before it
        bool anything = true;                         ///< some path string of the scene with this prefix is accepted
        bool scatters = true;                         ///< such a path string with another scattering is
    };

    /// Without tables: everything is live.
    Liveness() = default;
    Liveness(const LpeSetup& setup, const Alphabet& alphabet);

    [[nodiscard]] bool is_known() const { return !states_.empty(); }
    /// What is live for a path at the camera.
    [[nodiscard]] const LiveSet& at_camera() const { return at_camera_; }
    [[nodiscard]] LiveSet of(const Tracker& tracker) const;
    /// What is live after one of these events has scattered the path.
    [[nodiscard]] LiveSet after(const Tracker& tracker, std::span<const lpe::EventClass> scatterings) const;
    /// A hash of the tracker's states without their shares. Two different states have the same hash with probability
    /// 2^-63. 0 if there are no tables.
    [[nodiscard]] std::uint64_t state_of(const Tracker& tracker) const;
    /// The bit in LiveSet::terminals of a class in Alphabet::terminals. All kinds after the 63rd share the last bit.
    [[nodiscard]] std::uint64_t bit_of(lpe::EventClass terminal) const {
        return terminal < bits_.size() ? bits_[terminal] : 1;
    }
    /// The values of LiveSet::terminals in the states that paths of the scene reach, for each automaton. The value of a
    /// path is a union of some of these.
    [[nodiscard]] const std::vector<std::uint64_t>& sets_of_terminals() const { return sets_; }
    /// The union of sets_of_terminals(): the terminals that are live for some path.
    [[nodiscard]] std::uint64_t live_terminals() const;

  private:
    struct Builder;
    /// Codes of bit-parallel automata (lpe/program_view.h) for which `live` holds.
    struct ParallelSet {
        LiveSet live;
        std::vector<std::uint32_t> masks;  // laid out as one terminal of ProgramView::parallel_accept
    };
    void find_bits(const LpeSetup& setup, const std::vector<lpe::EventClass>& terminals);
    [[nodiscard]] LiveSet of_branch(const lpe::State* words) const;
    [[nodiscard]] LiveSet of_parallel(const Tracker& tracker) const;
    [[nodiscard]] LiveSet after_parallel(const Tracker& tracker, std::span<const lpe::EventClass> scatterings) const;

    const lpe::ProgramView* program_ = nullptr;
    std::vector<LiveSet> states_;      // [table state]; empty: nothing is known
    std::vector<std::uint64_t> bits_;  // [event class] of terminals
    std::vector<std::uint64_t> sets_;
    bool has_parallel_ = false;
    lpe::State underway_ = 0;            // the phase in which bit-parallel automata are live
    std::vector<ParallelSet> parallel_;  // few: "anything", "scatters", and one for terminals with equal masks
    LiveSet at_camera_;
    static void join(LiveSet& live, const LiveSet& other) {
        live.terminals |= other.terminals;
        live.anything |= other.anything;
        live.scatters |= other.scatters;
    }
};

inline Liveness::LiveSet Liveness::of(const Tracker& tracker) const {
    if (states_.empty()) return {};
    if (has_parallel_) return of_parallel(tracker);
    LiveSet live{0, false, false};
    const std::size_t words = std::size_t{tracker.count_} * program_->word_count;
    for (std::size_t i = 0; i < words; ++i) join(live, states_[tracker.state_[i]]);
    return live;
}

inline Liveness::LiveSet Liveness::after(const Tracker& tracker, std::span<const lpe::EventClass> scatterings) const {
    if (states_.empty()) return {};
    if (has_parallel_) return after_parallel(tracker, scatterings);
    LiveSet live{0, false, false};
    const std::size_t words = std::size_t{tracker.count_} * program_->word_count;
    for (std::size_t i = 0; i < words; ++i)
        for (const lpe::EventClass event : scatterings) join(live, states_[program_->next(tracker.state_[i], event)]);
    return live;
}

}  // namespace raylex::display
