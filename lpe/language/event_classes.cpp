#include "lpe/language/event_classes.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "lpe/failure.h"
#include "lpe/language/glob.h"
#include "lpe/limits.h"

namespace raylex::lpe {

struct EventClasses::Reached {
    Alive alive;
    std::size_t position = 0;  // labels read so far
    Event example;             // the event read so far
};

class EventClasses::Builder {
  public:
    Builder(EventClasses& classes, std::vector<EventSet> sets) : classes_(classes), sets_(std::move(sets)) {
        for (std::size_t set = 0; set < sets_.size(); ++set) {
            for (const EventPattern& pattern : sets_[set].any_of) {
                patterns_.push_back({&pattern, static_cast<std::uint32_t>(set), false});
            }
            for (const EventPattern& pattern : sets_[set].none_of) {
                patterns_.push_back({&pattern, static_cast<std::uint32_t>(set), true});
            }
        }
        for (const Entry& entry : patterns_) { deepest_ = std::max(deepest_, entry.pattern->labels.size()); }
    }

    void run() {
        class_of_sets_.emplace(std::vector<std::uint32_t>{}, 0);  // the class that nothing matches
        classes_.examples_.push_back(core_event(core_count - user_numbers));
        classes_.table_.node_of_core.resize(core_count);
        for (std::size_t core = 0; core < core_count; ++core) {
            Alive alive;
            for (std::uint32_t k = 0; k < patterns_.size(); ++k) {
                if (patterns_[k].pattern->cores.test(core)) { alive.push_back(k); }
            }
            classes_.table_.node_of_core[core] = reach({std::move(alive), 0, core_event(core)}, false);
        }
        for (std::size_t node = 0; node < reached_.size(); ++node) { expand(node); }
        classes_.members_.assign(sets_.size(), ClassSet(classes_.count(), false));
        for (const auto& [sets, event_class] : class_of_sets_) {
            for (const std::uint32_t set : sets) { classes_.members_[set][event_class] = true; }
        }
    }

  private:
    struct Entry {
        const EventPattern* pattern;
        std::uint32_t set;
        bool excludes;
    };

    /// The node for a set of live patterns; creates it if it is new. An event cannot end directly after an empty label.
    std::uint32_t reach(Reached reached, bool after_empty) {
        auto key = std::make_pair(std::make_pair(std::min(reached.position, deepest_), after_empty), reached.alive);
        const auto [place, fresh] = node_of_.emplace(std::move(key), static_cast<std::uint32_t>(reached_.size()));
        if (fresh) {
            ClassTable::Node node;
            if (!after_empty) { node.end_class = end_class(reached); }
            classes_.table_.nodes.push_back(node);
            reached_.push_back(std::move(reached));
        }
        return place->second;
    }

    std::uint32_t end_class(const Reached& reached) {
        std::vector<std::uint32_t> admitted;
        std::vector<std::uint32_t> excluded;
        for (const std::uint32_t k : reached.alive) {
            if (accepts_at_end(*patterns_[k].pattern, reached.position)) {
                (patterns_[k].excludes ? excluded : admitted).push_back(patterns_[k].set);
            }
        }
        std::vector<std::uint32_t> sets;
        std::set_difference(admitted.begin(), admitted.end(), excluded.begin(), excluded.end(),
                            std::back_inserter(sets));
        // set_difference counts repetitions, but a set that is admitted twice and excluded once must be excluded.
        sets.erase(std::unique(sets.begin(), sets.end()), sets.end());
        std::erase_if(sets,
                      [&](std::uint32_t set) { return std::binary_search(excluded.begin(), excluded.end(), set); });
        const auto [place, fresh] =
            class_of_sets_.emplace(std::move(sets), static_cast<std::uint32_t>(classes_.count()));
        if (fresh) {
            if (classes_.count() >= limits::event_classes) {
                fail("the expressions distinguish more than " + std::to_string(limits::event_classes) +
                         " kinds of events",
                     "name fewer labels, or compile the channels in several sets");
            }
            classes_.examples_.push_back(reached.example);
        }
        return place->second;
    }

    static bool accepts_at_end(const EventPattern& pattern, std::size_t position) {
        for (std::size_t slot = position; slot < pattern.labels.size(); ++slot) {
            if (pattern.missing == Missing::refuses || !pattern.labels[slot].matches({})) { return false; }
        }
        return true;
    }

    static bool accepts_label(const EventPattern& pattern, std::size_t position, const std::string& label) {
        if (position < pattern.labels.size()) { return pattern.labels[position].matches(label); }
        switch (pattern.extra) {
            case Extra::ignored:
                return true;
            case Extra::refused:
                return false;
            case Extra::unreserved:
                break;
        }
        return !std::binary_search(reserved_names().begin(), reserved_names().end(), label);
    }

    void expand(std::size_t index) {
        const Reached here = reached_[index];
        std::set<std::string> names{std::string()};
        std::set<std::string> globs;
        bool leaf = true;
        for (const std::uint32_t k : here.alive) {
            const EventPattern& pattern = *patterns_[k].pattern;
            leaf = leaf && here.position >= pattern.labels.size() && pattern.extra == Extra::ignored;
            if (here.position < pattern.labels.size()) {
                names.insert(pattern.labels[here.position].names.begin(), pattern.labels[here.position].names.end());
                globs.insert(pattern.labels[here.position].globs.begin(), pattern.labels[here.position].globs.end());
            } else if (pattern.extra == Extra::unreserved) {
                names.insert(reserved_names().begin(), reserved_names().end());
            }
        }
        if (leaf) {
            if (!here.example.labels.empty() && here.example.labels.back().empty()) {
                // No event ends here, but classify() does: the labels after the empty one change nothing.
                Reached ended = here;
                ended.example.labels.emplace_back("other");
                const std::uint32_t end = end_class(ended);
                classes_.table_.nodes[index].end_class = end;
            }
            return;
        }
        // step() can add nodes, so the arrays of the table are filled after all steps from this node.
        std::vector<std::pair<std::string, std::uint32_t>> named;
        for (const std::string& name : names) { named.emplace_back(name, step(here, name)); }
        std::vector<std::pair<std::vector<bool>, std::uint32_t>> kinds;
        const std::vector<std::string> glob_list(globs.begin(), globs.end());
        if (glob_list.empty()) {
            std::string other = "other";
            for (int k = 2; names.count(other) != 0; ++k) { other = "other" + std::to_string(k); }
            kinds.emplace_back(std::vector<bool>{}, step(here, other));
        } else {
            for (const LabelKind& kind : label_kinds(glob_list, {names.begin(), names.end()})) {
                kinds.emplace_back(kind.globs_matched, step(here, kind.example));
            }
        }
        write_node(index, named, glob_list, kinds);
    }

    void write_node(std::size_t index, const std::vector<std::pair<std::string, std::uint32_t>>& named,
                    const std::vector<std::string>& globs,
                    const std::vector<std::pair<std::vector<bool>, std::uint32_t>>& kinds) {
        ClassTable& table = classes_.table_;
        ClassTable::Node& node = table.nodes[index];
        const auto count = [](const auto& list) { return static_cast<std::uint32_t>(list.size()); };
        node = {node.end_class,     0,           count(table.names), count(named), count(table.globs), count(globs),
                count(table.kinds), count(kinds)};
        for (const auto& [name, target] : named) { table.names.push_back({text(name), target}); }
        for (const std::string& glob : globs) { table.globs.push_back(text(glob)); }
        for (const auto& [matched, target] : kinds) {
            table.kinds.push_back({count(table.matches), target});
            table.matches.insert(table.matches.end(), matched.begin(), matched.end());
        }
    }

    std::uint32_t text(const std::string& added) {
        const auto known = text_index_.find(added);
        return known != text_index_.end() ? known->second
                                          : text_index_.emplace(added, classes_.table_.add_text(added)).first->second;
    }

    std::uint32_t step(const Reached& here, const std::string& label) {
        work_ += here.alive.size() + 1;
        if (work_ > limits::label_tests) {
            fail("the expressions name too many labels", "compile the channels in several sets");
        }
        Reached next{{}, here.position + 1, here.example};
        for (const std::uint32_t k : here.alive) {
            if (accepts_label(*patterns_[k].pattern, here.position, label)) { next.alive.push_back(k); }
        }
        next.example.labels.push_back(label);
        return reach(std::move(next), label.empty());
    }

    EventClasses& classes_;
    std::vector<EventSet> sets_;
    std::vector<Entry> patterns_;
    std::size_t deepest_ = 0;
    std::size_t work_ = 0;
    std::vector<Reached> reached_;
    std::map<std::pair<std::pair<std::size_t, bool>, Alive>, std::uint32_t> node_of_;
    std::map<std::vector<std::uint32_t>, std::uint32_t> class_of_sets_;
    std::unordered_map<std::string, std::uint32_t> text_index_;
};

EventClasses::EventClasses(std::vector<EventSet> sets) {
    Builder(*this, std::move(sets)).run();
}

}  // namespace raylex::lpe
