#include "lpe/automata/groups.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "lpe/automata/bit_parallel.h"
#include "lpe/automata/languages.h"
#include "lpe/automata/liveness_table.h"
#include "lpe/failure.h"

namespace raylex::lpe {

namespace {

/// Unites the lists of two groups; each union once.
struct ListMerger {
    const std::vector<ChannelList>& left;
    const std::vector<ChannelList>& right;
    std::vector<ChannelList> merged{{}};
    std::unordered_map<std::uint64_t, std::uint32_t> index{{0, 0}};

    static std::uint32_t combine(void* context, std::uint32_t a, std::uint32_t b) {
        auto& self = *static_cast<ListMerger*>(context);
        const auto [place, fresh] =
            self.index.emplace(static_cast<std::uint64_t>(a) << 32 | b, static_cast<std::uint32_t>(self.merged.size()));
        if (fresh) {
            ChannelList list;
            std::merge(self.left[a].begin(), self.left[a].end(), self.right[b].begin(), self.right[b].end(),
                       std::back_inserter(list));
            self.merged.push_back(std::move(list));
        }
        return place->second;
    }
};

std::optional<Group> merged(const Group& a, const Group& b, std::size_t state_cap) {
    ListMerger merger{a.lists, b.lists};
    std::optional<Dfa> dfa = product(a.dfa, b.dfa, {ListMerger::combine, &merger, false, false}, state_cap);
    if (!dfa) { return std::nullopt; }
    return Group{std::move(*dfa), std::move(merger.merged)};
}

/// All states of six bits. Such a table, 64 states of 32 classes in 8 KiB, stays in the first-level cache.
constexpr std::size_t small_states = 64;
/// Two tables or fewer are the best grouping: bit-parallel automata take at least two words, their phase and one more.
constexpr std::size_t fewest_words = 2;

/// Most states of a product that grows like a sum: two bits more than both sides take side by side.
std::size_t proportionate(const Group& a, const Group& b) {
    return 4 * (a.dfa.states() + b.dfa.states() + small_states);
}

/// Joins the automaton to the table if that takes clearly less than one bit there, the least that it takes elsewhere.
bool join_cheaply(Group& table, const Group& automaton, const CompileOptions& options) {
    const std::size_t states = table.dfa.states();
    std::optional<Group> both =
        merged(table, automaton, std::min(options.state_cap, states + states / 2 + small_states));
    if (both) { table = std::move(*both); }
    return both.has_value();
}

/// Nothing as soon as some part of the tree needs more than `most` groups.
std::optional<std::vector<Group>> merge_balanced(std::span<const Group> leaves, std::size_t state_cap,
                                                 std::size_t most) {
    if (leaves.size() <= 1) { return std::vector<Group>(leaves.begin(), leaves.end()); }
    std::optional<std::vector<Group>> groups = merge_balanced(leaves.first(leaves.size() / 2), state_cap, most);
    if (!groups) { return std::nullopt; }
    std::optional<std::vector<Group>> others = merge_balanced(leaves.subspan(leaves.size() / 2), state_cap, most);
    if (!others) { return std::nullopt; }
    for (Group& right : *others) {
        bool placed = false;
        for (Group& left : *groups) {
            std::optional<Group> both = merged(left, right, std::min(state_cap, proportionate(left, right)));
            if (both) {
                left = std::move(*both);
                placed = true;
                break;
            }
        }
        if (!placed) { groups->push_back(std::move(right)); }
        if (groups->size() > most) { return std::nullopt; }
    }
    return groups;
}

/// Merges the smallest groups, now up to the cap itself, until `wanted` are left or nothing fits.
void merge_smallest(std::vector<Group>& groups, std::size_t wanted, std::size_t state_cap) {
    const auto smaller = [](const Group& a, const Group& b) { return a.dfa.states() < b.dfa.states(); };
    std::sort(groups.begin(), groups.end(), smaller);
    for (std::size_t i = 0; i + 1 < groups.size() && groups.size() > wanted;) {
        std::optional<Group> both;
        for (std::size_t k = i + 1; k < groups.size() && !both; ++k) {
            both = merged(groups[i], groups[k], state_cap);
            if (both) {
                groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(k));
                groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(i));
            }
        }
        if (!both) {
            ++i;
            continue;
        }
        groups.insert(std::upper_bound(groups.begin(), groups.end(), *both, smaller), std::move(*both));
    }
}

std::string channel_names(const Group& group, std::span<const ChannelSource> channels) {
    std::set<std::uint16_t> inside;
    for (const ChannelList& list : group.lists) { inside.insert(list.begin(), list.end()); }
    std::string names;
    std::size_t count = 0;
    for (const std::uint16_t k : inside) {
        if (++count <= 4) { names += (names.empty() ? "" : ", ") + channels[k].name; }
    }
    return count > 4 ? names + " and " + std::to_string(count - 4) + " more" : names;
}

[[noreturn]] void fail_groups(const Grouping& grouping, std::span<const ChannelSource> channels,
                              const CompileOptions& options) {
    std::string list;
    for (const Group& group : grouping.tables) {
        list += "\n  " + std::to_string(group.dfa.states()) + " states: " + channel_names(group, channels);
    }
    if (!grouping.parallel.empty()) {
        list += "\n  and " + std::to_string(grouping.parallel.size()) + " bit-parallel automata";
    }
    fail("these channels need " + std::to_string(grouping.tables.size()) + " groups of at most " +
             std::to_string(options.state_cap) + " states; " + std::to_string(options.group_cap) + " are allowed",
         "expressions such as C.*X.* multiply with one another; use fewer of them at a time:" + list);
}

/// The states between camera and terminal, without the dead one, in breadth-first order; `dies`: some of them, or the
/// camera event, may lead to the dead state. Stops above `most`.
std::vector<std::uint32_t> interior_states(const Dfa& dfa, const std::vector<ClassRole>& roles, std::size_t most,
                                           bool& dies) {
    std::vector<std::uint16_t> camera, scattering;
    for (std::size_t k = 0; k < roles.size(); ++k) {
        if (roles[k] == ClassRole::camera || roles[k] == ClassRole::scattering) {
            (roles[k] == ClassRole::camera ? camera : scattering).push_back(dfa.column_of_class[k]);
        }
    }
    for (std::vector<std::uint16_t>* columns : {&camera, &scattering}) {
        std::sort(columns->begin(), columns->end());
        columns->erase(std::unique(columns->begin(), columns->end()), columns->end());
    }
    std::vector<std::uint32_t> states;
    std::vector<bool> seen(dfa.states(), false);
    const auto visit = [&](std::uint32_t state) {
        dies = dies || state == 0;
        if (state != 0 && !seen[state]) {
            seen[state] = true;
            states.push_back(state);
        }
    };
    for (const std::uint16_t column : camera) { visit(dfa.next[dfa.start * dfa.columns + column]); }
    for (std::size_t i = 0; i < states.size() && states.size() <= most; ++i) {
        for (const std::uint16_t column : scattering) { visit(dfa.next[states[i] * dfa.columns + column]); }
    }
    return states;
}

/// What a channel waits for late on the path: for each state that it can stay in, the events that end the stay.
/// Channels multiply with one another by as many of these as differ among them; those that wait for the same events
/// move together.
class LateExits {
  public:
    using Signature = std::set<std::uint32_t>;

    explicit LateExits(const std::vector<ClassRole>& roles) : roles_(roles) {
        for (std::size_t k = 0; k < roles.size(); ++k) {
            if (roles[k] == ClassRole::scattering) { scatterings_.push_back(static_cast<EventClass>(k)); }
        }
    }

    Signature of(const Dfa& dfa) {
        bool dies = false;
        constexpr std::size_t most = 64;
        const std::vector<std::uint32_t> states = interior_states(dfa, roles_, most, dies);
        Signature signature;
        if (states.size() > most) { return signature; }  // far too large for bits, whatever it waits for
        // States of the table are numbered as in `states`, from 1 on. A state is on a cycle if it leads to itself.
        std::unordered_map<std::uint32_t, State> index{{0, 0}};
        StateSets itself(states.size() + 1);
        for (std::size_t i = 0; i < states.size(); ++i) {
            index.emplace(states[i], static_cast<State>(i + 1));
            itself[i + 1] = std::uint64_t{1} << i;
        }
        const LivenessTable table(
            itself.size(), [&](State from, EventClass event) { return index.at(dfa.step(states[from - 1], event)); });
        const StateSets follows = table.before(scatterings_, table.eventually(scatterings_, std::move(itself)));
        for (std::size_t i = 0; i < states.size(); ++i) {
            std::vector<EventClass> exits;
            for (const EventClass event : scatterings_) {
                if (dfa.step(states[i], event) != states[i]) { exits.push_back(event); }
            }
            if ((follows[i + 1] >> i & 1U) == 0 || exits.empty()) { continue; }
            signature.insert(index_.emplace(std::move(exits), static_cast<std::uint32_t>(index_.size())).first->second);
        }
        return signature;
    }

  private:
    const std::vector<ClassRole>& roles_;
    std::vector<EventClass> scatterings_;
    std::map<std::vector<EventClass>, std::uint32_t> index_;
};

/// Channels that wait for the same events, multiplied into automata of few states.
struct Family {
    std::vector<std::size_t> members;
    std::vector<Group> parallel;  ///< empty if some member has too many states
    bool wide = true;             ///< takes three bits or more
};

/// Events before the terminal on which every automaton dies (such as user events that none names) end the whole path,
/// so that no automaton needs a code for the dead state because of them.
std::vector<ClassRole> without_deadly(const std::vector<Group>& automata, std::vector<ClassRole> roles) {
    std::vector<bool> always_dies(roles.size());
    for (std::size_t k = 0; k < roles.size(); ++k) {
        always_dies[k] = roles[k] == ClassRole::scattering || roles[k] == ClassRole::camera;
    }
    for (const Group& automaton : automata) {
        bool dies = false;
        for (const std::uint32_t state : interior_states(automaton.dfa, roles, code_limit, dies)) {
            for (std::size_t k = 0; k < roles.size(); ++k) {
                const std::uint32_t from = roles[k] == ClassRole::camera ? automaton.dfa.start : state;
                always_dies[k] = always_dies[k] && automaton.dfa.step(from, static_cast<EventClass>(k)) == 0;
            }
        }
    }
    for (std::size_t k = 0; k < roles.size(); ++k) { roles[k] = always_dies[k] ? ClassRole::nowhere : roles[k]; }
    return roles;
}

/// Tries three ways to divide the families between tables and bit-parallel automata.
class Packer {
  public:
    Packer(std::span<const Group> leaves, const std::vector<ClassRole>& roles, const CompileOptions& options)
        : leaves_(leaves), roles_(roles), options_(options) {}

    Grouping run() {
        sort_into_families();
        // Wide families go to tables, with those that wait for nothing else than these do.
        LateExits::Signature waited_for;
        for (const auto& [signature, family] : families_) {
            if (family.wide) { waited_for.insert(signature.begin(), signature.end()); }
        }
        Grouping best = built([&](const LateExits::Signature& signature, const Family& family) {
            return family.wide ||
                   std::includes(waited_for.begin(), waited_for.end(), signature.begin(), signature.end());
        });
        // A family doubles a table once, however many members it has: those of one or two are the first to be packed,
        // then all that can be.
        for (const std::size_t most_members : {std::size_t{2}, leaves_.size()}) {
            Grouping other = built([&](const LateExits::Signature&, const Family& family) {
                return family.parallel.empty() || family.members.size() > most_members;
            });
            if (words(other) < words(best)) { best = std::move(other); }
        }
        return best;
    }

  private:
    void sort_into_families() {
        LateExits exits(roles_);
        for (std::size_t k = 0; k < leaves_.size(); ++k) { families_[exits.of(leaves_[k].dfa)].members.push_back(k); }
        for (auto& [signature, family] : families_) {
            const bool all_small = std::all_of(family.members.begin(), family.members.end(), [&](std::size_t k) {
                return !parallel_codes(leaves_[k].dfa, roles_).empty();
            });
            if (!all_small) { continue; }
            for (const std::size_t k : family.members) { add_automaton(family.parallel, leaves_[k]); }
            constexpr std::size_t two_bits = 4;
            family.wide = parallel_codes(family.parallel.front().dfa, roles_).size() > two_bits;
        }
    }

    void add_automaton(std::vector<Group>& automata, const Group& leaf) const {
        if (!automata.empty()) {
            const std::size_t cap = code_limit + 2 + automata.back().lists.size() * 2;  // with start and ends
            std::optional<Group> both = merged(automata.back(), leaf, cap);
            if (both && !parallel_codes(both->dfa, roles_).empty()) {
                automata.back() = std::move(*both);
                return;
            }
        }
        automata.push_back(leaf);
    }

    template <class InTables>
    Grouping built(InTables in_tables) const {
        Grouping grouping;
        std::vector<std::size_t> members;
        for (const auto& [signature, family] : families_) {
            if (in_tables(signature, family)) {
                members.insert(members.end(), family.members.begin(), family.members.end());
            } else {
                grouping.parallel.insert(grouping.parallel.end(), family.parallel.begin(), family.parallel.end());
            }
        }
        std::sort(members.begin(), members.end());
        std::vector<Group> leaves;
        for (const std::size_t k : members) { leaves.push_back(leaves_[k]); }
        grouping.tables = *merge_balanced(leaves, options_.state_cap, leaves.size() + 1);
        grouping.parallel_roles = without_deadly(grouping.parallel, roles_);
        move_to_tables(grouping);
        return grouping;
    }

    /// Automata of several bits that hardly make a table larger cost less there. So do the others, where all their
    /// states together are one small table.
    void move_to_tables(Grouping& grouping) const {
        const auto codes = [&](const Group& automaton) {
            return parallel_codes(automaton.dfa, grouping.parallel_roles).size();
        };
        if (!grouping.tables.empty()) {
            std::erase_if(grouping.parallel, [&](const Group& automaton) {
                return codes(automaton) > 2 && join_cheaply(grouping.tables.front(), automaton, options_);
            });
            grouping.parallel_roles = without_deadly(grouping.parallel, roles_);
        }
        std::size_t states = 1;
        for (const Group& automaton : grouping.parallel) {
            states = std::min(states * std::bit_ceil(codes(automaton)), small_states + 1);
        }
        if (grouping.parallel.empty() || states > small_states || grouping.tables.size() >= options_.group_cap) {
            return;
        }
        if (const auto table = merge_balanced(grouping.parallel, options_.state_cap, 1)) {
            grouping.tables.push_back(table->front());
            grouping.parallel.clear();
        }
    }

    static std::size_t words(const Grouping& grouping) {
        return grouping.tables.size() +
               (grouping.parallel.empty() ? 0 : 1 + parallel_word_count(grouping.parallel, grouping.parallel_roles));
    }

    std::span<const Group> leaves_;
    const std::vector<ClassRole>& roles_;
    const CompileOptions& options_;
    std::map<LateExits::Signature, Family> families_;
};

}  // namespace

std::vector<ClassRole> roles_of(const EventClasses& classes) {
    const PathStringSets sets = renderer_path_string_sets();
    std::vector<ClassRole> roles;
    for (std::size_t k = 0; k < classes.count(); ++k) {
        const Event& event = classes.example(static_cast<EventClass>(k));
        roles.push_back(matches(sets.camera, event)       ? ClassRole::camera
                        : matches(sets.scattering, event) ? ClassRole::scattering
                        : matches(sets.terminal, event)   ? ClassRole::terminal
                                                          : ClassRole::nowhere);
    }
    return roles;
}

std::vector<std::uint32_t> parallel_codes(const Dfa& dfa, const std::vector<ClassRole>& roles) {
    bool dies = false;
    std::vector<std::uint32_t> states = interior_states(dfa, roles, code_limit, dies);
    if (dies || states.empty()) { states.insert(states.begin(), 0); }
    if (states.size() > code_limit) { states.clear(); }
    return states;
}

Grouping group_channels(std::vector<Dfa> dfas, std::span<const ChannelSource> channels,
                        const std::vector<ClassRole>& roles, const CompileOptions& options) {
    std::vector<Group> leaves;
    for (std::size_t k = 0; k < dfas.size(); ++k) {
        leaves.push_back({std::move(dfas[k]), {{}, {static_cast<std::uint16_t>(k)}}});
    }
    Grouping grouping;
    std::vector<Group> alone;
    if (options.first_alone && !leaves.empty()) {
        alone.push_back(std::move(leaves.front()));
        leaves.erase(leaves.begin());
    }
    if (leaves.empty()) {
        grouping.tables = std::move(alone);
        return grouping;
    }
    const std::size_t most = roles.empty() ? leaves.size() + 1 : std::min(fewest_words, options.group_cap);
    if (std::optional<std::vector<Group>> tables = merge_balanced(leaves, options.state_cap, most)) {
        grouping.tables = std::move(*tables);
    } else {
        grouping = Packer(leaves, roles, options).run();
    }
    if (grouping.tables.size() > options.group_cap) {
        merge_smallest(grouping.tables, options.group_cap, options.state_cap);
    }
    if (grouping.tables.size() > options.group_cap) { fail_groups(grouping, channels, options); }
    grouping.tables.insert(grouping.tables.begin(), alone.begin(), alone.end());
    return grouping;
}

bool add_channel(Grouping& grouping, Group channel, const std::vector<ClassRole>& roles,
                 const CompileOptions& options) {
    constexpr std::size_t one_bit = 2;
    bool joins = false;
    for (Group& table : grouping.tables) { joins = joins || join_cheaply(table, channel, options); }
    if (!joins && !roles.empty() && !grouping.parallel.empty()) {
        std::vector<Group> automata = grouping.parallel;
        automata.push_back(channel);
        std::vector<ClassRole> seen = without_deadly(automata, roles);
        const std::size_t codes = parallel_codes(channel.dfa, seen).size();
        if (codes != 0 && codes <= one_bit) {
            grouping.parallel = std::move(automata);
            grouping.parallel_roles = std::move(seen);
            return true;
        }
    }
    if (!joins) {
        if (grouping.tables.size() >= std::min(fewest_words, options.group_cap)) { return false; }
        grouping.tables.push_back(std::move(channel));
    }
    if (!grouping.parallel.empty()) { grouping.parallel_roles = without_deadly(grouping.parallel, roles); }
    return true;
}

}  // namespace raylex::lpe
