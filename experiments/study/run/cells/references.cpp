// Makes references: each is rendered once to a stated error, and stored by its identity.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "display/output/atomic_file.h"
#include "display/services/hash64.h"
#include "experiments/job/rendering/provenance.h"
#include "experiments/program/console.h"
#include "experiments/program/work_lock.h"
#include "experiments/study/file_records.h"
#include "experiments/study/results_json.h"
#include "experiments/study/run/cells/method_settings.h"
#include "experiments/study/run/cells/run_files.h"
#include "experiments/study/run/cells/run_renderer.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

namespace fs = std::filesystem;
/// Returns a text that identifies a reference: equal texts mean equal images, whatever program made them.
std::string reference_identity(const ExperimentConfig& config, const StudyScene& scene, const ChannelPlan& channels,
                               const Variant& variant, std::uint64_t seed) {
    std::string text =
        "scene " + scene.hash + "\nsize " + std::to_string(scene.width) + "x" + std::to_string(scene.height);
    for (const auto& [key, value] : settings_text(variant.render, variant.effects, variant.passes))
        text += "\n" + key + " = " + value;
    text += "\nseed " + std::to_string(seed) + "\nsamples " + std::to_string(config.reference.samples) + "\nerror " +
            number_text(config.reference.error, 17);
    for (const ChannelInfo& each : channel_infos(channels))
        text += "\nchannel " + each.name + " " + each.dialect + " " + each.expression;
    return text;
}

Status write_reference_file(const std::string& path, const Json& json) {
    return display::write_text_file(path, json_text(json, 2) + "\n", display::FileSync::later);
}

/// Uses an existing reference; returns false if there is none.
Result<bool> take_known(const std::string& directory, SceneInfo& info) {
    const std::string path = directory + "/reference.json";
    if (std::error_code failed; !fs::exists(path, failed)) return false;
    const char* const remedy = "remove its folder, so that the reference is rendered again";
    const Result<Json> read = read_json_file(path, "a reference.json");
    if (!read) {
        Error error = read.error();
        error.hint = remedy;
        return error;
    }
    try {
        const Json& json = *read;
        info.reference = directory;
        info.reference_relative_error = json.at("relative_error");
        info.reference_method = json.at("method");
        info.reference_samples = whole(json.at("samples_per_pixel"));
    } catch (const Json::exception& error) {
        return error_at({path, 0, 0}, std::string("this is not a reference.json, or it is damaged: ") + error.what(),
                        remedy);
    }
    if (const std::string damage = damage_of_reference(directory); !damage.empty())
        return error_at({directory, 0, 0}, "this reference is damaged: " + damage, remedy);
    return true;
}

Status make_directory(const std::string& path) {
    std::error_code failed;
    fs::create_directories(path, failed);
    return failed ? error_at({path, 0, 0}, "cannot make this directory: " + failed.message()) : success();
}

Status close_reference(const std::string& partial, const std::string& directory, Json json) {
    const auto files = file_records(partial);
    if (!files) return files.error();
    json["files"] = *files;
    if (Status s = write_reference_file(partial + "/reference.json", json); !s) return s;
    if (Status s = display::sync_files_in(partial); !s) return s;
    std::error_code failed;
    fs::rename(partial, directory, failed);
    // Another run with the same cache may have finished first; its reference is the same image.
    if (failed && !fs::exists(directory + "/reference.json"))
        return error_at({directory, 0, 0}, "cannot rename the finished reference to this name: " + failed.message());
    return success();
}

/// Locks a reference, so that of all runs with the same cache one renders it while the others wait. Returns the lock
/// and whether it was taken before a stop.
Result<std::pair<std::optional<WorkLock>, bool>> lock_reference(const std::string& directory,
                                                                const std::atomic<bool>* stop) {
    if (Status s = make_directory(fs::path(directory).parent_path().string()); !s) return s.error();
    for (;;) {
        auto lock = WorkLock::take(directory + ".lock", "is making this reference");
        if (lock) return std::pair(std::optional(*std::move(lock)), true);
        if (stop != nullptr && stop->load()) return std::pair(std::optional<WorkLock>(), false);
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
}

/// Uses an imported image as reference.
Result<bool> import_reference(const WorkContext& context, const std::string& folder, std::size_t index,
                              SceneInfo& info) {
    const std::string& file = context.config.scenes[index].reference_file;
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    std::string names;
    for (const ChannelInfo& each : info.channels) names += each.name + "\n";
    const std::string directory = folder + "/" + hash_text(hash64(bytes, hash64(names)));
    auto known = take_known(directory, info);
    if (!known || *known) return known;
    const std::string partial = directory + ".partial";
    if (Status s = make_directory(partial); !s) return s.error();
    if (auto s = write_image_files(partial, file, info.width, info.height, info.channels); !s) return s.error();
    std::error_code failed;
    fs::copy_file(file, partial + "/image.exr", fs::copy_options::overwrite_existing, failed);
    const Json json{{"method", file},         {"settings", Json::object()}, {"samples_per_pixel", 0}, {"seed", 0},
                    {"relative_error", -1.0}, {"wall_seconds", 0.0},        {"cpu_seconds", 0.0}};
    if (Status s = close_reference(partial, directory, json); !s) return s.error();
    return take_known(directory, info);
}

/// Returns the reference.json of a render. `identity` must match for the reference to be used again.
Json reference_json(const ExperimentConfig& config, const Rendered& rendered, std::uint64_t seed,
                    const std::string& identity) {
    Json settings = Json::object();
    const Variant& variant = config.variants[config.reference.variant];
    for (const auto& [key, value] : settings_text(variant.render, variant.effects, variant.passes))
        settings[key] = value;
    return {{"method", config.reference.method},
            {"settings", settings},
            {"samples_per_pixel", rendered.output.samples.per_pixel},
            {"seed", seed},
            {"relative_error", relative_error(rendered.output)},
            {"wall_seconds", rendered.seconds},
            {"cpu_seconds", rendered.cpu_seconds},
            {"identity", identity}};
}

}  // namespace

Result<bool> provide_reference(const WorkContext& context, std::size_t index, SceneInfo& info, double& seconds) {
    const ExperimentConfig& config = context.config;
    const transport::Stopwatch watch;
    const std::string folder =
        config.reference.cache.empty() ? context.directory + "/references" : config.reference.cache;
    if (!config.scenes[index].reference_file.empty()) {
        if (Status s = make_directory(folder); !s) return s.error();
        return import_reference(context, folder, index, info);
    }
    if (config.reference.method.empty()) return true;
    // The method without sweeps, which do not change the true image.
    const std::size_t variant = config.reference.variant;
    const auto fails = [&](const Error& error) {
        info.reference_failure = error.to_string();
        return true;
    };
    auto scene = context.scenes.scene(index, config.variants[variant].effects);
    if (!scene) return fails(scene.error());
    auto channels = context.scenes.channels(index, variant);
    if (!channels) return fails(channels.error());
    const std::uint64_t seed = context.plan.reference_seeds[index];
    const std::string identity = reference_identity(config, **scene, **channels, config.variants[variant], seed);
    const std::string directory = folder + "/" + hash_text(hash64(identity));
    auto known = take_known(directory, info);
    if (!known || *known) return known;
    auto lock = lock_reference(directory, context.stop);
    if (!lock) return lock.error();
    if (!lock->second) return false;
    if (known = take_known(directory, info); !known || *known) return known;  // made while this process waited
    const std::string partial = directory + ".partial";
    if (Status s = make_directory(partial); !s) return s.error();
    RenderOrder order{.scene = index, .variant = variant, .samples = config.reference.samples, .seed = seed};
    if (config.reference.error > 0) order.limit = transport::SampleLimit{.error = config.reference.error};
    const std::string checkpoint = checkpoint_file(partial);
    if (config.checkpoint_seconds > 0)
        order.checkpoint = transport::CheckpointSettings{
            .file = checkpoint, .seconds = config.checkpoint_seconds, .resume = fs::exists(checkpoint)};
    auto rendered = context.scenes.render(
        order,
        [&](const transport::RenderProgress& now) {
            const auto total = static_cast<double>(std::max<std::uint64_t>(now.samples_total, 1));
            const bool has_error = now.adaptive != nullptr && !now.adaptive->channel.empty();
            if (context.progress)
                context.progress(
                    {static_cast<double>(now.samples_done) / total, now.seconds, has_error ? now.adaptive->error : -1});
        },
        context.stop);
    if (!rendered && rendered.error().file == checkpoint) return rendered.error();
    if (!rendered) return fails(rendered.error());
    seconds += watch.wall();
    if (!rendered->output.samples.complete) return false;
    auto splits = write_render_files(partial, *rendered, *(*scene)->loaded,
                                     {{"raylex/reference", identity}, {"raylex/revision", raylex_revision()}});
    if (!splits) return splits.error();
    std::error_code ignored;
    fs::remove(checkpoint, ignored);
    if (Status s = close_reference(partial, directory, reference_json(config, *rendered, seed, identity)); !s)
        return s.error();
    return take_known(directory, info);
}

}  // namespace raylex::experiments
