// Path suffixes: the path strings of light subpaths, with shares (Law 5 from the light end).
//
// A light subpath has only the end of its path string. It carries pairs (state of the reversed automaton, share), as
// a tracker carries pairs (state, share): each vertex prepends its event, a scattering by several lobes splits the
// shares by what each lobe scattered, equal states merge, and dead ones are dropped. A connection to a tracker takes
// one look-up for each pair of pairs, whatever the lengths. Shares multiply, so those of one contribution still sum
// to 1.
//
// A program may be too large to be reversed (lpe/reversal.h has the bound). Then suffixes keep their events, and a
// connection moves the tracker along them one by one.
//
// Suffixes are small handles into a pool, so that all vertices of a batch keep theirs:
//
//     pool.clear();                                               // once a batch
//     PathSuffix suffix = lpe.begin(pool, terminal);              // at the light
//     suffix = lpe.prepend(pool, suffix, parts, key);             // at each vertex that scatters
//     lpe.move(tracker, parts);  lpe.connect(tracker, pool, suffix); // the camera side, past the joined vertex
//     lpe.contribute(value, technique, tracker);
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "display/services/samples/lpe_services.h"
#include "lpe/reversal.h"

namespace raylex::display {

/// Opaque. Valid until its pool is cleared.
class PathSuffix {
  public:
    /// False: no channel takes anything from the light subpath, whatever events are prepended.
    [[nodiscard]] bool live() const { return branches_ != 0; }
    /// Pairs of (reversed state, share); for diagnostics.
    [[nodiscard]] int branches() const { return branches_; }

  private:
    friend class SuffixLiveness;
    friend class PathSuffixes;
    friend class LpeServices;
    std::uint32_t state_ = 0, share_ = 0;  // where they begin in the pool; state_ may be an event
    std::uint32_t path_ = 0;               // where its events begin for a path atlas, plus one
    std::uint16_t length_ = 1;             // number of events; it differs between the suffixes of one light subpath
    std::uint8_t branches_ = 0;
    bool whole_ = true;         // not split yet: one branch at most, its share 1 and not stored
    std::uint32_t layers_ = 0;  // the suffix of channels beside a class, in PathSuffixes::layers_
};

/// The suffixes of one thread. It keeps its memory from batch to batch.
class PathSuffixes {
  public:
    static constexpr std::size_t capacity = Tracker::capacity;  ///< branches of a suffix
    /// `reversed` reverses the LpeSetup's program and must outlive this object; null: suffixes keep their events.
    /// `keeps_paths`: a path atlas needs the events as well.
    explicit PathSuffixes(const lpe::ReversedProgram* reversed, bool keeps_paths = false)
        : reversed_(reversed), keeps_paths_(keeps_paths) {}
    /// Where the beauty is a class, `reversed` above reverses LpeSetup::main(), and this is the whole program,
    /// reversed, or null: the suffixes of the other channels.
    void add_layers(const lpe::ReversedProgram* reversed) { layers_ = std::make_unique<PathSuffixes>(reversed); }
    void clear() {
        states_.clear(), shares_.clear(), events_.clear(), parts_.clear(), suffixes_.clear();
        if (layers_) layers_->clear();
    }

  private:
    friend class SuffixLiveness;
    friend class LpeServices;
    [[nodiscard]] const lpe::State* states(const PathSuffix& suffix) const { return states_.data() + suffix.state_; }
    [[nodiscard]] const BranchShare* shares(const PathSuffix& suffix) const {
        return suffix.whole_ ? nullptr : shares_.data() + suffix.share_;
    }

    [[nodiscard]] Branches branches_of(const PathSuffix& suffix) const {
        return {states(suffix), shares(suffix), suffix.branches_, reversed_ == nullptr ? 0 : reversed_->word_count()};
    }

    [[nodiscard]] std::uint32_t add(const PathSuffix& suffix) {
        suffixes_.push_back(suffix);
        return static_cast<std::uint32_t>(suffixes_.size() - 1);
    }
    [[nodiscard]] PathSuffix layers_of(const PathSuffix& suffix) const { return layers_->suffixes_[suffix.layers_]; }

    struct Event {
        std::uint32_t next;          // towards the light: in events_; its own place for the terminal
        std::uint32_t first, count;  // in parts_
    };
    /// A suffix that consists of this event and the events of `next`. If `next` is null, the event is a terminal.
    [[nodiscard]] PathSuffix keep(std::span<const LobePart> parts, const PathSuffix* next);
    /// The value of `path_` for a suffix that keep() makes. It is 0, for no path, if that of `next` is 0.
    [[nodiscard]] std::uint32_t keep_path(std::span<const LobePart> parts, const PathSuffix* next);

    const lpe::ReversedProgram* reversed_;
    bool keeps_paths_ = false;
    std::unique_ptr<PathSuffixes> layers_;
    std::vector<PathSuffix> suffixes_;  // of channels beside a class
    std::vector<lpe::State> states_;
    std::vector<BranchShare> shares_;
    std::vector<Event> events_;
    std::vector<LobePart> parts_;
};

struct LpeServices::SplitSuffix {
    PathSuffix suffix;
    bool overflow = false;
};

}  // namespace raylex::display
