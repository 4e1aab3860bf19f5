#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "experiments/job/channels/channel_plan.h"

namespace raylex::experiments {

Status add_denoiser_inputs(const ScenePathStrings& scene, ChannelPlan& plan, Job& job) {
    if (!job.outputs.denoise && job.outputs.keep_noisy)
        return error_at({"--keep-noisy", 0, 0},
                        "--keep-noisy keeps the noisy layers of a denoised image; expected --denoise with it");
    if (!job.outputs.denoise) return success();
    const auto refuse = [](const std::string& what) { return error_at({"--denoise", 0, 0}, "--denoise " + what); };
    if (!job.outputs.filters.empty()) return refuse("needs light whose variance is known; expected no display filter");
    for (const display::ChannelKind kind : {display::ChannelKind::light, display::ChannelKind::color})
        if (const display::ExrStorage& storage = job.outputs.storage[static_cast<std::size_t>(kind)];
            storage.type != display::StoredType::single_float)
            return refuse("needs light as float, so that denoised layers sum; expected no half in --exr");
    if (job.settings.buckets)
        plan.notes.emplace_back("--denoise reads the whole image at the end, in more memory than buckets take");
    std::vector<std::string> names;
    if (job.settings.channels.beauty) names.emplace_back("beauty");
    for (const display::PartitionDeclaration& partition : plan.partitions) {
        names.insert(names.end(), partition.layers.begin(), partition.layers.end());
        if (!partition.of.empty()) names.push_back(partition.of);
    }
    for (const char* name : {"albedo", "Nn"}) {
        names.emplace_back(name);
        auto guide = transport::named_channel(name, scene.alphabet.pattern_channels);
        if (!guide) return guide.error();
        if (std::none_of(plan.channels.begin(), plan.channels.end(),
                         [&](const display::ChannelDefinition& each) { return each.name == guide->name; }))
            plan.channels.push_back(std::move(*guide));
    }
    std::vector<display::StatisticRequest>& statistics = job.settings.channels.statistics;
    for (const std::string& name : names)
        if (std::none_of(statistics.begin(), statistics.end(), [&](const display::StatisticRequest& each) {
                return each.channel == name && each.statistic == display::Statistic::mse;
            }))
            statistics.push_back({name, display::Statistic::mse, {"--denoise", 0, 0}});
    return success();
}

}  // namespace raylex::experiments
