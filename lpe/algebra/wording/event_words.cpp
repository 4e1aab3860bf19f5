#include "lpe/algebra/wording/event_words.h"

#include <algorithm>
#include <map>
#include <utility>

namespace raylex::lpe {

bool has_scatter(const std::vector<Scatter>& list, Scatter scatter) {
    return std::find(list.begin(), list.end(), scatter) != list.end();
}

namespace {

std::string quoted(const std::string& text) {
    return "'" + text + "'";
}

/// "diffuse or specular "
std::string adjectives(const std::vector<Scatter>& scatters, Dialect dialect) {
    const bool diffuse = has_scatter(scatters, Scatter::diffuse);
    const bool glossy = has_scatter(scatters, Scatter::glossy);
    const bool singular = has_scatter(scatters, Scatter::singular);
    std::vector<std::string> words;
    if (diffuse) { words.emplace_back("diffuse"); }
    if (dialect == Dialect::renderman && glossy && singular) {
        words.emplace_back("specular");
    } else {
        if (glossy) { words.emplace_back("glossy"); }
        if (singular) { words.emplace_back(dialect == Dialect::renderman ? "mirror-like" : "specular"); }
    }
    return joined_by(words) + " ";
}

/// The labels of a choice as nouns; `matched` precedes each glob.
std::vector<std::string> listed(const LabelChoice& choice, const std::string& matched) {
    std::vector<std::string> items;
    for (const std::string& name : choice.names) { items.push_back(quoted(name)); }
    for (const std::string& glob : choice.globs) { items.push_back(matched + quoted(glob)); }
    return shortened(std::move(items));
}

/// The object words after "off", "through", "at" or "in".
std::string object_words(const LabelChoice& choice) {
    std::vector<std::string> items = listed(choice, "what is called ");
    if (choice.kind == LabelChoice::Kind::only) {
        if (choice.empty_allowed) { items.emplace_back("what has no label"); }
        return joined_by(items);
    }
    const std::string what = choice.empty_allowed ? "anything" : "anything labelled";
    return items.empty() ? what : what + " but " + joined_by(items, " and ");
}

std::string lobe_words(const LabelChoice& choice) {
    std::vector<std::string> items = listed(choice, "");
    if (choice.kind == LabelChoice::Kind::only) {
        std::string text = items.empty() ? "" : "the lobe " + joined_by(items);
        if (choice.empty_allowed) { text += text.empty() ? "an unnamed lobe" : " or an unnamed one"; }
        return text;
    }
    const std::string what = choice.empty_allowed ? "any lobe" : "any named lobe";
    return items.empty() ? what : what + " but " + joined_by(items, " and ");
}

std::string group_words(const LabelChoice& choice) {
    std::vector<std::string> items = listed(choice, "");
    if (choice.kind == LabelChoice::Kind::only) {
        std::string text = items.empty() ? "" : "group " + joined_by(items);
        if (choice.empty_allowed) { text += text.empty() ? "no group" : " or of no group"; }
        return text;
    }
    const std::string what = choice.empty_allowed ? "any group" : "any named group";
    return items.empty() ? what : what + " but " + joined_by(items, " and ");
}

/// " (lobe D2)", " (any lobe but D2 and D3)"
std::string number_words(const ScatteringOutline& part) {
    std::vector<Scatter> all = part.reflection;
    all.insert(all.end(), part.transmission.begin(), part.transmission.end());
    if (part.numbers.empty()) { return {}; }
    std::vector<std::string> items;
    for (const auto& [letter, present] :
         {std::pair{'D', has_scatter(all, Scatter::diffuse)},
          std::pair{'S', has_scatter(all, Scatter::glossy) || has_scatter(all, Scatter::singular)}}) {
        for (const std::uint8_t number : part.numbers) {
            if (present) { items.push_back(std::string(1, letter) + std::to_string(number)); }
        }
    }
    return part.numbers_excluded ? " (any lobe but " + joined_by(items, " and ") + ")"
                                 : " (lobe " + joined_by(items) + ")";
}

struct NounForms {
    std::string one, many, preposition;
};

/// The noun phrases that together describe a part.
std::vector<NounForms> nouns(const ScatteringOutline& part, Dialect dialect) {
    std::vector<NounForms> forms;
    const std::string number = number_words(part);
    const auto add = [&](const std::vector<Scatter>& scatters, const std::string& noun,
                         const std::string& preposition) {
        const bool plain = scatters.size() == 3 && part.numbers.empty() && noun != "scattering";
        const std::string text = (plain ? "" : adjectives(scatters, dialect)) + noun;
        forms.push_back({text + number, text + "s" + number, preposition});
    };
    if (!part.reflection.empty() && part.reflection == part.transmission) {
        add(part.reflection, "scattering", " at ");
    } else {
        if (!part.reflection.empty()) { add(part.reflection, "reflection", " off "); }
        if (!part.transmission.empty()) { add(part.transmission, "transmission", " through "); }
    }
    if (part.straight) { forms.push_back({"straight passage", "straight passages", " through "}); }
    if (part.volume) { forms.push_back({"volume scattering", "volume scatterings", " in "}); }
    return forms;
}

bool contains(const std::vector<CoreKind>& cores, const CoreKind& wanted) {
    return std::any_of(cores.begin(), cores.end(), [&](const CoreKind& core) {
        return core.type == wanted.type && core.scatter == wanted.scatter && core.numbers == wanted.numbers;
    });
}

bool has_type(const std::vector<CoreKind>& cores, EventType type) {
    return std::any_of(cores.begin(), cores.end(), [type](const CoreKind& core) { return core.type == type; });
}

EventPhrase scattering_phrase(const EventBox& box, const std::vector<CoreKind>& possible, bool all, Dialect dialect) {
    EventPhrase phrase;
    std::string lobe;
    if (box.second.kind != LabelChoice::Kind::any) { lobe = " by " + lobe_words(box.second); }
    const std::string object = box.first.kind == LabelChoice::Kind::any ? "" : object_words(box.first);
    if (all) {
        const std::string tail = (object.empty() ? "" : " at " + object) + lobe;
        phrase.one.push_back("scattering of any kind" + tail);
        phrase.many.push_back("scatterings of any kind" + tail);
        return phrase;
    }
    for (const ScatteringOutline& part : outline(box.cores, possible)) {
        for (const NounForms& noun : nouns(part, dialect)) {
            const std::string tail = (object.empty() ? "" : noun.preposition + object) + lobe;
            phrase.one.push_back(noun.one + tail);
            phrase.many.push_back(noun.many + tail);
        }
    }
    return phrase;
}

EventPhrase terminal_phrase(const EventBox& box, const std::vector<CoreKind>& possible, Dialect dialect) {
    EventPhrase phrase;
    const std::string group = box.first.kind == LabelChoice::Kind::any ? "" : " of " + group_words(box.first);
    const auto add = [&](const std::string& one, const std::string& many) {
        phrase.one.push_back(one + group);
        phrase.many.push_back(many + group);
    };
    const bool light = has_type(box.cores, EventType::light);
    const bool background = has_type(box.cores, EventType::background);
    // In renderman every light is "a light", infinite lights included.
    const bool merged =
        dialect == Dialect::renderman && light && (background || !has_type(possible, EventType::background));
    if (merged) {
        add("a light", "lights");
    } else if (light) {
        const std::string but = dialect == Dialect::renderman ? " other than the background" : "";
        add("a light" + but, "lights" + but);
    }
    if (background && !merged) { add("the background", "backgrounds"); }
    if (has_type(box.cores, EventType::emission)) { add("emission", "emissions"); }
    return phrase;
}

EventPhrase user_phrase(const EventBox& box) {
    EventPhrase phrase;
    for (const CoreKind& core : box.cores) {
        std::string text = "user event U" + std::to_string(core.numbers.front());
        if (box.first.kind != LabelChoice::Kind::any) { text += " labelled " + object_words(box.first); }
        phrase.one.push_back(text);
        phrase.many.push_back(text.replace(0, 10, "user events"));
    }
    return phrase;
}

}  // namespace

std::vector<std::string> shortened(std::vector<std::string> items) {
    constexpr std::size_t most = 8;
    if (items.size() > most) {
        const std::size_t others = items.size() - (most - 1);
        items.resize(most - 1);
        items.push_back(std::to_string(others) + " others");
    }
    return items;
}

std::string joined_by(const std::vector<std::string>& items, const std::string& last_joint) {
    std::string text;
    for (std::size_t i = 0; i < items.size(); ++i) {
        text += i == 0 ? "" : i + 1 == items.size() ? last_joint : ", ";
        text += items[i];
    }
    return text;
}

std::vector<ScatteringOutline> outline(const std::vector<CoreKind>& cores, const std::vector<CoreKind>& possible) {
    // The lobe numbers of each (type, scatter) pair: all possible ones, and those of the box.
    std::map<std::pair<EventType, Scatter>, std::pair<std::vector<std::uint8_t>, std::vector<std::uint8_t>>> cells;
    for (const CoreKind& core : possible) {
        auto& all = cells[{core.type, core.scatter}].first;
        all.insert(all.end(), core.numbers.begin(), core.numbers.end());
    }
    for (const CoreKind& core : cores) {
        auto& chosen = cells[{core.type, core.scatter}].second;
        chosen.insert(chosen.end(), core.numbers.begin(), core.numbers.end());
    }
    std::vector<ScatteringOutline> parts;
    for (auto& [cell, numbers] : cells) {
        auto& [all, chosen] = numbers;
        if (chosen.empty()) { continue; }
        std::sort(all.begin(), all.end());
        std::sort(chosen.begin(), chosen.end());
        ScatteringOutline wanted;
        if (chosen != all) {
            wanted.numbers_excluded = chosen.front() == 0;
            if (wanted.numbers_excluded) {
                std::set_difference(all.begin(), all.end(), chosen.begin(), chosen.end(),
                                    std::back_inserter(wanted.numbers));
            } else {
                wanted.numbers = chosen;
            }
        }
        const auto same = [&](const ScatteringOutline& part) {
            return part.numbers == wanted.numbers && part.numbers_excluded == wanted.numbers_excluded;
        };
        auto part = std::find_if(parts.begin(), parts.end(), same);
        if (part == parts.end()) { part = parts.insert(parts.end(), std::move(wanted)); }
        const auto [type, scatter] = cell;
        if (type == EventType::volume) {
            part->volume = true;
        } else if (scatter == Scatter::straight) {
            part->straight = true;
        } else {
            (type == EventType::reflection ? part->reflection : part->transmission).push_back(scatter);
        }
    }
    return parts;
}

EventTeller::EventTeller(const EventSpace& space, Dialect dialect, const Members& occurring)
    : space_(space),
      dialect_(dialect),
      scattering_(space.possible(EventRole::scattering, occurring)),
      terminals_(space.possible(EventRole::terminal, occurring)) {}

bool EventTeller::is_all(const EventBox& box) const {
    if (box.first.kind != LabelChoice::Kind::any || box.second.kind != LabelChoice::Kind::any) { return false; }
    if (box.role == EventRole::camera) { return true; }
    const std::vector<CoreKind>& possible = box.role == EventRole::scattering ? scattering_ : terminals_;
    return box.role != EventRole::user && std::all_of(possible.begin(), possible.end(),
                                                      [&](const CoreKind& core) { return contains(box.cores, core); });
}

EventPhrase EventTeller::phrase(const EventBox& box) const {
    switch (box.role) {
        case EventRole::camera:
            return {{"camera"}, {"cameras"}};
        case EventRole::user:
            return user_phrase(box);
        case EventRole::terminal:
            return terminal_phrase(box, terminals_, dialect_);
        case EventRole::scattering:
            break;
    }
    const bool all = std::all_of(scattering_.begin(), scattering_.end(),
                                 [&](const CoreKind& core) { return contains(box.cores, core); });
    return scattering_phrase(box, scattering_, all, dialect_);
}

EventPhrase EventTeller::phrase(const std::vector<EventBox>& boxes, EventRole role) const {
    EventPhrase whole;
    for (const EventBox& box : boxes) {
        if (box.role == role) {
            EventPhrase part = phrase(box);
            std::move(part.one.begin(), part.one.end(), std::back_inserter(whole.one));
            std::move(part.many.begin(), part.many.end(), std::back_inserter(whole.many));
        }
    }
    return whole;
}

}  // namespace raylex::lpe
