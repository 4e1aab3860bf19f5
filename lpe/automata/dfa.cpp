#include "lpe/automata/dfa.h"

#include <algorithm>
#include <utility>

#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

/// A hash map with open addressing from pairs of states to states. The key (0, 0) marks an empty slot: that pair is
/// dead.
class PairMap {
  public:
    /// Returns the value of the key and whether it is new; a new key gets the value `fresh`.
    std::pair<std::uint32_t, bool> insert(std::uint64_t key, std::uint32_t fresh) {
        if (2 * (size_ + 1) > slots_.size()) { grow(); }
        Slot& slot = find(key);
        if (slot.key == key) { return {slot.value, false}; }
        slot = {key, fresh};
        ++size_;
        return {fresh, true};
    }

  private:
    struct Slot {
        std::uint64_t key = 0;
        std::uint32_t value = 0;
    };
    Slot& find(std::uint64_t key) {
        // Bits from 32 up of the product depend on both states.
        std::size_t at = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 32) & (slots_.size() - 1);
        while (slots_[at].key != 0 && slots_[at].key != key) { at = (at + 1) & (slots_.size() - 1); }
        return slots_[at];
    }
    void grow() {
        std::vector<Slot> old(std::max<std::size_t>(64, 2 * slots_.size()));
        std::swap(old, slots_);
        for (const Slot& slot : old) {
            if (slot.key != 0) { find(slot.key) = slot; }
        }
    }
    std::vector<Slot> slots_;
    std::size_t size_ = 0;
};

/// The columns of a product: the pairs of columns that at least one class uses.
struct JointColumns {
    std::vector<std::uint16_t> of_class;
    std::vector<std::pair<std::uint16_t, std::uint16_t>> pairs;
};

JointColumns join_columns(const Dfa& a, const Dfa& b) {
    JointColumns joint;
    std::unordered_map<std::uint32_t, std::uint16_t> seen;
    joint.of_class.reserve(a.column_of_class.size());
    for (std::size_t k = 0; k < a.column_of_class.size(); ++k) {
        const std::uint32_t key = static_cast<std::uint32_t>(a.column_of_class[k]) << 16 | b.column_of_class[k];
        const auto [place, fresh] = seen.emplace(key, static_cast<std::uint16_t>(joint.pairs.size()));
        if (fresh) { joint.pairs.emplace_back(a.column_of_class[k], b.column_of_class[k]); }
        joint.of_class.push_back(place->second);
    }
    return joint;
}

std::uint32_t combine_union(void* /*context*/, std::uint32_t a, std::uint32_t b) {
    return a | b;
}
std::uint32_t combine_intersection(void* /*context*/, std::uint32_t a, std::uint32_t b) {
    return a & b;
}
std::uint32_t combine_difference(void* /*context*/, std::uint32_t a, std::uint32_t b) {
    return a & ~b & 1U;
}
std::uint32_t combine_count(void* /*context*/, std::uint32_t a, std::uint32_t b) {
    return std::min<std::uint32_t>(a + b, 2);
}

}  // namespace

std::string Dfa::dump() const {
    std::string text;
    for (std::size_t state = 0; state < states(); ++state) {
        text += std::to_string(state) + (state == start ? " start" : "") + " [" + std::to_string(output[state]) + "]:";
        for (std::size_t column = 0; column < columns; ++column) {
            text += ' ';
            text += std::to_string(next[state * columns + column]);
        }
        text += "\n";
    }
    return text;
}

Dfa empty_dfa(std::size_t class_count) {
    Dfa dfa;
    dfa.column_of_class.assign(class_count, 0);
    dfa.columns = 1;
    dfa.next = {0};
    dfa.output = {0};
    return dfa;
}

Combination union_of() {
    return {combine_union, nullptr, false, false};
}
Combination intersection_of() {
    return {combine_intersection, nullptr, true, false};
}
Combination difference_of() {
    return {combine_difference, nullptr, false, true};
}
Combination count_of() {
    return {combine_count, nullptr, false, false};
}

std::optional<Dfa> product(const Dfa& a, const Dfa& b, const Combination& combination, std::size_t state_cap) {
    JointColumns joint = join_columns(a, b);
    Dfa result;
    result.column_of_class = std::move(joint.of_class);
    result.columns = joint.pairs.size();
    state_cap = std::min(state_cap, limits::table_entries / result.columns);
    PairMap numbers;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs{{0, 0}};
    const auto number = [&](std::uint32_t p, std::uint32_t q) -> std::uint32_t {
        if ((p == 0 && q == 0) || (combination.needs_both && (p == 0 || q == 0)) ||
            (combination.needs_first && p == 0)) {
            return 0;
        }
        const auto fresh = static_cast<std::uint32_t>(pairs.size());
        const auto [state, is_new] = numbers.insert(static_cast<std::uint64_t>(p) << 32 | q, fresh);
        if (is_new) { pairs.emplace_back(p, q); }
        return state;
    };
    result.start = number(a.start, b.start);
    result.next.assign(result.columns, 0);
    for (std::size_t state = 1; state < pairs.size(); ++state) {
        const auto [p, q] = pairs[state];
        const std::uint32_t* from_a = a.next.data() + p * a.columns;
        const std::uint32_t* from_b = b.next.data() + q * b.columns;
        for (const auto& [column_a, column_b] : joint.pairs) {
            result.next.push_back(number(from_a[column_a], from_b[column_b]));
        }
        if (pairs.size() > state_cap) { return std::nullopt; }
    }
    result.output.reserve(pairs.size());
    for (const auto& [p, q] : pairs) {
        result.output.push_back(combination.combine(combination.context, a.output[p], b.output[q]));
    }
    return result;
}

std::optional<std::vector<EventClass>> shortest_path_string(const Dfa& dfa, bool (*wanted)(std::uint32_t output)) {
    // The lowest class of each column. Columns are visited in that order because the simplest classes have the lowest
    // numbers.
    std::vector<EventClass> class_of_column(dfa.columns);
    std::vector<std::size_t> order;
    std::vector<bool> taken(dfa.columns, false);
    for (std::size_t k = 0; k < dfa.column_of_class.size(); ++k) {
        if (!taken[dfa.column_of_class[k]]) {
            taken[dfa.column_of_class[k]] = true;
            class_of_column[dfa.column_of_class[k]] = static_cast<EventClass>(k);
            order.push_back(dfa.column_of_class[k]);
        }
    }
    std::vector<std::pair<std::uint32_t, EventClass>> came_from(dfa.states());
    std::vector<bool> seen(dfa.states(), false);
    std::vector<std::uint32_t> queue{dfa.start};
    seen[dfa.start] = true;
    for (std::size_t i = 0; i < queue.size(); ++i) {
        std::uint32_t state = queue[i];
        if (wanted(dfa.output[state])) {
            std::vector<EventClass> word;
            for (; state != dfa.start; state = came_from[state].first) { word.push_back(came_from[state].second); }
            std::reverse(word.begin(), word.end());
            return word;
        }
        for (const std::size_t column : order) {
            const std::uint32_t target = dfa.next[state * dfa.columns + column];
            if (!seen[target]) {
                seen[target] = true;
                came_from[target] = {state, class_of_column[column]};
                queue.push_back(target);
            }
        }
    }
    return std::nullopt;
}

}  // namespace raylex::lpe
