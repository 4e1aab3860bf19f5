// What channels may still take of a path, told from where its tracker stands and from the events that a scene can bring
// (Law 4): whether anything, whether something with a scattering before it, and which lights without.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/samples/lpe_services.h"

namespace raylex::display {

class Foresight {
  public:
    /// The events of a scene, by class; one class may stand in a list more than once.
    struct Alphabet {
        std::vector<lpe::EventClass> scatterings;
        std::vector<lpe::EventClass> straight;  ///< passing through cutouts
        std::vector<lpe::EventClass> terminals;
        std::vector<lpe::EventClass> user;  ///< what surfaces say of themselves, ended by `user_terminal`
        lpe::EventClass user_terminal = 0;
        /// Of `scatterings` those that have a density: where subpaths of both ends can meet.
        std::vector<lpe::EventClass> with_density = {};
    };
    /// Ascending, each once.
    static std::vector<lpe::EventClass> distinct(std::vector<lpe::EventClass> classes);
    /// Of a path.
    struct Ahead {
        std::uint64_t terminals = ~std::uint64_t{0};  ///< bit by bit_of(): can count with no scattering before them
        bool anything = true;                         ///< some word of the scene that begins so is accepted
        bool scatters = true;                         ///< one with a scattering more is
    };

    /// Knows nothing: everything may still come.
    Foresight() = default;
    Foresight(const LpeSetup& setup, const Alphabet& alphabet);

    [[nodiscard]] bool knows() const { return !states_.empty(); }
    /// Of paths that are still at the camera.
    [[nodiscard]] const Ahead& at_camera() const { return at_camera_; }
    [[nodiscard]] Ahead of(const Tracker& tracker) const;
    /// The same once the path is scattered by an event of any of these classes.
    [[nodiscard]] Ahead after(const Tracker& tracker, std::span<const lpe::EventClass> scatterings) const;
    /// Tells apart where trackers stand, shares aside, with a chance of 2^-63 to take two for one; 0: nothing is known.
    [[nodiscard]] std::uint64_t state_of(const Tracker& tracker) const;
    /// The bit of Ahead::terminals for a class of Alphabet::terminals. Those after the 63rd share the last.
    [[nodiscard]] std::uint64_t bit_of(lpe::EventClass terminal) const;
    /// The values that Ahead::terminals has for one branch in one automaton, of the states that paths come to; that of
    /// a path is a union of such.
    [[nodiscard]] const std::vector<std::uint64_t>& sets_of_terminals() const { return sets_; }
    /// Their union: what no path's Ahead::terminals goes beyond.
    [[nodiscard]] std::uint64_t terminals_ever() const;

  private:
    struct Maker;
    struct LaneMaker;
    /// What is ahead of the lanes (lpe/program_view.h) that are in one of these codes.
    struct LanesAhead {
        Ahead ahead;
        std::vector<std::uint32_t> masks;  // as one terminal of ProgramView::lane_accept
    };
    static void add_set(std::vector<std::uint64_t>& sets, std::uint64_t terminals) {
        if (std::find(sets.begin(), sets.end(), terminals) == sets.end()) sets.push_back(terminals);
    }
    /// `first`: the planes after the camera event.
    void foresee_lanes(const Alphabet& alphabet, const lpe::State* first);
    [[nodiscard]] Ahead of_branch(const lpe::State* words) const;
    [[nodiscard]] Ahead of_packed(const Tracker& tracker) const;
    [[nodiscard]] Ahead after_packed(const Tracker& tracker, std::span<const lpe::EventClass> scatterings) const;

    const lpe::ProgramView* program_ = nullptr;
    std::vector<Ahead> states_;               // [table state]; empty: nothing is known
    std::vector<lpe::EventClass> terminals_;  // distinct, ascending
    std::vector<std::uint64_t> sets_;
    bool packed_ = false;
    lpe::State underway_ = 0;        // the phase in which lanes have anything ahead
    std::vector<LanesAhead> lanes_;  // few: "anything", "scatters", and one for all terminals of the same lanes
    Ahead at_camera_;
    static void join(Ahead& ahead, const Ahead& other) {
        ahead.terminals |= other.terminals;
        ahead.anything |= other.anything;
        ahead.scatters |= other.scatters;
    }
};

inline Foresight::Ahead Foresight::of(const Tracker& tracker) const {
    if (states_.empty()) return {};
    if (packed_) return of_packed(tracker);
    Ahead ahead{0, false, false};
    const std::size_t words = std::size_t{tracker.count_} * tracker.groups_;
    for (std::size_t i = 0; i < words; ++i) join(ahead, states_[tracker.state_[i]]);
    return ahead;
}

inline Foresight::Ahead Foresight::after(const Tracker& tracker, std::span<const lpe::EventClass> scatterings) const {
    if (states_.empty()) return {};
    if (packed_) return after_packed(tracker, scatterings);
    Ahead ahead{0, false, false};
    const std::size_t words = std::size_t{tracker.count_} * tracker.groups_;
    for (std::size_t i = 0; i < words; ++i)
        for (const lpe::EventClass event : scatterings) join(ahead, states_[program_->next(tracker.state_[i], event)]);
    return ahead;
}

}  // namespace raylex::display
