#include "lpe/channels/split_bins.h"

#include <algorithm>
#include <utility>

#include "lpe/failure.h"
#include "lpe/language/glob.h"

namespace raylex::lpe {

namespace {

constexpr int most_bounces = 64;

}  // namespace

bool has_axis(const SplitRequest& request, SplitAxis axis) {
    return std::find(request.by.begin(), request.by.end(), axis) != request.by.end();
}

std::string bin_name(const std::string& label, std::vector<std::string>& taken) {
    std::string name;
    for (const char c : label) {
        const bool fits =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
        if (fits) {
            name += c;
        } else if (name.empty() || name.back() != '_') {
            name += '_';
        }
    }
    while (name.size() > 1 && name.back() == '_') { name.pop_back(); }
    if (name.size() > 1 && name.front() == '_' && label.front() != '_') { name.erase(0, 1); }
    const std::string stem = name;
    for (int k = 2; std::find(taken.begin(), taken.end(), name) != taken.end(); ++k) {
        name = stem + "_" + std::to_string(k);
    }
    taken.push_back(name);
    return name;
}

std::string label_text(const std::string& label, Dialect dialect) {
    if (dialect == Dialect::renderman) { return quoted_label(label); }
    if (label.find('\'') != std::string::npos) {
        fail("the label \"" + label + "\" contains a quote, which osl cannot write; expected --dialect renderman");
    }
    return "'" + label + "'";
}

std::string quoted_list(const std::vector<std::string>& labels, Dialect dialect) {
    std::string text;
    for (const std::string& label : labels) { text += label_text(label, dialect); }
    return text;
}

std::vector<std::string> unique_names(const std::vector<std::string>& list, const char* axis, const char* option) {
    std::vector<std::string> result;
    for (const std::string& each : list) {
        if (!each.empty() && std::find(result.begin(), result.end(), each) == result.end()) { result.push_back(each); }
    }
    if (result.empty()) { fail(std::string("a split by ") + axis + " needs names; expected " + option); }
    return result;
}

std::vector<BounceBin> bounce_bins(const SplitRequest& request) {
    if (!has_axis(request, SplitAxis::bounce)) { return {{"", 1, true}}; }
    const int count = request.bounces;
    if (count < 1 || count > most_bounces) {
        fail("the split has " + std::to_string(count) + " bins of bounces; expected 1 to " +
             std::to_string(most_bounces));
    }
    if (count == 2) { return {{"direct", 1, false}, {"indirect", 2, true}}; }
    std::vector<BounceBin> bins;
    for (int k = 1; k <= count; ++k) {
        bins.push_back({"bounce" + std::to_string(k) + (k == count ? "plus" : ""), k, k == count});
    }
    return bins;
}

namespace {

/// A kind of terminal with light groups: its letter before a label, and its expression without a label.
struct LightKind {
    std::string name, letter, plain;
};

/// L and B separately, or together as `lights`. In renderman L includes B; lights alone are the terminals other than B
/// and O.
std::vector<LightKind> light_kinds(const SplitRequest& request) {
    const bool osl = request.dialect == Dialect::osl;
    const bool apart = request.words.background && (osl || has_axis(request, SplitAxis::terminal));
    std::vector<LightKind> kinds(1);
    kinds[0].name = "lights";
    kinds[0].letter = osl || !apart ? "L" : "[^BO]";
    kinds[0].plain = osl ? "L" : apart ? "[^BO]" : "<L.>";
    if (apart) {
        kinds.resize(2);
        kinds[1].name = "background";
        kinds[1].letter = kinds[1].plain = "B";
    }
    return kinds;
}

std::string one_of(const std::vector<std::string>& items) {
    std::string text;
    for (const std::string& item : items) { text += item; }
    return items.size() == 1 ? text : "[" + text + "]";
}

/// Adds the bins of one group: one per kind if the split separates kinds, otherwise one. An empty label: every light.
void add_group(std::vector<TerminalBin>& bins, const SplitRequest& request, const std::string& name,
               const std::string& label, bool with_emission) {
    std::vector<std::string> together;
    const bool by_kind = has_axis(request, SplitAxis::terminal);
    for (const LightKind& kind : light_kinds(request)) {
        const std::string text = label.empty() ? kind.plain : "<" + kind.letter + "." + label + ">";
        if (by_kind) {
            bins.push_back({name, kind.name, text});
        } else {
            together.push_back(text);
        }
    }
    if (with_emission && request.words.emission) {
        if (by_kind) {
            bins.push_back({name, "emission", "O"});
        } else {
            together.emplace_back("O");
        }
    }
    if (!by_kind) { bins.push_back({name, "", one_of(together)}); }
}

}  // namespace

std::vector<TerminalBin> terminal_bins(const SplitRequest& request) {
    std::vector<TerminalBin> bins;
    if (!has_axis(request, SplitAxis::light_group)) {
        add_group(bins, request, "", "", true);
        return bins;
    }
    std::vector<std::string> groups = unique_names(request.groups, "light-group", "--groups key,fill");
    std::erase(groups, "default");  // the bin of that name contains lights with that label anyway
    if (!groups.empty() && request.dialect == Dialect::osl && request.words.unlabelled_lights) {
        fail("osl cannot distinguish lights without a label, so no channel can contain them alone",
             "if every light has a label, add --all-labelled; otherwise use --dialect renderman");
    }
    std::vector<std::string> taken{"default"};
    for (const std::string& group : groups) {
        add_group(bins, request, bin_name(group, taken), label_text(group, request.dialect), false);
    }
    add_group(bins, request, "default", groups.empty() ? "" : "[^" + quoted_list(groups, request.dialect) + "]", true);
    return bins;
}

}  // namespace raylex::lpe
