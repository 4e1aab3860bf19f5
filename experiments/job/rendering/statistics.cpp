#include "experiments/job/rendering/statistics.h"

#include <sys/resource.h>
#include <array>
#include <chrono>
#include <ctime>

#include "experiments/job/rendering/effect_report.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/job/text/json.h"
#include "experiments/program/console.h"
#include "transport/paths/guide/guide_view.h"

namespace raylex::experiments {
namespace {

double wall_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double cpu_now() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

Json phases_json(const RunRecord& record) {
    Json phases;
    for (const char* name : {"load", "plan", "build", "prepare", "render", "write"}) {
        const auto found = record.phases.find(name);
        const PhaseTime time = found != record.phases.end() ? found->second : PhaseTime{};
        phases[name] = {{"wall_seconds", time.wall_seconds}, {"cpu_seconds", time.cpu_seconds}};
    }
    return phases;
}

/// Returns every logged rejected contribution with the command that renders its sample again.
Json invalid_json(const RunRecord& record) {
    const transport::RenderStatistics& statistics = record.output->statistics;
    Json log = Json::array();
    const auto channels = record.output->frame_buffer.channels();
    for (const display::InvalidSample& each : statistics.invalid_log) {
        // JSON has no form for non-finite numbers, so they are stored as text.
        log.push_back(
            {{"pixel", {each.pixel_x, each.pixel_y}},
             {"sample", each.sample},
             {"value", {std::to_string(each.value.r), std::to_string(each.value.g), std::to_string(each.value.b)}},
             {"replay",
              {{"seed", record.output->used.seed},
               {"isa", record.output->used.isa},
               {"sampler", record.output->used.sampler},
               {"integrator", record.output->used.integrator},
               {"scene", record.job->scene_file},
               {"samples_per_pixel", record.output->samples.per_pixel},
               {"command", replay_command(*record.job, *record.output, record.arguments, each)}}}});
        if (each.channel >= 0) log.back()["channel"] = channels[static_cast<std::size_t>(each.channel)].name;
    }
    Json by_channel = Json::object();
    for (std::size_t i = 0; i < statistics.invalid_by_channel.size(); ++i)
        if (statistics.invalid_by_channel[i] > 0) by_channel[channels[i].name] = statistics.invalid_by_channel[i];
    return {{"count", statistics.invalid_samples}, {"by_channel", by_channel}, {"logged", log}};
}

Json splits_json(const RunRecord& record) {
    Json splits = Json::array();
    for (const display::SplitResult& result : record.splits)
        splits.push_back({{"partition", result.partition},
                          {"of", result.of.empty() ? "beauty" : result.of},
                          {"layers", result.layers},
                          {"holds", result.holds},
                          {"largest_absolute", result.largest_absolute},
                          {"largest_relative", result.largest_relative},
                          {"bound", result.bound},
                          {"past_rounding_pixels", result.past_rounding},
                          {"exceeding_pixels", result.exceeding},
                          {"non_finite_pixels", result.non_finite}});
    return splits;
}

Json cryptomatte_json(const transport::RenderOutput& output) {
    Json mattes = Json::array();
    for (const geoaovs::Cryptomatte& matte : output.cryptomatte) {
        const geoaovs::Cryptomatte::Remainder left = matte.remainder();
        mattes.push_back({{"name", matte.name()},
                          {"ranks", matte.ranks()},
                          {"names", matte.name_count()},
                          {"memory_bytes", matte.coverage().memory_bytes()},
                          {"remainder", {{"largest", left.largest}, {"mean", left.mean}, {"pixels", left.pixels}}}});
    }
    return mattes;
}

Json memory_json(const RunRecord& record) {
    Json layers = Json::object();
    for (const display::MemoryItem& item : record.memory) layers[item.name] = item.bytes;
    return {{"total_bytes", display::total_bytes(record.memory)},
            {"limit_bytes", record.job->outputs.memory_limit},
            {"layers", layers}};
}

/// Where the guide pays: the probability of each region is the one that was expected to pay most.
Json paid_json(const transport::GuideView& view) {
    constexpr std::array<const char*, transport::GuideTree::orientations> names{"+x", "-x", "+y",   "-y",
                                                                                "+z", "-z", "media"};
    const std::vector<transport::GuideTree::Region>& regions = view.tree.regions();
    const std::vector<std::uint8_t> sides = view.tree.sides();
    std::map<transport::Real, std::uint64_t> counts;
    std::array<std::uint64_t, names.size()> all{}, guided{};
    for (std::size_t i = 0; i < regions.size(); ++i) {
        ++counts[regions[i].share];
        ++all[sides[i]];
        if (regions[i].share > 0) ++guided[sides[i]];
    }
    double sum = 0;
    for (std::size_t i = 0; i < view.regions.size(); ++i) sum += double{view.share(i)};
    Json json{{"image_share", view.guided()}, {"image_probability", sum / static_cast<double>(view.regions.size())}};
    for (const auto& [probability, count] : counts) json["regions"][number_text(double{probability})] = count;
    for (std::size_t i = 0; i < names.size(); ++i)
        json["sides"][names[i]] = {{"regions", all[i]}, {"guided", guided[i]}};
    return json;
}

Json guide_json(const RunRecord& record) {
    const transport::RenderStatistics& statistics = record.output->statistics;
    const transport::GuideSummary& guide = statistics.guide;
    Json json{{"used", guide.used},          {"samples_per_pixel", guide.samples}, {"paths", guide.paths},
              {"regions", guide.regions},    {"guided_share", guide.guided},       {"memory_bytes", guide.bytes},
              {"forecast_gain", guide.gain}, {"wall_seconds", guide.seconds},      {"cpu_seconds", guide.cpu_seconds}};
    if (guide.read) json["read"] = true;
    if (statistics.guide_view) json["paid"] = paid_json(*statistics.guide_view);
    if (!record.guide_view.is_null()) json["view"] = record.guide_view;
    return json;
}

Json deep_json(const display::DeepCounts& counts) {
    return {{"samples", counts.samples},
            {"pixels_past_the_limit", counts.merged_pixels},
            {"coarsest_tolerance", counts.coarsest},
            {"refused_rows", counts.refused_rows}};
}

}  // namespace

PhaseClock::PhaseClock() : wall_(wall_now()), cpu_(cpu_now()) {}

PhaseTime PhaseClock::elapsed() const {
    return {wall_now() - wall_, cpu_now() - cpu_};
}

std::uint64_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux reports kilobytes
}

std::string statistics_json(const RunRecord& record) {
    const transport::RenderOutput& output = *record.output;
    const transport::RenderStatistics& statistics = output.statistics;
    const std::uint64_t rays = statistics.camera_rays + statistics.scattering_rays + statistics.shadow_rays;
    const double cpu = statistics.render_cpu_seconds;
    Json json;
    json["complete"] = output.samples.complete;
    json["image"] = {{"file", record.job->output}, {"width", output.view.width}, {"height", output.view.height}};
    json["phases"] = phases_json(record);
    json["rays"] = {{"camera", statistics.camera_rays},
                    {"scattering", statistics.scattering_rays},
                    {"shadow", statistics.shadow_rays},
                    {"total", rays},
                    {"pilot", statistics.pilot_rays}};
    json["branches"] = statistics.branches;
    if (statistics.guide.samples > 0 || statistics.guide.read) json["guide"] = guide_json(record);
    json["effects"] = effects_json(record.effects, record.job->effects);
    json["aovs"] = aovs_json(record.job->settings.channels.list);
    const auto pruned = [&](transport::Pruned cause) { return statistics.pruned[static_cast<std::size_t>(cause)]; };
    json["pruned"] = {{"paths", pruned(transport::Pruned::paths)},
                      {"light_samples", pruned(transport::Pruned::light_samples)},
                      {"shadow_rays", pruned(transport::Pruned::shadow_rays)},
                      {"rays_left_to_light_samples", pruned(transport::Pruned::rays_left_to_light_samples)},
                      {"light_samples_left_to_rays", pruned(transport::Pruned::light_samples_left_to_rays)},
                      {"lobes", pruned(transport::Pruned::lobes)},
                      {"light_paths", pruned(transport::Pruned::light_paths)},
                      {"joins", pruned(transport::Pruned::connections)},
                      {"weak_paths", pruned(transport::Pruned::weak_paths)},
                      {"closures", pruned(transport::Pruned::closures)}};
    json["samples"] = {{"camera", statistics.camera_samples},
                       {"per_pixel", output.samples.per_pixel},
                       {"per_cpu_second", cpu > 0 ? static_cast<double>(statistics.camera_samples) / cpu : 0.0}};
    if (output.frame_buffer.light_path_count() > 0)
        json["samples"]["light_paths"] = output.frame_buffer.light_path_count();
    if (output.samples.resumed > 0) json["samples"]["resumed"] = output.samples.resumed;
    if (output.samples.adaptive)
        json["adaptive"] = {{"settings", describe(*record.job->settings.stop.adaptive)},
                            {"channel", output.samples.adaptive->channel},
                            {"error", output.samples.adaptive->error},
                            {"unconverged_pixels", output.samples.unconverged_pixels}};
    if (record.job->settings.checkpoint)
        json["checkpoints"] = {{"written", statistics.checkpoints},
                               {"stall_seconds", statistics.checkpoint_stall_seconds}};
    json["rays_per_cpu_second"] = cpu > 0 ? static_cast<double>(rays) / cpu : 0.0;
    json["path_length_histogram"] = statistics.path_length_histogram;
    json["attribution_overflow"] = statistics.attribution_overflow;
    json["invalid_samples"] = invalid_json(record);
    json["rejected_block_sums"] = output.sums.rejected;
    json["refused_services_calls"] = statistics.refused_services_calls;
    json["memory"] = memory_json(record);
    if (record.deep != nullptr) json["deep"] = deep_json(record.deep->counts());
    json["peak_memory_bytes"] = peak_memory_bytes();
    json["threads"] = output.used.threads;
    json["seed"] = output.used.seed;
    json["splits"] = splits_json(record);
    json["cryptomatte"] = cryptomatte_json(output);
    json["warnings"] = record.warnings;
    json["provenance"] = record.attributes;
    // Paths and scene text may contain bytes that are not UTF-8. They are replaced; nothing is thrown.
    return json_text(json, 2) + "\n";
}

}  // namespace raylex::experiments
