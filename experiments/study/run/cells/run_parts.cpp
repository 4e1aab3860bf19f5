#include "experiments/study/run/cells/run_parts.h"

#include <algorithm>
#include <set>

#include "display/checkpoint/banded_record.h"
#include "display/services/parameters.h"
#include "experiments/job/text/json.h"
#include "experiments/shards/recorded_image.h"
#include "experiments/study/run/cells/run_files.h"
#include "transport/integrators/integrator.h"
#include "transport/render/tiles.h"

namespace raylex::experiments {
namespace {

constexpr auto block = static_cast<std::uint64_t>(transport::TileGrid::block_size);

/// Returns why all cells of a method with budgets of this kind stay whole; empty if they can be split.
std::string reason_of_plan(const ExperimentConfig& config, const PlannedRun& planned) {
    const Variant& variant = config.variants[planned.variant];
    if (!config.methods[variant.method].command.empty()) return "an external command renders whole cells";
    if (!variant.passes.empty()) return "its passes have numbers of samples of their own";
    if (planned.run.budget_kind != BudgetKind::samples)
        return "the number of samples for a budget of " + budget_kind_name(planned.run.budget_kind) +
               " is not known in advance";
    if (!config.base.settings.mattes.kinds.empty()) return "cryptomattes need whole renders";
    return {};
}

std::string range_text(const StudyRun& part) {
    return "samples " + std::to_string(part.first_sample) + " to " + std::to_string(part.end_sample - 1);
}

Error part_error(const StudyRun& part, std::string message, std::string hint = {}) {
    return error_at({part.directory, 0, 0}, std::move(message), std::move(hint));
}

}  // namespace

std::string reason_of_scene(const ExperimentConfig& config, std::size_t scene_index, std::size_t variant,
                            SceneStore& scenes) {
    auto scene = scenes.scene(scene_index, config.variants[variant].effects);
    if (!scene) return {};  // the cells report this error
    const transport::RenderSettings& render = config.variants[variant].render;
    auto chosen = transport::choose_integrator(
        render.paths.integrator ? *render.paths.integrator : (*scene)->loaded->scene.integrator,
        render.paths.max_depth);
    if (chosen && chosen->integrator->starts_up())
        return "the Markov chains of integrator '" + chosen->name + "' would start in the same state in every part";
    return {};
}

WorkList split_runs(const ExperimentConfig& config, const Plan& plan, const ReasonToKeep& reason_to_keep,
                    unsigned split) {
    WorkList work;
    std::set<std::string> said;
    std::map<std::pair<std::size_t, std::size_t>, std::string> reasons;
    for (const PlannedRun& planned : plan.runs) {
        std::string reason;
        if (split > 1) {
            const std::pair key(planned.scene, planned.variant);
            reason = reason_of_plan(config, planned);
            if (reason.empty()) {
                if (!reasons.contains(key)) reasons[key] = reason_to_keep(planned.scene, planned.variant);
                reason = reasons[key];
            }
        }
        const auto samples = static_cast<std::uint64_t>(planned.run.budget);
        const std::uint64_t blocks = (samples + block - 1) / block, parts = std::min<std::uint64_t>(split, blocks);
        if (split > 1 && reason.empty() && parts < 2)
            reason = "a part needs at least " + std::to_string(block) + " samples per pixel";
        if (split < 2 || !reason.empty()) {
            const std::string who = "cells of method '" + planned.run.method + "' with a budget of " +
                                    budget_text(planned.run.budget_kind, planned.run.budget);
            if (!reason.empty() && said.insert(who).second) work.notes.push_back(who + " stay whole: " + reason);
            work.items.push_back(planned);
            continue;
        }
        for (std::uint64_t part = 0; part < parts; ++part) {
            PlannedRun item = planned;
            item.run.part_of = planned.run.id;
            item.run.id += ".p" + std::to_string(part + 1) + "of" + std::to_string(parts);
            item.run.first_sample = blocks * part / parts * block;
            item.run.end_sample = std::min(samples, blocks * (part + 1) / parts * block);
            work.items.push_back(std::move(item));
        }
    }
    return work;
}

Status write_part_record(const std::string& directory, const Rendered& rendered, const JobScene& scene,
                         const std::map<std::string, std::string>& attributes) {
    RecordedImage image;
    image.description = image_description(rendered.job, scene, rendered.output, rendered.partitions, attributes);
    image.beauty = rendered.output.beauty;
    return write_sums(directory + "/record.bin", record_identity(rendered), rendered.output.frame_buffer,
                      json_text(image_json(image)));
}

Status check_parts(const StudyRun& run, std::vector<const StudyRun*>& parts) {
    std::sort(parts.begin(), parts.end(), [](const StudyRun* a, const StudyRun* b) {
        return a->first_sample != b->first_sample ? a->first_sample < b->first_sample
               : a->end_sample != b->end_sample   ? a->end_sample < b->end_sample
                                                  : a->directory < b->directory;
    });
    const auto total = static_cast<std::uint64_t>(run.budget);
    const auto gap = [&](std::uint64_t from, std::uint64_t to) {
        return part_error(*parts.front(),
                          "cell '" + run.id + "' is incomplete: samples " + std::to_string(from) + " to " +
                              std::to_string(to - 1) + " are in no directory",
                          "run the shard with these samples, with the same --split-cells");
    };
    std::uint64_t reached = 0;
    const StudyRun* rendered = nullptr;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const StudyRun& part = *parts[i];
        if (part.seed != run.seed)
            return part_error(part, "this part has seed " + std::to_string(part.seed) + "; its cell '" + run.id +
                                        "' has " + std::to_string(run.seed));
        if (!part.failed && rendered == nullptr) rendered = &part;
        if (!part.failed && part.isa != rendered->isa)
            return part_error(
                part,
                "this part was rendered with " + part.isa + ", the one in '" + rendered->directory + "' with " +
                    rendered->isa + ", so they do not belong to one render",
                "isa = \"sse4.2\" or another in the config makes all machines use the same instruction set");
        if (i > 0 && part.first_sample < reached)
            return part_error(part,
                              "this part of cell '" + run.id + "' has " + range_text(part) + ", and '" +
                                  parts[i - 1]->directory + "' has " + range_text(*parts[i - 1]) + ": they overlap",
                              "every sample may occur once; leave out one of the two");
        if (part.first_sample > reached) return gap(reached, part.first_sample);
        reached = part.end_sample;
    }
    if (reached < total) return gap(reached, total);
    return success();
}

StudyRun merged_run(const StudyRun& planned, const std::vector<const StudyRun*>& parts) {
    StudyRun run = planned;
    run.parts = static_cast<unsigned>(parts.size());
    for (const StudyRun* part : parts) {
        if (!part->failed) run.isa = part->isa;
        run.samples_per_pixel += part->samples_per_pixel;
        run.wall_seconds += part->wall_seconds;
        run.cpu_seconds += part->cpu_seconds;
        run.rays += part->rays;
        run.invalid_samples += part->invalid_samples;
        run.peak_memory_bytes = std::max(run.peak_memory_bytes, part->peak_memory_bytes);
        run.threads = std::max(run.threads, part->threads);
        run.other_load = std::max(run.other_load, part->other_load);
        if (("\n" + run.machine + "\n").find("\n" + part->machine + "\n") == std::string::npos)
            run.machine += (run.machine.empty() ? "" : "\n") + part->machine;
        for (const Phase& phase : part->phases) {
            auto same = std::find_if(run.phases.begin(), run.phases.end(),
                                     [&](const Phase& each) { return each.name == phase.name; });
            if (same == run.phases.end()) same = run.phases.insert(run.phases.end(), {phase.name, 0, 0});
            same->wall_seconds += phase.wall_seconds;
            same->cpu_seconds += phase.cpu_seconds;
        }
        if (run.omits.empty()) run.omits = part->omits;
        for (const std::string& warning : part->warnings)
            if (std::find(run.warnings.begin(), run.warnings.end(), warning) == run.warnings.end())
                run.warnings.push_back(warning);
        if (part->failed && !run.failed) {
            run.failed = true;
            run.failure = "part '" + part->id + "' failed: " + part->failure;
        }
    }
    return run;
}

Result<std::vector<PartitionResult>> write_merged_files(const std::string& directory, const StudyRun& run,
                                                        const std::vector<const StudyRun*>& parts) {
    std::vector<display::BandedRecord> records;
    RecordedImage whole_image;
    std::uint64_t camera_samples = 0;
    for (const StudyRun* part : parts) {
        const std::string path = part->directory + "/record.bin";
        auto file = display::RecordFileReader::open(path);
        if (!file) return file.error();
        if (!file->has("image")) return error_at({path, 0, 0}, "this is not a record of a part of a cell");
        const auto image = file->read("image");
        if (!image) return image.error();
        try {
            const Json json = parse_json(*image);
            if (records.empty()) whole_image = image_of(json);
            camera_samples += std::stoull(json.at("attributes").at("raylex/camera_samples").get<std::string>());
        } catch (const std::exception& error) {
            return error_at({path, 0, 0}, std::string("the record's image is damaged: ") + error.what());
        }
        auto record = display::BandedRecord::open(*std::move(file));
        if (!record) return record.error();
        records.push_back(*std::move(record));
    }
    const auto sum = display::sum_of_records(records);
    if (!sum) return sum.error();
    display::RecordIdentity identity = records.front().file().identity();
    const std::string samples = std::to_string(run.samples_per_pixel);
    for (auto& [name, value] : identity)
        if (name == "samples per pixel") value = samples;
    display::ImageDescription& description = whole_image.description;
    description.attributes["raylex/samples_per_pixel"] = samples;
    description.attributes["raylex/camera_samples"] = std::to_string(camera_samples);
    description.attributes["raylex/parts"] = std::to_string(parts.size());
    if (const std::uint64_t paths = sum->light_path_count(); paths > 0)
        description.attributes["raylex/light_paths"] = std::to_string(paths);
    return write_buffer_files(directory, *sum, &*sum, whole_image.beauty, std::move(description), std::move(identity));
}

}  // namespace raylex::experiments
