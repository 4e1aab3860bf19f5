// The LPE services: they follow light paths for the integrator and splat every contribution to each display channel
// whose expression accepts the path. An integrator moves a tracker and reports contributions; it never asks which
// channels exist, so adding an AOV never means editing an integrator.
//
// Attribution (Law 5). A tracker carries branches (automaton state, share). When a direction was sampled from a mixture of
// lobes, each lobe's part of the scattering value moves along its own transition, so a contribution reaches each channel
// with exactly the fraction of it that those lobes carried, and the fractions of one contribution sum to 1 in every
// colour. Equal states merge, dead ones drop out. Beauty takes the full value and never looks at the states (Law 2).
//
// Groups. When the compiler spreads the channels over several automata, the state of a branch is one state per automaton:
// a share belongs to a set of paths, not to an automaton, so that a partition whose channels lie in different groups
// still sums exactly when a tracker overflows (Law 1).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/channel.h"
#include "display/services/rgb.h"
#include "display/services/sample_table.h"
#include "lpe/program.h"

namespace raylex::display {

/// How a contribution was found; recorded for technique splits and diagnostics, never part of the word (an emitter is L
/// by what it is, not by how it was hit).
enum class Technique : std::uint8_t { scattering, light_sampling };

/// One lobe's part of a scattering value f(wo, wi) |cos|, in any common scale: only ratios within one move matter.
struct LobePart {
    lpe::EventClass event = 0;
    Rgb value;
};

/// Opaque, fixed capacity, no heap: copy it to look one event ahead (a light sample), then drop the copy. A copy costs
/// what is live: nothing to speak of without expression channels, one state for a path that was never split.
class Tracker {
  public:
    static constexpr int capacity = 24;     ///< branches, with up to two automaton groups; state_room / groups with more
    static constexpr int state_room = 48;
    static constexpr int group_limit = 8;   ///< automaton groups: leaves room for 6 branches

    Tracker() noexcept = default;
    Tracker(const Tracker& other) noexcept { copy(other); }
    Tracker& operator=(const Tracker& other) noexcept {
        if (this != &other) copy(other);
        return *this;
    }

  private:
    friend class LpeServices;
    void copy(const Tracker& other) noexcept;

    std::int32_t row_ = 0;
    std::uint16_t moves_ = 0;    // with the pixel and sample of row_: the source of the overflow choice
    std::uint8_t count_ = 0;     // branches
    std::uint8_t groups_ = 0;    // states per branch
    bool whole_ = true;          // nothing was split yet: at most one branch, its share 1 and not stored
    std::array<lpe::State, state_room> state_;     // [branch][group]
    std::array<double, 3 * capacity> share_;       // [branch][r, g, b]; plain doubles: a copy initialises nothing
};

/// What all threads share: the compiled program and where its channels stand in the sample table. Immutable.
class LpeSetup {
  public:
    /// Compiles every expression channel of `channels` but `beauty`, the id that takes the whole of every contribution, or
    /// invalid_channel when beauty was not asked for. `rest_of` counts in `channels`.
    ///
    /// Errors: an expression that does not parse or is too large; more automaton groups than a tracker can follow; a
    /// channel of another type than rgb; a prefix that is not honoured. `noclamp` is (sample_filter.h); `noinfinitecheck`
    /// never will be (Law 6); the others (unoccluded, nothruput, shadows, holdouts, overwrite) are refused for now.
    static Result<LpeSetup> build(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                  const lpe::CompileOptions& options = {});
    /// Not for the inner loop: ask once per (object label, lobe) and per light group.
    [[nodiscard]] lpe::EventClass classify(const lpe::Event& event) const {
        return program_.group_count() == 0 ? lpe::EventClass{0} : program_.classify(event);
    }
    [[nodiscard]] const lpe::Program& program() const { return program_; }
    [[nodiscard]] ChannelId beauty() const { return beauty_; }

  private:
    friend class LpeServices;
    lpe::Program program_;
    std::vector<lpe::State> first_states_;        // [group] after the camera event; empty when all are dead
    std::vector<ChannelId> channel_of_accept_;    // program channel -> display channel
    ChannelId beauty_ = invalid_channel;
};

/// A rejected contribution, with what it takes to render the sample again (Law 6).
struct InvalidSample {
    std::int32_t pixel_x = 0, pixel_y = 0;
    std::uint64_t sample = 0;
    Rgb value;
};

/// Per thread. All calls are inline-cheap when no expression channel exists.
class LpeServices {
  public:
    static constexpr std::size_t invalid_samples_kept = 16;
    /// A contribution with a larger component is as invalid as one that is not finite: a block of samples with it would
    /// leave the frame buffer's range, for beauty but not for every layer. Far above the sun's 2e9 cd/m^2.
    static constexpr float largest_contribution = 0x1p38f;

    /// How lobes are attributed: `exact` is Law 5; `picked` labels each scattering by one lobe drawn in proportion to its
    /// part (per colour, by one random number, so that colours still sum), the common practice, kept to measure against.
    enum class Attribution : std::uint8_t { exact, picked };

    /// `setup` and `table` must outlive this object; a tracker lives within one batch of the table.
    LpeServices(const LpeSetup& setup, SampleTable& table, std::uint64_t seed, Attribution attribution = Attribution::exact);

    /// A tracker at the camera of `row`, the camera event read.
    [[nodiscard]] Tracker begin(int row) const;

    void move(Tracker& tracker, lpe::EventClass event) const;
    /// A scattering whose value is the sum of `parts`. Per colour the parts are normalised to sum to 1; a colour to which
    /// no part gives anything goes to the first. No parts: the path scatters nothing and every branch dies.
    void move(Tracker& tracker, std::span<const LobePart> parts);

    /// Adds `value` (radiance times throughput, filter weight not applied) to beauty and to every channel whose
    /// expression accepts the path; the terminal event must have been moved along. Non-finite values, and those beyond
    /// largest_contribution, are rejected for beauty and splits alike, counted and logged (Law 6).
    void contribute(const Rgb& value, Technique technique, const Tracker& tracker);

    /// Whether anything could still accept: false means that the path may end (Law 4).
    [[nodiscard]] bool live(const Tracker& tracker) const { return setup_.beauty_ >= 0 || tracker.count_ != 0; }
    /// The same, one event ahead: whether contributing after `event` could reach any channel.
    [[nodiscard]] bool live_after(const Tracker& tracker, lpe::EventClass event) const;

    [[nodiscard]] std::uint64_t overflow_count() const { return overflow_count_; }   ///< moves that had to collapse branches
    [[nodiscard]] std::uint64_t invalid_count() const { return invalid_count_; }
    [[nodiscard]] std::span<const InvalidSample> invalid_samples() const { return invalid_samples_; }
    /// Contributions accepted so far that were found by `technique`.
    [[nodiscard]] std::uint64_t contribution_count(Technique technique) const {
        return contributions_[static_cast<std::size_t>(technique)];
    }

  private:
    struct BranchList;
    void split(Tracker& tracker, std::span<const LobePart> parts);
    void reject(const Rgb& value, const Tracker& tracker);
    static void collapse(BranchList& branches, std::size_t target, std::uint64_t& random_state);
    [[nodiscard]] std::uint64_t random_key(const Tracker& tracker, const LobePart& first) const;

    const LpeSetup& setup_;
    SampleTable& table_;
    std::uint64_t seed_ = 0;
    Attribution attribution_ = Attribution::exact;
    std::uint64_t overflow_count_ = 0, invalid_count_ = 0;
    std::array<std::uint64_t, 2> contributions_{};
    std::vector<InvalidSample> invalid_samples_;
};

}  // namespace raylex::display

#include "display/services/lpe_services_inl.h"
