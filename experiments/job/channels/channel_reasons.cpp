#include "experiments/job/channels/channel_reasons.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "experiments/job/channels/likely_mistakes.h"
#include "experiments/job/channels/named_labels.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/failure.h"
#include "lpe/language/glob.h"
#include "lpe/language/parser/parser.h"
#include "lpe/match.h"
#include "transport/materials/bsdf/bsdf.h"

namespace raylex::experiments {
namespace {

using enum NamedLabel::Role;
using Role = NamedLabel::Role;

/// Returns the labels in the scene, by role.
std::array<std::set<std::string>, 3> known_labels(const ScenePathStrings& scene) {
    std::array<std::set<std::string>, 3> known;
    known[object].insert(scene.alphabet.object_labels.begin(), scene.alphabet.object_labels.end());
    known[group].insert(scene.alphabet.light_groups.begin(), scene.alphabet.light_groups.end());
    for (const lpe::Event& event : scene.alphabet.scattering)
        // labels of media are their names
        if (event.type == lpe::EventType::volume) known[object].insert(event.labels[0]);
    for (const auto* events : {&scene.alphabet.scattering, &scene.user})
        for (const lpe::Event& event : *events)
            if (event.labels.size() > 1) known[lobe].insert(event.labels[1]);
    return known;
}

/// Increasingly larger worlds. Each adds something that this scene lacks to the previous one.
enum Lack : int { depth, user_events, objects, groups, lobes, background, emission, media, lack_count };

class Relaxed {
  public:
    Relaxed(const ScenePathStrings& scene, const std::vector<NamedLabel>& labels)
        : scene_(scene), user_(scene.user), words_(scene.words) {
        for (const NamedLabel& each : labels) {
            // A label for a glob that matches nothing: the glob with its wildcards replaced.
            std::string label;
            for (const char c : each.text)
                if (!each.glob || (c != '*' && c != '\\')) label += each.glob && c == '?' ? 'x' : c;
            for (const Role role : each.roles) named_[role].insert(label);
        }
        for (std::set<std::string>& names : named_) names.insert("another");
        known_ = known_labels(scene);
    }

    void add(Lack lack) {
        lpe::Alphabet& alphabet = *words_.alphabet;
        switch (lack) {
            case depth:
                words_.max_depth.reset();
                break;
            case user_events:
                for (std::uint8_t number = 1; number <= 12; ++number)
                    for (const std::string& label : scene_.alphabet.object_labels)
                        for (const std::string& name : all(lobe))
                            user_.push_back({lpe::EventType::user, lpe::Scatter::none, number, {label, name}});
                break;
            case objects:
                relabel(alphabet.scattering);
                relabel(user_);
                break;
            case groups:
                add_terminals(alphabet, scene_.alphabet.has_lights, scene_.alphabet.has_background);
                break;
            case lobes:
                add_lobes(alphabet);
                break;
            case background:
                add_terminals(alphabet, true, true);
                break;
            case emission:
                for (const std::string& name : all(group))
                    alphabet.terminals.push_back({lpe::EventType::emission, lpe::Scatter::none, 0, {name}});
                break;
            default:
                for (const std::string& label : all(object))
                    for (const std::string& name : all(lobe))
                        alphabet.scattering.push_back({lpe::EventType::volume, lpe::Scatter::none, 0, {label, name}});
        }
    }

    [[nodiscard]] lpe::PathStrings words() const {
        lpe::PathStrings result = words_;
        result.alphabet->scattering.insert(result.alphabet->scattering.end(), user_.begin(), user_.end());
        return result;
    }

  private:
    [[nodiscard]] std::set<std::string> all(Role role) const {
        std::set<std::string> result = known_[role];
        result.insert(named_[role].begin(), named_[role].end());
        result.insert("");
        return result;
    }
    /// Gives every object label all kinds of event that any object has.
    void relabel(std::vector<lpe::Event>& events) const {
        std::vector<lpe::Event> kinds;
        for (lpe::Event event : events) {
            event.labels[0].clear();
            if (std::find(kinds.begin(), kinds.end(), event) == kinds.end()) kinds.push_back(std::move(event));
        }
        for (const std::string& label : named_[object])
            for (lpe::Event event : kinds) {
                event.labels[0] = label;
                events.push_back(std::move(event));
            }
    }
    void add_lobes(lpe::Alphabet& alphabet) const {
        std::vector<lpe::Event> kinds;
        for (const auto type : {lpe::EventType::reflection, lpe::EventType::transmission})
            for (const auto scatter : {lpe::Scatter::diffuse, lpe::Scatter::glossy, lpe::Scatter::singular})
                for (std::uint8_t number = 0; number <= (scatter == lpe::Scatter::diffuse ? 4 : 8); ++number)
                    for (const std::string& name : all(lobe)) kinds.push_back({type, scatter, number, {"", name}});
        for (const std::string& label : scene_.alphabet.object_labels)
            for (lpe::Event event : kinds) {
                event.labels[0] = label;
                alphabet.scattering.push_back(std::move(event));
            }
    }
    void add_terminals(lpe::Alphabet& alphabet, bool lights, bool infinite) const {
        for (const std::string& name : all(group)) {
            if (lights) alphabet.terminals.push_back({lpe::EventType::light, lpe::Scatter::none, 0, {name}});
            if (infinite) alphabet.terminals.push_back({lpe::EventType::background, lpe::Scatter::none, 0, {name}});
        }
    }

    const ScenePathStrings& scene_;
    std::vector<lpe::Event> user_;
    lpe::PathStrings words_;
    std::array<std::set<std::string>, 3> named_, known_;
};

bool has(const std::vector<lpe::Event>& events, const lpe::Event& event) {
    return std::find(events.begin(), events.end(), event) != events.end();
}

/// Returns whether an event of the same kind exists, for any object.
bool has_lobe(const std::vector<lpe::Event>& events, const lpe::Event& wanted) {
    return std::any_of(events.begin(), events.end(), [&](const lpe::Event& event) {
        return event.type == wanted.type && event.scatter == wanted.scatter &&
               event.lobe_number == wanted.lobe_number && event.labels.size() == 2 && wanted.labels.size() == 2 &&
               event.labels[1] == wanted.labels[1];
    });
}

/// Returns the part of an event that the scene lacks, or nothing.
std::string lack_of(lpe::Event event, const ScenePathStrings& scene) {
    const std::array<std::set<std::string>, 3> known = known_labels(scene);
    const bool terminal = event.type == lpe::EventType::light || event.type == lpe::EventType::background ||
                          event.type == lpe::EventType::emission;
    event.labels.resize(terminal ? 1 : 2);  // a witness omits trailing empty labels
    if (event.type == lpe::EventType::camera) return {};
    const auto of_object = [&] { return event.labels[0].empty() ? std::string() : " on '" + event.labels[0] + "'"; };
    if (terminal) {
        if (has(scene.alphabet.terminals, event)) return {};
        if (event.type == lpe::EventType::emission) {
            const bool glows = std::any_of(scene.alphabet.terminals.begin(), scene.alphabet.terminals.end(),
                                           [](const lpe::Event& e) { return e.type == lpe::EventType::emission; });
            return glows ? "emission (O) with the label '" + event.labels[0] +
                               "', and emitting objects of this scene have none"
                         : "emission (O), and nothing in this scene emits";
        }
        const bool infinite = event.type == lpe::EventType::background;
        if (infinite ? !scene.alphabet.has_background : !scene.alphabet.has_lights)
            return infinite ? "an infinite light (B), and this scene has none"
                            : "a light other than infinite ones, and this scene has none";
        const std::string& name = event.labels[0];
        const bool no_groups = known[group].empty() || (known[group].size() == 1 && known[group].contains(""));
        return (infinite ? "an infinite light " : "a light ") +
               (name.empty() ? std::string("without a group") : "of the group '" + name + "'") +
               (no_groups ? ", and no light of this scene has a group; a job's [[light_group]] tables give them"
                          : ", and this scene has none" + did_you_mean(name, known[group]));
    }
    if (event.type == lpe::EventType::volume) {
        if (has(scene.alphabet.scattering, event)) return {};
        std::set<std::string> media;
        for (const lpe::Event& each : scene.alphabet.scattering)
            if (each.type == lpe::EventType::volume) media.insert(each.labels[0]);
        if (media.empty()) return "a medium that scatters (V), and this scene has none";
        if (media.contains(event.labels[0]))
            return "a lobe of the medium '" + event.labels[0] + "', and media have none";
        return "a medium that scatters (V) labelled '" + event.labels[0] + "', and this scene has none" +
               did_you_mean(event.labels[0], media);
    }
    const bool user = event.type == lpe::EventType::user;
    const std::vector<lpe::Event>& events = user ? scene.user : scene.alphabet.scattering;
    if (has(events, event)) return {};
    if (!known[object].contains(event.labels[0]))
        return (event.labels[0] == "another" ? std::string("an object of another label")
                                             : "an object labelled '" + event.labels[0] + "'") +
               ", and this scene has none" + did_you_mean(event.labels[0], known[object]);
    lpe::Event plain = event;
    plain.labels.clear();
    std::string what = user ? "the user event U" + std::to_string(event.lobe_number)
                            : lpe::to_sentence(std::vector<lpe::Event>{plain});
    if (!event.labels[1].empty() && event.labels[1] != "another") what += " by the lobe '" + event.labels[1] + "'";
    if (user && !has_lobe(events, event))
        return what + ", which the integrator does not report" + did_you_mean(event.labels[1], known[lobe]);
    if (!has_lobe(events, event))
        return what + ", and no material of this scene gives it" + did_you_mean(event.labels[1], known[lobe]);
    return what + of_object() + ", which its material does not give";
}

/// Returns what the scene lacks for a path that matches: "it needs X and Y".
std::string reason(const lpe::Witness& witness, const ScenePathStrings& scene) {
    std::vector<std::string> lacks;
    int scatterings = 0;
    for (const lpe::Event& event : witness.events) {
        const bool scatters = event.type == lpe::EventType::reflection || event.type == lpe::EventType::transmission ||
                              event.type == lpe::EventType::volume;
        scatterings += scatters && event.scatter != lpe::Scatter::straight ? 1 : 0;
        const std::string lack = lack_of(event, scene);
        if (!lack.empty() && std::find(lacks.begin(), lacks.end(), lack) == lacks.end()) lacks.push_back(lack);
    }
    if (scene.words.max_depth && scatterings > *scene.words.max_depth)
        lacks.push_back(std::to_string(scatterings) + " scattering events, and this render follows at most " +
                        std::to_string(*scene.words.max_depth));
    std::string text = "it needs ";
    for (std::size_t i = 0; i < lacks.size(); ++i) text += (i > 0 ? "; and " : "") + lacks[i];
    return text;
}

}  // namespace

Result<std::vector<std::string>> unknown_labels(const lpe::ChannelSource& channel, const ScenePathStrings& scene) {
    auto labels = labels_of(channel);
    if (!labels) return labels.error();
    const std::array<std::set<std::string>, 3> known = known_labels(scene);
    std::vector<std::string> notes;
    for (const NamedLabel& label : *labels) {
        std::set<std::string> candidates;
        std::string roles;
        for (const Role role : label.roles) {
            candidates.insert(known[role].begin(), known[role].end());
            roles += (roles.empty() ? "" : " or ") + std::string(NamedLabel::role_names[role]);
        }
        if (label.roles.empty()) continue;
        const bool found =
            label.glob ? std::any_of(candidates.begin(), candidates.end(),
                                     [&](const std::string& each) { return lpe::glob_matches(label.text, each); })
                       : candidates.contains(label.text);
        if (found) continue;
        std::string note = label.glob ? "'" + label.text + "' matches no " + roles + " of this scene"
                                      : "'" + label.text + "' is not a known " + roles + " of this scene";
        note += did_you_mean(label.text, candidates);
        if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
    }
    return notes;
}

Result<std::optional<std::string>> why_never(const lpe::ChannelSource& channel, const ScenePathStrings& scene) {
    const auto matches = [&](const lpe::PathStrings& words) { return lpe::find_path_string(channel, words); };
    auto word = matches(scene.with_user_events());
    if (!word) return word.error();
    if (word->has_value()) return std::optional<std::string>();
    auto labels = labels_of(channel);
    if (!labels) return labels.error();
    // The reason is a single addition if one suffices; otherwise all additions up to the first that suffices.
    for (int lack = 0; lack < lack_count; ++lack) {
        Relaxed wider(scene, *labels);
        wider.add(static_cast<Lack>(lack));
        word = matches(wider.words());
        if (!word) return word.error();
        if (word->has_value()) return std::optional(reason(**word, scene));
    }
    Relaxed wider(scene, *labels);
    for (const Lack lack : {depth, user_events, lobes, objects, groups, background, emission, media}) {
        wider.add(lack);
        word = matches(wider.words());
        if (!word) return word.error();
        if (word->has_value()) return std::optional(reason(**word, scene));
    }
    const std::string mistake = likely_mistake(channel, wider.words());
    return std::optional<std::string>("no path of any scene matches it" +
                                      (mistake.empty() ? std::string() : ": " + mistake));
}

}  // namespace raylex::experiments
