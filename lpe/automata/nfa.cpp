#include "lpe/automata/nfa.h"

#include <algorithm>
#include <map>
#include <unordered_map>
#include <utility>

#include "lpe/failure.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

constexpr std::uint32_t none = 0xFFFFFFFFU;

/// A state has one symbol edge, or up to two silent edges.
struct NfaState {
    std::uint32_t symbol = none;  // index into Nfa::symbols
    std::uint32_t target = none;
    std::uint32_t silent[2] = {none, none};
};

struct Fragment {
    std::uint32_t first = 0, last = 0;
};

/// An automaton under construction. A state with more than two silent edges is a chain of silent states.
class Nfa {
  public:
    /// The automata of '&', '-' and '!' nodes; a repetition meets the same node many times.
    using Cache = std::unordered_map<const Node*, Dfa>;

    Nfa(const ClassLookup& lookup, std::size_t state_cap, Cache& cache)
        : lookup_(lookup), state_cap_(state_cap), cache_(cache) {}

    Fragment build(const Node& node) {
        switch (node.kind) {
            case NodeKind::event:
                return symbol_fragment(intern(lookup_.classes->members(node.event_set)));
            case NodeKind::sequence:
                return build_sequence(node);
            case NodeKind::alternatives:
                return build_alternatives(node);
            case NodeKind::repeat:
                return build_repeat(node);
            case NodeKind::complement:
            case NodeKind::intersection:
            case NodeKind::difference:
                return embed(build_boolean(node));
        }
        return {};
    }

    /// The automaton of an operator on whole languages.
    const Dfa& build_boolean(const Node& node);

    [[nodiscard]] const std::vector<NfaState>& states() const { return states_; }
    [[nodiscard]] const std::vector<ClassSet>& symbols() const { return symbols_; }

  private:
    std::uint32_t add_state() {
        if (states_.size() >= limits::nfa_states) {
            fail("the expression unrolls to more than " + std::to_string(limits::nfa_states) + " positions",
                 "use smaller repetition counts");
        }
        states_.emplace_back();
        return static_cast<std::uint32_t>(states_.size() - 1);
    }

    void connect(std::uint32_t from, std::uint32_t to) {
        while (states_[from].silent[1] != none) { from = states_[from].silent[1]; }
        if (states_[from].silent[0] == none) {
            states_[from].silent[0] = to;
            return;
        }
        const std::uint32_t relay = add_state();
        states_[relay].silent[0] = to;
        states_[from].silent[1] = relay;
    }

    std::uint32_t intern(const ClassSet& set) {
        const auto [place, fresh] = symbol_of_.emplace(set, static_cast<std::uint32_t>(symbols_.size()));
        if (fresh) { symbols_.push_back(set); }
        return place->second;
    }

    Fragment symbol_fragment(std::uint32_t symbol) {
        const std::uint32_t first = add_state();
        const std::uint32_t last = add_state();
        states_[first].symbol = symbol;
        states_[first].target = last;
        return {first, last};
    }

    Fragment empty_fragment() {
        const std::uint32_t state = add_state();
        return {state, state};
    }

    Fragment build_sequence(const Node& node) {
        Fragment whole = empty_fragment();
        for (const NodePtr& child : node.children) {
            const Fragment part = build(*child);
            connect(whole.last, part.first);
            whole.last = part.last;
        }
        return whole;
    }

    Fragment build_alternatives(const Node& node) {
        const Fragment whole{add_state(), add_state()};
        std::uint32_t fan = whole.first;
        for (const NodePtr& child : node.children) {
            const Fragment part = build(*child);
            connect(fan, part.first);
            fan = states_[fan].silent[1] == none ? fan : states_[fan].silent[1];
            const std::uint32_t exit = add_state();  // `part.last` may already have both silent edges
            connect(part.last, exit);
            connect(exit, whole.last);
        }
        return whole;
    }

    Fragment build_repeat(const Node& node) {
        const Node& child = *node.children.front();
        Fragment whole = empty_fragment();
        for (int i = 0; i < node.min; ++i) { append(whole, build(child)); }
        if (node.max == Node::unbounded) {
            const Fragment loop = build(child);
            const std::uint32_t hub = add_state();
            connect(whole.last, hub);
            connect(hub, loop.first);
            const std::uint32_t back = add_state();
            connect(loop.last, back);
            connect(back, hub);
            const std::uint32_t exit = add_state();
            connect(hub, exit);
            whole.last = exit;
            return whole;
        }
        const std::uint32_t exit = add_state();
        for (int i = node.min; i < node.max; ++i) {
            const std::uint32_t fork = add_state();
            connect(whole.last, fork);
            connect(fork, exit);
            const Fragment part = build(child);
            connect(fork, part.first);
            whole.last = part.last;
        }
        const std::uint32_t relay = add_state();
        connect(whole.last, relay);
        connect(relay, exit);
        whole.last = exit;
        return whole;
    }

    void append(Fragment& whole, const Fragment& part) {
        connect(whole.last, part.first);
        whole.last = part.last;
    }

    Fragment embed(const Dfa& dfa) {
        const Fragment whole{add_state(), add_state()};
        std::vector<std::uint32_t> place(dfa.states(), none);
        for (std::size_t state = 1; state < dfa.states(); ++state) { place[state] = add_state(); }
        if (dfa.start != 0) { connect(whole.first, place[dfa.start]); }
        for (std::size_t state = 1; state < dfa.states(); ++state) {
            std::map<std::uint32_t, ClassSet> by_target;
            for (std::size_t k = 0; k < dfa.column_of_class.size(); ++k) {
                const std::uint32_t target = dfa.step(static_cast<std::uint32_t>(state), static_cast<EventClass>(k));
                if (target != 0) {
                    ClassSet& set = by_target.try_emplace(target, dfa.column_of_class.size(), false).first->second;
                    set[k] = true;
                }
            }
            std::uint32_t fan = place[state];
            for (const auto& [target, set] : by_target) {
                const Fragment edge = symbol_fragment(intern(set));
                connect(fan, edge.first);
                fan = states_[fan].silent[1] == none ? fan : states_[fan].silent[1];
                connect(edge.last, place[target]);
            }
            if (dfa.output[state] != 0) { connect(fan, whole.last); }
        }
        return whole;
    }

    const ClassLookup& lookup_;
    std::size_t state_cap_;
    Cache& cache_;
    std::vector<NfaState> states_;
    std::vector<ClassSet> symbols_;
    std::map<ClassSet, std::uint32_t> symbol_of_;
};

struct SubsetHash {
    std::size_t operator()(const std::vector<std::uint32_t>& set) const {
        std::uint64_t hash = 0xCBF29CE484222325ULL;
        for (const std::uint32_t element : set) {
            hash = (hash ^ element) * 0x100000001B3ULL;
            hash ^= hash >> 29;
        }
        return static_cast<std::size_t>(hash);
    }
};

/// Subset construction. A subset needs only its states with a symbol edge, and the last state.
class Determinizer {
  public:
    Determinizer(const Nfa& nfa, const Fragment& whole, const ClassLookup& lookup, std::size_t state_cap)
        : nfa_(nfa), whole_(whole), work_(*lookup.work), state_cap_(state_cap), stamp_(nfa.states().size(), 0) {
        find_columns(lookup.classes->count());
    }

    Dfa run() {
        number({});  // the dead state
        begin_subset();
        close(whole_.first);
        dfa_.start = number(take_subset());
        for (std::size_t state = 0; state < order_.size(); ++state) {
            const std::vector<std::uint32_t>& subset = *order_[state];
            work_.spend((subset.size() + 1) * dfa_.columns);
            for (std::size_t column = 0; column < dfa_.columns; ++column) {
                begin_subset();
                for (const std::uint32_t from : subset) {
                    const NfaState& edge = nfa_.states()[from];
                    if (edge.symbol != none && symbol_in_column_[column][edge.symbol]) { close(edge.target); }
                }
                dfa_.next.push_back(number(take_subset()));
            }
            dfa_.output.push_back(!subset.empty() && std::binary_search(subset.begin(), subset.end(), whole_.last) ? 1
                                                                                                                   : 0);
        }
        return std::move(dfa_);
    }

  private:
    void find_columns(std::size_t class_count) {
        const auto& symbols = nfa_.symbols();
        std::map<std::vector<bool>, std::uint16_t> seen;
        for (std::size_t k = 0; k < class_count; ++k) {
            std::vector<bool> signature(symbols.size());
            for (std::size_t s = 0; s < symbols.size(); ++s) { signature[s] = symbols[s][k]; }
            const auto [place, fresh] = seen.emplace(signature, static_cast<std::uint16_t>(symbol_in_column_.size()));
            if (fresh) { symbol_in_column_.push_back(std::move(signature)); }
            dfa_.column_of_class.push_back(place->second);
        }
        dfa_.columns = symbol_in_column_.size();
        state_cap_ = std::min(state_cap_, limits::table_entries / std::max<std::size_t>(dfa_.columns, 1));
    }

    void begin_subset() {
        ++round_;
        subset_.clear();
    }

    void close(std::uint32_t state) {
        pending_.push_back(state);
        while (!pending_.empty()) {
            const std::uint32_t at = pending_.back();
            pending_.pop_back();
            if (stamp_[at] == round_) { continue; }
            stamp_[at] = round_;
            work_.spend(1);
            const NfaState& entry = nfa_.states()[at];
            if (entry.symbol != none || at == whole_.last) { subset_.push_back(at); }
            for (const std::uint32_t next : entry.silent) {
                if (next != none) { pending_.push_back(next); }
            }
        }
    }

    std::vector<std::uint32_t> take_subset() {
        std::sort(subset_.begin(), subset_.end());
        return subset_;
    }

    std::uint32_t number(std::vector<std::uint32_t> subset) {
        const auto [place, fresh] = number_.emplace(std::move(subset), static_cast<std::uint32_t>(order_.size()));
        if (fresh) {
            elements_ += place->first.size();
            if (order_.size() >= state_cap_ || elements_ > limits::subset_elements) {
                fail("the expression needs more than " + std::to_string(order_.size()) + " states",
                     "patterns like .*D.{20} double the states with every step; use smaller repetition counts");
            }
            order_.push_back(&place->first);
        }
        return place->second;
    }

    const Nfa& nfa_;
    Fragment whole_;
    WorkMeter& work_;
    std::size_t state_cap_;
    std::vector<std::uint64_t> stamp_;
    std::uint64_t round_ = 0;
    std::vector<std::uint32_t> subset_, pending_;
    std::vector<std::vector<bool>> symbol_in_column_;
    std::unordered_map<std::vector<std::uint32_t>, std::uint32_t, SubsetHash> number_;
    std::vector<const std::vector<std::uint32_t>*> order_;
    std::size_t elements_ = 0;
    Dfa dfa_;
};

Dfa required(std::optional<Dfa> dfa, WorkMeter& work) {
    if (!dfa) {
        fail("an operand of '&', '-' or '!' needs more than " + std::to_string(limits::boolean_states) + " states",
             "use smaller repetition counts");
    }
    work.spend(10 * dfa->next.size());
    return minimized(*dfa);
}

/// The automaton of every word over the universe's classes.
Dfa all_path_strings(const ClassLookup& lookup) {
    Dfa dfa;
    for (std::size_t k = 0; k < lookup.classes->count(); ++k) {
        dfa.column_of_class.push_back((*lookup.universe)[k] ? 1 : 0);
    }
    dfa.columns = 2;
    dfa.next = {0, 0, 0, 1};
    dfa.output = {0, 1};
    dfa.start = 1;
    return dfa;
}

Dfa build_node(const Node& root, const ClassLookup& lookup, std::size_t state_cap, Nfa::Cache& cache) {
    Nfa nfa(lookup, state_cap, cache);
    if (root.kind == NodeKind::complement || root.kind == NodeKind::intersection || root.kind == NodeKind::difference) {
        return nfa.build_boolean(root);
    }
    const Fragment whole = nfa.build(root);
    const Dfa dfa = Determinizer(nfa, whole, lookup, state_cap).run();
    lookup.work->spend(10 * dfa.next.size());
    return minimized(dfa);
}

const Dfa& Nfa::build_boolean(const Node& node) {
    const auto known = cache_.find(&node);
    if (known != cache_.end()) { return known->second; }
    Dfa first = build_node(*node.children.front(), lookup_, state_cap_, cache_);
    Dfa second;
    Combination combination = difference_of();
    if (node.kind == NodeKind::complement) {
        second = std::exchange(first, all_path_strings(lookup_));
    } else {
        second = build_node(*node.children.back(), lookup_, state_cap_, cache_);
        combination = node.kind == NodeKind::intersection ? intersection_of() : difference_of();
    }
    Dfa result = required(product(first, second, combination, limits::boolean_states), *lookup_.work);
    return cache_.emplace(&node, std::move(result)).first->second;
}

}  // namespace

void WorkMeter::spend(std::size_t steps) {
    spent_ += steps;
    if (spent_ > limits::work_steps) {
        fail("the expression is too complex to compile", "use smaller repetition counts and fewer operators");
    }
}

Dfa build_dfa(const Node& root, const ClassLookup& lookup, std::size_t state_cap) {
    Nfa::Cache cache;
    return build_node(root, lookup, state_cap, cache);
}

}  // namespace raylex::lpe
