#include "experiments/atlas/what_if.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "display/output/reader/exr_layers.h"
#include "experiments/atlas/path_string_answers.h"

namespace raylex::experiments {
namespace {

using FactorRgb = std::array<double, 3>;
using lpe::EventType;
using lpe::Scatter;

constexpr FactorRgb no_change{1, 1, 1};

bool ends_path(const lpe::Event& event) {
    return event.type == EventType::light || event.type == EventType::background || event.type == EventType::emission;
}

std::string label_of(const lpe::Event& event, std::size_t slot) {
    return slot < event.labels.size() ? event.labels[slot] : std::string();
}

/// Returns whether a selector such as "RD", "S" or "V" has the event; nothing if it is no selector.
std::optional<bool> selects(std::string_view selector, const lpe::Event& event) {
    if (selector == "V") return event.type == EventType::volume;
    bool good = !selector.empty();
    if (selector.starts_with('R') || selector.starts_with('T')) {
        good = event.type == (selector.front() == 'R' ? EventType::reflection : EventType::transmission);
        selector.remove_prefix(1);
        if (selector.empty()) return good && event.scatter != Scatter::straight;
    }
    if (selector == "D") return good && event.scatter == Scatter::diffuse;
    if (selector == "G") return good && event.scatter == Scatter::glossy;
    if (selector == "S") return good && (event.scatter == Scatter::glossy || event.scatter == Scatter::singular);
    return std::nullopt;
}

/// The least and the largest factor of a letter, or of a path string.
struct FactorRange {
    FactorRgb least{HUGE_VAL, HUGE_VAL, HUGE_VAL}, most{0, 0, 0};
    bool passes = false;  ///< it can stand for an event that is no scattering

    void include(const FactorRgb& factor, bool straight) {
        passes = passes || straight;
        for (std::size_t c = 0; c < 3; ++c) {
            least[c] = std::min(least[c], factor[c]);
            most[c] = std::max(most[c], factor[c]);
        }
    }
    /// Multiplies by a factor of `range` for each of `least_hits` to `most_hits` events.
    void multiply(const FactorRange& range, double least_hits, double most_hits) {
        for (std::size_t c = 0; c < 3; ++c) {
            least[c] *= std::pow(range.least[c], range.least[c] < 1 ? most_hits : least_hits);
            most[c] *= std::pow(range.most[c], range.most[c] > 1 ? most_hits : least_hits);
        }
    }
    [[nodiscard]] bool is_bounded() const {
        return std::all_of(most.begin(), most.end(), [](double factor) { return std::isfinite(factor); });
    }
};

/// Multiplies the factors of the events by those of a mix.
class EventFactors {
  public:
    explicit EventFactors(const display::AtlasFile& atlas)
        : table_(atlas.table()), path_(atlas.path()), factors_(table_.events.size(), no_change) {}

    Status add_light(const ColorFactor& light) {
        std::set<std::string> groups;
        for (const lpe::Event& event : table_.events)
            if (ends_path(event)) groups.insert(label_of(event, 0).empty() ? "default" : label_of(event, 0));
        if (groups.count(light.name) == 0)
            return unknown(light, "light group", groups, "no light of the atlas belongs to it");
        return add(light, [&](const lpe::Event& event) {
            const std::string group = label_of(event, 0);
            return ends_path(event) && (group == light.name || (group.empty() && light.name == "default"));
        });
    }

    Status add_color(const ColorFactor& color) {
        std::set<std::string> objects;
        for (const lpe::Event& event : table_.events)
            if (!ends_path(event) && !label_of(event, 0).empty()) objects.insert(label_of(event, 0));
        std::string object = color.name, lobe;
        if (const std::size_t dot = object.rfind('.'); objects.count(object) == 0 && dot != std::string::npos) {
            lobe = object.substr(dot + 1);
            object.resize(dot);
        }
        if (objects.count(object) == 0) return unknown(color, "object", objects, "no path of the atlas meets it");
        for (const char* parameter : {"roughness", "uroughness", "vroughness", "alpha", "index", "ior", "eta", "k"})
            if (lobe == parameter)
                return error_at(color.where,
                                "'" + color.name + "': " + lobe +
                                    " changes the directions of light, so no factor describes it; "
                                    "expected a colour, such as '" +
                                    object + ".D'",
                                "render the scene anew");
        return add_lobe(color, object, lobe);
    }

    /// Sets the factor of each path string, or its bounds; nothing if all are 1.
    Status set_factors(bool intervals, std::optional<int> max_depth, WhatIf& result) const {
        std::map<display::PathStringTable::Letter, FactorRange> of_letter;
        for (std::size_t i = 0; i < factors_.size(); ++i) {
            const lpe::Event& event = table_.events[i];
            of_letter[table_.letters[i]].include(factors_[i], event.scatter == Scatter::straight);
            if (!ends_path(event)) of_letter[display::PathAlphabet::open].include(factors_[i], true);
        }
        bool changes = false, is_open = false;
        for (std::uint32_t word = 0; word < table_.words.size(); ++word) {
            FactorRange product{no_change, no_change};
            int known = 0, more = 0;
            for (const auto letter : table_.words[word]) {
                const FactorRange& range = of_letter.at(letter);
                if (letter == display::PathAlphabet::open) ++more;
                else product.multiply(range, 1, 1);
                known += range.passes ? 0 : 1;  // the terminal counts too
            }
            if (more > 0) {
                const FactorRange& range = of_letter.at(display::PathAlphabet::open);
                const double most_hits =
                    max_depth ? static_cast<double>(std::max(more, *max_depth + 1 - known)) : HUGE_VAL;
                product.multiply(range, more, most_hits);
            }
            if (product.least != product.most && (!intervals || !product.is_bounded())) return merged(word, intervals);
            is_open = is_open || product.least != product.most;
            changes = changes || product.most != no_change || product.least != no_change;
            result.factors.push_back(product.least);
            result.most.push_back(product.most);
        }
        if (!changes) result.factors.clear();
        if (!is_open) result.most.clear();
        return success();
    }

  private:
    Status add_lobe(const ColorFactor& color, const std::string& object, const std::string& lobe) {
        std::set<std::string> lobes, names;
        bool by_name = false, by_selector = false;
        const auto of_object = [&](const lpe::Event& event) {
            return !ends_path(event) && event.scatter != Scatter::straight && label_of(event, 0) == object;
        };
        for (const lpe::Event& event : table_.events) {
            if (!of_object(event)) continue;
            lobes.insert(label_of(event, 1));
            const std::string name = label_of(event, 1);
            names.insert(name.empty() ? "V" : name);
            by_name = by_name || (!lobe.empty() && name == lobe);
            by_selector = by_selector || selects(lobe, event).value_or(false);
        }
        if (!lobe.empty() && !by_name && !by_selector)
            return error_at(color.where, "'" + color.name + "': object '" + object + "' has no lobe '" + lobe +
                                             "'; expected one of its lobes, " +
                                             display::list_names({names.begin(), names.end()}) +
                                             ", or D, G, S, R, T, V, with R or T before D, G and S");
        const auto chosen = [&](const lpe::Event& event) {
            return of_object(event) &&
                   (lobe.empty() || (by_name ? label_of(event, 1) == lobe : selects(lobe, event).value_or(false)));
        };
        for (const lpe::Event& event : table_.events)
            if (chosen(event))
                if (Status good = check_lobe(color, object, label_of(event, 1), lobes); !good) return good;
        return add(color, chosen);
    }

    /// Returns an error for lobes whose light is no product of their colour.
    static Status check_lobe(const ColorFactor& color, const std::string& object, const std::string& lobe,
                             const std::set<std::string>& lobes) {
        std::string reason;
        if (lobes.count("coat") > 0)
            reason = "is coated, and its coat and its base share energy: light passes between them several times";
        else if (lobe == "subsurface") reason = "has a subsurface body, whose colour acts at every scattering inside";
        else if (lobe == "TT" || lobe == "TRT" || lobe == "TRRT" || (lobe == "R" && lobes.count("TT") > 0))
            reason = "is hair, whose colour acts along the way inside the fibre";
        if (color.is_one() || reason.empty()) return success();
        return error_at(color.where,
                        "'" + color.name + "': object '" + object + "' " + reason +
                            ", so its light is no power of a factor; expected another object",
                        "render the scene anew");
    }

    template <class Chosen>
    Status add(const ColorFactor& factor, const Chosen& chosen) {
        if (table_.negative == display::SignedLight::light && !factor.is_grey())
            return error_at(factor.where, "'" + factor.name + "': the scene disperses light, and " + path_ +
                                              " has paths of one wavelength, which no factor of red, green and blue "
                                              "describes; expected one number");
        for (std::size_t i = 0; i < factors_.size(); ++i)
            if (chosen(table_.events[i]))
                for (std::size_t c = 0; c < 3; ++c) factors_[i][c] *= factor.rgb[c];
        return success();
    }

    static Status unknown(const ColorFactor& factor, const std::string& kind, const std::set<std::string>& names,
                          const std::string& reason) {
        return error_at(factor.where,
                        "unknown " + kind + " '" + factor.name + "', " + reason +
                            "; expected one of: " + display::list_names({names.begin(), names.end()}),
                        near_miss(factor.name, {names.begin(), names.end()}));
    }

    [[nodiscard]] Error merged(std::uint32_t word, bool intervals) const {
        const auto& letters = table_.words[word];
        const bool open = std::find(letters.begin(), letters.end(), display::PathAlphabet::open) != letters.end();
        return error_at(
            {path_, 0, 0},
            "the atlas merges path strings with different factors as '" + path_string_text(table_, word) +
                (intervals
                     ? "', of any length, and a factor above 1 has no largest power; expected factors up to 1, or "
                       "a render with a maximum depth"
                     : "', so their light cannot be scaled; expected an atlas that distinguishes them"),
            std::string(intervals ? "" : "--intervals gives bounds; ") + "render it with " +
                (!open               ? "--atlas-by label,lobe,group"
                 : table_.merged > 0 ? "a greater --atlas-budget"
                                     : "an --atlas-length above " + std::to_string(table_.rules.length)));
    }

    const display::PathStringTable& table_;
    std::string path_;
    std::vector<FactorRgb> factors_;  // [event]
};

}  // namespace

Result<WhatIf> what_if(const display::AtlasFile& atlas, const Mix& mix, bool intervals, std::optional<int> max_depth) {
    WhatIf result;
    if (mix.lights.empty() && mix.colors.empty()) return result;
    if (atlas.description().attributes.count("raylex/denoised") > 0)
        return error_at({atlas.path(), 0, 0}, "this atlas is denoised; expected the atlas of a render");
    for (const auto* factors : {&mix.lights, &mix.colors})
        if (Status once = check_once(*factors); !once) return once.error();
    EventFactors events(atlas);
    for (const ColorFactor& light : mix.lights)
        if (Status added = events.add_light(light); !added) return added.error();
    for (const ColorFactor& color : mix.colors) {
        if (Status added = events.add_color(color); !added) return added.error();
        if (std::any_of(color.rgb.begin(), color.rgb.end(), [](double factor) { return factor > 1; }))
            result.notes.push_back(
                "'" + color.name +
                "' gets a factor above 1; an atlas stores no albedos, so it is not known whether one "
                "exceeds 1 now");
    }
    if (Status set = events.set_factors(intervals, max_depth, result); !set) return set.error();
    return result;
}

}  // namespace raylex::experiments
