// The LPE services: they follow light paths for the integrator and splat every contribution to each display channel
// whose expression accepts the path. An integrator moves a tracker and reports contributions; it never asks which
// channels exist, so adding an AOV never means editing an integrator.
//
// Attribution (Law 5). A tracker carries branches (automaton state, share). When a direction was sampled from a mixture
// of lobes, each lobe's part of the scattering value moves along its own transition, so a contribution reaches each
// channel with exactly the fraction of it that those lobes carried, and the fractions of one contribution sum to 1 in
// every colour. Equal states merge, dead ones drop out. Beauty takes the full value and never looks at the states (Law
// 2).
//
// Groups. When the compiler spreads the channels over several automata, or packs some of them into bits, the state of a
// branch is a few words (lpe/program_view.h): a share belongs to a set of paths, not to an automaton, so that a
// partition whose channels lie in different groups still sums exactly when a tracker overflows (Law 1).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "display/services/channel.h"
#include "display/services/channel_prefixes.h"
#include "display/services/rgb.h"
#include "display/services/samples/sample_table.h"
#include "display/services/samples/splat_sets.h"
#include "lpe/liveness_table.h"
#include "lpe/program.h"

namespace raylex::display {

/// An emitter as a path found it, before the path changes it: what channels with prefixes splat instead of the value
/// that beauty takes (channel_prefixes.h). An integrator fills it in only where LpeServices::wants_emitter_samples().
struct EmitterSample {
    Rgb emitted;     ///< what leaves the emitter towards the path: radiance; intensity of point and spot lights;
                     ///< irradiance across the beam of distant ones. No throughput, density or geometry in it.
    Rgb unweighted;  ///< radiance times throughput over density with nothing in the way, and all of the MIS weight
                     ///< given to the technique that found it
    float visibility = 1;            ///< fraction that arrives: 0 behind an opaque surface
    bool found_by_sampling = false;  ///< found in another way, though light sampling finds the same emitter there too:
                                     ///< channels of light that nothing shadows leave it to the light sample
};

/// One lobe's part of a scattering value f(wo, wi) |cos|, in any common scale: only ratios within one move matter.
struct LobePart {
    lpe::EventClass event = 0;
    Rgb value;
};

/// What part of a contribution a branch carries, per colour.
struct BranchShare {
    double r, g, b;
    [[nodiscard]] RgbD rgb() const { return {r, g, b}; }
};

class BranchList;
struct Branches;
class PathSuffix;
class PathSuffixes;
class PathWords;
class WordAlphabet;

/// Opaque, fixed capacity, no heap: copy it to look one event ahead (a light sample), then drop the copy. A copy costs
/// what is live: nothing to speak of without expression channels, one state for a path that was never split.
class Tracker {
  public:
    static constexpr int capacity = 24;  ///< branches, with up to five words of state; state_room / words with more
    static constexpr int state_room = 128;
    static constexpr int group_limit = 32;  ///< words of state (automaton groups, packed channels): room for 4 branches

    Tracker() noexcept = default;
    Tracker(const Tracker& other) noexcept { copy(other); }
    Tracker& operator=(const Tracker& other) noexcept {
        if (this != &other) copy(other);
        return *this;
    }

    /// Pairs of (automaton state, share) carried at the moment; for diagnostics.
    [[nodiscard]] int branches() const noexcept { return count_; }

  private:
    friend class LpeServices;
    friend class Liveness;
    friend class SuffixLiveness;
    void copy(const Tracker& other) noexcept;
    std::int32_t row_ = 0;
    std::uint32_t path_ = 0;                    // in the batch's PathWords, where an atlas keeps words
    std::uint16_t moves_ = 0;                   // with the pixel and sample of row_: the source of the overflow choice
    std::uint8_t count_ = 0;                    // branches
    std::uint8_t groups_ = 0;                   // words of state per branch
    bool whole_ = true;                         // nothing was split yet: at most one branch, its share 1 and not stored
    bool held_out_ = false;                     // the path's first hit is a holdout
    std::array<lpe::State, state_room> state_;  // [branch][group]; nothing is initialised
    std::array<BranchShare, capacity> share_;   // [branch]
};

/// What all threads share: the compiled program and where its channels stand in the sample table. Immutable.
class LpeSetup {
  public:
    /// Compiles every expression channel of `channels` but `beauty`, the id that takes the whole of every contribution,
    /// or invalid_channel when beauty was not asked for. `rest_of` counts in `channels`.
    ///
    /// Errors: an expression that does not parse or is too large; more automaton groups than a tracker can follow; a
    /// channel of another type than rgb; prefixes that contradict each other.
    static Result<LpeSetup> build(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                  const lpe::CompileOptions& options = {});
    /// Has every contribution's words told apart by this alphabet and kept (path_words.h): for a path atlas. Events are
    /// classified by its columns from here on, so call it before any is. Errors: too large an automaton.
    Status keep_words(WordAlphabet alphabet);
    /// Null when no words are kept.
    [[nodiscard]] const std::shared_ptr<const WordAlphabet>& words() const { return alphabet_; }
    /// Whether moves mean anything to somebody: channels or an atlas.
    [[nodiscard]] bool reads_words() const { return program_.group_count() > 0 || alphabet_ != nullptr; }
    /// Not for the inner loop: ask once per (object label, lobe) and per light group.
    [[nodiscard]] lpe::EventClass classify(const lpe::Event& event) const {
        if (alphabet_ != nullptr) return column_of(event);
        return program_.group_count() == 0 ? lpe::EventClass{0} : program_.classify(event);
    }
    [[nodiscard]] const lpe::Program& program() const { return program_; }
    [[nodiscard]] ChannelId beauty() const { return beauty_; }
    /// A contribution with a larger component is as invalid as one that is not finite: a block of samples with it would
    /// leave the frame buffer's range, for beauty but not for every layer. 2^38 times what
    /// ChannelDefinition::scale_exponent of the channels says, far above the sun's 2e9 cd/m^2.
    [[nodiscard]] float largest_contribution() const { return largest_contribution_; }

    /// A channel whose prefixes need an integrator that fills in EmitterSample, or one that samples lights; or
    /// invalid_channel. An integrator that does not is to be refused before the render.
    [[nodiscard]] ChannelId needs_emitter_samples() const { return needs_emitter_samples_; }
    [[nodiscard]] ChannelId needs_light_samples() const { return needs_light_samples_; }
    /// Sets of the channels that `shares` [display channel] marks, for a SampleTable and a frame buffer of this block
    /// size.
    [[nodiscard]] SplatSets splat_sets(std::span<const std::uint8_t> shares, int block_size) const {
        return {program_.view(), channel_of_accept_, shares, block_size};
    }
    /// Whether some path may go on after an event of this class: false for user events that no expression names.
    [[nodiscard]] bool follows(lpe::EventClass event) const;

  private:
    friend class Liveness;
    friend class SuffixLiveness;
    friend class LpeServices;
    enum Takers : std::uint8_t { ordinary = 1, holdouts = 2 };  ///< channels by the paths that they take
    [[nodiscard]] lpe::EventClass column_of(const lpe::Event& event) const;
    Status read_channel_prefixes(std::span<const ChannelDefinition> channels);
    void find_liveness();
    [[nodiscard]] Takers taker(std::uint16_t channel) const {
        return prefixes_[channel].holdouts ? holdouts : ordinary;
    }
    lpe::Program program_;
    std::shared_ptr<const WordAlphabet> alphabet_;
    std::vector<lpe::State> first_states_;      // [word] after the camera event; empty when all are dead
    std::vector<ChannelId> channel_of_accept_;  // program channel -> display channel
    SplatTargets targets_;                      // each channel its own
    ChannelId beauty_ = invalid_channel;
    std::vector<ChannelPrefixes> prefixes_;  // [program channel]
    lpe::StateSets live_;                    // [table state] Takers that can still accept; empty without holdouts
    float largest_contribution_ = 0x1p38f;
    bool has_user_events_ = false;        // some expression may name one
    bool prefixed_ = false;               // some prefix changes what is splatted
    bool wants_emitter_samples_ = false;  // some prefix changes nothing but by what an EmitterSample says
    ChannelId needs_emitter_samples_ = invalid_channel, needs_light_samples_ = invalid_channel;
};

/// Per thread. All calls are inline-cheap when no expression channel exists.
class LpeServices {
  public:
    /// How lobes are attributed: `exact` is Law 5; `picked` labels each scattering by one lobe drawn in proportion to
    /// its part (per colour, by one random number, so that colours still sum), the common practice, kept to measure
    /// against.
    enum class Attribution : std::uint8_t { exact, picked };

    /// `setup` and `table` must outlive this object; a tracker lives within one batch of the table.
    LpeServices(const LpeSetup& setup, SampleTable& table, std::uint64_t seed,
                Attribution attribution = Attribution::exact);

    /// A tracker at the camera of `row`, the camera event read.
    [[nodiscard]] Tracker begin(int row) const;

    void move(Tracker& tracker, lpe::EventClass event) const;
    /// A scattering whose value is the sum of `parts`. Per colour the parts are normalised to sum to 1; a colour to
    /// which no part gives anything goes to the first. No parts: the path scatters nothing and every branch dies. At
    /// most 64.
    void move(Tracker& tracker, std::span<const LobePart> parts);

    // Light subpaths: path_suffix.h.
    /// A suffix of one event, its terminal. `pool` belongs to this object's setup.
    [[nodiscard]] PathSuffix begin(PathSuffixes& pool, lpe::EventClass terminal) const;
    /// `suffix` with one more event before it.
    [[nodiscard]] PathSuffix prepend(PathSuffixes& pool, const PathSuffix& suffix, lpe::EventClass event) const;
    /// `suffix` with a scattering before it, as for move(). `key` seeds the choice if there are too many branches.
    [[nodiscard]] PathSuffix prepend(PathSuffixes& pool, const PathSuffix& suffix, std::span<const LobePart> parts,
                                     std::uint64_t key);
    /// Moves the tracker along all events of `suffix`, its terminal included.
    void join(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix);

    /// Adds `value` (radiance times throughput, filter weight not applied) to beauty and to every channel whose
    /// expression accepts the path; the terminal event must have been moved along. Non-finite values, and those beyond
    /// LpeSetup::largest_contribution(), are rejected for beauty and splits alike, counted and logged in the table (Law
    /// 6).
    void contribute(const Rgb& value, Technique technique, const Tracker& tracker);
    /// The same with what channels with prefixes take. A light sample that is blocked has a black value and is reported
    /// all the same. A channel that takes another value than beauty is checked for that value too, and with
    /// `noinfinitecheck` for that value only.
    void contribute(const Rgb& value, Technique technique, const Tracker& tracker, const EmitterSample& sample);
    /// False when no channel looks at an EmitterSample: then the integrator need not make any, nor report blocked
    /// light.
    [[nodiscard]] bool wants_emitter_samples() const { return setup_.wants_emitter_samples_; }
    /// Whether what a tracker that stands after its terminal contributes depends on what is in the way. False: no
    /// shadow ray is needed (Law 4).
    [[nodiscard]] bool needs_visibility(const Tracker& tracker) const;
    /// Adds what a surface says of itself (its albedo, its normal) to the channels that accept the path; beauty never
    /// takes it. The user event and a light after it must have been moved along; `throughput` leads to the surface.
    void contribute_user(const Rgb& value, const Rgb& throughput, const Tracker& tracker);

    /// Declares the path's first hit, at which the tracker stands, a holdout: from here on beauty and ordinary channels
    /// take nothing of it, and channels with the prefix `holdouts` all.
    void hold_out(Tracker& tracker);

    /// Whether anything could still accept: false means that the path may end (Law 4).
    [[nodiscard]] bool live(const Tracker& tracker) const {
        if (takes_all(tracker)) return true;
        return setup_.live_.empty() ? tracker.count_ != 0 && !tracker.held_out_ : is_live(tracker);
    }
    /// The same, one event ahead: whether contributing after `event` could reach any channel.
    [[nodiscard]] bool live_after(const Tracker& tracker, lpe::EventClass event) const;
    /// Whether beauty was asked for, which takes whatever is not held out.
    [[nodiscard]] bool wants_beauty() const { return setup_.beauty_ >= 0; }
    /// Whether any channel still follows the path, beauty apart.
    [[nodiscard]] bool channels_follow(const Tracker& tracker) const { return tracker.count_ != 0; }
    /// Whether beauty takes everything that this path finds, so that nothing of it can be saved.
    [[nodiscard]] bool takes_all(const Tracker& tracker) const { return setup_.beauty_ >= 0 && !tracker.held_out_; }

    [[nodiscard]] std::uint64_t overflow_count() const {
        return overflow_count_;
    }  ///< moves that had to collapse branches
    [[nodiscard]] std::uint64_t invalid_count() const { return invalid_count_; }  ///< contributions rejected

  private:
    struct Report;
    struct SplitSuffix;
    void contribute_apart(const Report& report, const Tracker& tracker);
    void splat_apart(const Report& report, const Tracker& tracker, bool valid);
    [[nodiscard]] bool is_live(const Tracker& tracker) const;
    /// Whether a channel that takes such paths can still accept from these states. Needs setup_.live_.
    [[nodiscard]] bool is_live(const lpe::State* words, bool held_out) const {
        const LpeSetup::Takers taker = held_out ? LpeSetup::holdouts : LpeSetup::ordinary;
        const std::uint32_t tables = setup_.program_.view().table_count;
        return std::any_of(words, words + tables, [&](lpe::State state) { return (setup_.live_[state] & taker) != 0; });
    }
    // What channels need of moves and joins, and what an atlas needs of the same.
    void move_states(Tracker& tracker, lpe::EventClass event) const;
    void move_states(Tracker& tracker, std::span<const LobePart> parts);
    void join_states(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix);
    [[nodiscard]] PathSuffix begin_states(PathSuffixes& pool, lpe::EventClass terminal) const;
    [[nodiscard]] PathSuffix prepend_states(PathSuffixes& pool, const PathSuffix& suffix, lpe::EventClass event) const;
    [[nodiscard]] PathSuffix prepend_states(PathSuffixes& pool, const PathSuffix& suffix,
                                            std::span<const LobePart> parts, std::uint64_t key);
    void keep_move(Tracker& tracker, std::span<const LobePart> parts) const;
    void keep_move(Tracker& tracker, lpe::EventClass event) const;
    void keep_light(const Rgb& value, Technique technique, const Tracker& tracker) const;
    void split(Tracker& tracker, std::span<const LobePart> parts);
    void reject(const Rgb& value, const Tracker& tracker);
    void splat_apart(std::span<const ChannelId> channels, const RgbD& value, int row);
    SplitSuffix prepend_split(PathSuffixes& pool, const PathSuffix& suffix, std::span<const LobePart> parts,
                              std::uint64_t key) const;
    [[nodiscard]] static Branches branches_of(const Tracker& tracker);
    [[nodiscard]] static std::size_t branch_limit(const Tracker& tracker);
    void take(Tracker& tracker, const BranchList& branches);
    [[nodiscard]] std::uint64_t random_key(const Tracker& tracker, const LobePart& first) const;

    const LpeSetup& setup_;
    SampleTable& table_;
    const SplatTargets& targets_;  // of the table
    std::uint64_t seed_ = 0;
    Attribution attribution_ = Attribution::exact;
    std::uint64_t overflow_count_ = 0, invalid_count_ = 0;
    PathWords* path_words_;  // of the table; null unless an atlas keeps words
    bool apart_;             // prefixes or holdouts: contributions take the long way
    static constexpr RgbD unused{-1.0};
    std::vector<RgbD> shares_;            // [program channel] of one contribution, for own_value() channels
    std::vector<std::uint16_t> sharing_;  // the channels whose shares_ are in use
};

}  // namespace raylex::display

#include "display/services/samples/lpe_services_inl.h"
