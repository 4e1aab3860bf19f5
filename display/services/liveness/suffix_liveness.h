// Computes what channels can still take of a light subpath (Law 4), from its path suffix and the events that a scene
// can produce. It is the counterpart of Liveness for paths that grow from the light. A scattering has the same effect
// on the suffix whether the light subpath grows by it or a camera subpath arrives through it, so one table serves both.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "display/services/liveness/liveness.h"
#include "display/services/liveness/path_suffix.h"

namespace raylex::display {

class SuffixLiveness {
  public:
    /// What is live for a suffix.
    struct LiveSet {
        bool seen = true;      ///< its last vertex can count where the camera sees it, through cutouts or not
        bool connects = true;  ///< that vertex can count where it is joined with a vertex of a camera subpath
        /// The light subpath can scatter further and count there, seen or joined. Either needs a density at that
        /// vertex, and a join also one at its neighbour.
        bool goes_on = true;
        [[nodiscard]] bool anything() const { return seen || connects || goes_on; }
    };

    /// Without tables: everything is live.
    SuffixLiveness() = default;
    /// `reversed` reads the path strings of setup.main() from their ends; both must outlive this object. Everything is
    /// live if it is null, or if the program has bit-parallel automata (lpe/program_view.h).
    SuffixLiveness(const LpeSetup& setup, const lpe::ReversedProgram* reversed, const Liveness::Alphabet& alphabet);

    /// What is live for a suffix that is a light's terminal alone.
    [[nodiscard]] LiveSet of(lpe::EventClass terminal) const;
    [[nodiscard]] LiveSet of(const PathSuffixes& pool, const PathSuffix& suffix) const;
    /// What is live after one of these events is prepended to the suffix. The first `with_density` of them have a
    /// density: only at those can the vertex be seen or connected.
    [[nodiscard]] LiveSet after(const PathSuffixes& pool, const PathSuffix& suffix,
                                std::span<const lpe::EventClass> scatterings, std::size_t with_density) const;
    /// Whether a channel may accept the path string of `camera`, then one event of `here`, one of `there`, and
    /// `suffix`.
    [[nodiscard]] bool connects(const Tracker& camera, std::span<const lpe::EventClass> here, const PathSuffixes& pool,
                                const PathSuffix& suffix, std::span<const lpe::EventClass> there) const;

  private:
    [[nodiscard]] LiveSet before(std::span<const lpe::State> state, lpe::EventClass event) const;
    static void join(LiveSet& live, const LiveSet& other) {
        live.seen |= other.seen;
        live.connects |= other.connects;
        live.goes_on |= other.goes_on;
    }

    const lpe::ProgramView* program_ = nullptr;
    const lpe::ReversedProgram* reversed_ = nullptr;
    std::vector<std::vector<LiveSet>> states_;  // [word of state][reversed state]; empty: nothing is known
    bool cutouts_ = false;
};

}  // namespace raylex::display
