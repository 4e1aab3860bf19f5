#include "lpe/algebra/wording/event_space.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "lpe/failure.h"
#include "lpe/language/glob.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

/// The label tests of the patterns, slot by slot, and the core sets that distinguish lobe numbers.
struct Tests {
    std::set<std::string> object_names, lobe_names, group_names;
    std::set<std::string> object_globs, lobe_globs, group_globs;
    std::set<std::string> seen;  // keys of event sets that were already read
    std::vector<CoreSet> core_sets;
};

bool has_role(const CoreSet& cores, EventRole role) {
    for (std::size_t core = 0; core < core_count; ++core) {
        if (cores[core] && role_of(core_event(core).type) == role) { return true; }
    }
    return false;
}

void add_test(const LabelTest& test, std::set<std::string>& names, std::set<std::string>& globs) {
    names.insert(test.names.begin(), test.names.end());
    globs.insert(test.globs.begin(), test.globs.end());
}

void add_pattern(const EventPattern& pattern, Tests& tests) {
    if (std::find(tests.core_sets.begin(), tests.core_sets.end(), pattern.cores) == tests.core_sets.end()) {
        tests.core_sets.push_back(pattern.cores);
    }
    if (pattern.labels.empty()) { return; }
    if (has_role(pattern.cores, EventRole::terminal)) {
        add_test(pattern.labels[0], tests.group_names, tests.group_globs);
    }
    if (has_role(pattern.cores, EventRole::scattering) || has_role(pattern.cores, EventRole::user)) {
        add_test(pattern.labels[0], tests.object_names, tests.object_globs);
        if (pattern.labels.size() > 1) { add_test(pattern.labels[1], tests.lobe_names, tests.lobe_globs); }
    }
}

void add_tree(const Node& node, Tests& tests) {
    if (node.kind == NodeKind::event && tests.seen.insert(node.events.key()).second) {
        for (const EventPattern& pattern : node.events.any_of) { add_pattern(pattern, tests); }
        for (const EventPattern& pattern : node.events.none_of) { add_pattern(pattern, tests); }
    }
    for (const NodePtr& child : node.children) { add_tree(*child, tests); }
}

int highest_number(Scatter scatter) {
    return scatter == Scatter::diffuse ? 4 : scatter == Scatter::glossy || scatter == Scatter::singular ? 8 : 0;
}

/// Groups the lobe numbers of a core that every pattern treats alike; the group of the unnumbered lobe comes first.
void add_cores(EventType type, Scatter scatter, const Tests& tests, std::vector<CoreKind>& cores) {
    std::map<std::vector<bool>, std::size_t> known;
    for (int number = 0; number <= highest_number(scatter); ++number) {
        const std::size_t core = core_index({type, scatter, static_cast<std::uint8_t>(number), {}});
        std::vector<bool> answers;
        for (const CoreSet& set : tests.core_sets) { answers.push_back(set[core]); }
        const auto [place, fresh] = known.emplace(std::move(answers), cores.size());
        if (fresh) { cores.push_back({type, scatter, {}}); }
        cores[place->second].numbers.push_back(static_cast<std::uint8_t>(number));
    }
}

Event example(const CoreKind& core, const std::string& first, const std::string& second) {
    return {core.type, core.scatter, core.numbers.front(), {first, second}};
}

}  // namespace

EventRole role_of(EventType type) {
    switch (type) {
        case EventType::camera:
            return EventRole::camera;
        case EventType::reflection:
        case EventType::transmission:
        case EventType::volume:
            return EventRole::scattering;
        case EventType::light:
        case EventType::background:
        case EventType::emission:
            return EventRole::terminal;
        case EventType::user:
            return EventRole::user;
    }
    return EventRole::user;
}

EventSpace::EventSpace(const std::vector<const Node*>& trees) {
    Tests tests;
    for (const Node* tree : trees) { add_tree(*tree, tests); }
    cores_.push_back({EventType::camera, Scatter::none, {0}});
    for (const EventType type : {EventType::reflection, EventType::transmission}) {
        for (const Scatter scatter : {Scatter::diffuse, Scatter::glossy, Scatter::singular}) {
            add_cores(type, scatter, tests, cores_);
        }
    }
    cores_.push_back({EventType::transmission, Scatter::straight, {0}});
    cores_.push_back({EventType::volume, Scatter::none, {0}});
    for (std::uint8_t number = 1; number < user_numbers; ++number) {
        cores_.push_back({EventType::user, Scatter::none, {number}});
    }
    for (const EventType type : {EventType::light, EventType::background, EventType::emission}) {
        cores_.push_back({type, Scatter::none, {0}});
    }
    const auto fill = [](Slot& slot, const std::set<std::string>& names, const std::set<std::string>& globs) {
        slot.globs.assign(globs.begin(), globs.end());
        std::set<std::string> all = names;
        all.insert("");
        for (const std::string& name : all) {
            Value value{name, true, {}};
            for (const std::string& glob : slot.globs) { value.globs.push_back(glob_matches(glob, name)); }
            slot.values.push_back(std::move(value));
        }
        for (LabelKind& kind : label_kinds(slot.globs, {all.begin(), all.end()})) {
            slot.values.push_back({std::move(kind.example), false, std::move(kind.globs_matched)});
        }
    };
    fill(objects_, tests.object_names, tests.object_globs);
    fill(lobes_, tests.lobe_names, tests.lobe_globs);
    fill(groups_, tests.group_names, tests.group_globs);
    none_.values.push_back({"", true, {}});
    if (cores_.size() * objects_.values.size() * lobes_.values.size() > limits::event_points) {
        fail("the expression names too many labels to describe its events in words", "use fewer labels, or globs");
    }
}

EventSpace::Matrix EventSpace::ask(const CoreKind& core, const std::function<Membership(const Event&)>& member) const {
    const EventRole role = role_of(core.type);
    Matrix matrix;
    const bool labelled = role != EventRole::camera;
    for (const Value& first : first_slot(role).values) {
        for (const Value& second : second_slot(role).values) {
            const bool bare = first.example.empty() && second.example.empty();
            matrix.push_back(labelled || bare ? member(example(core, first.example, second.example))
                                              : Membership::never);
        }
    }
    return matrix;
}

std::vector<CoreKind> EventSpace::possible(EventRole role,
                                           const std::function<Membership(const Event&)>& member) const {
    std::vector<CoreKind> kinds;
    for (const CoreKind& core : cores_) {
        if (role_of(core.type) == role) {
            const Matrix matrix = ask(core, member);
            if (std::any_of(matrix.begin(), matrix.end(), [](Membership m) { return m != Membership::never; })) {
                kinds.push_back(core);
            }
        }
    }
    return kinds;
}

std::vector<EventBox> EventSpace::boxes(const std::function<Membership(const Event&)>& member) const {
    std::vector<EventBox> result;
    for (const EventRole role : {EventRole::camera, EventRole::scattering, EventRole::user, EventRole::terminal}) {
        // Group cores that give the same answers about labels; cores that are in the set whatever their labels come
        // first.
        std::vector<std::pair<Matrix, std::vector<CoreKind>>> groups;
        std::vector<CoreKind> whole;
        for (const CoreKind& core : cores_) {
            if (role_of(core.type) != role) { continue; }
            Matrix matrix = ask(core, member);
            const auto count = [&](Membership m) { return std::count(matrix.begin(), matrix.end(), m); };
            if (count(Membership::in) == 0) { continue; }
            if (count(Membership::out) == 0) {
                whole.push_back(core);
                continue;
            }
            const auto same = [&](const auto& group) { return group.first == matrix; };
            const auto known = std::find_if(groups.begin(), groups.end(), same);
            if (known == groups.end()) {
                groups.emplace_back(std::move(matrix), std::vector{core});
            } else {
                known->second.push_back(core);
            }
        }
        if (!whole.empty()) { result.push_back({role, std::move(whole), {}, {}}); }
        for (const auto& [matrix, cores] : groups) { cut(role, cores, matrix, result); }
    }
    // Sort by core, so that L comes before O whatever their labels.
    const auto earlier = [](const EventBox& a, const EventBox& b) {
        const CoreKind& first = a.cores.front();
        const CoreKind& second = b.cores.front();
        return std::tie(a.role, first.type, first.scatter) < std::tie(b.role, second.type, second.scatter);
    };
    std::stable_sort(result.begin(), result.end(), earlier);
    return result;
}

/// Makes one box from all equal rows of the matrix.
void EventSpace::cut(EventRole role, const std::vector<CoreKind>& cores, const Matrix& matrix,
                     std::vector<EventBox>& boxes) const {
    const Slot& first = first_slot(role);
    const Slot& second = second_slot(role);
    const std::size_t width = second.values.size();
    const auto row_possible = [&](std::size_t row) {
        std::vector<bool> flags;
        for (std::size_t column = 0; column < width; ++column) {
            flags.push_back(matrix[row * width + column] != Membership::never);
        }
        return flags;
    };
    std::vector<std::pair<std::vector<bool>, std::vector<bool>>> distinct;  // membership and possibility of equal rows
    std::vector<std::vector<bool>> rows_of;
    std::vector<bool> some_possible(first.values.size());
    for (std::size_t row = 0; row < first.values.size(); ++row) {
        std::vector<bool> possible = row_possible(row);
        some_possible[row] = std::find(possible.begin(), possible.end(), true) != possible.end();
        std::vector<bool> in;
        for (std::size_t column = 0; column < width; ++column) {
            in.push_back(matrix[row * width + column] == Membership::in);
        }
        if (std::find(in.begin(), in.end(), true) == in.end()) { continue; }
        const auto same = [&](const auto& entry) { return entry.first == in; };
        const auto known = std::find_if(distinct.begin(), distinct.end(), same);
        const auto index = static_cast<std::size_t>(known - distinct.begin());
        if (known == distinct.end()) {
            distinct.emplace_back(std::move(in), std::move(possible));
            rows_of.emplace_back(first.values.size(), false);
        }
        rows_of[index][row] = true;
    }
    // Rows whose second label does not matter come first, because they give the shortest text.
    std::vector<std::size_t> order(distinct.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_partition(order.begin(), order.end(),
                          [&](std::size_t k) { return distinct[k].first == distinct[k].second; });
    for (const std::size_t k : order) {
        boxes.push_back({role, cores, choice(first, rows_of[k], some_possible),
                         choice(second, distinct[k].first, distinct[k].second)});
    }
}

LabelChoice EventSpace::choice(const Slot& slot, const std::vector<bool>& in, const std::vector<bool>& possible) {
    LabelChoice result;
    bool rest_in = false;  // labels that no expression names
    bool all = true;
    std::vector<std::size_t> open;  // kinds of labels that differ only in the globs they match
    for (std::size_t k = 0; k < slot.values.size(); ++k) {
        all = all && (in[k] || !possible[k]);
        const Value& value = slot.values[k];
        const bool by_glob = std::find(value.globs.begin(), value.globs.end(), true) != value.globs.end();
        if (value.named && value.example.empty()) {
            result.empty_allowed = in[k];
        } else if (!value.named && !by_glob) {
            rest_in = in[k];
        }
    }
    if (all) { return {}; }
    result.kind = rest_in ? LabelChoice::Kind::except : LabelChoice::Kind::only;
    // List what differs from the rest: first the globs whose labels all differ, then the names that no such glob
    // covers.
    std::vector<bool> listed(slot.values.size(), false);
    const auto differs = [&](std::size_t k) { return in[k] != rest_in; };
    for (std::size_t glob = 0; glob < slot.globs.size(); ++glob) {
        bool whole = true;
        bool some = false;
        for (std::size_t k = 0; k < slot.values.size(); ++k) {
            whole = whole && (!slot.values[k].globs[glob] || differs(k) || !possible[k]);
            some = some || (slot.values[k].globs[glob] && differs(k) && !slot.values[k].named);
        }
        if (whole && some) {
            result.globs.push_back(slot.globs[glob]);
            for (std::size_t k = 0; k < slot.values.size(); ++k) {
                listed[k] = listed[k] || slot.values[k].globs[glob];
            }
        }
    }
    for (std::size_t k = 0; k < slot.values.size(); ++k) {
        if (!listed[k] && differs(k) && !(slot.values[k].named && slot.values[k].example.empty())) {
            result.names.push_back(slot.values[k].example);
        }
    }
    return result;
}

}  // namespace raylex::lpe
