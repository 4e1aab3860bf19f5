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

#include "lpe/automata/lanes.h"
#include "lpe/automata/languages.h"
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

/// States up to which a product is in proportion to its parts: sums of a few parts, not their product.
std::size_t proportionate(const Group& a, const Group& b) {
    return 4 * (a.dfa.states() + b.dfa.states()) + 256;
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
    if (!grouping.lanes.empty()) {
        list += "\n  and " + std::to_string(grouping.lanes.size()) + " small automata packed into words";
    }
    fail("these channels need " + std::to_string(grouping.tables.size()) + " groups of at most " +
             std::to_string(options.state_cap) + " states; " + std::to_string(options.group_cap) + " are allowed",
         "expressions such as C.*X.* multiply with one another; use fewer of them at a time:" + list);
}

/// The states between camera and terminal, without the dead one, in breadth-first order; `dies`: some of them, or the
/// camera event, may lead to the dead state. Stops above `most`.
std::vector<std::uint32_t> interior_states(const Dfa& dfa, const std::vector<Place>& places, std::size_t most,
                                           bool& dies) {
    std::vector<std::uint16_t> camera, scattering;
    for (std::size_t k = 0; k < places.size(); ++k) {
        if (places[k] == Place::camera || places[k] == Place::scattering) {
            (places[k] == Place::camera ? camera : scattering).push_back(dfa.column_of_class[k]);
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

/// Which of at most 64 states lie on a cycle of scattering events.
std::vector<bool> recurrent(const Dfa& dfa, const std::vector<Place>& places,
                            const std::vector<std::uint32_t>& states) {
    std::unordered_map<std::uint32_t, std::size_t> index;
    for (std::size_t i = 0; i < states.size(); ++i) { index.emplace(states[i], i); }
    std::vector<std::uint64_t> reach(states.size(), 0);
    for (std::size_t i = 0; i < states.size(); ++i) {
        for (std::size_t k = 0; k < places.size(); ++k) {
            const std::uint32_t to =
                places[k] == Place::scattering ? dfa.step(states[i], static_cast<EventClass>(k)) : 0;
            reach[i] |= to == 0 ? 0 : std::uint64_t{1} << index.at(to);
        }
    }
    for (std::size_t through = 0; through < states.size(); ++through) {  // Warshall's closure
        for (std::uint64_t& row : reach) { row |= (row >> through & 1U) != 0 ? reach[through] : 0; }
    }
    std::vector<bool> on_cycle(states.size());
    for (std::size_t i = 0; i < states.size(); ++i) { on_cycle[i] = (reach[i] >> i & 1U) != 0; }
    return on_cycle;
}

/// What a channel waits for late on the path: for each state that it can stay in, the events that end the stay.
/// Channels multiply with one another by as many of these as differ among them; those that wait for the same events
/// move together.
class LateExits {
  public:
    using Signature = std::set<std::uint32_t>;

    explicit LateExits(const std::vector<Place>& places) : places_(places) {}

    Signature of(const Dfa& dfa) {
        bool dies = false;
        constexpr std::size_t most = 64;
        const std::vector<std::uint32_t> states = interior_states(dfa, places_, most, dies);
        Signature signature;
        if (states.size() > most) {
            return signature;  // far too large for a lane whatever it waits for
        }
        const std::vector<bool> stays = recurrent(dfa, places_, states);
        for (std::size_t i = 0; i < states.size(); ++i) {
            if (!stays[i]) { continue; }
            ClassSet exits(places_.size(), false);
            bool any = false;
            for (std::size_t k = 0; k < places_.size(); ++k) {
                exits[k] =
                    places_[k] == Place::scattering && dfa.step(states[i], static_cast<EventClass>(k)) != states[i];
                any = any || exits[k];
            }
            if (any) {
                signature.insert(
                    index_.emplace(std::move(exits), static_cast<std::uint32_t>(index_.size())).first->second);
            }
        }
        return signature;
    }

  private:
    const std::vector<Place>& places_;
    std::map<ClassSet, std::uint32_t> index_;
};

/// Channels that wait for the same events, multiplied into automata small enough for lanes.
struct Family {
    std::vector<std::size_t> members;
    std::vector<Group> lanes;
    bool all_small = true;  ///< every member fits in a lane
    bool wide = false;      ///< more than one lane of two bits: better in a table, unless tables multiply all the same
};

/// Events before the terminal on which every lane dies (user events that none names, say) end the whole path, so that
/// no lane needs a code for being dead because of them.
std::vector<Place> without_deadly(const std::vector<Group>& lanes, std::vector<Place> places) {
    std::vector<bool> always_dies(places.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
        always_dies[k] = places[k] == Place::scattering || places[k] == Place::camera;
    }
    for (const Group& lane : lanes) {
        bool dies = false;
        for (const std::uint32_t state : interior_states(lane.dfa, places, lane_code_limit, dies)) {
            for (std::size_t k = 0; k < places.size(); ++k) {
                const std::uint32_t from = places[k] == Place::camera ? lane.dfa.start : state;
                always_dies[k] = always_dies[k] && lane.dfa.step(from, static_cast<EventClass>(k)) == 0;
            }
        }
    }
    for (std::size_t k = 0; k < places.size(); ++k) { places[k] = always_dies[k] ? Place::nowhere : places[k]; }
    return places;
}

class LanePacker {
  public:
    LanePacker(std::span<const Group> leaves, const std::vector<Place>& places, const CompileOptions& options)
        : leaves_(leaves), places_(places), options_(options) {}

    Grouping run() {
        sort_into_families();
        Grouping best = built(choose_tables());
        // Where tables multiply all the same, families that stand alone are packed too, then all that can be.
        for (const std::size_t most_members : {std::size_t{2}, leaves_.size()}) {
            constexpr std::size_t fine = 3;
            if (best.tables.size() <= fine) { break; }
            std::vector<std::size_t> in_tables;
            for (auto& [signature, family] : families_) {
                if (!family.all_small || family.members.size() > most_members) {
                    in_tables.insert(in_tables.end(), family.members.begin(), family.members.end());
                }
            }
            Grouping other = built(std::move(in_tables));
            if (words(other) < words(best)) { best = std::move(other); }
        }
        return best;
    }

  private:
    void sort_into_families() {
        LateExits exits(places_);
        for (std::size_t k = 0; k < leaves_.size(); ++k) { families_[exits.of(leaves_[k].dfa)].members.push_back(k); }
        for (auto& [signature, family] : families_) {
            for (const std::size_t k : family.members) {
                family.all_small = family.all_small && !lane_codes(leaves_[k].dfa, places_).empty();
            }
            if (family.all_small) {
                for (const std::size_t k : family.members) { add_lane(family.lanes, leaves_[k]); }
            }
            constexpr std::size_t two_bits = 4;
            family.wide = family.lanes.size() != 1 || lane_codes(family.lanes.front().dfa, places_).size() > two_bits;
        }
    }

    void add_lane(std::vector<Group>& lanes, const Group& leaf) const {
        if (!lanes.empty()) {
            const std::size_t cap = lane_code_limit + 2 + lanes.back().lists.size() * 2;
            std::optional<Group> both = merged(lanes.back(), leaf, cap);
            if (both && !lane_codes(both->dfa, places_).empty()) {
                lanes.back() = std::move(*both);
                return;
            }
        }
        lanes.push_back(leaf);
    }

    /// The channels of wide families, and those that wait for nothing else than these do.
    std::vector<std::size_t> choose_tables() const {
        LateExits::Signature waited_for;
        for (const auto& [signature, family] : families_) {
            if (family.wide) { waited_for.insert(signature.begin(), signature.end()); }
        }
        std::vector<std::size_t> chosen;
        for (const auto& [signature, family] : families_) {
            if (family.wide ||
                std::includes(waited_for.begin(), waited_for.end(), signature.begin(), signature.end())) {
                chosen.insert(chosen.end(), family.members.begin(), family.members.end());
            }
        }
        return chosen;
    }

    Grouping built(std::vector<std::size_t> in_tables) {
        std::sort(in_tables.begin(), in_tables.end());
        Grouping grouping;
        std::vector<Group> leaves;
        for (const std::size_t k : in_tables) { leaves.push_back(leaves_[k]); }
        grouping.tables = *merge_balanced(leaves, options_.state_cap, leaves.size() + 1);
        for (auto& [signature, family] : families_) {
            if (!std::binary_search(in_tables.begin(), in_tables.end(), family.members.front())) {
                grouping.lanes.insert(grouping.lanes.end(), family.lanes.begin(), family.lanes.end());
            }
        }
        grouping.lane_places = without_deadly(grouping.lanes, places_);
        move_wide_lanes(grouping);
        std::size_t bits = 0;
        for (const Group& lane : grouping.lanes) {
            bits += static_cast<std::size_t>(std::bit_width(lane_codes(lane.dfa, grouping.lane_places).size() - 1));
        }
        constexpr std::size_t worth_packing = 6;  // below, a table of at most 2^6 states underway is faster
        if (bits <= worth_packing && !grouping.lanes.empty() && grouping.tables.size() < options_.group_cap) {
            const auto table = merge_balanced(grouping.lanes, options_.state_cap, 1);
            if (table) {
                grouping.tables.push_back(table->front());
                grouping.lanes.clear();
            }
        }
        return grouping;
    }

    /// Lanes of several bits that hardly make a table larger cost less there.
    void move_wide_lanes(Grouping& grouping) const {
        if (grouping.tables.empty()) { return; }
        Group& table = grouping.tables.front();
        std::erase_if(grouping.lanes, [&](const Group& lane) {
            if (lane_codes(lane.dfa, grouping.lane_places).size() <= 2) { return false; }
            const std::size_t states = table.dfa.states();
            std::optional<Group> both = merged(table, lane, std::min(options_.state_cap, states + states / 2 + 64));
            if (both) { table = std::move(*both); }
            return both.has_value();
        });
        grouping.lane_places = without_deadly(grouping.lanes, places_);
    }

    static std::size_t words(const Grouping& grouping) {
        return grouping.tables.size() +
               (grouping.lanes.empty() ? 0 : 1 + lane_word_count(grouping.lanes, grouping.lane_places));
    }

    std::span<const Group> leaves_;
    const std::vector<Place>& places_;
    const CompileOptions& options_;
    std::map<LateExits::Signature, Family> families_;
};

}  // namespace

std::vector<Place> places_of(const EventClasses& classes) {
    const WordSets sets = renderer_word_sets();
    std::vector<Place> places;
    for (std::size_t k = 0; k < classes.count(); ++k) {
        const Event& event = classes.example(static_cast<EventClass>(k));
        places.push_back(matches(sets.camera, event)       ? Place::camera
                         : matches(sets.scattering, event) ? Place::scattering
                         : matches(sets.terminal, event)   ? Place::terminal
                                                           : Place::nowhere);
    }
    return places;
}

std::vector<std::uint32_t> lane_codes(const Dfa& dfa, const std::vector<Place>& places) {
    bool dies = false;
    std::vector<std::uint32_t> states = interior_states(dfa, places, lane_code_limit, dies);
    if (dies || states.empty()) { states.insert(states.begin(), 0); }
    if (states.size() > lane_code_limit) { states.clear(); }
    return states;
}

Grouping group_channels(std::vector<Dfa> dfas, std::span<const ChannelSource> channels,
                        const std::vector<Place>& places, const CompileOptions& options) {
    std::vector<Group> leaves;
    for (std::size_t k = 0; k < dfas.size(); ++k) {
        leaves.push_back({std::move(dfas[k]), {{}, {static_cast<std::uint16_t>(k)}}});
    }
    Grouping grouping;
    if (leaves.empty()) { return grouping; }
    // One or two tables are faster than anything else.
    constexpr std::size_t fast_groups = 2;
    const std::size_t most = places.empty() ? leaves.size() + 1 : std::min(fast_groups, options.group_cap);
    if (std::optional<std::vector<Group>> tables = merge_balanced(leaves, options.state_cap, most)) {
        grouping.tables = std::move(*tables);
    } else {
        grouping = LanePacker(leaves, places, options).run();
    }
    if (grouping.tables.size() > options.group_cap) {
        merge_smallest(grouping.tables, options.group_cap, options.state_cap);
    }
    if (grouping.tables.size() > options.group_cap) { fail_groups(grouping, channels, options); }
    return grouping;
}

bool add_channel(Grouping& grouping, Group channel, const std::vector<Place>& places, const CompileOptions& options) {
    for (Group& table : grouping.tables) {
        const std::size_t states = table.dfa.states();
        const std::size_t hardly_more = states + states / 2 + 4 * channel.dfa.states();
        if (std::optional<Group> both = merged(table, channel, std::min(options.state_cap, hardly_more))) {
            table = std::move(*both);
            if (!grouping.lanes.empty()) { grouping.lane_places = without_deadly(grouping.lanes, places); }
            return true;
        }
    }
    constexpr std::size_t one_bit = 2;
    std::vector<Group> lanes = grouping.lanes;
    if (!places.empty() && !lanes.empty()) {
        lanes.push_back(channel);
        std::vector<Place> lane_places = without_deadly(lanes, places);
        const std::vector<std::uint32_t> codes = lane_codes(channel.dfa, lane_places);
        if (!codes.empty() && codes.size() <= one_bit) {
            grouping.lanes = std::move(lanes);
            grouping.lane_places = std::move(lane_places);
            return true;
        }
    }
    constexpr std::size_t fine_tables = 2;
    if (grouping.tables.size() < std::min(fine_tables, options.group_cap)) {
        grouping.tables.push_back(std::move(channel));
        if (!grouping.lanes.empty()) { grouping.lane_places = without_deadly(grouping.lanes, places); }
        return true;
    }
    return false;
}

}  // namespace raylex::lpe
