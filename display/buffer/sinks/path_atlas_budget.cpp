// Keeps the atlas within its budget: words with the least light lose their last scattering. The rest of the atlas
// depends on this only through merged_into_.
#include <algorithm>
#include <numeric>
#include <utility>

#include "display/buffer/sinks/path_atlas_pixel.h"

namespace raylex::display {

void PathAtlas::end_phase() {
    if (settings_.budget > 0 && memory_bytes() > settings_.budget) fit_budget();
}

/// The class that contains a word: without its last scattering, and with "one or more" instead; or the class that
/// already contains that one. A word with no scattering to lose returns itself. Cutouts in words (--atlas-by straight)
/// count as scatterings.
std::uint32_t PathAtlas::class_above(std::uint32_t word) {
    const PathStringTree::Node last = words_.node(word);
    const bool found_by = PathAlphabet::is_technique(last.letter);
    const PathStringTree::Node terminal = found_by ? words_.node(last.parent) : last;
    std::uint32_t before = terminal.parent;
    if (before == PathStringTree::root) return word;
    if (words_.node(before).letter == PathAlphabet::open) before = words_.node(before).parent;
    if (before == PathStringTree::root || words_.node(before).letter == PathAlphabet::open) return word;
    const std::uint32_t prefix = words_.node(before).parent;
    std::uint32_t merged = words_.child(prefix, PathAlphabet::open);
    // A word with at least two scatterings keeps that fact, so direct and indirect light remain separate.
    if (prefix == PathStringTree::root && words_.letters_in(terminal.parent) > 1)
        merged = words_.child(merged, PathAlphabet::open);
    merged = words_.child(merged, terminal.letter);
    if (found_by) merged = words_.child(merged, last.letter);
    for (auto next = static_cast<std::uint32_t>(merged_into_.size()); next < words_.size(); ++next)
        merged_into_.push_back(next);
    return survivor(merged);
}

void PathAtlas::fit_budget() {
    const std::uint64_t fixed = pixels_.size() * sizeof(Pixel);
    const std::uint64_t room = settings_.budget > fixed ? (settings_.budget - fixed) / 8 * 7 : 0;  // further phases
                                                                                                   // will follow
    // A class has light of more eighths than its words had, so its size is computed again each time.
    for (bool merges = true; merges;) {
        const auto bytes = static_cast<double>(memory_bytes() - fixed), entries = static_cast<double>(entry_count());
        merges = bytes > static_cast<double>(room) &&
                 merge_round(static_cast<std::uint64_t>(static_cast<double>(room) / bytes * entries));
    }
    ++generation_;
}

namespace {

/// Candidates in the order of merging: least light first; words that lose the first scattering or the distinction of
/// direct light last, because most expressions use these. Ties are decided by letters, because numbers of words depend
/// on threads.
struct Candidate {
    bool loses_first = false;
    double light = 0;
    std::vector<PathStringTree::Letter> letters;
    std::uint32_t word = 0, merged = 0;

    [[nodiscard]] bool operator<(const Candidate& other) const {
        if (loses_first != other.loses_first) return other.loses_first;
        return light != other.light ? light < other.light : letters < other.letters;
    }
};

}  // namespace

/// Merges as few words as necessary by one scattering each, and at most half of them. Returns false if none can be
/// merged.
bool PathAtlas::merge_round(std::uint64_t most_entries) {
    const std::vector<double> light = light_of_path_strings();
    std::vector<Candidate> candidates;
    std::vector<bool> alive(words_.size(), false);
    pools_->for_each([&](const Entry& entry) { alive[entry.word >> 1] = entry.word != Entry::unused; });
    for (std::uint32_t word = 0; word < alive.size(); ++word) {
        if (!alive[word]) continue;
        if (const std::uint32_t merged = class_above(word); merged != word)
            candidates.push_back({words_.letters(merged).front() == PathAlphabet::open, light[word],
                                  words_.letters(word), word, merged});
    }
    if (candidates.empty()) return false;
    std::sort(candidates.begin(), candidates.end());
    std::vector<std::uint32_t> target(words_.size());
    std::vector<std::uint64_t> seen_at(2 * words_.size(), 0);
    std::uint64_t stamp = 0;
    const auto entries_with = [&](std::size_t merged) {
        std::iota(target.begin(), target.end(), 0u);
        for (std::size_t i = 0; i < merged; ++i) target[candidates[i].word] = candidates[i].merged;
        std::uint64_t count = 0;
        for (const Pixel& pixel : pixels_) {
            ++stamp;
            pixel.for_each(*pools_, [&](const Entry& entry) {
                std::uint64_t& at = seen_at[2 * std::size_t{target[entry.word >> 1]} + (entry.word & 1)];
                if (at != stamp) ++count;
                at = stamp;
            });
        }
        return count;
    };
    // Merges at most the darker half at a time, because the resulting class can be bright and is then kept. For the
    // same reason no word loses its first scattering in a round in which other merges are possible.
    const auto keep_first =
        std::partition_point(candidates.begin(), candidates.end(), [](const Candidate& c) { return !c.loses_first; });
    std::size_t few = 0, enough = (candidates.size() + 1) / 2;
    if (keep_first != candidates.begin())
        enough = std::min(enough, static_cast<std::size_t>(keep_first - candidates.begin()));
    if (entries_with(enough) <= most_entries)
        while (enough - few > 1) {
            const std::size_t middle = few + (enough - few) / 2;
            (entries_with(middle) <= most_entries ? enough : few) = middle;
        }
    for (std::size_t i = 0; i < enough; ++i) merged_into_[candidates[i].word] = candidates[i].merged;
    merged_path_strings_ += enough;
    apply_merges();
    return true;
}

/// Adds the light of `more` to `entry`; the result has a single eighth only if both have the same one.
void PathAtlas::take_in(Entry& entry, const Entry& more, Reserves& reserves) {
    if (more.is_spread() || more.eighth != entry.eighth) reserves.spread(entry);
    if (entry.is_spread())
        more.for_each_eighth(reserves.eighths, [&](std::uint32_t k, Int128 sum) {
            static_cast<void>(add_fixed(reserves.eighths[entry.eighths].sums[k], sum));
        });
    for (std::size_t c = 0; c < 3; ++c) static_cast<void>(add_fixed(entry.light[c], more.light[c]));
}

void PathAtlas::apply_merges() {
    Reserves reserves(*pools_);
    for (Pixel& pixel : pixels_) {
        const std::span<Slot> before = std::exchange(pixel.slots, {});
        pixel.count = 0;
        for (const Slot slot : before) {
            if (slot.word == Entry::unused) continue;
            const std::uint32_t word = 2 * survivor(slot.word >> 1) + (slot.word & 1);
            Slot* const into = pixel.find(word);
            if (into == nullptr) {
                if (slot.is_single()) reserves.singles[slot.single()].word = word;
                else reserves.entries[slot.place].word = word;
                pixel.insert({word, slot.place}, reserves.slots);
                continue;
            }
            Slot from = slot;
            const Entry& entry = reserves.entry(from);
            take_in(reserves.entry(*into), entry, reserves);
            if (entry.is_spread()) reserves.eighths.give_back(entry.eighths);
            reserves.entries.give_back(from.place);
        }
        reserves.slots.give_back(before);
    }
}

}  // namespace raylex::display
