// A slow and simple implementation of expressions, for comparison with the compiler. It shares no code with lpe/: it
// has its own parser of ready-made tokens, its own predicates on events, and a matcher that computes sets of end
// positions.
#pragma once

#include <bitset>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "display/services/split_mix.h"
#include "lpe/event.h"

namespace oracle {

using raylex::lpe::Dialect;
using raylex::lpe::Event;
using Path = std::vector<Event>;

/// A token of the oracle: a mark of the grammar, or an event with its predicate.
struct Token {
    std::string text;
    std::function<bool(const Event&)> matches;  ///< empty for marks
};

/// Marks ( ) [ ] | * + {2} {0,1} and events; renderman also has ? ! & -.
const std::vector<Token>& tokens(Dialect dialect);

struct Tree;

/// Parses a sequence of token indices; null if it is not an expression of the dialect.
std::shared_ptr<Tree> parse(const std::vector<std::size_t>& sequence, Dialect dialect);

/// Returns whether the tree matches the whole path.
bool matches(const Tree& tree, const Path& path, Dialect dialect);

std::string text_of(const std::vector<std::size_t>& sequence, Dialect dialect);

/// Every path of at most `longest` events over a small alphabet for which each predicate is both true and false.
std::vector<Path> all_paths(Dialect dialect, std::size_t longest);
const std::vector<Event>& alphabet();

/// All words of at most `longest` events over the small alphabet of all_paths(), and the languages of trees restricted
/// to them: sets of words, united and concatenated word by word. A second implementation beside matches(), fast enough
/// for exhaustive tests.
class ShortPathStrings {
  public:
    static constexpr std::size_t most = 3906;  ///< words of at most 5 events over 5 letters
    using Set = std::bitset<most>;

    ShortPathStrings(Dialect dialect, std::size_t longest);

    /// The words in the order of all_paths(): shorter words first, then by value.
    [[nodiscard]] const std::vector<Path>& words() const { return words_; }
    [[nodiscard]] const std::vector<Event>& events() const { return events_; }
    /// The index of word `w` without its last event; w > 0.
    [[nodiscard]] std::size_t parent(std::size_t w) const { return (w - 1) / events_.size(); }
    [[nodiscard]] std::size_t last_event(std::size_t w) const { return (w - 1) % events_.size(); }
    [[nodiscard]] Set language(const Tree& tree) const;

  private:
    [[nodiscard]] Set concatenated(const Set& a, const Set& b) const;

    std::size_t longest_;
    std::vector<Event> events_;
    std::vector<Path> words_;
    std::vector<std::size_t> first_;  // [length] begin of the words of that length, plus one entry at the end
    Set without_user_;
};

/// A small generator with a fixed sequence on every machine (SplitMix64).
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() { return raylex::mix_bits(state_ += raylex::golden_gamma); }
    std::size_t below(std::size_t bound) { return static_cast<std::size_t>(next() % bound); }

  private:
    std::uint64_t state_;
};

/// A random well-formed expression with about `size` events.
std::vector<std::size_t> random_expression(Random& random, Dialect dialect, std::size_t size);
Path random_path(Random& random, std::size_t longest);

}  // namespace oracle
