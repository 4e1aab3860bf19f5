#include "experiments/shards/shard_render.h"

#include <algorithm>
#include <filesystem>

#include "display/checkpoint/banded_record.h"
#include "display/output/atlas/atlas_file.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/job/text/json_fields.h"
#include "transport/integrators/integrator.h"
#include "transport/render/tiles.h"
#include "transport/scene/sampler.h"

namespace raylex::experiments {
namespace {

constexpr auto shard_block = static_cast<std::uint64_t>(transport::TileGrid::block_size);

constexpr const char* one_process = "render in one process, without --shard and --shards";

Result<transport::ChosenIntegrator> integrator_of(const Job& job, const transport::SceneDescription& scene) {
    return transport::choose_integrator(
        job.settings.paths.integrator ? *job.settings.paths.integrator : scene.integrator,
        job.settings.paths.max_depth);
}

}  // namespace

static void visit_fields(auto visit, ShardFacts& facts) {
    visit("part", facts.part);
    visit("parts", facts.parts);
    visit("first_sample", facts.range.first);
    visit("end_sample", facts.range.end);
    visit("samples_per_pixel", facts.range.total);
    visit("camera_samples", facts.camera_samples);
    visit("invalid_samples", facts.invalid_samples);
    visit("atlas", facts.has_atlas);
    visit("wall_seconds", facts.wall_seconds);
    visit("cpu_seconds", facts.cpu_seconds);
    visit("guide_samples", facts.guide_samples);
    visit("guide_cpu_seconds", facts.guide_cpu_seconds);
}

Result<ShardRange> shard_range(unsigned part, unsigned parts, std::uint64_t total) {
    const std::uint64_t blocks = (total + shard_block - 1) / shard_block;
    if (parts > blocks)
        return error_at({"--shard", 0, 0}, std::to_string(parts) + " shards of " + std::to_string(total) +
                                               " samples per pixel; expected at most " + std::to_string(blocks) +
                                               ", because a shard needs at least " + std::to_string(shard_block) +
                                               " of them");
    return ShardRange{blocks * (part - 1) / parts * shard_block, std::min(total, blocks * part / parts * shard_block),
                      total};
}

std::string shard_file(const std::string& output, unsigned part, unsigned parts) {
    return output + ".shard-" + std::to_string(part) + "-of-" + std::to_string(parts);
}

std::string shard_lock(const std::string& record) {
    return record + ".lock";
}

Result<std::uint64_t> samples_of_job(const Job& job, const transport::SceneDescription& scene) {
    if (job.settings.samples.per_pixel) return *job.settings.samples.per_pixel;
    auto integrator = integrator_of(job, scene);
    if (!integrator) return integrator.error();
    if (integrator->samples_per_pixel) return *integrator->samples_per_pixel;
    auto sampler =
        transport::choose_sampler(job.settings.samples.sampler ? *job.settings.samples.sampler : scene.sampler);
    if (!sampler) return sampler.error();
    return sampler->samples_per_pixel;
}

Status check_shardable(const Job& job, const transport::SceneDescription& scene) {
    if (job.settings.stop.adaptive)
        return error_at(job.settings.stop.adaptive->location,
                        "adaptive sampling in shards: the number of samples of a pixel depends on all its samples",
                        "leave out --until-error and [adaptive], or --shard and --shards");
    if (job.settings.stop.limit)
        return error_at({"--time", 0, 0},
                        "a render with a time limit in shards: its number of samples is not known in advance",
                        "expected --spp instead of --time");
    if (job.settings.samples.only) return error_at({"--replay", 0, 0}, "a single sample in shards", one_process);
    if (!job.outputs.deep.file.empty())
        return error_at(job.outputs.deep.location, "a deep image in shards: merged deep samples are not sums",
                        "leave out the deep image, or --shard and --shards");
    auto chosen = integrator_of(job, scene);
    if (!chosen) return chosen.error();
    if (chosen->integrator->starts_up())
        return error_at(
            {"--shard", 0, 0},
            "the Markov chains of integrator '" + chosen->name + "' would start in the same state in every shard",
            "leave out --shard and --shards, or choose another integrator, such as path");
    if (chosen->integrator->traits().saved_state == transport::SavedState::saved)
        return error_at({"--shard", 0, 0},
                        "integrator '" + chosen->name + "' learns from earlier samples, which a shard does not have",
                        "leave out --shard and --shards, or choose another integrator, such as path");
    return success();
}

Result<ShardRender> ShardRender::make(Job& job, const transport::SceneDescription& scene) {
    if (Status possible = check_shardable(job, scene); !possible) return possible.error();
    auto total = samples_of_job(job, scene);
    if (!total) return total.error();
    ShardRender shard;
    shard.request_ = *job.shard;
    shard.atlas_ = job.outputs.atlas.file;
    auto range = shard_range(shard.request_.part, shard.request_.parts, *total);
    if (!range) return range.error();
    shard.range_ = *range;
    job.settings.samples.first = range->first;
    job.settings.samples.per_pixel = range->end;
    job.settings.samples.whole = *total;
    std::error_code failed;
    job.resume = std::filesystem::exists(checkpoint_file(job), failed);
    return shard;
}

Result<bool> ShardRender::is_done(const transport::RenderPlan& plan, std::string& warning) {
    identity_ = plan.identity;
    std::erase_if(identity_, [](const auto& field) { return field.first == "first sample"; });
    for (auto& [name, value] : identity_)
        if (name == "samples per pixel") value = std::to_string(range_.total);
    std::error_code failed;
    if (!std::filesystem::exists(request_.record, failed)) return false;
    if (!atlas_.empty() && !display::is_atlas(atlas_)) return false;
    const auto record = display::RecordFileReader::open(request_.record);
    const Status sound = record ? record->check() : Status(record.error());
    if (!sound) {
        warning = "this shard is rendered again: " + sound.error().to_string();
        return false;
    }
    std::vector<std::string> differences = display::identity_differences(record->identity(), identity_);
    try {
        const auto image = record->read("image");
        const ShardRange there = shard_facts(parse_json(image ? *image : "{}")).range;
        if (there.first != range_.first || there.end != range_.end)
            differences.push_back("samples: " + std::to_string(there.first) + " to " + std::to_string(there.end - 1) +
                                  " there, " + std::to_string(range_.first) + " to " + std::to_string(range_.end - 1) +
                                  " here");
    } catch (const std::exception& error) {
        if (differences.empty()) {
            warning = "this shard is rendered again: the record's image is damaged: " + std::string(error.what());
            return false;
        }
    }
    if (differences.empty()) return true;
    std::string message = "this record belongs to another render";
    for (const std::string& each : differences) message += "\n  " + each;
    return error_at({request_.record, 0, 0}, message,
                    "use the settings of that render, choose another file with -o, or remove this record to render the "
                    "shard again");
}

Status ShardRender::write(const std::string& path, const transport::RenderOutput& output,
                          const display::ImageDescription& description,
                          const std::vector<ObjectRequest>& filters) const {
    RecordedImage image;
    image.description = description;
    image.beauty = output.beauty;
    image.filters = filters;
    for (const geoaovs::Cryptomatte& matte : output.cryptomatte)
        image.mattes.push_back({matte.kind(), matte.ranks(), matte.names()});
    Json json = image_json(image);
    const transport::RenderStatistics& statistics = output.statistics;
    json["shard"] = ShardFacts{request_.part,
                               request_.parts,
                               !atlas_.empty(),
                               range_,
                               statistics.camera_samples,
                               statistics.invalid_samples,
                               statistics.render_seconds,
                               statistics.render_cpu_seconds,
                               statistics.guide.repeated(),
                               statistics.guide.cpu_seconds};
    const display::PixelImage& pixels = output.image();
    const auto bands =
        display::record_bands(pixels.layout(), pixels.channels(), output.frame_buffer.takes_raster_splats());
    auto record = display::RecordFileWriter::create(path, identity_, bands.size() + output.cryptomatte.size() + 1);
    if (!record) return record.error();
    Status added = output.buckets.image ? display::add_bands(*record, bands, *output.buckets.image)
                                        : display::add_bands(*record, output.frame_buffer);
    for (const geoaovs::Cryptomatte& matte : output.cryptomatte) {
        std::string bytes;
        matte.coverage().append_record(bytes);
        if (added) added = record->add(matte.name(), bytes);
    }
    if (added) added = record->add("image", json_text(json));
    return added ? record->commit() : added;
}

std::string ShardRender::text() const {
    return "shard " + std::to_string(request_.part) + "/" + std::to_string(request_.parts) + ", samples " +
           std::to_string(range_.first) + " to " + std::to_string(range_.end - 1) + " of " +
           std::to_string(range_.total);
}

ShardFacts shard_facts(const Json& json) {
    return json.at("shard");
}

}  // namespace raylex::experiments
