#include "lpe/algebra/proofs/sorting.h"

#include <algorithm>
#include <map>
#include <utility>

#include "lpe/algebra/proofs/question.h"
#include "lpe/failure.h"

namespace raylex::lpe {

namespace {

constexpr std::size_t most_tries = 2'000;  // differences of automata; about half a second
constexpr std::size_t most_sorted = 200;   // channels of one partition, and candidates; each is a level of the
                                           // recursion

class Sorter {
  public:
    Sorter(std::vector<Dfa> channels, Dfa whole) : channels_(std::move(channels)), whole_(std::move(whole)) {}

    Sorting run() {
        Sorting sorting;
        std::vector<bool> open;
        for (const Dfa& channel : channels_) {
            // A channel that counts no path, or paths outside the beauty, belongs to no partition.
            open.push_back(channel.start != 0 && !shortest_path_string(difference(channel, whole_), is_set));
        }
        for (std::size_t first = 0; first < channels_.size(); ++first) {
            std::vector<std::size_t> chosen{first};
            if (open[first] && extend(chosen, open, difference(whole_, channels_[first]))) {
                for (const std::size_t channel : chosen) { open[channel] = false; }
                std::sort(chosen.begin(), chosen.end());
                sorting.partitions.push_back(std::move(chosen));
            }
        }
        std::vector<bool> placed(channels_.size(), false);
        for (const auto& partition : sorting.partitions) {
            for (const std::size_t channel : partition) { placed[channel] = true; }
        }
        for (std::size_t channel = 0; channel < channels_.size(); ++channel) {
            if (!placed[channel]) { sorting.left.push_back(channel); }
        }
        sorting.gave_up = tries_ > most_tries;
        return sorting;
    }

  private:
    /// Adds channels until `missed` is covered. Returns false, with `chosen` unchanged, if no choice covers it.
    bool extend(std::vector<std::size_t>& chosen, const std::vector<bool>& open, const Dfa& missed) {
        const auto word = shortest_path_string(missed, is_set);
        if (!word) { return true; }
        for (const std::size_t next : accepting(channels_, channels_.size(), *word)) {
            const bool apart =
                std::all_of(chosen.begin(), chosen.end(), [&](std::size_t channel) { return disjoint(channel, next); });
            if (!open[next] || !apart || chosen.size() > most_sorted || ++tries_ > most_tries) { continue; }
            chosen.push_back(next);
            if (extend(chosen, open, difference(missed, channels_[next]))) { return true; }
            chosen.pop_back();
        }
        return false;
    }

    bool disjoint(std::size_t a, std::size_t b) {
        const auto [place, fresh] = disjoint_.try_emplace(std::minmax(a, b), false);
        if (fresh) { place->second = intersection(channels_[a], channels_[b]).start == 0; }
        return place->second;
    }

    std::vector<Dfa> channels_;  // restricted to W
    Dfa whole_;
    std::map<std::pair<std::size_t, std::size_t>, bool> disjoint_;
    std::size_t tries_ = 0;
};

Sorting sorted(std::span<const ChannelSource> channels, const std::optional<ChannelSource>& beauty,
               const PathStrings& words) {
    std::vector<ChannelSource> all(channels.begin(), channels.end());
    if (beauty) { all.push_back(*beauty); }
    const Question question = pose(all, words, "a partition");
    const Languages& languages = question.languages;
    std::vector<Dfa> cut;
    for (const Dfa& channel : languages.channels) { cut.push_back(intersection(*languages.words, channel)); }
    Dfa whole = *languages.words;
    if (beauty) {
        whole = std::move(cut.back());
        cut.pop_back();
    }
    return Sorter(std::move(cut), std::move(whole)).run();
}

}  // namespace

Result<Sorting> sort_into_partitions(std::span<const ChannelSource> channels,
                                     const std::optional<ChannelSource>& beauty, const PathStrings& words) {
    return guarded([&] { return sorted(channels, beauty, words); });
}

}  // namespace raylex::lpe
