#include "display/services/samples/batch_path_strings.h"

#include "display/services/samples/branches.h"

namespace raylex::display {

BatchPathStrings::BatchPathStrings(const PathAlphabet& alphabet)
    : alphabet_(alphabet), steps_(std::size_t{1} << step_bits), seen_(alphabet.column_count(), 0) {
    clear();
}

void BatchPathStrings::clear() {
    nodes_.clear();
    parts_.clear();
    path_strings_.assign(1, PathStringTree::root);
    shares_.assign(1, RgbD(1.0));
    entries_.clear();
    nodes_.push_back({.pairs = 1});
}

BatchPathStrings::Path BatchPathStrings::move(Path from, lpe::EventClass event) {
    nodes_.push_back({from, event, 1});
    return static_cast<Path>(nodes_.size() - 1);
}

BatchPathStrings::Path BatchPathStrings::move(Path from, std::span<const LobePart> parts) {
    if (parts.size() == 1) return move(from, parts[0].event);
    nodes_.push_back({from, static_cast<std::uint32_t>(parts_.size()), static_cast<std::uint32_t>(parts.size())});
    parts_.insert(parts_.end(), parts.begin(), parts.end());
    return static_cast<Path>(nodes_.size() - 1);
}

void BatchPathStrings::add(int row, Path path, const Rgb& value, Technique technique) {
    find_pairs(path);
    const Node& node = nodes_[path];
    const RgbD whole(value);
    for (std::uint32_t k = 0; k < node.pairs; ++k) {
        const RgbD part = whole * shares_[node.first_share + k];
        if (part.r == 0 && part.g == 0 && part.b == 0) continue;
        std::uint32_t word = path_strings_[node.first_path_string + k];
        if (alphabet_.rules().techniques) word = words_.child(word, PathAlphabet::letter_of(technique));
        entries_.push_back({static_cast<std::uint32_t>(row), word, part.r, part.g, part.b});
    }
}

void BatchPathStrings::find_pairs(Path path) {
    open_paths_.clear();
    for (; nodes_[path].pairs == not_known; path = nodes_[path].before) open_paths_.push_back(path);
    while (!open_paths_.empty()) {
        find_pairs_of(open_paths_.back());
        open_paths_.pop_back();
    }
}

std::uint32_t BatchPathStrings::longer(std::uint32_t word, lpe::EventClass event) {
    news_ = news_ || seen_[event] == 0;
    seen_[event] = 1;
    const PathAlphabet::Kind kind = alphabet_.kind(event);
    if (kind == PathAlphabet::Kind::straight && !alphabet_.rules().straight) {
        dropped_straight_ = true;
        return word;
    }
    if (kind == PathAlphabet::Kind::terminal) return words_.child(word, alphabet_.letter(event));
    if (word != PathStringTree::root && words_.node(word).letter == PathAlphabet::open) return word;
    const bool whole = words_.letters_in(word) < static_cast<std::size_t>(alphabet_.rules().length);
    return words_.child(word, whole ? alphabet_.letter(event) : PathAlphabet::open);
}

/// Extends one word by each part's event. Different words stay different, so only words with a common origin can become
/// equal.
void BatchPathStrings::split(std::uint32_t word, const RgbD& share, std::span<const LobePart> parts,
                             const Fractions& fractions) {
    split_path_strings_.clear();
    bool agree = true;
    for (const LobePart& part : parts) {
        split_path_strings_.push_back(after(word, part.event));
        agree = agree && split_path_strings_.back() == split_path_strings_.front();
    }
    if (agree) {  // the fractions sum to 1: no split, and no rounding
        if (parts.empty()) return;
        path_strings_.push_back(split_path_strings_.front());
        shares_.push_back(share);
        return;
    }
    const std::size_t first = path_strings_.size(), first_share = shares_.size();
    for (std::size_t j = 0; j < parts.size(); ++j) {
        const RgbD part = share * fractions.of(j);
        if (part.r == 0 && part.g == 0 && part.b == 0) continue;
        std::size_t at = first;
        while (at < path_strings_.size() && path_strings_[at] != split_path_strings_[j]) ++at;
        if (at < path_strings_.size()) {
            shares_[first_share + (at - first)] += part;
        } else {
            path_strings_.push_back(split_path_strings_[j]);
            shares_.push_back(part);
        }
    }
}

/// Requires that the previous node is known.
void BatchPathStrings::find_pairs_of(Path path) {
    Node& node = nodes_[path];
    const Node& before = nodes_[node.before];
    node.first_path_string = static_cast<std::uint32_t>(path_strings_.size());
    if (node.parts == 1) {
        node.first_share = before.first_share;
        for (std::uint32_t k = 0; k < before.pairs; ++k) {
            const std::uint32_t word = path_strings_[before.first_path_string + k];
            path_strings_.push_back(after(word, static_cast<lpe::EventClass>(node.first)));
        }
    } else {
        node.first_share = static_cast<std::uint32_t>(shares_.size());
        const std::span<const LobePart> parts{parts_.data() + node.first, node.parts};
        const Fractions fractions(parts);
        for (std::uint32_t k = 0; k < before.pairs; ++k)
            split(path_strings_[before.first_path_string + k], RgbD(shares_[before.first_share + k]), parts, fractions);
    }
    node.pairs = static_cast<std::uint32_t>(path_strings_.size()) - node.first_path_string;
}

}  // namespace raylex::display
