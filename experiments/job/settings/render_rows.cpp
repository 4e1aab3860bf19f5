// Settings of samples, image size, long renders, the machine and the method.
#include <charconv>
#include <limits>

#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/services/processor.h"
#include "experiments/job/sampling_requests.h"
#include "experiments/job/settings/kinds.h"

namespace raylex::experiments {
namespace {

using enum RenderSetting::Use;

constexpr std::uint64_t most_int = std::numeric_limits<std::int32_t>::max();

/// A type by its name. The parameters in the job stay if its type is the same.
template <typename Field>
RenderSetting::Values entity(Field field) {
    return applied([field](Job& job, const std::string& name, const SourceLocation& where) {
        std::optional<transport::SceneEntity>& entity = *field(job);
        if (entity && entity->type == name) return success();
        entity.emplace();
        entity->type = name;
        entity->location = entity->parameters.location = where;
        return success();
    });
}

Status set_tolerance(Job& job, const std::string& text, const SourceLocation& where) {
    auto error = parse_tolerance(text, where);
    if (!error) return error.error();
    if (!job.settings.stop.adaptive) job.settings.stop.adaptive.emplace();
    job.settings.stop.adaptive->error = *error;
    job.settings.stop.adaptive->location = where;
    return success();
}

Status set_time(Job& job, const std::string& text, const SourceLocation& where) {
    auto seconds = parse_interval(text, where, "render time");
    if (!seconds) return seconds.error();
    job.settings.stop.limit.emplace().seconds = *seconds;
    return success();
}

Status add_pass(Job& job, const std::string& text, const SourceLocation& where) {
    auto pass = parse_pass(text, where);
    if (!pass) return pass.error();
    job.passes.push_back(std::move(*pass));
    return success();
}

/// Forces an effect on or off: NAME=on or NAME=off.
Status add_effect(Job& job, const std::string& text, const SourceLocation& where) {
    const std::size_t equals = text.find('=');
    const std::string value = equals == std::string::npos ? std::string() : text.substr(equals + 1);
    if (value != "on" && value != "off")
        return error_at(where,
                        "'" + text + "' is not a forced effect; expected NAME=on or NAME=off, such as media=off");
    auto effect = transport::effect_named(text.substr(0, equals), where);
    if (!effect) return effect.error();
    job.effects[*effect] = value == "on";
    return success();
}

/// Parses X,Y,SAMPLE
Result<transport::SampleChoice> parse_replay(const std::string& text, const SourceLocation& where) {
    transport::SampleChoice choice;
    const char* at = text.data();
    const char* const end = at + text.size();
    const auto read = [&](auto& number, bool last) {
        const auto [next, failed] = std::from_chars(at, end, number);
        if (failed != std::errc() || (last ? next != end : next == end || *next != ',')) return false;
        at = next + (last ? 0 : 1);
        return true;
    };
    if (read(choice.x, false) && read(choice.y, false) && read(choice.sample, true)) return choice;
    return error_at(where, "'" + text + "' is not a sample of a pixel; expected X,Y,SAMPLE, such as 12,7,3");
}

Result<double> checkpoint_interval(const std::string& text, const SourceLocation& where) {
    return parse_interval(text, where);
}

std::string effect_names() {
    std::string names;
    for (const transport::EffectInfo& each : transport::effect_catalogue())
        names += (names.empty() ? "" : ", ") + std::string(each.name);
    return names;
}

}  // namespace

std::vector<RenderSetting> sampling_settings() {
    return {
        {"--spp", "render.spp", "spp", "N", often, "samples per pixel; default: the scene's value",
         whole(1, most_int, [](Job& job) { return &job.settings.samples.per_pixel; })},
        {"--until-error", "adaptive.error", "until_error", "E", often,
         "samples each pixel until the standard error of the beauty (without beauty: of every layer of light) is at "
         "most E of its value, such as 1%; --spp is then the maximum, default 65536. The table [adaptive] of a job has "
         "more settings",
         applied(set_tolerance)},
        {"--time", "render.time", "time", "TIME", often,
         "stops the render after this time (to within a second), such as 30s, 5m or 1h; --spp is then the maximum. The "
         "number of samples is printed; --spp with that number gives the same bits; if a guide was used, also set "
         "the printed guidesamples",
         applied(set_time)},
        {"--seed", "render.seed", "seed", "N", often, "seed of the sampler",
         whole(0, std::numeric_limits<std::uint64_t>::max(), [](Job& job) { return &job.settings.samples.seed; })},
        {"--sampler", "sampler", "sampler", "NAME", rare, "sampler; default: the scene's",
         entity([](Job& job) { return &job.settings.samples.sampler; })},
        {"--replay", "", "", "X,Y,SAMPLE", rare,
         "renders one sample of one pixel and prints its value in every layer and all rejected values (NaN or "
         "infinite); writes no file; exit code 1 if a value is rejected",
         parsed(parse_replay, [](Job& job) { return &job.settings.samples.only; })},
    };
}

std::vector<RenderSetting> image_settings() {
    return {
        {"--resolution", "render.resolution", "resolution", "WxH", often,
         "image size in pixels; default: the scene's size",
         parsed(
             parse_resolution, [](Job& job) { return &job.settings.film.resolution; }, {}, "x",
             "[width, height], each from 1 to 65536")},
        {"--crop", "render.crop", "crop", "X0,Y0,X1,Y1", often,
         "renders only this rectangle; its pixels have the same bits as in the whole image. In the file, it is the "
         "data window inside the display window of the whole image",
         parsed(
             parse_crop, [](Job& job) { return &job.settings.film.crop; }, {}, ",",
             "[x0, y0, x1, y1] in pixels with x0 < x1 and y0 < y1")},
        {"--filter", "filter", "filter", "NAME", rare, "pixel filter; default: the scene's",
         entity([](Job& job) { return &job.settings.film.filter; })},
        {"--missing", "scene.missing", "", "error|placeholder", rare,
         "what happens if the file of a texture, light image or mesh is missing: error; or placeholder: renders "
         "magenta in its place, and counts the files in warnings and in the image's header",
         choice({"error", "placeholder"}, [](Job& job) { return &job.missing; })},
        {"--filter-mode", "render.filter_mode", "", "MODE", rare,
         "importance: draws samples in proportion to the pixel filter, each for one pixel; splat: draws samples "
         "uniformly, each for all pixels under the filter, without statistics, deep images and cryptomattes",
         choice({"importance", "splat"}, [](Job& job) { return &job.settings.film.splat; })},
        {"", "render.lobes", "", "", rare,
         "exact: splits light by the exact shares of the lobes; picked: one lobe, drawn at random, gets all of it",
         choice({"exact", "picked"}, [](Job& job) { return &job.settings.labels.picked_lobes; })},
    };
}

std::vector<RenderSetting> schedule_settings() {
    return {
        {"--checkpoint", "render.checkpoint", "", "TIME", often,
         "saves the render to OUT.exr.checkpoint at this interval, such as 60s, 5m or 1h, and at Ctrl-C; the file is "
         "removed when the image is written",
         parsed(checkpoint_interval, [](Job& job) { return &job.checkpoint_seconds; })},
        {"--resume", "", "", "", often,
         "continues from OUT.exr.checkpoint; the image has the same bits as without the interruption. Saves every 60s, "
         "or at the interval of --checkpoint",
         on_or_off([](Job& job) { return &job.resume; })},
        {"--shard", "", "", "PART/PARTS", rare,
         "renders one part of the samples, such as 2/4, to OUT.exr.shard-2-of-4. Does nothing if that file exists; "
         "continues from a checkpoint after an interruption. 'raylex merge' combines all shards into the image, with "
         "the same bits as a single render"},
        {"--shards", "", "", "N", rare,
         "with --commands: prints the commands of this many shards and the command that merges them, with the memory, "
         "CPU seconds and cores of each",
         whole(1, 100000, [](Job& job) { return &job.shard_commands; })},
    };
}

std::vector<RenderSetting> machine_settings() {
    return {
        {"--threads", "render.threads", "threads", "N", often, "number of threads; 0: all cores",
         whole(0, 4096, [](Job& job) { return &job.settings.machine.threads; })},
        {"--isa", "render.isa", "", "NAME", rare,
         "instruction set: " + std::string(display::instruction_set_names) +
             "; default: the best that the processor supports",
         text([](Job& job) { return &job.settings.machine.isa; })},
        {"--memory-limit", "render.memory_limit", "", "SIZE", rare,
         "refuses a render whose layers need more memory, such as 8G; default: no limit",
         parsed(display::parse_memory_size, [](Job& job) { return &job.outputs.memory_limit; })},
        {"--memory", "render.memory", "", "SIZE", rare,
         "memory limit of the whole program, such as 2GiB; default: no limit. A larger image is rendered in buckets "
         "(bands of rows) with the same bits. Each finished bucket is saved in the folder OUT.exr.checkpoint; --resume "
         "renders the missing ones",
         parsed(display::parse_memory_size, [](Job& job) { return &bucket_settings(job).memory; })},
        {"--bucket-rows", "render.bucket_rows", "", "N", rare,
         "renders in buckets of N rows, even if the whole image fits into memory",
         whole(1, 65536, [](Job& job) { return &bucket_settings(job).rows; })},
        {"--plugin", "plugins", "plugins", "FILE.so", rare,
         "loads a plugin: a shared library that adds integrators, cameras, materials, filters, drivers or other types, "
         "which scenes and options then use by name; 'raylex plugins FILE.so' lists them"},
    };
}

std::vector<RenderSetting> method_settings() {
    return {
        {"--integrator", "integrator", "integrator", "NAME", often,
         "path, lighttracer, bdpt, pssmlt or one of a plugin; default: the scene's",
         entity([](Job& job) { return &job.settings.paths.integrator; })},
        {"--max-depth", "render.max_depth", "max_depth", "N", often,
         "maximum number of scattering events on a path; default: the integrator's",
         whole(0, most_int, [](Job& job) { return &job.settings.paths.max_depth; })},
        {"--guide-file", "render.guide_file", "guide_file", "FILE", rare,
         "file of the guide that path and bdpt learn (their parameter 'guide'): if it exists, the render reads it and "
         "does not train; otherwise the render writes it after the training. The image has the same bits. The shards "
         "of a render can share one file",
         text([](Job& job) { return &job.settings.paths.guide_file; }, true)},
        {"--guide-only", "", "", "", rare, "ends when --guide-file is written or read, without rendering or statistics",
         on_or_off([](Job& job) { return &job.guide_only; })},
        {"--pass", "pass", "passes", "METHOD:EXPR", rare,
         "renders one class of paths by a method of its own, such as lighttracer:C<RD>S+[<L.>O]:spp=256; EXPR is an "
         "expression, a layer, a light group, or 'rest' for all other paths. The classes must be a partition of the "
         "beauty. Keys: spp, share (of --time), name, aovs=true, and the method's parameters. The image is the sum",
         each(add_pass)},
        {"--layer-passes", "render.layer_passes", "layer_passes", "", rare,
         "adds a layer for each pass, pass_NAME, and the partition 'passes'",
         on_or_off([](Job& job) { return &job.layer_passes; })},
        {"--effect", "render.effects.NAME", "", "NAME=on|off", rare,
         "turns an effect off that the scene needs (to measure its cost and its contribution), or on where the scene "
         "does not need it (to measure the saving): " +
             effect_names(),
         each(add_effect)},
        {"--effects", "", "", "", rare, "prints for every effect whether it is simulated, and why",
         on_or_off([](Job& job) { return &job.show_effects; })},
    };
}

}  // namespace raylex::experiments
