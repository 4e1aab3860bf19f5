// What channels may still take of a light subpath, told from its word and from the events that a scene can bring (Law
// 4): Foresight from the far end. A light subpath that grows by a scattering and a camera subpath that comes to it by
// one read the same words, so one table answers for both.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "display/services/foresight/foresight.h"
#include "display/services/foresight/light_words.h"

namespace raylex::display {

class LightForesight {
  public:
    /// Of a word.
    struct Ahead {
        bool seen = true;   ///< can count where the camera sees its last vertex, cutouts in between
        bool joins = true;  ///< can where that is joined with a vertex of a camera subpath
        /// Can with scatterings before it that are the light subpath's own, at one of which it is seen or joined. That
        /// needs a density there, and of joins at the neighbour too.
        bool goes_on = true;
        [[nodiscard]] bool anything() const { return seen || joins || goes_on; }
    };

    /// Knows nothing: everything may still come.
    LightForesight() = default;
    /// `language` reads the words of `setup`; both must outlive this object. Knows nothing where there is none, or
    /// where channels are packed into lanes (lpe/program_view.h).
    LightForesight(const LpeSetup& setup, const lpe::ReversedProgram* language, const Foresight::Alphabet& alphabet);

    /// Of a light's word.
    [[nodiscard]] Ahead of(lpe::EventClass terminal) const;
    [[nodiscard]] Ahead of(const LightWords& words, const LightWord& word) const;
    /// The same once an event of any of these classes stands before it. The first `with_density` of them have one: only
    /// those are seen or joined.
    [[nodiscard]] Ahead after(const LightWords& words, const LightWord& word,
                              std::span<const lpe::EventClass> scatterings, std::size_t with_density) const;
    /// Whether a channel may accept `camera`, one of `here`, one of `there`, `word`.
    [[nodiscard]] bool joins(const Tracker& camera, std::span<const lpe::EventClass> here, const LightWords& words,
                             const LightWord& word, std::span<const lpe::EventClass> there) const;

  private:
    struct Maker;
    [[nodiscard]] Ahead before(std::span<const lpe::State> state, lpe::EventClass event) const;
    static void unite(Ahead& ahead, const Ahead& other) {
        ahead.seen |= other.seen;
        ahead.joins |= other.joins;
        ahead.goes_on |= other.goes_on;
    }

    const lpe::ProgramView* program_ = nullptr;
    const lpe::ReversedProgram* language_ = nullptr;
    std::vector<std::vector<Ahead>> states_;  // [word of state][reversed state]; empty: nothing is known
    bool cutouts_ = false;
};

}  // namespace raylex::display
