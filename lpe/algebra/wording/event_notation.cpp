// Writes sets of events in the notation of the expression language. event_words.cpp writes them in English.
#include <algorithm>
#include <string>
#include <vector>

#include "lpe/algebra/wording/event_words.h"
#include "lpe/language/glob.h"

namespace raylex::lpe {

namespace {

std::string label_text(const std::string& label, Dialect dialect) {
    return dialect == Dialect::renderman ? quoted_label(label) : "'" + label + "'";
}

/// A label choice in notation: 'floor', ['a''b'], [^'a'] or '.'
std::string slot_text(const LabelChoice& choice, Dialect dialect) {
    if (choice.kind == LabelChoice::Kind::any) { return "."; }
    std::vector<std::string> items;
    for (const std::string& name : choice.names) { items.push_back(label_text(name, dialect)); }
    for (const std::string& glob : choice.globs) { items.push_back("'" + glob + "'"); }
    const bool except = choice.kind == LabelChoice::Kind::except;
    // In renderman a missing label is the empty label. In osl it is no label, and [^'a'] requires some other label. osl
    // has no notation for that, so we write "(.-'a')" and "''".
    const bool only_empty = !except && items.empty();
    const bool any_name = except && items.empty();
    if (dialect == Dialect::renderman ? choice.empty_allowed != except
                                      : only_empty || any_name || (!except && choice.empty_allowed)) {
        items.emplace_back("''");
    }
    if (dialect == Dialect::osl && except && !any_name && choice.empty_allowed) {
        std::string text = "(.";
        for (const std::string& item : items) { text += "-" + item; }
        return text + ")";
    }
    if (!except && items.size() == 1) { return items.front(); }
    std::string text = except ? "[^" : "[";
    for (const std::string& item : items) { text += item; }
    return text + "]";
}

/// A letter with its lobe number, a letter that must match too, and letters that must not match: S, D2, G&S2, S-S2,
/// S-G.
struct Letter {
    std::string text, also;
    std::vector<std::string> without;
};

std::vector<Letter> scatter_letters(const std::vector<Scatter>& scatters, const ScatteringOutline& part,
                                    Dialect dialect) {
    std::vector<Letter> letters;
    if (has_scatter(scatters, Scatter::diffuse)) { letters.push_back({"D", {}, {}}); }
    if (has_scatter(scatters, Scatter::glossy) &&
        !(dialect == Dialect::renderman && has_scatter(scatters, Scatter::singular))) {
        letters.push_back({"G", {}, {}});
    }
    if (has_scatter(scatters, Scatter::singular)) {
        // In renderman S includes glossy lobes; a specular lobe that is not glossy has no letter of its own.
        const bool narrower = dialect == Dialect::renderman && !has_scatter(scatters, Scatter::glossy);
        letters.push_back({"S", {}, narrower ? std::vector<std::string>{"G"} : std::vector<std::string>{}});
    }
    std::vector<Letter> numbered;
    for (const Letter& letter : letters) {
        if (part.numbers.empty() || part.numbers_excluded) { numbered.push_back(letter); }
        for (const std::uint8_t number : part.numbers) {
            const bool glossy = letter.text == "G";  // has no numbers of its own; it uses those of S
            const std::string text = (glossy ? "S" : letter.text) + std::to_string(number);
            if (part.numbers_excluded) {
                numbered.back().without.push_back(text);
            } else {
                numbered.push_back(glossy ? Letter{"G", text, {}} : Letter{text, {}, letter.without});
            }
        }
    }
    return numbered;
}

/// Writes the events of one type: <R[DS]'floor'>, D, (<RS>-<RS2>).
void add_surface(const std::string& type, const std::vector<Scatter>& scatters, const ScatteringOutline& part,
                 const std::string& labels, Dialect dialect, std::vector<std::string>& items) {
    if (scatters.empty()) { return; }
    if (scatters.size() == 3 && part.numbers.empty() && type != ".") {
        items.push_back(labels.empty() ? type : "<" + type + "." + labels + ">");
        return;
    }
    const auto event = [&](const std::string& letter) {
        return type == "." && labels.empty() ? letter : "<" + type + letter + labels + ">";
    };
    std::vector<std::string> plain;
    for (const Letter& letter : scatter_letters(scatters, part, dialect)) {
        if (letter.without.empty() && letter.also.empty()) {
            plain.push_back(letter.text);
            continue;
        }
        items.push_back(event(letter.text));
        if (!letter.also.empty()) { items.back() += "&" + event(letter.also); }
        for (const std::string& without : letter.without) { items.back() += "-" + event(without); }
    }
    if (plain.size() > 1 && !(type == "." && labels.empty())) {
        std::string list = "[";
        for (const std::string& letter : plain) { list += letter; }
        plain = {list + "]"};
    }
    for (const std::string& letter : plain) { items.push_back(event(letter)); }
}

bool has_type(const EventBox& box, EventType type) {
    return std::any_of(box.cores.begin(), box.cores.end(), [type](const CoreKind& core) { return core.type == type; });
}

std::string label_slots(const EventBox& box, Dialect dialect) {
    std::string first = slot_text(box.first, dialect);
    std::string second = slot_text(box.second, dialect);
    if (second != ".") { return first + second; }
    return first == "." ? "" : first;
}

std::vector<std::string> terminal_items(const EventBox& box, const std::vector<CoreKind>& possible, Dialect dialect) {
    const std::string labels = label_slots(box, dialect);
    const auto item = [&](const std::string& letter) {
        return labels.empty() ? letter : "<" + letter + "." + labels + ">";
    };
    std::vector<std::string> items;
    const bool light = has_type(box, EventType::light);
    bool background = has_type(box, EventType::background);
    const bool background_possible = std::any_of(
        possible.begin(), possible.end(), [](const CoreKind& core) { return core.type == EventType::background; });
    if (light) {
        const bool narrower = dialect == Dialect::renderman && background_possible && !background;
        items.push_back(narrower ? item("L") + "-" + item("B") : item("L"));
        background = background && dialect == Dialect::osl;
    }
    if (background) { items.push_back(item("B")); }
    if (has_type(box, EventType::emission)) { items.push_back(item("O")); }
    return items;
}

}  // namespace

std::vector<std::string> EventTeller::notation(const EventBox& box) const {
    const std::string labels = label_slots(box, dialect_);
    std::vector<std::string> items;
    switch (box.role) {
        case EventRole::camera:
            return {"C"};
        case EventRole::terminal:
            return terminal_items(box, terminals_, dialect_);
        case EventRole::user:
            for (const CoreKind& core : box.cores) {
                const std::string name = "U" + std::to_string(core.numbers.front());
                items.push_back(labels.empty() ? name : "<." + name + labels + ">");
            }
            return items;
        case EventRole::scattering:
            break;
    }
    for (const ScatteringOutline& part : outline(box.cores, scattering_)) {
        if (part.reflection == part.transmission) {
            add_surface(".", part.reflection, part, labels, dialect_, items);
        } else {
            add_surface("R", part.reflection, part, labels, dialect_, items);
            add_surface("T", part.transmission, part, labels, dialect_, items);
        }
        if (part.straight) { items.push_back("<Ts" + labels + ">"); }
        if (part.volume) { items.push_back(labels.empty() ? "V" : "<V." + labels + ">"); }
    }
    return items;
}

}  // namespace raylex::lpe
