#include "experiments/study/run/cells/scene_store.h"

#include <algorithm>
#include <fstream>
#include <new>
#include <set>

#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/services/hash64.h"
#include "experiments/job/rendering/statistics.h"
#include "experiments/program/interrupt.h"
#include "lpe/algebra/proofs/check.h"
#include "transport/integrators/integrator.h"
#include "transport/integrators/omitted_paths.h"
#include "transport/render/clock.h"
#include "transport/render/film.h"
#include "transport/scene/scene_hash.h"

namespace raylex::experiments {
namespace {

Phase phase_of(const char* name, const transport::Stopwatch& watch) {
    return {name, watch.wall(), watch.process_cpu()};
}

/// Resets this process's peak memory, if the system supports it.
void reset_peak_memory() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

std::uint64_t peak_memory_since_reset() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;  // kilobytes
    return peak_memory_bytes();
}

Result<JobOutput> rendered_by(const Job& job, const PassPlan& passes, const StudyScene& made,
                              const std::function<void(const transport::RenderProgress&)>& progress,
                              const std::atomic<bool>* stop) {
    try {
        if (!passes.passes.empty()) return render_job(job, passes, made.loaded->scene, *made.built, progress, stop);
        // The identity of the checkpoint has the hash of the scene; render_job() would add another.
        auto image = transport::render(*made.built, job.settings, progress, stop);
        if (!image) return image.error();
        return JobOutput{*std::move(image)};
    } catch (const std::bad_alloc&) {
        return error_at({}, "out of memory; use a smaller resolution or fewer channels");
    }
}

}  // namespace

double relative_error(const transport::RenderOutput& output) {
    if (output.sum || output.beauty < 0 ||
        !output.frame_buffer.channels()[static_cast<std::size_t>(output.beauty)].statistics)
        return -1;
    display::AdaptiveSettings settings;
    settings.neighbourhood = 0;
    display::AdaptiveSampler measure(settings, output.frame_buffer.channels(), output.beauty,
                                     output.frame_buffer.layout());
    measure.decide(output.frame_buffer);
    return measure.progress().error;
}

Result<Job> SceneStore::job_of(std::size_t scene, std::size_t variant) {
    Job job = config_.job(scene, config_.variants[variant]);
    job.measure_refuted = true;
    // A sum of passes has no statistics in a study: its error is that between replicates.
    if (!job.passes.empty()) job.settings.channels.statistics.clear();
    if (Status possible = begin_passes(job); !possible) return possible.error();
    return job;
}

Result<const StudyScene*> SceneStore::scene(std::size_t index, const transport::EffectChoices& effects) {
    const std::pair key(index, effects.text());
    if (const auto known = scenes_.find(key); known != scenes_.end()) return &known->second;
    Job job = config_.base;
    const Job& from = config_.scenes[index].job;
    job.scene_file = from.scene_file;
    job.label_rules = from.label_rules;
    job.effects = effects;
    StudyScene made;
    // Loading does not check the flag, and no cell is in progress.
    const InterruptsAtOnce at_once("raylex: interrupted while a scene was loading; finished cells are kept\n");
    const transport::Stopwatch loading;
    auto loaded = load_job_scene(job);
    if (!loaded) return loaded.error();
    made.loaded = std::move(*loaded);
    made.load = phase_of("load", loading);
    made.hash =
        hash_text(hash64(job.rendering_space + "\n" + std::to_string(transport::scene_hash(made.loaded->scene))));
    const transport::Stopwatch building;
    auto built = transport::BuiltScene::build(made.loaded->scene, job.settings.machine);
    if (!built) return built.error();
    made.built = std::move(*built);
    made.build = phase_of("build", building);
    std::vector<Error> ignored;
    auto film = transport::read_film(made.built->film, from.settings.film.resolution, ignored);
    if (!film) return film.error();
    made.width = film->width;
    made.height = film->height;
    seconds_ += made.load.wall_seconds + made.build.wall_seconds;
    return &scenes_.emplace(key, std::move(made)).first->second;
}

Result<const ChannelPlan*> SceneStore::channels(std::size_t scene_index, std::size_t variant) {
    const std::pair key(scene_index, variant);
    if (const auto known = channels_.find(key); known != channels_.end()) return &known->second.first;
    auto made = scene(scene_index, config_.variants[variant].effects);
    if (!made) return made.error();
    auto job = job_of(scene_index, variant);
    if (!job) return job.error();
    const transport::Stopwatch planning;
    auto words = scene_path_strings(*job, (*made)->loaded->scene, (*made)->built.get());
    if (!words) return words.error();
    auto plan = plan_channels(*job, *words);
    if (!plan) return plan.error();
    if (!job->passes.empty()) {
        StudyPasses& of_variant = passes_[key];
        of_variant.channels = *plan;
        auto passes = plan_passes(*job, (*made)->loaded->scene, *words, of_variant.channels);
        if (!passes) return passes.error();
        if (!passes->refuted.empty()) return error_at({}, passes->refuted);
        of_variant.plan = *std::move(passes);
    } else {
        omissions_[key] = omissions(*job, **made, *words);
    }
    std::set<std::string> ruled;
    for (const display::RuleRequest& each : job->settings.channels.rules) ruled.insert(each.channel);
    for (display::ChannelDefinition& channel : plan->channels)
        if (channel.style == display::ChannelStyle::expression && !ruled.contains(channel.name))
            channel.statistics = !job->settings.film.splat;
    return &channels_.emplace(key, std::pair(std::move(*plan), phase_of("plan", planning))).first->second.first;
}

std::vector<OmittedPathsInfo> SceneStore::omissions(const Job& job, const StudyScene& scene,
                                                    const ScenePathStrings& words) {
    const transport::SceneEntity& entity =
        job.settings.paths.integrator ? *job.settings.paths.integrator : scene.loaded->scene.integrator;
    auto chosen = transport::choose_integrator(entity, job.settings.paths.max_depth);
    std::vector<OmittedPathsInfo> found;
    if (!chosen) return found;
    for (const transport::OmittedPaths& each : transport::omitted_paths(chosen->name)) {
        lpe::ChannelSource source;
        source.name = "omitted";
        source.expression = each.expression;
        source.dialect = each.dialect;
        source.origin = "what integrator '" + chosen->name + "' omits";
        const auto word = lpe::find_path_string(source, words.words);
        // If this cannot be determined, such paths may exist.
        if (!word || *word) found.push_back({each.expression, each.dialect == lpe::Dialect::osl ? "osl" : "renderman"});
    }
    return found;
}

Result<std::uint64_t> SceneStore::frame_buffer_bytes(std::size_t scene_index, std::size_t variant) {
    auto made = scene(scene_index, config_.variants[variant].effects);
    if (!made) return made.error();
    auto plan = channels(scene_index, variant);
    if (!plan) return plan.error();
    std::vector<display::ChannelDefinition> all = (*plan)->channels;
    if (const transport::RenderSettings& render = config_.variants[variant].render; render.channels.beauty) {
        display::ChannelDefinition beauty;
        beauty.name = "beauty";
        beauty.style = display::ChannelStyle::expression;
        beauty.statistics = !render.film.splat;
        all.push_back(beauty);
    }
    display::FrameBufferLayout layout;
    layout.width = (*made)->width;
    layout.height = (*made)->height;
    return display::total_bytes(display::frame_buffer_memory(layout, all));
}

Result<Rendered> SceneStore::render(const RenderOrder& order,
                                    const std::function<void(const transport::RenderProgress&)>& progress,
                                    const std::atomic<bool>* stop) {
    auto made = scene(order.scene, config_.variants[order.variant].effects);
    if (!made) return made.error();
    auto plan = channels(order.scene, order.variant);
    if (!plan) return plan.error();
    auto assembled = job_of(order.scene, order.variant);
    if (!assembled) return assembled.error();
    Job& job = *assembled;
    const ChannelPlan* rendered = *plan;
    PassPlan passes;
    std::uint64_t samples_of_passes = 0;  // for each sample of the budget
    if (const auto found = passes_.find({order.scene, order.variant}); found != passes_.end()) {
        passes = found->second.plan;
        rendered = &found->second.channels;
        for (PlannedPass& pass : passes.passes) {
            const std::uint64_t samples = pass.samples_per_pixel.value_or(1);
            samples_of_passes += samples;
            pass.samples_per_pixel.reset();
            if (order.samples > 0) pass.samples_per_pixel = order.samples * samples;
        }
    }
    job.settings.channels.list = rendered->channels;
    if (order.samples > 0) job.settings.samples.per_pixel = order.samples;
    job.settings.samples.seed = order.seed;
    job.settings.stop.limit = order.limit;
    job.settings.samples.first = order.first_sample;
    job.settings.samples.whole = order.whole;
    job.settings.paths.guide_samples = order.guide_samples;
    if (order.checkpoint) {
        job.settings.checkpoint = order.checkpoint;
        job.settings.identity = checkpoint_identity(job, (*made)->loaded->color);
        job.settings.identity.emplace_back("scene", (*made)->hash);
    }
    reset_peak_memory();
    const auto baseline_cpu = [&] { return order.beside == nullptr ? 0.0 : order.beside->cpu_seconds(); };
    const double before = baseline_cpu();
    const transport::Stopwatch watch;
    auto output = rendered_by(job, passes, **made, progress, stop);
    const double wall = watch.wall(), cpu = watch.process_cpu() - (baseline_cpu() - before);
    seconds_ += wall;
    if (!output) return output.error();
    const transport::RenderStatistics& statistics = output->output.statistics;
    // The statistics include sessions before an interruption; the stopwatch does not.
    const Phase prepare{"prepare", std::max(0.0, wall - statistics.render_seconds),
                        std::max(0.0, cpu - statistics.render_cpu_seconds)};
    const Phase rendering{"render", statistics.render_seconds, statistics.render_cpu_seconds};
    std::vector<std::string> warnings = (*made)->loaded->warnings;
    warnings.insert(warnings.end(), (*plan)->notes.begin(), (*plan)->notes.end());
    for (const Error& each : output->output.warnings) warnings.push_back(each.to_string());
    const Phase& planning = channels_.at({order.scene, order.variant}).second;
    if (samples_of_passes > 0 && order.samples > 0) output->output.samples.per_pixel /= samples_of_passes;
    std::vector<PassResult> of_passes;
    for (const PassRecord& each : output->passes)
        of_passes.push_back({each.name, each.method, each.samples_per_pixel, each.cpu_seconds});
    return Rendered{.job = std::move(job),
                    .output = std::move(output->output),
                    .partitions = rendered->partitions,
                    .passes = std::move(of_passes),
                    .pass_lines = output->pass_lines(),
                    .phases = {(*made)->load, planning, (*made)->build, prepare, rendering},
                    .warnings = std::move(warnings),
                    .omits = omissions_[{order.scene, order.variant}],
                    .peak_memory_bytes = peak_memory_since_reset(),
                    .seconds = prepare.wall_seconds + rendering.wall_seconds,
                    .cpu_seconds = prepare.cpu_seconds + rendering.cpu_seconds};
}

}  // namespace raylex::experiments
