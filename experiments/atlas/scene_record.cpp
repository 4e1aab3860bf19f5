#include "experiments/atlas/scene_record.h"

#include <utility>

#include "experiments/job/text/json_fields.h"
#include "lpe/match.h"

namespace raylex::experiments {
namespace {

/// Events as text. to_text() omits trailing empty labels, so they are added after reading.
struct EventsText {
    std::vector<lpe::Event>& events;
    std::size_t labels;
};
void to_json(Json& json, const EventsText& text) {
    json = lpe::to_text(text.events);
}
void from_json(const Json& json, EventsText& text) {
    auto events = lpe::parse_events(json.get<std::string>());
    if (!events) throw Json::other_error::create(501, "no events", &json);
    for (lpe::Event& event : *events) event.labels.resize(text.labels);
    text.events = std::move(*events);
}

}  // namespace

static void visit_fields(auto visit, transport::SceneAlphabet& alphabet) {
    visit("labels", alphabet.object_labels);
    visit("groups", alphabet.light_groups);
    visit("lights", alphabet.has_lights);
    visit("background", alphabet.has_background);
    visit("straight", alphabet.has_straight);
    visit("scattering", EventsText{alphabet.scattering, 2});
    visit("terminals", EventsText{alphabet.terminals, 1});
}

std::string scene_record(const ScenePathStrings& scene) {
    Json json = scene.alphabet;
    if (scene.words.max_depth) json["max_depth"] = *scene.words.max_depth;
    json["holdouts"] = scene.holdouts;
    return json_text(json);
}

Result<ScenePathStrings> read_scene_record(const std::string& text, const std::string& path) {
    try {
        const Json json = parse_json(text);
        ScenePathStrings scene{json, {}, {}, json.at("holdouts")};
        scene.words.alphabet = lpe::Alphabet{scene.alphabet.scattering, scene.alphabet.terminals};
        if (json.contains("max_depth")) scene.words.max_depth = whole(json.at("max_depth"));
        return scene;
    } catch (const Json::exception&) {
        return error_at({path, 0, 0},
                        "the atlas has no record of its scene (atlas/scene in the header); "
                        "expected an atlas from raylex render --atlas");
    }
}

}  // namespace raylex::experiments
