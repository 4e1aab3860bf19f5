#include "display/services/path_words.h"

#include "display/services/branches.h"

namespace raylex::display {

PathWords::PathWords(const WordAlphabet& alphabet) : alphabet_(alphabet), seen_(alphabet.column_count(), 0) {
    clear();
}

void PathWords::clear() {
    nodes_.clear();
    parts_.clear();
    pairs_.clear();
    entries_.clear();
    pairs_.push_back({WordTree::root, RgbD(1.0)});
    nodes_.push_back({0, 0, 0, 0, 1});
}

PathWords::Path PathWords::move(Path from, lpe::EventClass event) {
    nodes_.push_back({from, event, 1, 0, not_known});
    return static_cast<Path>(nodes_.size() - 1);
}

PathWords::Path PathWords::move(Path from, std::span<const LobePart> parts) {
    if (parts.size() == 1) return move(from, parts[0].event);
    nodes_.push_back(
        {from, static_cast<std::uint32_t>(parts_.size()), static_cast<std::uint32_t>(parts.size()), 0, not_known});
    parts_.insert(parts_.end(), parts.begin(), parts.end());
    return static_cast<Path>(nodes_.size() - 1);
}

void PathWords::add(int row, Path path, const Rgb& value, Technique technique) {
    find_pairs(path);
    const Node& node = nodes_[path];
    const RgbD whole(value);
    for (std::uint32_t k = node.first_pair; k < node.first_pair + node.pairs; ++k) {
        const RgbD part = whole * pairs_[k].share;
        if (part.r == 0 && part.g == 0 && part.b == 0) continue;
        const std::uint32_t word = alphabet_.rules().techniques
                                       ? words_.child(pairs_[k].word, WordAlphabet::letter_of(technique))
                                       : pairs_[k].word;
        entries_.push_back({static_cast<std::uint32_t>(row), word, part.r, part.g, part.b});
    }
}

void PathWords::find_pairs(Path path) {
    open_paths_.clear();
    for (; nodes_[path].pairs == not_known; path = nodes_[path].before) open_paths_.push_back(path);
    while (!open_paths_.empty()) {
        find_pairs_of(open_paths_.back());
        open_paths_.pop_back();
    }
}

std::uint32_t PathWords::longer(std::uint32_t word, lpe::EventClass event) {
    news_ = news_ || seen_[event] == 0;
    seen_[event] = 1;
    const WordAlphabet::Kind kind = alphabet_.kind(event);
    if (kind == WordAlphabet::Kind::straight && !alphabet_.rules().straight) {
        dropped_straight_ = true;
        return word;
    }
    if (kind == WordAlphabet::Kind::terminal) return words_.child(word, alphabet_.letter(event));
    if (word != WordTree::root && words_.node(word).letter == WordAlphabet::open) return word;
    const bool whole = words_.letters_in(word) < static_cast<std::size_t>(alphabet_.rules().length);
    return words_.child(word, whole ? alphabet_.letter(event) : WordAlphabet::open);
}

/// From one word: each part by its own event. Words that differ stay different whatever follows, so those of one word
/// are all that can become equal.
void PathWords::split(const Pair& from, std::span<const LobePart> parts, const Fractions& fractions) {
    split_words_.clear();
    bool agree = true;
    for (const LobePart& part : parts) {
        split_words_.push_back(longer(from.word, part.event));
        agree = agree && split_words_.back() == split_words_.front();
    }
    if (agree) {  // the fractions sum to 1: nothing is split, nothing is rounded
        if (!parts.empty()) pairs_.push_back({split_words_.front(), from.share});
        return;
    }
    const std::size_t first = pairs_.size();
    for (std::size_t j = 0; j < parts.size(); ++j) {
        const RgbD share = from.share * fractions.of(j);
        if (share.r == 0 && share.g == 0 && share.b == 0) continue;
        std::size_t at = first;
        while (at < pairs_.size() && pairs_[at].word != split_words_[j]) ++at;
        if (at < pairs_.size()) pairs_[at].share += share;
        else pairs_.push_back({split_words_[j], share});
    }
}

/// The node before it is known.
void PathWords::find_pairs_of(Path path) {
    Node& node = nodes_[path];
    const Node& before = nodes_[node.before];
    const std::uint32_t end = before.first_pair + before.pairs;
    node.first_pair = static_cast<std::uint32_t>(pairs_.size());
    if (node.parts == 1) {
        for (std::uint32_t k = before.first_pair; k < end; ++k) {
            const RgbD share = pairs_[k].share;
            pairs_.push_back({longer(pairs_[k].word, static_cast<lpe::EventClass>(node.first)), share});
        }
    } else {
        const std::span<const LobePart> parts{parts_.data() + node.first, node.parts};
        const Fractions fractions(parts);
        for (std::uint32_t k = before.first_pair; k < end; ++k) split(Pair(pairs_[k]), parts, fractions);
    }
    node.pairs = static_cast<std::uint32_t>(pairs_.size()) - node.first_pair;
}

}  // namespace raylex::display
