#include "experiments/atlas/scene_record.h"

#include <utility>

#include "experiments/job/text/json.h"
#include "lpe/match.h"

namespace raylex::experiments {
namespace {

/// Reads events from JSON. to_text() omits trailing empty labels, so they are added here.
std::vector<lpe::Event> events_of(const Json& json, std::size_t labels, bool& good) {
    auto events = lpe::parse_events(json.get<std::string>());
    if (!events) {
        good = false;
        return {};
    }
    for (lpe::Event& event : *events) event.labels.resize(labels);
    return std::move(*events);
}

}  // namespace

std::string scene_record(const SceneWords& scene) {
    const transport::SceneAlphabet& alphabet = scene.alphabet;
    Json json;
    json["labels"] = alphabet.object_labels;
    json["groups"] = alphabet.light_groups;
    json["lights"] = alphabet.has_lights;
    json["background"] = alphabet.has_background;
    json["straight"] = alphabet.has_straight;
    json["scattering"] = lpe::to_text(alphabet.scattering);
    json["terminals"] = lpe::to_text(alphabet.terminals);
    if (scene.words.max_depth) json["max_depth"] = *scene.words.max_depth;
    json["holdouts"] = scene.holdouts;
    return json_text(json);
}

Result<SceneWords> read_scene_record(const std::string& text, const std::string& path) {
    const Error damaged = error_at({path, 0, 0},
                                   "the atlas has no record of its scene (atlas/scene in the header); "
                                   "expected an atlas from raylex render --atlas");
    try {
        const Json json = parse_json(text);
        SceneWords scene;
        bool good = true;
        transport::SceneAlphabet& alphabet = scene.alphabet;
        alphabet.object_labels = json.at("labels").get<std::vector<std::string>>();
        alphabet.light_groups = json.at("groups").get<std::vector<std::string>>();
        alphabet.has_lights = json.at("lights").get<bool>();
        alphabet.has_background = json.at("background").get<bool>();
        alphabet.has_straight = json.at("straight").get<bool>();
        alphabet.scattering = events_of(json.at("scattering"), 2, good);
        alphabet.terminals = events_of(json.at("terminals"), 1, good);
        scene.words.alphabet = lpe::Alphabet{alphabet.scattering, alphabet.terminals};
        if (json.contains("max_depth")) scene.words.max_depth = whole(json.at("max_depth"));
        scene.holdouts = json.at("holdouts").get<bool>();
        if (!good) return damaged;
        return scene;
    } catch (const Json::exception&) { return damaged; }
}

}  // namespace raylex::experiments
