#include "experiments/atlas/answer.h"

#include <algorithm>
#include <utility>

#include "experiments/atlas/scene_record.h"
#include "experiments/atlas/what_if.h"

namespace raylex::experiments {
namespace {

/// Removes partitions with a layer that became an interval, because the sum of its bounds is not known.
void keep_exact_partitions(AtlasAnswer& answer) {
    const std::vector<std::string>& undecided = answer.layers.undecided();
    std::erase_if(answer.description.partitions, [&](const display::PartitionDeclaration& partition) {
        const auto is_open = [&](const std::string& layer) {
            return std::find(undecided.begin(), undecided.end(), layer.empty() ? "beauty" : layer) != undecided.end();
        };
        const bool broken =
            is_open(partition.of) || std::any_of(partition.layers.begin(), partition.layers.end(), is_open);
        if (broken)
            answer.notes.push_back("partition '" + partition.name +
                                   "' is left out of the file: the atlas gives only bounds of one of its layers");
        return broken;
    });
}

}  // namespace

Result<AtlasAnswer> answer_question(display::AtlasFile& atlas, const Job& job, const AskSettings& settings) {
    const auto& attributes = atlas.description().attributes;
    const auto record = attributes.find("atlas/scene");
    auto scene = read_scene_record(record == attributes.end() ? "" : record->second, atlas.path());
    if (!scene) return scene.error();
    auto plan = plan_channels(job, *scene);
    if (!plan) return plan.error();
    AtlasAnswer answer;
    answer.notes = plan->notes;
    answer.refuted = plan->refuted;
    if (!answer.refuted.empty()) return answer;
    if (!plan->channels.empty())
        if (Status fits = display::check_exr_layout(plan->channels, display::invalid_channel, {}); !fits)
            return fits.error();
    const auto changed = what_if(atlas, settings.mix, settings.intervals, scene->words.max_depth);
    if (!changed) return changed.error();
    answer.notes.insert(answer.notes.end(), changed->notes.begin(), changed->notes.end());
    auto layers = RequestedLayers::make(atlas, *plan, settings, *changed);
    if (!layers) return layers.error();
    answer.layers = *std::move(layers);
    answer.description = atlas.description();
    answer.description.attributes["raylex/atlas"] = atlas.path();
    answer.description.partitions = plan->partitions;
    if (!settings.mix.lights.empty()) answer.description.attributes["raylex/mix"] = factors_text(settings.mix.lights);
    if (!settings.mix.colors.empty())
        answer.description.attributes["raylex/what_if"] = factors_text(settings.mix.colors);
    if (!changed->most.empty())
        answer.notes.emplace_back(
            "the atlas merges path strings with different factors, so the beauty is the middle of its bounds "
            "beauty_least and beauty_most");
    keep_exact_partitions(answer);
    if (Status fits =
            display::check_exr_layout(answer.layers.channels(), RequestedLayers::beauty, answer.description.partitions);
        !fits)
        return fits.error();
    return answer;
}

}  // namespace raylex::experiments
