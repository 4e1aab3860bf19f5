#include "experiments/job/channels/named_labels.h"

#include <algorithm>

#include "display/services/parameters.h"
#include "lpe/failure.h"
#include "lpe/language/parser/parser.h"

namespace raylex::experiments {
namespace {

using enum NamedLabel::Role;
using Role = NamedLabel::Role;

/// Returns whether an event can occur. <.S'x'> means scattering, because lights do not scatter.
bool happens(const lpe::Event& event) {
    const bool scatters = event.type == lpe::EventType::reflection || event.type == lpe::EventType::transmission;
    return scatters == (event.scatter != lpe::Scatter::none);
}

std::set<Role> roles_of(const lpe::CoreSet& cores, std::size_t slot) {
    std::set<Role> roles;
    for (std::size_t core = 0; core < lpe::core_count; ++core) {
        if (!cores.test(core)) continue;
        const lpe::Event event = lpe::core_event(core);
        if (!happens(event)) continue;
        switch (event.type) {
            case lpe::EventType::camera:
                break;
            case lpe::EventType::light:
            case lpe::EventType::background:
            case lpe::EventType::emission:
                if (slot == 0) roles.insert(group);
                break;
            default:
                if (slot < 2) roles.insert(slot == 0 ? object : lobe);
        }
    }
    return roles;
}

/// Returns the possible roles of a label. osl compares a label with every symbol of an event, also the letters of its
/// type and scattering, so any role of such events is possible.
std::set<Role> roles_of(const lpe::EventPattern& pattern, std::size_t slot, lpe::Dialect dialect) {
    if (dialect == lpe::Dialect::renderman) return roles_of(pattern.cores, slot);
    std::set<Role> roles = roles_of(pattern.cores, 0);
    roles.merge(roles_of(pattern.cores, 1));
    return roles;
}

void collect(const lpe::Node& node, lpe::Dialect dialect, std::vector<NamedLabel>& labels) {
    const std::vector<std::string>& letters = lpe::reserved_names();
    const auto is_label = [&](const std::string& name) {
        return !name.empty() &&
               (dialect == lpe::Dialect::renderman || !std::binary_search(letters.begin(), letters.end(), name));
    };
    for (const auto* patterns : {&node.events.any_of, &node.events.none_of})
        for (const lpe::EventPattern& pattern : *patterns)
            for (std::size_t slot = 0; slot < pattern.labels.size(); ++slot) {
                const std::set<Role> roles = roles_of(pattern, slot, dialect);
                for (const std::string& name : pattern.labels[slot].names)
                    if (is_label(name)) labels.push_back({name, false, roles});
                for (const std::string& glob : pattern.labels[slot].globs) labels.push_back({glob, true, roles});
            }
    for (const lpe::NodePtr& child : node.children) collect(*child, dialect, labels);
}

}  // namespace

Result<std::vector<NamedLabel>> labels_of(const lpe::ChannelSource& channel) {
    return lpe::guarded([&] {
        std::vector<NamedLabel> labels;
        const lpe::Expression expression = lpe::parse(channel);
        collect(*expression.root, expression.dialect, labels);
        return labels;
    });
}

std::string did_you_mean(const std::string& label, const std::set<std::string>& candidates) {
    std::vector<std::string> list(candidates.begin(), candidates.end());
    std::erase(list, "");
    const std::string near = nearest_name(label, list);
    return near.empty() ? std::string() : "; did you mean '" + near + "'?";
}

}  // namespace raylex::experiments
