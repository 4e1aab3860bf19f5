// The words of a batch's contributions, for a path atlas: the third thing that the LPE services keep, beside beauty and
// channels.
//
// A tracker carries, beside its pairs of (automaton state, share), a handle to the events it was moved along. Nothing
// is made of them before light arrives: then the words of every prefix are worked out once, each a pair (word, share)
// by Law 5, with no bound on their number but that of the words the path can mean. Shares of one contribution sum to 1,
// so its words sum to what beauty takes.
//
// One thread's, kept by its SampleTable and emptied with it. Nothing is allocated per sample but by growing.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "display/services/samples/lpe_services.h"
#include "display/services/samples/word_alphabet.h"

namespace raylex::display {

class Fractions;

class PathWords {
  public:
    /// Of a path: where it is in the pool of events. 0: at the camera.
    using Path = std::uint32_t;

    /// Light of one word in one row, the filter weight not applied.
    struct Entry {
        std::uint32_t row = 0;
        std::uint32_t word = 0;  ///< in words()
        double r = 0, g = 0, b = 0;
    };

    /// `alphabet` must outlive this object.
    explicit PathWords(const WordAlphabet& alphabet);

    /// Forgets paths and light, and no word.
    void clear();
    /// The path of one event more.
    [[nodiscard]] Path move(Path from, lpe::EventClass event);
    /// The same of a scattering by several lobes; no parts: a path that brings nothing.
    [[nodiscard]] Path move(Path from, std::span<const LobePart> parts);
    /// Light that `path`, which ends in its terminal, brings to a row.
    void add(int row, Path path, const Rgb& value, Technique technique);

    /// In the order of contributions.
    [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
    [[nodiscard]] const WordTree& words() const { return words_; }
    /// [column] whether some word had light through this event.
    [[nodiscard]] std::span<const std::uint8_t> seen() const { return seen_; }
    /// Whether words were told of without the cutouts that their light passed.
    [[nodiscard]] bool dropped_straight() const { return dropped_straight_; }
    /// [word] what an atlas calls it; the atlas fills it in.
    std::vector<std::uint32_t> known_as;
    /// Of the atlas, when it did.
    std::uint64_t atlas_generation = 0;
    /// Whether seen() or dropped_straight() changed since the last call.
    [[nodiscard]] bool take_news() { return std::exchange(news_, false); }

  private:
    struct Node {
        Path before = 0;
        std::uint32_t first = 0;  ///< in parts_; the event itself where there is one part
        std::uint32_t parts = 0;
        std::uint32_t pairs = not_known;
        std::uint32_t first_word = 0;   ///< in path_words_
        std::uint32_t first_share = 0;  ///< in shares_; of the node before where one event left shares as they were
    };
    static constexpr std::uint32_t not_known = ~std::uint32_t{0};
    /// What longer() said last of words and events that share this place: most paths repeat what others did.
    struct Step {
        std::uint32_t word = not_known;
        lpe::EventClass event = 0;
        std::uint32_t next = 0;
    };
    static constexpr int step_bits = 12;
    void find_pairs(Path path);
    void find_pairs_of(Path path);
    [[nodiscard]] std::uint32_t after(std::uint32_t word, lpe::EventClass event) {
        Step& step = steps_[(word * 0x9e3779b1u + event * 0x85ebca6bu) >> (32 - step_bits)];
        if (step.word != word || step.event != event) step = {word, event, longer(word, event)};
        return step.next;
    }
    [[nodiscard]] std::uint32_t longer(std::uint32_t word, lpe::EventClass event);
    void split(std::uint32_t word, const RgbD& share, std::span<const LobePart> parts, const Fractions& fractions);

    const WordAlphabet& alphabet_;
    WordTree words_;
    std::vector<Node> nodes_;
    std::vector<LobePart> parts_;
    std::vector<std::uint32_t> path_words_;  // side by side, for they are looked at more often than shares
    std::vector<RgbD> shares_;
    std::vector<Step> steps_;
    std::vector<Entry> entries_;
    std::vector<Path> open_paths_;
    std::vector<std::uint32_t> split_words_;
    std::vector<std::uint8_t> seen_;
    bool dropped_straight_ = false, news_ = false;
};

}  // namespace raylex::display
