#include "experiments/job/channels/label_warnings.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include "display/services/parameters.h"
#include "experiments/job/channels/named_labels.h"
#include "lpe/language/glob.h"

namespace raylex::experiments {
namespace {

using enum NamedLabel::Role;

/// A label of the expressions: its possible roles, and the channels that use it.
struct Use {
    std::set<NamedLabel::Role> roles;
    bool glob = false;
    std::vector<std::string> channels;
};

std::string without_digits(std::string text) {
    std::erase_if(text, [](unsigned char c) { return std::isdigit(c) != 0; });
    return text;
}

/// Returns whether one typing error turns `a` into `b`: a letter too many, missing, wrong or in another case, or two
/// exchanged. Names that differ in a number or a one-letter ending (key_L, key_R) are different on purpose.
bool one_edit(const std::string& a, const std::string& b) {
    if (a == b || without_digits(a) == without_digits(b)) return false;
    if (lower_case(a) == lower_case(b)) return true;
    if (std::min(a.size(), b.size()) < 3) return false;
    const auto [from_a, from_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
    const std::string rest_a(from_a, a.end()), rest_b(from_b, b.end());
    const bool ending = std::max(rest_a.size(), rest_b.size()) <= 1;
    if (ending && from_a != a.begin() && (*(from_a - 1) == '_' || *(from_a - 1) == '.')) return false;
    if (rest_a.size() == rest_b.size()) {
        if (ending || rest_a.substr(1) == rest_b.substr(1)) return true;
        return rest_a[0] == rest_b[1] && rest_a[1] == rest_b[0] && rest_a.substr(2) == rest_b.substr(2);
    }
    return rest_a.size() == rest_b.size() + 1 ? rest_a.substr(1) == rest_b
                                              : rest_a == rest_b.substr(std::min<std::size_t>(1, rest_b.size()));
}

bool share_a_role(const Use& a, const Use& b) {
    return std::any_of(a.roles.begin(), a.roles.end(), [&](auto role) { return b.roles.count(role) != 0; });
}

std::string named_in(const Use& use) {
    std::string text = "channel '" + use.channels.front() + "'";
    if (use.channels.size() == 2) text += " and '" + use.channels[1] + "'";
    if (use.channels.size() > 2) text += " and " + std::to_string(use.channels.size() - 1) + " more";
    return text;
}

bool is_known(const std::string& label, const Use& use, const std::set<std::string>& names) {
    if (!use.glob) return names.count(label) != 0;
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return lpe::glob_matches(label, name); });
}

/// Checks a label against the lists. Returns nothing if there is no list for its roles.
std::optional<std::string> unknown_text(const std::string& label, const Use& use, const KnownLabels& known) {
    std::set<std::string> names;
    std::string what;
    for (const NamedLabel::Role role : use.roles) {
        const auto& list = role == group ? known.groups : known.labels;
        if (role == lobe || !list) return std::nullopt;
        names.insert(list->begin(), list->end());
        what +=
            std::string(what.empty() ? "" : " or ") + (role == group ? "light group of --groups" : "label of --labels");
    }
    if (what.empty() || is_known(label, use, names)) return std::nullopt;
    return "'" + label + "' (" + named_in(use) + ") " + (use.glob ? "matches no " : "is not a ") + what +
           did_you_mean(label, names);
}

std::optional<std::string> mistake_text(const std::string& label, const Use& use,
                                        const std::map<std::string, Use>& uses) {
    if (use.glob || use.roles == std::set<NamedLabel::Role>{lobe}) return std::nullopt;
    for (const auto& [other, others] : uses) {
        // Half of the other name's channels at most, and at least two of those: less is not enough evidence.
        const bool rare = others.channels.size() >= 2 && others.channels.size() >= 2 * use.channels.size();
        if (!rare || others.glob || !share_a_role(use, others) || !one_edit(label, other)) continue;
        return "'" + label + "' (" + named_in(use) + ") occurs beside '" + other + "' in " +
               std::to_string(others.channels.size()) + " channels; did you mean '" + other + "'?";
    }
    return std::nullopt;
}

}  // namespace

Result<std::vector<std::string>> label_warnings(std::span<const lpe::ChannelSource> channels,
                                                const KnownLabels& known) {
    std::map<std::string, Use> uses;
    for (const lpe::ChannelSource& channel : channels) {
        auto labels = labels_of(channel);
        if (!labels) return labels.error();
        for (const NamedLabel& label : *labels) {
            Use& use = uses[label.text];
            use.roles.insert(label.roles.begin(), label.roles.end());
            use.glob = use.glob || label.glob;
            if (use.channels.empty() || use.channels.back() != channel.name) use.channels.push_back(channel.name);
        }
    }
    std::vector<std::string> warnings;
    for (const auto& [label, use] : uses) {
        auto text = unknown_text(label, use, known);
        if (!text) text = mistake_text(label, use, uses);
        if (text) warnings.push_back(std::move(*text));
    }
    return warnings;
}

}  // namespace raylex::experiments
