// The numbers of one path as the state of a Markov chain: primary sample space (C. Kelemen et al. 2002, "A Simple and
// Robust Mutation Strategy for the Metropolis Light Transport Algorithm", Computer Graphics Forum 21(3)).
//
// A path reads numbers by dimension, as from every PixelSampler; a number that was never read does not exist. Mutations
// are lazy: a number catches up with the small steps that it missed when it is read again, as one normal step scaled by
// the square root of their number (M. Pharr et al. 2016, "Physically Based Rendering", section 16.4.4). All draws are
// counter-based, keyed by chain, mutation and dimension. They depend neither on the order of reads nor on anything
// outside the chain.
//
// Paths may scatter a million times, so memory is bounded. Subpaths number their dimensions scattering by scattering;
// the first `remembered_dimensions` of each kind are stored, enough for 680 scatterings. Later ones are recomputed at
// each read: large steps draw them, small steps do not change them. Proposals stay symmetric, so the chain has the same
// distribution.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "transport/math/vec.h"

namespace raylex::transport {

class PrimarySamples {
  public:
    /// Deletes all numbers; the next mutation is a large step. `stream` keys the draws.
    void restart(std::uint64_t stream);
    /// Continues with the draws of another stream: chains that start at one point diverge.
    void switch_stream(std::uint64_t stream) { draws_.stream = stream; }

    /// Begins a mutation: new values for all numbers (`large`), or a small change of each (normal steps of `sigma`,
    /// with wrapping in the unit interval).
    void propose(bool large, Real sigma);
    /// accept() makes the mutation the state; reject() restores the previous state.
    void accept();
    void reject();

    /// The value of a dimension in the mutation, in [0, 1); `second` selects the other number of a pair.
    [[nodiscard]] Real get(std::uint32_t dimension, bool second);
    /// A number for the chain's own decisions; `use` distinguishes those of one mutation.
    [[nodiscard]] Real choose(std::uint32_t use) const;
    /// The number of stored values.
    [[nodiscard]] std::size_t size() const { return numbers_.size(); }
    [[nodiscard]] std::uint64_t mutations() const { return draws_.mutation; }

  private:
    struct Number {
        std::uint64_t name = 0;  // the dimension, and which number of the pair
        Real value = 0, kept = 0;
        std::uint64_t changed = 0, kept_changed = 0;  // the step of the chain at which the value was last updated
    };
    static constexpr std::uint32_t remembered_dimensions = 4096;  // of each kind: subpath.h
    /// The key of one mutation's draws.
    struct Draws {
        std::uint64_t stream = 0, mutation = 0;
        [[nodiscard]] std::uint64_t bits(std::uint64_t name) const;
    };
    Number& find(std::uint64_t name);
    void grow();

    Draws draws_;                              // its mutation is the number of proposals so far
    Draws large_draws_;                        // of the last accepted large step
    std::uint64_t step_ = 0, last_large_ = 0;  // accepted proposals and the current one; the last accepted large step
    bool large_ = true;
    Real sigma_ = 0;
    std::vector<Number> numbers_;
    std::vector<std::uint32_t> slots_;  // open addressing by name: index + 1; 0 is free
};

}  // namespace raylex::transport
