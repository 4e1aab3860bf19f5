// Moves the pairs (automaton state, share) of Law 5. Trackers, path suffixes and their connections use it. Private to
// the LPE services.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "display/services/samples/lpe_services.h"
#include "display/services/split_mix.h"

namespace raylex::display {

/// Random numbers that resolve an overflow. Few moves need any, so the key is computed at the first request.
template <class MakeKey>
class ChoiceNumbers {
  public:
    explicit ChoiceNumbers(MakeKey make_key) : make_key_(make_key) {}
    double next() {
        if (!made_) state_ = make_key_();
        made_ = true;
        state_ += golden_gamma;
        return static_cast<double>(mix_bits(state_) >> 11) * 0x1p-53;
    }

  private:
    MakeKey make_key_;
    std::uint64_t state_ = 0;
    bool made_ = false;
};

/// The fraction of a scattering that each part carries, per colour: proportional, or everything for one drawn part.
class Fractions {
  public:
    explicit Fractions(std::span<const LobePart> parts) : parts_(parts) {
        for (const LobePart& part : parts) total_ += RgbD(part.value);
        for (int c = 0; c < 3; ++c) {
            proportional_[c] = total_[c] > 0 && std::isfinite(total_[c]);
            scale_[c] = 1 / total_[c];  // sums of floats: never outside the range of double where it is used
        }
    }
    /// Draws one part per colour, in proportion to its value, with the same number for every colour.
    void pick(double random);
    [[nodiscard]] RgbD of(std::size_t part) const {
        RgbD fraction;
        for (int c = 0; c < 3; ++c)
            fraction[c] = proportional_[c] ? static_cast<double>(parts_[part].value[c]) * scale_[c]
                                           : (part == picked_[c] ? 1.0 : 0.0);
        return fraction;
    }

  private:
    std::span<const LobePart> parts_;
    RgbD total_, scale_;
    std::array<std::size_t, 3> picked_{};  // part 0 for a colour without a value
    std::array<bool, 3> proportional_{};
};

/// Branches after a move, with equal states merged.
class BranchList {
  public:
    static constexpr std::size_t room = 96, most_words = 256;
    std::size_t count = 0;
    bool whole = true;  ///< nothing was split: at most one branch, with share 1
    bool overflow = false;
    std::array<lpe::State, room * most_words> state;  // uninitialised, like the shares
    std::array<BranchShare, room> share;

    /// `beside_class`: the first word of a state is that of a class, and collapse() keeps the share of each.
    explicit BranchList(std::size_t state_words, bool beside_class = false)
        : words_(state_words), beside_class_(beside_class) {}

    void clear() {
        count = 0;
        whole = true;
        overflow = false;
    }
    [[nodiscard]] Branches branches() const { return {state.data(), whole ? nullptr : share.data(), count, words_}; }
    [[nodiscard]] bool has_room_for(std::size_t more) const { return count + more <= room; }
    /// The memory for candidates of further branches, which are contiguous.
    [[nodiscard]] lpe::State* candidates() { return &state[count * words_]; }
    [[nodiscard]] static bool same(const lpe::State* a, const lpe::State* b, std::size_t words) {
        for (std::size_t i = 0; i < words; ++i)
            if (a[i] != b[i]) return false;
        return true;
    }
    /// Adds a candidate as a branch. Later candidates stay where they are, because branches never need more room than
    /// candidates.
    void add(const lpe::State* candidate, const RgbD& amount) {
        std::size_t at = 0;
        while (at < count && !same(candidate, &state[at * words_], words_)) ++at;
        if (at < count) {
            share[at] = {share[at].r + amount.r, share[at].g + amount.g, share[at].b + amount.b};
            return;
        }
        for (std::size_t i = 0; i < words_; ++i) state[at * words_ + i] = candidate[i];
        share[at] = {amount.r, amount.g, amount.b};
        ++count;
    }
    /// Moves all branches of `from`: each part by its own event, `advance(state, event, to)`, with its fraction.
    template <class Advance, class Numbers>
    void split(const Branches& from, std::span<const LobePart> parts, const Fractions& fractions, std::size_t target,
               Numbers& numbers, Advance advance);
    /// Joins the branches of a camera subpath with those of a light subpath: `connect(camera, light, whole)` for each
    /// pair.
    template <class Connect, class Numbers>
    void join(const Branches& of_camera, const Branches& of_light, std::size_t target, Numbers& numbers,
              Connect connect);
    /// Reduces the number of branches to `target` by collapsing the smallest ones. Per colour, the collapse moves the
    /// whole share of the chosen branches to one of them, drawn in proportion to its share. So the sum is preserved
    /// exactly, and the expected share of each branch is unchanged. One random number serves the three colours, so that
    /// they usually choose the same survivor; at most three survive, so three branches more than the excess are chosen.
    void collapse(std::size_t target, double random);
    /// Scales the shares so that those of each state of the class sum to its share in `of_class`.
    void fit(const Branches& of_class);

  private:
    void collapse(std::size_t first, std::size_t last, std::size_t target, double random);
    void collapse_each_class(std::size_t target, double random);
    [[nodiscard]] lpe::State class_of(std::size_t i) const { return state[i * words_]; }
    [[nodiscard]] double size(std::size_t i) const { return share[i].r + share[i].g + share[i].b; }
    /// Removes branches whose shares are all 0.
    void compact();

    std::size_t words_;
    bool beside_class_;
};

template <class Advance, class Numbers>
void BranchList::split(const Branches& from, std::span<const LobePart> parts, const Fractions& fractions,
                       std::size_t target, Numbers& numbers, Advance advance) {
    whole = from.share == nullptr;
    const auto shrink = [&] {
        collapse(target, numbers.next());
        overflow = true;
    };
    for (std::size_t branch = 0; branch < from.count; ++branch) {
        if (!has_room_for(parts.size())) shrink();
        lpe::State* const next = candidates();  // target of each part
        std::uint64_t alive = 0;
        bool agree = true;
        for (std::size_t j = 0; j < parts.size(); ++j) {
            const bool lives = advance(from.state_of(branch), parts[j].event, next + j * words_);
            alive |= std::uint64_t{lives} << j;
            agree = agree && lives == ((alive & 1) != 0) && same(next + j * words_, next, words_);
        }
        const RgbD base = from.share_of(branch);
        if (agree) {
            if (alive != 0) add(next, base);  // the fractions sum to 1: no split, and no rounding
            continue;
        }
        whole = false;
        for (std::size_t j = 0; j < parts.size(); ++j) {
            const RgbD part = (alive >> j & 1) != 0 ? base * fractions.of(j) : RgbD();
            if (part.r != 0 || part.g != 0 || part.b != 0) add(next + j * words_, part);
        }
    }
    if (count > target) shrink();
}

template <class Connect, class Numbers>
void BranchList::join(const Branches& of_camera, const Branches& of_light, std::size_t target, Numbers& numbers,
                      Connect connect) {
    const auto shrink = [&] {
        collapse(target, numbers.next());
        overflow = true;
    };
    whole = of_camera.share == nullptr && of_light.share == nullptr;
    for (std::size_t i = 0; i < of_camera.count; ++i)
        for (std::size_t k = 0; k < of_light.count; ++k) {
            if (!has_room_for(1)) shrink();
            if (!connect(of_camera.state_of(i), of_light.state_of(k), candidates())) continue;
            const RgbD part = of_camera.share_of(i) * of_light.share_of(k);
            if (part.r != 0 || part.g != 0 || part.b != 0) add(candidates(), part);
        }
    if (count > target) shrink();
}

}  // namespace raylex::display
