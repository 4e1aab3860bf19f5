// The LPE services follow light paths for the integrator and splat every contribution to each display channel whose
// expression accepts the path. An integrator moves a tracker and reports contributions without regard to the channels,
// so a new AOV never changes an integrator.
//
// Attribution (Law 5). A tracker has branches (automaton state, share). If a direction was sampled from a mixture of
// lobes, each lobe's part of the scattering value follows its own transition. So a contribution reaches each channel
// with exactly the fraction that its lobes carried, and the fractions of a contribution sum to 1 in every colour. Equal
// states merge, and dead ones are dropped. Beauty takes the full value and never depends on the states (Law 2).
//
// Groups. If the compiler distributes the channels over several automata, or packs some of them into bits, the state of
// a branch is a few words (lpe/program_view.h). A share belongs to a set of paths and not to an automaton, so a
// partition with channels in different groups still sums exactly when a tracker overflows (Law 1).
//
// Classes. A beauty of one class of paths (CompileOptions::first_alone) has branches of its own in a tracker, which no
// other channel splits, merges or drops: so its value and its liveness do not depend on the channels (Law 2). A second
// list of branches is for the channels. Each of its states begins with that of the class, and its shares with one state
// of the class sum to the share that the class has there, also after an overflow (Law 1).
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
#include "lpe/automata/liveness_table.h"
#include "lpe/program.h"

namespace raylex::display {

/// An emitter before the path's throughput: channels with prefixes splat these values instead of beauty's
/// (channel_prefixes.h). An integrator fills it in only if LpeServices::wants_emitter_samples().
struct EmitterSample {
    Rgb emitted;     ///< what the emitter sends towards the path: radiance; intensity of point and spot lights;
                     ///< irradiance across the beam of distant lights. Without throughput, density and geometry.
    Rgb unweighted;  ///< unoccluded radiance times throughput over density, with an MIS weight of 1 for the technique
                     ///< that found it
    float visibility = 1;      ///< transmitted fraction: 0 behind an opaque surface
    bool sampled_too = false;  ///< light sampling finds this emitter here, too, but another technique found it:
                               ///< channels of unoccluded light leave it to the light sample
};

/// One lobe's part of a scattering value f(wo, wi) |cos|, in any common scale, because only ratios within one move
/// matter.
struct LobePart {
    lpe::EventClass event = 0;
    Rgb value;
};

/// The part of a contribution that a branch carries, per colour.
struct BranchShare {
    double r, g, b;
    [[nodiscard]] RgbD rgb() const { return {r, g, b}; }
};

/// Branches in one automaton, in place. `share` null: at most one branch, with share 1.
struct Branches {
    const lpe::State* state = nullptr;
    const BranchShare* share = nullptr;
    std::size_t count = 0;
    std::size_t words = 0;  ///< words of a state

    [[nodiscard]] const lpe::State* state_of(std::size_t branch) const { return state + branch * words; }
    [[nodiscard]] RgbD share_of(std::size_t branch) const { return share == nullptr ? RgbD(1.0) : share[branch].rgb(); }
    /// Whether a branch has this state, of one word.
    [[nodiscard]] bool has_state(lpe::State one) const { return std::find(state, state + count, one) != state + count; }
};

class BranchList;
class Fractions;
class PathSuffix;
class PathSuffixes;
class BatchPathStrings;
class PathAlphabet;

/// Opaque, with fixed capacity and without heap memory. To look one event ahead (a light sample), copy it and drop the
/// copy. Copying costs only the used part: almost nothing without expression channels, one state for a path that was
/// never split.
class Tracker {
  public:
    static constexpr int capacity = 24;  ///< branches, with up to five words of state each; with more words state_room
                                         ///< / words
    static constexpr int state_room = 128;
    static constexpr int group_limit = 32;  ///< words of state (automaton groups, packed channels); leaves room for 4
                                            ///< branches
    // Where the beauty is a class: its branches, of one word each, come before those of the other channels. An overflow
    // leaves at most three of these for each branch of the class, one for each colour.
    static constexpr int class_capacity = 6, layer_capacity = 3 * class_capacity, layer_group_limit = 6;

    Tracker() noexcept = default;
    Tracker(const Tracker& other) noexcept { copy(other); }
    Tracker& operator=(const Tracker& other) noexcept {
        if (this != &other) copy(other);
        return *this;
    }

    /// The number of pairs (automaton state, share) at the moment; for diagnostics.
    [[nodiscard]] int branches() const noexcept { return count_; }

  private:
    friend class LpeServices;
    friend class Liveness;
    friend class SuffixLiveness;
    /// Branches in one automaton, in place, to be moved. With `whole` shares are not stored.
    struct List {
        lpe::State* state;
        BranchShare* share;
        std::uint8_t& count;
        bool whole;
        std::size_t words;
    };
    [[nodiscard]] List main() { return {state_.data(), share_.data(), count_, whole_, groups_}; }
    [[nodiscard]] List layers() {
        return {state_.data() + class_capacity, share_.data() + class_capacity, layer_count_, false, layer_groups_};
    }
    [[nodiscard]] Branches branches_of_main() const {
        return {state_.data(), whole_ ? nullptr : share_.data(), count_, groups_};
    }
    [[nodiscard]] Branches branches_of_layers() const {
        return {state_.data() + class_capacity, share_.data() + class_capacity, layer_count_, layer_groups_};
    }
    void divide();  ///< from a whole path to two lists
    void unite();   ///< back, if nothing is split
    void copy(const Tracker& other) noexcept;
    void copy_layers(const Tracker& other) noexcept;
    std::int32_t row_ = 0;
    std::uint32_t path_ = 0;   // path in the batch's BatchPathStrings, if an atlas keeps words
    std::uint16_t moves_ = 0;  // number of moves; with the pixel and sample of row_ it seeds the
                               // random numbers at overflows
    std::uint8_t count_ = 0;   // branches
    std::uint8_t groups_ = 0;  // words of state per branch
    bool whole_ = true;        // never split: at most one branch, whose share of 1 is not stored
    bool held_out_ = false;    // the path's first hit is a holdout
    // Branches of channels beside a class, and words of their states, once the path is split. A whole path needs only
    // one list, because its state begins with that of the class.
    std::uint8_t layer_count_ = 0, layer_groups_ = 0;
    std::array<lpe::State, state_room> state_;  // [branch][group]; uninitialised
    std::array<BranchShare, capacity> share_;   // [branch]
};

/// The data that all threads share: the compiled program, and the positions of its channels in the sample table.
/// Immutable.
class LpeSetup {
  public:
    /// Compiles every expression channel of `channels` except `beauty`, the id that takes every contribution in full,
    /// or invalid_channel if beauty is not requested. `rest_of` contains indices of `channels`.
    ///
    /// With `options.first_alone` the first expression channel is the beauty of a class of paths, and no other channel
    /// may accept a path outside of it. The class alone decides what is live and what beauty takes.
    ///
    /// Errors: an expression that does not parse or is too large; more automaton groups than a tracker can follow; a
    /// channel of another type than rgb; prefixes that contradict each other.
    static Result<LpeSetup> build(std::span<const ChannelDefinition> channels, ChannelId beauty,
                                  const lpe::CompileOptions& options = {});
    /// Makes the services keep the path string of every contribution in this alphabet (batch_path_strings.h), for a
    /// path atlas. Events are then classified by the columns of the alphabet, so call it before classifying any.
    /// Errors: too large an automaton.
    Status keep_path_strings(PathAlphabet alphabet);
    /// Null if path strings are not kept.
    [[nodiscard]] const std::shared_ptr<const PathAlphabet>& words() const { return alphabet_; }
    /// Returns whether moves matter, because there are channels or an atlas.
    [[nodiscard]] bool reads_path_strings() const { return program_.group_count() > 0 || alphabet_ != nullptr; }
    /// The class of an event. Call it once per (object label, lobe) and per light group, not in the inner loop.
    [[nodiscard]] lpe::EventClass classify(const lpe::Event& event) const {
        if (alphabet_ != nullptr) return column_of(event);
        return program_.group_count() == 0 ? lpe::EventClass{0} : program_.classify(event);
    }
    [[nodiscard]] const lpe::Program& program() const { return program_; }
    /// The automata that decide what is live: those of all channels, or that of the class alone.
    [[nodiscard]] const lpe::ProgramView& main() const { return main_; }
    /// Whether the beauty is a class, and whether other channels are followed beside it.
    [[nodiscard]] bool is_of_class() const { return of_class_; }
    [[nodiscard]] bool has_layers() const { return main_.word_count < program_.word_count(); }
    [[nodiscard]] ChannelId beauty() const { return beauty_; }
    /// The largest valid component of a contribution. A block of samples with a larger one would leave the frame
    /// buffer's range, for beauty but not for every layer, so such a contribution is as invalid as one that is not
    /// finite. It is 2^38 times the scale of the channels (ChannelDefinition::scale_exponent), far above the sun's 2e9
    /// cd/m^2.
    [[nodiscard]] float largest_contribution() const { return largest_contribution_; }

    /// A channel whose prefixes need an integrator that fills in EmitterSample, or one that samples lights; or
    /// invalid_channel. Callers refuse other integrators before the render.
    [[nodiscard]] ChannelId needs_emitter_samples() const { return needs_emitter_samples_; }
    [[nodiscard]] ChannelId needs_light_samples() const { return needs_light_samples_; }
    /// The sets of the channels that `shares` [display channel] marks, for a SampleTable and a frame buffer of this
    /// block size.
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
    void find_main();
    [[nodiscard]] Takers taker(std::uint16_t channel) const {
        return prefixes_[channel].holdouts ? holdouts : ordinary;
    }
    lpe::Program program_;
    lpe::ProgramView main_;  // points into program_
    bool of_class_ = false;
    std::shared_ptr<const PathAlphabet> alphabet_;
    std::vector<lpe::State> first_states_;      // [word] after the camera event; empty when all are dead
    std::vector<ChannelId> channel_of_accept_;  // program channel -> display channel
    SplatTargets targets_;                      // each channel separately
    ChannelId beauty_ = invalid_channel;
    std::vector<ChannelPrefixes> prefixes_;  // [program channel]
    lpe::StateSets live_;                    // [table state] Takers that can still accept; empty without holdouts
    float largest_contribution_ = 0x1p38f;
    bool has_user_events_ = false;        // some expression can name one
    bool prefixed_ = false;               // some prefix changes what is splatted
    bool wants_emitter_samples_ = false;  // some prefix changes values that only an EmitterSample contains
    ChannelId needs_emitter_samples_ = invalid_channel, needs_light_samples_ = invalid_channel;
};

/// The services of one thread. All calls are inline and cheap if there are no expression channels.
class LpeServices {
  public:
    /// How lobes are attributed. `exact` is Law 5. `picked`, the common practice, labels each scattering by one lobe,
    /// drawn in proportion to its part (per colour, with one random number, so that colours still sum); it exists for
    /// comparison.
    enum class Attribution : std::uint8_t { exact, picked };

    /// `setup` and `table` must outlive this object; a tracker is valid within one batch of the table.
    LpeServices(const LpeSetup& setup, SampleTable& table, std::uint64_t seed,
                Attribution attribution = Attribution::exact);

    /// A tracker at the camera of `row`, after the camera event.
    [[nodiscard]] Tracker begin(int row) const;

    void move(Tracker& tracker, lpe::EventClass event) const;
    /// A scattering whose value is the sum of `parts`, at most 64. Per colour the parts are normalised to a sum of 1; a
    /// colour without any value goes to the first part. Without parts the path scatters nothing and every branch dies.
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
    void connect(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix);

    /// Adds `value` (radiance times throughput, without the filter weight) to beauty and to every channel whose
    /// expression accepts the path. The tracker must have passed the terminal event. Values that are not finite, or
    /// above LpeSetup::largest_contribution(), are rejected for beauty and splits alike, counted and logged in the
    /// table (Law 6).
    void contribute(const Rgb& value, Technique technique, const Tracker& tracker);
    /// Adds a contribution with the EmitterSample that channels with prefixes need. A blocked light sample has a black
    /// value, and is reported, too. If a channel takes a value other than beauty's, that value is checked, too; with
    /// `noinfinitecheck` only that value is checked.
    void contribute(const Rgb& value, Technique technique, const Tracker& tracker, const EmitterSample& sample);
    /// False if no channel uses an EmitterSample; then the integrator need not compute any, nor report blocked light.
    [[nodiscard]] bool wants_emitter_samples() const { return setup_.wants_emitter_samples_; }
    /// Whether the beauty is a class of paths.
    [[nodiscard]] bool is_of_class() const { return setup_.of_class_; }
    /// For a tracker that has moved along its terminal: whether its contribution depends on what is in the way. False:
    /// no shadow ray is needed (Law 4).
    [[nodiscard]] bool needs_visibility(const Tracker& tracker) const;
    /// Adds a surface's own value (its albedo, its normal) to the channels that accept the path; beauty never takes it.
    /// The tracker must have passed the user event and a light after it; `throughput` is that of the path to the
    /// surface.
    void contribute_user(const Rgb& value, const Rgb& throughput, const Tracker& tracker);

    /// Declares the path's first hit, where the tracker is, a holdout: from then on beauty and ordinary channels take
    /// nothing of the path, and channels with the prefix `holdouts` take everything.
    void hold_out(Tracker& tracker);

    /// Whether anything could still accept: false means that the path may end (Law 4).
    [[nodiscard]] bool live(const Tracker& tracker) const {
        if (takes_all(tracker)) return true;
        return setup_.live_.empty() ? tracker.count_ != 0 && !tracker.held_out_ : is_live(tracker);
    }
    /// Whether anything could still accept the path after it moves along `event`, at once or after further events.
    [[nodiscard]] bool live_after(const Tracker& tracker, lpe::EventClass event) const;
    /// Returns whether beauty is requested; it takes everything that is not held out.
    [[nodiscard]] bool wants_beauty() const { return setup_.beauty_ >= 0; }
    /// Whether any channel other than beauty still follows the path.
    [[nodiscard]] bool channels_follow(const Tracker& tracker) const { return tracker.count_ != 0; }
    [[nodiscard]] bool is_held_out(const Tracker& tracker) const { return tracker.held_out_; }
    /// Whether beauty takes everything that this path finds, so that nothing of it can be saved.
    [[nodiscard]] bool takes_all(const Tracker& tracker) const { return setup_.beauty_ >= 0 && !tracker.held_out_; }

    [[nodiscard]] std::uint64_t overflow_count() const {
        return overflow_count_;
    }  ///< moves that had to collapse branches
    [[nodiscard]] std::uint64_t invalid_count() const { return invalid_count_; }  ///< contributions rejected

  private:
    struct Report;
    struct SplitSuffix;
    void contribute_slow_path(const Report& report, const Tracker& tracker);
    void splat_slow_path(const Report& report, const Tracker& tracker, bool valid);
    [[nodiscard]] bool is_live(const Tracker& tracker) const;
    /// Whether a channel that takes such paths can still accept from these states. Needs setup_.live_.
    [[nodiscard]] bool is_live(const lpe::ProgramView& program, const lpe::State* words, bool held_out) const {
        const LpeSetup::Takers taker = held_out ? LpeSetup::holdouts : LpeSetup::ordinary;
        const std::uint32_t tables = program.table_count;
        return std::any_of(words, words + tables, [&](lpe::State state) { return (setup_.live_[state] & taker) != 0; });
    }
    /// Calls visit(channel, share) for every branch and each program channel that accepts there.
    template <class Visit>
    void for_each_accepted(const Tracker& tracker, Visit visit) const;
    // The parts of moves and connections for channels, and those for an atlas.
    static void move_list(const lpe::ProgramView& program, Tracker::List list, lpe::EventClass event);
    void move_split(Tracker& tracker, lpe::EventClass event) const;
    void split_layers(Tracker& tracker, std::span<const LobePart> parts, const Fractions& fractions,
                      const Branches& of_class);
    void move_along(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix);
    void connect_main(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix);
    void connect_divided(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix);
    void connect_layers(const Tracker& camera, const PathSuffixes& pool, const PathSuffix& suffix, Tracker& connected);
    void splat_branch(const lpe::ProgramView& program, const lpe::State* states, std::uint32_t first_table,
                      const SampleTable::Light& part, int row);
    void move_states(Tracker& tracker, lpe::EventClass event) const;
    void move_states(Tracker& tracker, std::span<const LobePart> parts);
    void connect_states(Tracker& tracker, const PathSuffixes& pool, const PathSuffix& suffix);
    [[nodiscard]] PathSuffix begin_states(PathSuffixes& pool, lpe::EventClass terminal) const;
    // `of_class`: null for the automata of main(); else the branches of the class after the event.
    [[nodiscard]] PathSuffix prepend_states(PathSuffixes& pool, const PathSuffix& suffix, lpe::EventClass event,
                                            const Branches* of_class = nullptr) const;
    [[nodiscard]] PathSuffix prepend_states(PathSuffixes& pool, const PathSuffix& suffix,
                                            std::span<const LobePart> parts, std::uint64_t key,
                                            const Branches* of_class = nullptr);
    void keep_move(Tracker& tracker, std::span<const LobePart> parts) const;
    void keep_move(Tracker& tracker, lpe::EventClass event) const;
    void keep_light(const Rgb& value, Technique technique, const Tracker& tracker) const;
    void split(Tracker& tracker, std::span<const LobePart> parts);
    void reject(const Rgb& value, const Tracker& tracker);
    void splat_slow_path(std::span<const ChannelId> channels, const RgbD& value, int row);
    SplitSuffix prepend_split(PathSuffixes& pool, const PathSuffix& suffix, std::span<const LobePart> parts,
                              std::uint64_t key, const Branches* of_class) const;
    [[nodiscard]] std::size_t branch_limit(const Tracker& tracker) const;
    void take(Tracker& tracker, const BranchList& branches);
    void put(Tracker::List list, const BranchList& branches);
    [[nodiscard]] std::uint64_t random_key(const Tracker& tracker, const LobePart& first) const;

    const LpeSetup& setup_;
    SampleTable& table_;
    const SplatTargets& targets_;  // of the table
    std::uint64_t seed_ = 0;
    Attribution attribution_ = Attribution::exact;
    std::uint64_t overflow_count_ = 0, invalid_count_ = 0;
    BatchPathStrings* path_strings_;  // of the table; null unless an atlas keeps words
    bool slow_path_;                  // prefixes or holdouts: contributions use the slow path
    static constexpr RgbD unused{-1.0};
    std::vector<RgbD> shares_;            // [program channel] of one contribution, for channels with own_value()
    std::vector<std::uint16_t> sharing_;  // channels whose shares_ are in use
};

}  // namespace raylex::display

#include "display/services/samples/lpe_services_inl.h"
