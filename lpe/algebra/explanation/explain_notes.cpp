// Notes on paths that an expression omits although users of other renderers expect them.
#include <algorithm>
#include <string>
#include <vector>

#include "lpe/algebra/explanation/explain_study.h"
#include "lpe/algebra/proofs/samples.h"

namespace raylex::lpe {

namespace {

struct Traits {
    bool numbers = false;         // an event names a lobe number
    bool negated_labels = false;  // a label test is negated: [^'label']
    bool second_label = false;
    bool letter_s = false, letter_l = false;
};

void read_traits(const Node& node, Traits& traits) {
    for (const std::vector<EventPattern>* patterns : {&node.events.any_of, &node.events.none_of}) {
        for (const EventPattern& pattern : *patterns) {
            for (const LabelTest& test : pattern.labels) {
                traits.negated_labels = traits.negated_labels || (test.negated && !test.is_any());
            }
            const auto number = [](Scatter scatter, std::uint8_t k) {
                return core_index({EventType::reflection, scatter, k, {}});
            };
            for (std::uint8_t k = 1; k < lobe_numbers; ++k) {
                const bool diffuse =
                    k <= 4 && pattern.cores[number(Scatter::diffuse, k)] != pattern.cores[number(Scatter::diffuse, 0)];
                traits.numbers =
                    traits.numbers || diffuse ||
                    pattern.cores[number(Scatter::singular, k)] != pattern.cores[number(Scatter::singular, 0)];
            }
        }
    }
    for (const NodePtr& child : node.children) { read_traits(*child, traits); }
}

/// Returns whether the letter occurs in the expression outside labels.
bool has_letter(const std::string& text, char letter) {
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '\\' && quoted) {
            ++i;
        } else if (text[i] == '\'') {
            quoted = !quoted;
        } else if (text[i] == letter && !quoted) {
            return true;
        }
    }
    return false;
}

void notes_on_ends(const Study& study, std::vector<std::string>& notes) {
    const bool renderman = study.source.dialect == Dialect::renderman;
    const bool light = study.accepts_some(Feature::light);
    const bool background = study.accepts_some(Feature::background);
    const bool emission = study.accepts_some(Feature::emission);
    if (light && !emission && study.occurs(Feature::emission)) {
        notes.push_back(
            std::string("It never ends at emission (O), so it omits glowing objects and volume emission; ") +
            (renderman ? "[<L.>O]" : "[LO]") + " includes both.");
    }
    if (light && !background && study.occurs(Feature::background)) {
        notes.emplace_back(renderman ? "It never ends at the background (B), although a plain L includes it."
                                     : "It never ends at the background (B): in this dialect L excludes infinite "
                                       "lights; [LB] includes both.");
    }
    if (light && background && renderman && has_letter(study.source.expression, 'L')) {
        notes.emplace_back("L is every light, including the background (infinite lights); B is only the background.");
    }
    if (!light && !background && emission) { notes.emplace_back("It never ends at a light (L): O is only emission."); }
}

void notes_on_scattering(const Study& study, std::vector<std::string>& notes) {
    const bool renderman = study.source.dialect == Dialect::renderman;
    const bool diffuse = study.accepts_some(Feature::diffuse);
    const bool glossy = study.accepts_some(Feature::glossy);
    const bool singular = study.accepts_some(Feature::singular);
    const bool endless = !longest_path_string(study.paths).has_value();
    if (endless && (diffuse || glossy || singular) && !study.accepts_some(Feature::volume) &&
        study.occurs(Feature::volume)) {
        notes.emplace_back("No path that scatters in a medium (V) matches; V is a separate event, as in [DSV].");
    }
    if (renderman) {
        if (glossy && singular && has_letter(study.source.expression, 'S')) {
            notes.emplace_back("S is every specular lobe, both glossy (rough) and mirror-like: S includes G.");
        }
        if (glossy && !singular) {
            notes.emplace_back(
                "Mirror-like lobes do not match: G is only the glossy lobes, S includes both. RenderMan itself has no "
                "G.");
        }
    } else {
        if (singular && !glossy && study.occurs(Feature::glossy)) {
            notes.emplace_back(
                "Glossy lobes (G) do not match: in this dialect S is only the mirror-like lobes; [GS] includes both.");
        }
        if (glossy && !singular && study.occurs(Feature::singular)) {
            notes.emplace_back("Mirror-like lobes (S) do not match: G is only the glossy lobes; [GS] includes both.");
        }
        if (study.occurs(Feature::straight) && !study.accepts_some(Feature::straight)) {
            notes.emplace_back(
                "A path through a cutout (Ts) never matches: in this dialect passing straight through is an event; "
                "insert <Ts>* where it can occur.");
        }
    }
}

void notes_on_labels(const Study& study, std::vector<std::string>& notes) {
    Traits traits;
    read_traits(*study.expression.root, traits);
    if (traits.numbers) {
        notes.emplace_back(
            "A numbered lobe (D2, S8) matches only that slot, not lobes in other slots or without a slot.");
    }
    if (traits.negated_labels) {
        notes.emplace_back(study.source.dialect == Dialect::renderman
                               ? "[^'label'] also matches events without a label."
                               : "[^'label'] requires some other label: events without a label do not match.");
    }
    if (study.user_events) {
        notes.emplace_back("User events (U1 to U12) match only where they are written; '.' does not match them.");
    }
}

}  // namespace

std::vector<std::string> notes_about(const Study& study) {
    std::vector<std::string> notes;
    notes_on_ends(study, notes);
    notes_on_scattering(study, notes);
    notes_on_labels(study, notes);
    return notes;
}

}  // namespace raylex::lpe
