// The path strings of a batch's contributions, for a path atlas: the third output of the LPE services, after beauty and
// channels.
//
// In addition to its pairs (automaton state, share), a tracker has a handle to the events along which it was moved.
// They are processed only when light arrives. Then the path strings of every prefix are computed once, as pairs (path
// string, share) by Law 5. Their number is limited only by the number of path strings that the path can have. Shares of
// one contribution sum to 1, so its path strings sum to the value that beauty takes.
//
// Each SampleTable owns one object, for one thread, and clears it with itself. It allocates only when it grows.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "display/services/samples/lpe_services.h"
#include "display/services/samples/path_alphabet.h"

namespace raylex::display {

class Fractions;

class BatchPathStrings {
  public:
    /// The handle of a path: its index in the pool of events. 0: at the camera.
    using Path = std::uint32_t;

    /// The light of one path string in one row, without the filter weight.
    struct Entry {
        std::uint32_t row = 0;
        std::uint32_t word = 0;  ///< index in words()
        double r = 0, g = 0, b = 0;
    };

    /// `alphabet` must outlive this object.
    explicit BatchPathStrings(const PathAlphabet& alphabet);

    /// Clears paths and light, but keeps the path strings.
    void clear();
    /// The path with one more event.
    [[nodiscard]] Path move(Path from, lpe::EventClass event);
    /// The path with one more scattering by several lobes; without parts it contributes nothing.
    [[nodiscard]] Path move(Path from, std::span<const LobePart> parts);
    /// Adds light to a row; `path` ends in its terminal.
    void add(int row, Path path, const Rgb& value, Technique technique);

    /// The entries in the order of contributions.
    [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
    [[nodiscard]] const PathStringTree& words() const { return words_; }
    /// [column] whether some path string had light through this event.
    [[nodiscard]] std::span<const std::uint8_t> seen() const { return seen_; }
    /// Returns whether path strings omit cutouts that their light passed.
    [[nodiscard]] bool dropped_straight() const { return dropped_straight_; }
    /// [path string] the number of the path string in the atlas, which fills it in.
    std::vector<std::uint32_t> known_as;
    /// The generation of the atlas when it filled in known_as.
    std::uint64_t atlas_generation = 0;
    /// Returns whether seen() or dropped_straight() has changed since the last call.
    [[nodiscard]] bool take_news() { return std::exchange(news_, false); }

  private:
    struct Node {
        Path before = 0;
        std::uint32_t first = 0;  ///< index in parts_; if there is one part, the event itself
        std::uint32_t parts = 0;
        std::uint32_t pairs = not_known;
        std::uint32_t first_path_string = 0;  ///< index in path_strings_
        std::uint32_t first_share = 0;  ///< index in shares_; that of the previous node if one event left the shares
                                        ///< unchanged
    };
    static constexpr std::uint32_t not_known = ~std::uint32_t{0};
    /// Cache of longer(), indexed by a hash of word and event: most paths repeat what others did.
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

    const PathAlphabet& alphabet_;
    PathStringTree words_;
    std::vector<Node> nodes_;
    std::vector<LobePart> parts_;
    std::vector<std::uint32_t> path_strings_;  // contiguous, because they are used more often than shares
    std::vector<RgbD> shares_;
    std::vector<Step> steps_;
    std::vector<Entry> entries_;
    std::vector<Path> open_paths_;
    std::vector<std::uint32_t> split_path_strings_;
    std::vector<std::uint8_t> seen_;
    bool dropped_straight_ = false, news_ = false;
};

}  // namespace raylex::display
