#include <algorithm>
#include <optional>
#include <utility>

#include "lpe/algebra/wording/event_text.h"
#include "lpe/channels/split_bins.h"
#include "lpe/failure.h"
#include "lpe/language/glob.h"

namespace raylex::lpe {

namespace {

/// A requested lobe: a set of events, or a lobe name.
struct LobeItem {
    std::string name, text;
    bool is_event = false;
    CoreSet cores;
};

CoreSet scattering_cores(const PathStrings& words) {
    CoreSet cores;
    for (const EventType type : {EventType::reflection, EventType::transmission}) {
        for (const Scatter scatter : {Scatter::diffuse, Scatter::glossy, Scatter::singular}) {
            for (std::uint8_t number = 0; number <= (scatter == Scatter::diffuse ? 4 : 8); ++number) {
                cores.set(core_index({type, scatter, number, {}}));
            }
        }
    }
    if (words.volume) { cores.set(core_index({EventType::volume, Scatter::none, 0, {}})); }
    return cores;
}

CoreSet volume_cores() {
    CoreSet cores;
    cores.set(core_index({EventType::volume, Scatter::none, 0, {}}));
    return cores;
}

/// The events of an item such as RD, S4, <TS8>, T, V or R[GS]; nothing when the item is not of this form.
std::optional<CoreSet> read_event(std::string_view text, Dialect dialect) {
    if (text.size() > 2 && text.front() == '<' && text.back() == '>') { text = text.substr(1, text.size() - 2); }
    if (text == "V") { return volume_cores(); }
    std::vector<EventType> types{EventType::reflection, EventType::transmission};
    if (!text.empty() && (text.front() == 'R' || text.front() == 'T' || text.front() == '.')) {
        if (text.front() != '.') { types = {text.front() == 'R' ? EventType::reflection : EventType::transmission}; }
        text.remove_prefix(1);
    }
    std::string letters;
    if (text.starts_with('[') && text.find(']') != std::string_view::npos) {
        letters = text.substr(1, text.find(']') - 1);
        text.remove_prefix(text.find(']') + 1);
    } else if (!text.empty() && text.front() >= 'A') {
        letters = text.substr(0, 1);
        text.remove_prefix(1);
    } else if (text.empty()) {
        letters = "DGS";
    }
    int number = 0;
    if (text.size() == 1 && text.front() >= '1' && text.front() <= '8' && letters.size() == 1) {
        number = text.front() - '0';
        text.remove_prefix(1);
    }
    if (letters.empty() || !text.empty() || letters.find_first_not_of("DGS.") != std::string::npos) {
        return std::nullopt;
    }
    CoreSet cores;
    for (const EventType type : types) {
        for (const char letter : letters) {
            for (const Scatter scatter : {Scatter::diffuse, Scatter::glossy, Scatter::singular}) {
                const char own = scatter_letter(scatter);
                const bool fits =
                    letter == '.' || letter == own || (letter == 'S' && own == 'G' && dialect == Dialect::renderman);
                for (std::uint8_t k = 0; fits && k <= (own == 'D' ? 4 : 8); ++k) {
                    if (number == 0 || k == number) { cores.set(core_index({type, scatter, k, {}})); }
                }
            }
        }
    }
    return cores.any() ? std::optional(cores) : std::nullopt;
}

std::vector<std::string> usual_lobes(const SplitRequest& request) {
    const std::string specular = request.dialect == Dialect::osl ? "[GS]" : "S";
    std::vector<std::string> lobes{"diffuse=RD", "specular=R" + specular, "subsurface=TD", "transmissive=T" + specular};
    if (request.words.volume) { lobes.emplace_back("volume=V"); }
    return lobes;
}

std::vector<LobeItem> read_lobes(const SplitRequest& request) {
    std::vector<LobeItem> items;
    std::vector<std::string> taken;
    for (const std::string& given : request.lobes.empty() ? usual_lobes(request) : request.lobes) {
        LobeItem item;
        const std::size_t equals = given.find('=');
        item.text = equals == std::string::npos ? given : given.substr(equals + 1);
        if (item.text.size() > 2 && item.text.front() == '\'' && item.text.back() == '\'') {
            item.text = item.text.substr(1, item.text.size() - 2);
        } else if (const auto cores = read_event(item.text, request.dialect)) {
            item.is_event = true;
            item.cores = *cores;
        }
        if (item.text.empty()) {
            fail("a lobe of the split is empty; expected events such as RD, S4 or V, or lobe names such as coat");
        }
        item.name = bin_name(equals == std::string::npos ? item.text : given.substr(0, equals), taken);
        if (!items.empty() && items.front().is_event != item.is_event) {
            const std::string& event = item.is_event ? item.text : items.front().text;
            fail("the lobes '" + items.front().text + "' and '" + item.text +
                     "' are of different kinds; expected events only (RD, S4, V) or lobe names only (coat, glass)",
                 "a lobe whose name is '" + event + "' must be in quotes: \"'" + event + "'\"");
        }
        items.push_back(std::move(item));
    }
    return items;
}

/// Assigns each event to the first item that contains it, and all remaining events to `other`.
void part(std::vector<LobeItem>& items, const CoreSet& all) {
    CoreSet left = all;
    for (LobeItem& item : items) {
        const CoreSet asked = item.cores & all;
        item.cores = asked & left;
        if (asked.none()) {
            fail("the lobe '" + item.text + "' contains only events that cannot occur", "leave it out");
        }
        if (item.cores.none()) {
            fail("the lobe '" + item.text + "' is covered by the lobes before it; expected it before them");
        }
        left &= ~asked;
    }
    if (left.any()) { items.push_back({"other", "other", true, left}); }
}

/// Combines event items with objects, as texts of the renderman dialect.
class RendermanFirst {
  public:
    explicit RendermanFirst(const std::vector<LobeItem>& lobes)
        : lobes_(lobes), classes_(sets_of(lobes)), writer_(classes_, {}) {}

    std::vector<FirstBin> run(const std::vector<std::string>& objects, bool by_object) {
        std::vector<FirstBin> bins;
        std::vector<std::string> taken{"other"};
        for (const std::string& object : objects) {
            const std::string name = bin_name(object, taken);
            for (std::size_t lobe = 0; lobe < lobes_.size(); ++lobe) {
                if ((lobes_[lobe].cores & ~volume_cores()).any()) {
                    const std::string text = labelled(lobe, quoted_label(object));
                    bins.push_back(
                        {lobes_[lobe].name, name, text.find('>') == text.size() - 1 ? text : "[" + text + "]"});
                }
            }
        }
        for (std::size_t lobe = 0; lobe < lobes_.size(); ++lobe) {
            bins.push_back({lobes_[lobe].name, by_object ? "other" : "",
                            by_object ? outside(lobe, "[^" + quoted_list(objects) + "]")
                                      : written(writer_.write(surface(lobe, true), others(lobe)), lobe)});
        }
        return bins;
    }

  private:
    /// Two sets per lobe: on surfaces and in media. Media are not objects: their scattering goes to the object bin
    /// `other`.
    static std::vector<EventSet> sets_of(const std::vector<LobeItem>& lobes) {
        std::vector<EventSet> sets;
        for (const LobeItem& item : lobes) {
            for (const CoreSet& cores : {item.cores & ~volume_cores(), item.cores & volume_cores()}) {
                sets.push_back({{{cores, {}, Missing::is_empty, Extra::ignored}}, {}});
            }
        }
        return sets;
    }

    [[nodiscard]] ClassSet surface(std::size_t lobe, bool with_volume = false) const {
        ClassSet set = classes_.members(2 * lobe);
        for (std::size_t c = 0; c < set.size(); ++c) {
            set[c] = set[c] || (with_volume && classes_.members(2 * lobe + 1)[c]);
        }
        return set;
    }

    /// Every event of the split except those of this lobe; with `media`, also the lobe's own events in media.
    [[nodiscard]] ClassSet others(std::size_t lobe, bool media = false) const {
        ClassSet set(classes_.count(), false);
        for (std::size_t k = 0; k < 2 * lobes_.size(); ++k) {
            const bool mine = k == 2 * lobe || (!media && k == 2 * lobe + 1);
            for (std::size_t c = 0; c < set.size() && !mine; ++c) { set[c] = set[c] || classes_.members(k)[c]; }
        }
        return set;
    }

    [[nodiscard]] std::string labelled(std::size_t lobe, const std::string& label) const {
        return written(writer_.write_labelled(surface(lobe), others(lobe, true), label), lobe);
    }

    [[nodiscard]] std::string outside(std::size_t lobe, const std::string& label) const {
        const bool media = (lobes_[lobe].cores & volume_cores()).any();
        if (lobes_[lobe].cores == volume_cores()) { return "V"; }
        const std::string text = labelled(lobe, label) + (media ? "V" : "");
        return text.find('>') == text.size() - 1 ? text : "[" + text + "]";
    }

    [[nodiscard]] std::string written(const std::optional<std::string>& text, std::size_t lobe) const {
        if (!text) {
            fail("the lobe '" + lobes_[lobe].text + "' has no short expression that excludes the other lobes");
        }
        return *text;
    }

    const std::vector<LobeItem>& lobes_;
    EventClasses classes_;
    EventWriter writer_;
};

/// The cores in osl: <RD>, <R[GS]>, V, or [...] for several.
std::string osl_text(const CoreSet& cores) {
    std::vector<std::string> items;
    for (const EventType type : {EventType::reflection, EventType::transmission}) {
        std::string letters;
        for (const Scatter scatter : {Scatter::diffuse, Scatter::glossy, Scatter::singular}) {
            if (cores.test(core_index({type, scatter, 0, {}}))) { letters += scatter_letter(scatter); }
        }
        if (!letters.empty()) {
            items.push_back(std::string("<") + type_letter(type) +
                            (letters.size() == 1 ? letters : "[" + letters + "]") + ">");
        }
    }
    if ((cores & volume_cores()).any()) { items.emplace_back("V"); }
    if (items.size() == 1) { return items.front(); }
    std::string text = "[";
    for (const std::string& item : items) { text += item; }
    return text + "]";
}

std::vector<FirstBin> osl_first(const SplitRequest& request, std::vector<LobeItem> lobes) {
    if (has_axis(request, SplitAxis::object)) {
        fail(
            "osl cannot distinguish objects without a label, so it has no bin for them; expected --dialect "
            "renderman");
    }
    for (const LobeItem& item : lobes) {
        if (!item.is_event) {
            fail("osl cannot distinguish lobes without a name; expected events such as RD or R[GS]");
        }
        if (item.text.find_first_of("12345678") != std::string::npos) {
            fail("osl has no lobe numbers, as in '" + item.text + "'; expected events such as RD or R[GS]");
        }
    }
    part(lobes, scattering_cores(request.words));
    std::vector<FirstBin> bins;
    for (const LobeItem& item : lobes) { bins.push_back({item.name, "", osl_text(item.cores)}); }
    return bins;
}

/// Combines lobe names, tested in the second label, with objects, tested in the first.
std::vector<FirstBin> named_first(const std::vector<LobeItem>& lobes, const std::vector<std::string>& objects,
                                  bool by_object) {
    std::vector<std::string> lobe_labels, taken{"other"};
    for (const LobeItem& item : lobes) { lobe_labels.push_back(item.text); }
    std::vector<FirstBin> bins;
    for (std::size_t object = 0; object <= objects.size(); ++object) {
        const bool rest = object == objects.size();
        const std::string name = !by_object ? "" : rest ? "other" : bin_name(objects[object], taken);
        const std::string label = !by_object ? "."
                                  : rest     ? "[^" + quoted_list(objects) + "]"
                                             : quoted_label(objects[object]);
        for (const LobeItem& item : lobes) {
            bins.push_back({item.name, name, "<.." + label + quoted_label(item.text) + ">"});
        }
        bins.push_back({"other", name, "<.." + label + "[^" + quoted_list(lobe_labels) + "]>"});
    }
    return bins;
}

}  // namespace

std::vector<FirstBin> first_bins(const SplitRequest& request) {
    const bool by_lobe = has_axis(request, SplitAxis::lobe), by_object = has_axis(request, SplitAxis::object);
    if (!by_lobe && !by_object) { return {}; }
    std::vector<std::string> objects;
    if (by_object) { objects = unique_names(request.objects, "object", "--objects floor,wall"); }
    std::vector<LobeItem> lobes{{"", "any", true, scattering_cores(request.words)}};
    if (by_lobe) { lobes = read_lobes(request); }
    if (request.dialect == Dialect::osl) { return osl_first(request, std::move(lobes)); }
    if (!lobes.front().is_event) { return named_first(lobes, objects, by_object); }
    part(lobes, scattering_cores(request.words));
    return RendermanFirst(lobes).run(objects, by_object);
}

}  // namespace raylex::lpe
