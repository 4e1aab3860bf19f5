// Light subpaths in the language, with shares: Law 5 from the far end.
//
// A light subpath's word is known from its end. It carries pairs (state of the reversed automaton, share) as a tracker
// carries forward ones: each vertex puts its event before all that were read, a scattering by several lobes splits the
// shares by what each lobe scattered, equal states merge, dead ones drop out. A join with a tracker then is one look-up
// for each pair of pairs, whatever the lengths, and shares multiply: those of one contribution still sum to 1.
//
// A program may be too large to be reversed (lpe/reversal.h has the bound). Then words keep their events, and a join
// moves the tracker along them one by one.
//
// Words are small handles into a pool, so that all vertices of a batch keep theirs:
//
//     words.clear();                                              // once a batch
//     LightWord word = lpe.begin(words, terminal);                // at the light
//     word = lpe.prepend(words, word, parts, key);                // at each vertex that scatters
//     lpe.move(tracker, parts);  lpe.join(tracker, words, word);  // the camera's side, past the vertex that is joined
//     lpe.contribute(value, technique, tracker);
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "display/services/samples/lpe_services.h"
#include "lpe/reversal.h"

namespace raylex::display {

/// Opaque: good until its pool is cleared.
class LightWord {
  public:
    /// False: no channel makes anything of the light subpath, whatever comes before.
    [[nodiscard]] bool live() const { return branches_ != 0; }
    /// Pairs of (reversed state, share); for diagnostics.
    [[nodiscard]] int branches() const { return branches_; }

  private:
    friend class LightForesight;
    friend class LightWords;
    friend class LpeServices;
    std::uint32_t state_ = 0, share_ = 0;  // where they begin in the pool; state_ may be that of an event
    std::uint32_t path_ = 0;               // where its events begin, one by one, for a path atlas; one past the place
    std::uint16_t length_ = 1;             // number of events; it differs between the words of one light subpath
    std::uint8_t branches_ = 0;
    bool whole_ = true;  // nothing was split yet: one branch at most, its share 1 and not stored
};

/// One thread's words. Keeps its memory from batch to batch.
class LightWords {
  public:
    static constexpr std::size_t capacity = Tracker::capacity;  ///< branches of a word
    /// `language` reads the words of the LpeSetup's program, and must outlive this object; null: words keep events.
    /// `keeps_paths`: for a path atlas, events as well.
    explicit LightWords(const lpe::ReversedProgram* language, bool keeps_paths = false)
        : language_(language), keeps_paths_(keeps_paths) {}
    void clear() { states_.clear(), shares_.clear(), events_.clear(), parts_.clear(); }

  private:
    friend class LightForesight;
    friend class LpeServices;
    [[nodiscard]] const lpe::State* states(const LightWord& word) const { return states_.data() + word.state_; }
    [[nodiscard]] const BranchShare* shares(const LightWord& word) const {
        return word.whole_ ? nullptr : shares_.data() + word.share_;
    }

    struct Event {
        std::uint32_t next;          // towards the light: in events_; its own place for the terminal
        std::uint32_t first, count;  // in parts_
    };
    /// A word that begins with this event and goes on with the one at `next`; none: the event is a terminal.
    [[nodiscard]] LightWord keep(std::span<const LobePart> parts, const LightWord* next);
    /// The same in `path_` alone: 0, no path, goes on as none.
    [[nodiscard]] std::uint32_t keep_path(std::span<const LobePart> parts, const LightWord* next);

    const lpe::ReversedProgram* language_;
    bool keeps_paths_ = false;
    std::vector<lpe::State> states_;
    std::vector<BranchShare> shares_;
    std::vector<Event> events_;
    std::vector<LobePart> parts_;
};

struct LpeServices::SplitWord {
    LightWord word;
    bool overflow = false;
};

}  // namespace raylex::display
