// The numbers of one path as the state of a Markov chain: primary sample space (C. Kelemen et al. 2002, "A Simple and
// Robust Mutation Strategy for the Metropolis Light Transport Algorithm", Computer Graphics Forum 21(3)).
//
// A path asks by dimension, as of every PixelSampler; a number that was never asked for does not exist. Mutations are
// lazy: a number learns of the small steps that it missed when it is asked for again, and they are one normal step of
// the square root of their number (M. Pharr et al. 2016, "Physically Based Rendering", section 16.4.4). All draws are
// counter-based, keyed by chain, mutation and dimension: they depend neither on the order of questions nor on anything
// beside the chain.
//
// Paths may scatter a million times, so memory is bounded: subpaths name their dimensions scattering by scattering, and
// of each kind the first `remembered_dimensions` are remembered, which are those of 680 scatterings. Later ones are
// worked out again where they are asked for: large steps draw them, small steps leave them. Proposals are as symmetric
// without these moves, so the chain goes by the same distribution.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "transport/math/vec.h"

namespace raylex::transport {

class PrimarySamples {
  public:
    /// Forgets everything; the next mutation is a large step. `stream` keys the draws.
    void restart(std::uint64_t stream);
    /// Goes on with draws of another stream: chains that start at one point go different ways.
    void switch_stream(std::uint64_t stream) { draws_.stream = stream; }

    /// Begins a mutation: all numbers anew (`large`), or each a little (normal steps of `sigma`, around the unit
    /// interval).
    void propose(bool large, Real sigma);
    /// The mutation becomes the state, or the state is what it was.
    void accept();
    void reject();

    /// The number of that dimension in the mutation; `second` for the other one of a pair. In [0, 1).
    [[nodiscard]] Real get(std::uint32_t dimension, bool second);
    /// A number for the chain's own choices, `use` telling apart those of one mutation.
    [[nodiscard]] Real choose(std::uint32_t use) const;
    /// Numbers that are remembered.
    [[nodiscard]] std::size_t size() const { return numbers_.size(); }
    [[nodiscard]] std::uint64_t mutations() const { return draws_.mutation; }

  private:
    struct Number {
        std::uint64_t name = 0;  // dimension and which of the pair
        Real value = 0, kept = 0;
        std::uint64_t changed = 0, kept_changed = 0;  // the step of the chain in which it was last brought up to date
    };
    static constexpr std::uint32_t remembered_dimensions = 4096;  // of every kind: subpath.h
    /// Key of one mutation's draws.
    struct Draws {
        std::uint64_t stream = 0, mutation = 0;
        [[nodiscard]] std::uint64_t bits(std::uint64_t name) const;
    };
    Number& find(std::uint64_t name);
    void grow();

    Draws draws_;                              // its mutation counts proposals so far
    Draws large_draws_;                        // of the last accepted large step
    std::uint64_t step_ = 0, last_large_ = 0;  // accepted proposals and the one at hand; the last accepted large one
    bool large_ = true;
    Real sigma_ = 0;
    std::vector<Number> numbers_;
    std::vector<std::uint32_t> slots_;  // open addressing by name: index + 1; 0 is free
};

}  // namespace raylex::transport
