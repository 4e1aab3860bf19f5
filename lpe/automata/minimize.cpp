// Hopcroft's partition refinement, in the array form of Valmari and Lehtinen ("Efficient Minimization of DFAs with
// Partial Transition Functions", 2008): blocks are ranges of one permutation of the states, and splitting a block moves
// its marked states to the front.
#include <algorithm>
#include <map>
#include <utility>

#include "lpe/automata/dfa.h"

namespace raylex::lpe {

namespace {

class Partition {
  public:
    explicit Partition(const std::vector<std::uint32_t>& outputs)
        : elements_(outputs.size()), place_(outputs.size()), block_(outputs.size()) {
        for (std::uint32_t state = 0; state < outputs.size(); ++state) { elements_[state] = state; }
        std::stable_sort(elements_.begin(), elements_.end(),
                         [&outputs](std::uint32_t a, std::uint32_t b) { return outputs[a] < outputs[b]; });
        for (std::uint32_t i = 0; i < elements_.size(); ++i) {
            if (i == 0 || outputs[elements_[i]] != outputs[elements_[i - 1]]) {
                begin_.push_back(i);
                end_.push_back(i);
                marked_.push_back(0);
            }
            ++end_.back();
            place_[elements_[i]] = i;
            block_[elements_[i]] = static_cast<std::uint32_t>(begin_.size() - 1);
        }
    }

    [[nodiscard]] std::size_t size() const { return begin_.size(); }
    [[nodiscard]] std::uint32_t block_of(std::uint32_t state) const { return block_[state]; }
    [[nodiscard]] std::vector<std::uint32_t> members(std::uint32_t block) const {
        return {elements_.begin() + begin_[block], elements_.begin() + end_[block]};
    }
    [[nodiscard]] std::uint32_t block_size(std::uint32_t block) const { return end_[block] - begin_[block]; }

    void mark(std::uint32_t state) {
        const std::uint32_t block = block_[state];
        const std::uint32_t boundary = begin_[block] + marked_[block];
        if (place_[state] < boundary) { return; }
        if (marked_[block]++ == 0) { touched_.push_back(block); }
        const std::uint32_t other = elements_[boundary];
        std::swap(elements_[place_[state]], elements_[boundary]);
        std::swap(place_[state], place_[other]);
    }

    /// Splits every touched block into its marked and its other states, and calls split(old block, new block) for each.
    template <class Split>
    void split_marked(Split&& split) {
        for (const std::uint32_t block : touched_) {
            const std::uint32_t count = marked_[block];
            marked_[block] = 0;
            if (count == block_size(block)) { continue; }
            const auto fresh = static_cast<std::uint32_t>(size());
            begin_.push_back(begin_[block]);
            end_.push_back(begin_[block] + count);
            marked_.push_back(0);
            begin_[block] += count;
            for (std::uint32_t i = begin_[fresh]; i < end_[fresh]; ++i) { block_[elements_[i]] = fresh; }
            split(block, fresh);
        }
        touched_.clear();
    }

  private:
    std::vector<std::uint32_t> elements_, place_, block_;
    std::vector<std::uint32_t> begin_, end_, marked_, touched_;
};

/// The predecessors of every state for each column, as ranges of one array.
struct Predecessors {
    std::vector<std::uint32_t> first;  // [column][state], plus one entry past the end
    std::vector<std::uint32_t> sources;
};

Predecessors invert(const Dfa& dfa) {
    const std::size_t states = dfa.states();
    Predecessors inverse;
    inverse.first.assign(dfa.columns * states + 1, 0);
    inverse.sources.resize(dfa.columns * states);
    for (std::size_t state = 0; state < states; ++state) {
        for (std::size_t column = 0; column < dfa.columns; ++column) {
            ++inverse.first[column * states + dfa.next[state * dfa.columns + column] + 1];
        }
    }
    for (std::size_t i = 1; i < inverse.first.size(); ++i) { inverse.first[i] += inverse.first[i - 1]; }
    std::vector<std::uint32_t> fill(inverse.first.begin(), inverse.first.end() - 1);
    for (std::uint32_t state = 0; state < states; ++state) {
        for (std::size_t column = 0; column < dfa.columns; ++column) {
            inverse.sources[fill[column * states + dfa.next[state * dfa.columns + column]]++] = state;
        }
    }
    return inverse;
}

Partition refine(const Dfa& dfa) {
    Partition partition(dfa.output);
    const Predecessors inverse = invert(dfa);
    std::vector<std::uint32_t> waiting;
    std::vector<bool> is_waiting;
    for (std::uint32_t block = 0; block < partition.size(); ++block) {
        waiting.push_back(block);
        is_waiting.push_back(true);
    }
    while (!waiting.empty()) {
        const std::uint32_t splitter = waiting.back();
        waiting.pop_back();
        is_waiting[splitter] = false;
        const std::vector<std::uint32_t> members = partition.members(splitter);
        for (std::size_t column = 0; column < dfa.columns; ++column) {
            for (const std::uint32_t state : members) {
                const std::size_t slot = column * dfa.states() + state;
                for (std::uint32_t i = inverse.first[slot]; i < inverse.first[slot + 1]; ++i) {
                    partition.mark(inverse.sources[i]);
                }
            }
            partition.split_marked([&](std::uint32_t block, std::uint32_t fresh) {
                is_waiting.push_back(false);
                // The current splitter is a copy, so its parts can be queued like any other block.
                const bool queue_block =
                    !is_waiting[block] && partition.block_size(block) < partition.block_size(fresh);
                const std::uint32_t chosen = queue_block ? block : fresh;
                is_waiting[chosen] = true;
                waiting.push_back(chosen);
            });
        }
    }
    return partition;
}

/// Merges columns that are equal in every state.
void merge_columns(Dfa& dfa) {
    std::map<std::vector<std::uint32_t>, std::uint16_t> seen;
    std::vector<std::uint16_t> merged(dfa.columns);
    std::vector<std::size_t> kept;
    for (std::size_t column = 0; column < dfa.columns; ++column) {
        std::vector<std::uint32_t> targets(dfa.states());
        for (std::size_t state = 0; state < dfa.states(); ++state) {
            targets[state] = dfa.next[state * dfa.columns + column];
        }
        const auto [place, fresh] = seen.emplace(std::move(targets), static_cast<std::uint16_t>(kept.size()));
        if (fresh) { kept.push_back(column); }
        merged[column] = place->second;
    }
    if (kept.size() == dfa.columns) { return; }
    std::vector<std::uint32_t> next;
    next.reserve(dfa.states() * kept.size());
    for (std::size_t state = 0; state < dfa.states(); ++state) {
        for (const std::size_t column : kept) { next.push_back(dfa.next[state * dfa.columns + column]); }
    }
    for (std::uint16_t& column : dfa.column_of_class) { column = merged[column]; }
    dfa.next = std::move(next);
    dfa.columns = kept.size();
}

}  // namespace

Dfa minimized(const Dfa& dfa) {
    const Partition partition = refine(dfa);
    constexpr std::uint32_t unnumbered = 0xFFFFFFFFU;
    std::vector<std::uint32_t> number(partition.size(), unnumbered);
    std::vector<std::uint32_t> representative{0};
    number[partition.block_of(0)] = 0;
    const auto number_of = [&](std::uint32_t state) {
        std::uint32_t& entry = number[partition.block_of(state)];
        if (entry == unnumbered) {
            entry = static_cast<std::uint32_t>(representative.size());
            representative.push_back(state);
        }
        return entry;
    };
    Dfa result;
    result.column_of_class = dfa.column_of_class;
    result.columns = dfa.columns;
    result.start = number_of(dfa.start);
    for (std::size_t state = 0; state < representative.size(); ++state) {
        for (std::size_t column = 0; column < dfa.columns; ++column) {
            result.next.push_back(number_of(dfa.next[representative[state] * dfa.columns + column]));
        }
        result.output.push_back(dfa.output[representative[state]]);
    }
    merge_columns(result);
    return result;
}

}  // namespace raylex::lpe
