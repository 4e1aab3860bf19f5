#include "lpe/algebra/explanation/explain.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "lpe/algebra/explanation/explain_study.h"
#include "lpe/algebra/explanation/reach.h"
#include "lpe/algebra/proofs/samples.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/failure.h"
#include "lpe/language/prefixes.h"
#include "lpe/language/source_text.h"

namespace raylex::lpe {

namespace {

constexpr std::size_t sample_count = 5;
constexpr std::size_t most_tried_events = 64;     // pieces that are checked for use
constexpr std::size_t most_studied_states = 500;  // largest automaton whose pieces are checked one by one

std::string prefix_effect(std::string_view prefix) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 8> effects{{
        {"unoccluded", "light samples ignore occluders"},
        {"noclamp", "sample filters do not change the channel: it is not clamped"},
        {"nothruput", "takes the emitted radiance, or the user event's value, without the path's throughput"},
        {"shadows", "takes the blocked part of light samples: the unoccluded light minus the light that arrives"},
        {"holdouts", "takes only paths whose first hit is a holdout"},
        {"overwrite", "the last contribution of a camera sample replaces the earlier ones; they do not add up"},
        {"noinfinitecheck", "checks its own values for infinities, independently of the beauty's"},
        {"unweighted", "takes the contributions of each technique without MIS weights"},
    }};
    for (const auto& [name, effect] : effects) {
        if (name == prefix) { return std::string(effect); }
    }
    if (const std::optional<TechniquePrefix> technique = technique_prefix(prefix); technique && technique->t == 0) {
        return "takes only contributions of techniques with more than " + std::to_string(technique->beyond) +
               " vertices";
    } else if (technique) {
        return "takes only contributions found with " + std::to_string(technique->s) + " vertices from the light and " +
               std::to_string(technique->t) + " from the camera";
    }
    return "changes the splatted value";
}

/// Events that can occur somewhere in W, regardless of labels and lobe numbers.
CoreSet occurring_cores(const Study& study) {
    const PathStringSets sets = path_string_sets(study.words, false);
    std::array<bool, core_count> letters_seen{};
    for (const EventSet* set : {&sets.camera, &sets.scattering, &sets.straight, &sets.terminal}) {
        for (const EventPattern& pattern : set->any_of) {
            for (std::size_t core = 0; core < core_count; ++core) {
                Event letter = core_event(core);
                letter.lobe_number = 0;
                letters_seen[core_index(letter)] = letters_seen[core_index(letter)] || pattern.cores[core];
            }
        }
    }
    CoreSet cores;
    for (std::size_t core = 0; core < core_count; ++core) {
        Event letter = core_event(core);
        const bool user = letter.type == EventType::user;
        letter.lobe_number = 0;
        cores[core] = user ? study.user_events : letters_seen[core_index(letter)];
    }
    return cores;
}

std::string capitalised(std::string text) {
    if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') { text[0] = static_cast<char>(text[0] - 'a' + 'A'); }
    return text;
}

std::string piece_text(const Study& study, const Node& node) {
    return "'" + study.source.expression.substr(node.begin, node.end - node.begin) + "' (column " +
           std::to_string(node.begin + 1) + ")";
}

void warn_about_dead_pieces(const Study& study, bool empty, std::vector<std::string>& warnings) {
    if (study.languages.channels.front().states() > most_studied_states) { return; }
    const HasPath has_path = [&study](std::vector<NodePtr> trees) { return have_paths(study, std::move(trees)); };
    const Node& root = *study.expression.root;
    if (empty) {
        const Node* step = first_dead_step(root, has_path);
        if (step != nullptr && step->end > step->begin) {
            warnings.push_back("no path can continue at " + piece_text(study, *step));
        }
        return;
    }
    for (const Node* event : dead_events(root, most_tried_events, has_path)) {
        if (event->end > event->begin) {
            warnings.push_back(piece_text(study, *event) + " can never match: no path of the expression uses it");
        }
    }
}

/// Outside labels such letters are errors; inside labels they are legal and nearly always a mistake.
void warn_about_look_alikes(const Study& study, std::vector<std::string>& warnings) {
    const SourceText text(study.source);
    for (std::size_t i = 0; i < text.size() && warnings.size() < 8; ++i) {
        const std::string hint =
            (static_cast<unsigned char>(text.text()[i]) & 0xC0U) == 0xC0U ? text.look_alike_hint(i) : "";
        if (!hint.empty()) {
            warnings.push_back(text.describe(i) + " at column " + std::to_string(i + 1) + ": " + hint);
        }
    }
}

/// Warns about a label that mixes Latin letters with Cyrillic or Greek ones (U+0370 to U+052F; in UTF-8 their first
/// byte is 0xCD to 0xD4).
void warn_about_mixed_scripts(const Study& study, std::vector<std::string>& warnings) {
    const std::string& text = study.source.expression;
    for (std::size_t open = text.find('\''); open != std::string::npos; open = text.find('\'', open)) {
        bool latin = false;
        std::size_t other = 0;
        std::size_t end = open + 1;
        for (; end < text.size() && text[end] != '\''; ++end) {
            const auto byte = static_cast<unsigned char>(text[end]);
            latin = latin || (byte >= 'A' && byte <= 'Z') || (byte >= 'a' && byte <= 'z');
            other = other == 0 && byte >= 0xCD && byte <= 0xD4 ? end : other;
        }
        if (latin && other != 0) {
            warnings.push_back("the label " + text.substr(open, end + 1 - open) +
                               " mixes Latin letters with others that only look like them: " +
                               SourceText(study.source).describe(other) + " at column " + std::to_string(other + 1));
        }
        open = end + 1;
        if (open >= text.size()) { return; }
    }
}

/// Warns about labels in the second slot of <...>: in osl, <R'coat'> compares the label with the scattering.
void warn_about_slots(const Study& study, std::vector<std::string>& warnings) {
    const std::string& text = study.source.expression;
    const auto item_end = [&](std::size_t at) {
        const char closer = text[at] == '[' ? ']' : text[at] == '(' ? ')' : '\0';
        return closer == '\0' ? at + 1 : std::min(text.find(closer, at), text.size() - 1) + 1;
    };
    bool quoted = false;
    for (std::size_t at = 0; at + 2 < text.size(); ++at) {
        quoted = quoted != (text[at] == '\'');
        if (quoted || text[at] != '<' || text[at + 1] == '\'') { continue; }
        const std::size_t second = item_end(at + 1);
        const std::string_view item = std::string_view(text).substr(std::min(second, text.size()));
        const bool excluded = item.starts_with("[^'");
        if (item.starts_with("'") || item.starts_with("['") || excluded) {
            warnings.push_back("the label at column " + std::to_string(second + 1) +
                               " is in the slot of <...> for the scattering: it " +
                               (excluded ? "excludes nothing" : "never matches") +
                               "; write '.' or the scattering before it, as in <R.'floor'>");
        }
    }
}

Explanation explanation_of(const ChannelSource& channel, const PathStrings& words) {
    const Study subject = study(channel, words);
    Explanation result;
    result.dialect = channel.dialect;
    result.expression = subject.source.expression;
    result.warnings = subject.expression.warnings;
    for (const std::string& prefix : subject.expression.prefixes) {
        result.prefixes.emplace_back(prefix, prefix_effect(prefix));
    }
    const CoreSet cores = occurring_cores(subject);
    const EventTeller::Members occurring = [&cores](const Event& event) {
        return cores[core_index(event)] ? Membership::in : Membership::never;
    };
    const EventSpace space({subject.expression.root.get()});
    const EventTeller events(space, channel.dialect, occurring);
    PathTeller teller(events, occurring, *subject.expression.root);
    result.sentence = capitalised(teller.sentence()) + ".";
    result.pieces = teller.pieces();
    for (const auto& word : sample_path_strings(subject.paths, sample_count)) {
        result.samples.push_back(witness_of(word, *subject.languages.classes));
    }
    const bool empty = result.samples.empty();
    if (!empty) {
        result.same_as = known_equals(subject, result.beauty);
        result.notes = notes_about(subject);
    }
    warn_about_bar(channel, subject.expression, words, result.warnings);
    if (channel.dialect == Dialect::osl) { warn_about_slots(subject, result.warnings); }
    warn_about_dead_pieces(subject, empty, result.warnings);
    warn_about_look_alikes(subject, result.warnings);
    warn_about_mixed_scripts(subject, result.warnings);
    return result;
}

}  // namespace

Result<Explanation> explain(const ChannelSource& channel, const PathStrings& words) {
    return guarded([&] { return explanation_of(channel, words); });
}

}  // namespace raylex::lpe
