// Channels to tables. Every channel becomes a minimal automaton (languages.h); automata are then multiplied together, in
// a balanced tree so that all but the last few products are small. A product of minimal automata that remembers which
// side accepts is minimal itself, so nothing is minimised on the way.
//
// Where channels ask about anything "anywhere" on the path (C.*X.*) the product doubles with each of them. A product that
// grows out of proportion to its parts, or past the state cap, is given up as soon as that shows, and its two sides stay
// separate groups.
#include "lpe/program.h"

#include <algorithm>
#include <map>
#include <unordered_map>
#include <utility>

#include "lpe/failure.h"
#include "lpe/languages.h"
#include "lpe/limits.h"

namespace raylex::lpe {

struct Program::Classifier {
    std::unique_ptr<EventClasses> classes;
    std::vector<EventClass> column_of_class;
};

namespace {

using ChannelList = std::vector<std::uint16_t>;

/// An automaton whose outputs are indices into `lists`.
struct Group {
    Dfa dfa;
    std::vector<ChannelList> lists{{}};
};

/// Unites the lists of two groups; each union once.
struct ListMerger {
    const std::vector<ChannelList>& left;
    const std::vector<ChannelList>& right;
    std::vector<ChannelList> merged{{}};
    std::unordered_map<std::uint64_t, std::uint32_t> index{{0, 0}};

    static std::uint32_t combine(void* context, std::uint32_t a, std::uint32_t b) {
        auto& self = *static_cast<ListMerger*>(context);
        const auto [place, fresh] = self.index.emplace(static_cast<std::uint64_t>(a) << 32 | b,
                                                       static_cast<std::uint32_t>(self.merged.size()));
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
    if (!dfa) {
        return std::nullopt;
    }
    return Group{std::move(*dfa), std::move(merger.merged)};
}

/// States up to which a product is in proportion to its parts: sums of a few parts, not their product.
std::size_t proportionate(const Group& a, const Group& b) { return 4 * (a.dfa.states() + b.dfa.states()) + 256; }

std::vector<Group> merge_balanced(std::vector<Group>& leaves, std::size_t first, std::size_t count, std::size_t state_cap) {
    std::vector<Group> groups;
    if (count == 1) {
        groups.push_back(std::move(leaves[first]));
        return groups;
    }
    groups = merge_balanced(leaves, first, count / 2, state_cap);
    for (Group& right : merge_balanced(leaves, first + count / 2, count - count / 2, state_cap)) {
        bool placed = false;
        for (Group& left : groups) {
            std::optional<Group> both = merged(left, right, std::min(state_cap, proportionate(left, right)));
            if (both) {
                left = std::move(*both);
                placed = true;
                break;
            }
        }
        if (!placed) {
            groups.push_back(std::move(right));
        }
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
    std::vector<bool> inside(channels.size(), false);
    for (const ChannelList& list : group.lists) {
        for (const std::uint16_t k : list) {
            inside[k] = true;
        }
    }
    std::string names;
    std::size_t count = 0;
    for (std::size_t k = 0; k < channels.size(); ++k) {
        if (inside[k] && ++count <= 4) {
            names += (names.empty() ? "" : ", ") + channels[k].name;
        }
    }
    return count > 4 ? names + " and " + std::to_string(count - 4) + " more" : names;
}

std::vector<Group> make_groups(std::vector<Dfa> dfas, std::span<const ChannelSource> channels, const CompileOptions& options) {
    std::vector<Group> leaves;
    for (std::size_t k = 0; k < dfas.size(); ++k) {
        leaves.push_back({std::move(dfas[k]), {{}, {static_cast<std::uint16_t>(k)}}});
    }
    if (leaves.empty()) {
        return leaves;
    }
    std::vector<Group> groups = merge_balanced(leaves, 0, leaves.size(), options.state_cap);
    if (groups.size() > options.group_cap) {
        merge_smallest(groups, options.group_cap, options.state_cap);
    }
    if (groups.size() > options.group_cap) {
        std::string list;
        for (const Group& group : groups) {
            list += "\n  " + std::to_string(group.dfa.states()) + " states: " + channel_names(group, channels);
        }
        fail("these channels need " + std::to_string(groups.size()) + " groups of at most " +
                 std::to_string(options.state_cap) + " states; " + std::to_string(options.group_cap) + " are allowed",
             "expressions such as C.*X.* multiply with one another; use fewer of them at a time:" + list);
    }
    return groups;
}

}  // namespace

/// Lays the groups out as one table.
class ProgramBuilder {
  public:
    static Program build(Languages languages, std::vector<Group> groups) {
        Program program;
        program.classifier_ = std::make_unique<Program::Classifier>();
        Program::Classifier& classifier = *program.classifier_;
        // Classes that every group treats alike share a column.
        std::map<std::vector<std::uint16_t>, EventClass> columns;
        std::vector<std::size_t> class_of_column;
        for (std::size_t k = 0; k < languages.classes->count(); ++k) {
            std::vector<std::uint16_t> key;
            for (const Group& group : groups) {
                key.push_back(group.dfa.column_of_class[k]);
            }
            const auto [place, fresh] = columns.emplace(std::move(key), static_cast<EventClass>(columns.size()));
            if (fresh) {
                class_of_column.push_back(k);
            }
            classifier.column_of_class.push_back(place->second);
        }
        classifier.classes = std::move(languages.classes);
        program.class_count_ = class_of_column.size();
        program.next_state_.assign(program.class_count_, Program::dead);
        program.accept_begin_ = {0, 0};
        for (const Group& group : groups) {
            append(program, group, class_of_column);
        }
        return program;
    }

  private:
    static void append(Program& program, const Group& group, const std::vector<std::size_t>& class_of_column) {
        const auto base = static_cast<State>(program.state_count() - 1);  // state 0 is shared
        const auto global = [base](std::uint32_t state) { return state == 0 ? Program::dead : base + state; };
        program.starts_.push_back(global(group.dfa.start));
        for (std::uint32_t state = 1; state < group.dfa.states(); ++state) {
            for (const std::size_t event_class : class_of_column) {
                program.next_state_.push_back(global(group.dfa.step(state, static_cast<EventClass>(event_class))));
            }
            const ChannelList& list = group.lists[group.dfa.output[state]];
            program.accept_lists_.insert(program.accept_lists_.end(), list.begin(), list.end());
            program.accept_begin_.push_back(static_cast<std::uint32_t>(program.accept_lists_.size()));
        }
    }
};

Program::Program() : class_count_(1), next_state_{dead}, accept_begin_{0, 0} {}
Program::~Program() = default;
Program::Program(Program&&) noexcept = default;
Program& Program::operator=(Program&&) noexcept = default;

Result<Program> Program::compile(std::span<const ChannelSource> channels, const CompileOptions& options) {
    return guarded([&]() -> Program {
        if (channels.size() > 0xFFFF) {
            fail(std::to_string(channels.size()) + " channels; at most 65535 can be compiled together");
        }
        LanguageOptions language_options;
        language_options.state_cap = std::max(options.state_cap, limits::boolean_states);
        language_options.renderer_words = !options.any_word;
        Languages languages = build_languages(channels, language_options);
        std::vector<Group> groups = make_groups(std::move(languages.channels), channels, options);
        return ProgramBuilder::build(std::move(languages), std::move(groups));
    });
}

EventClass Program::classify(const Event& event) const {
    return classifier_ ? classifier_->column_of_class[classifier_->classes->classify(event)] : EventClass{0};
}

}  // namespace raylex::lpe
