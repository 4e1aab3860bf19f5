// Settings of files, viewers, previews, colour and filters.
#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/drivers/tev_driver.h"
#include "display/filters/display_filter.h"
#include "display/services/samples/sample_filter.h"
#include "experiments/job/settings/kinds.h"

namespace raylex::experiments {
namespace {

using enum RenderSetting::Use;

/// KIND='TYPE COMPRESSION', a preset, single or multi
Status set_storage(Job& job, const std::string& text, const SourceLocation& where) {
    const std::size_t equals = text.find('=');
    for (const display::ExrPreset& preset : display::exr_presets())
        if (text == preset.name) return use_exr_preset(job.outputs.storage, text, where);
    if (equals == std::string::npos) return set_exr_parts(job.outputs, text, where);
    return display::override_exr_storage(job.outputs.storage, text.substr(0, equals), text.substr(equals + 1), where);
}

/// The file of a deep image or an atlas.
template <typename Field>
RenderSetting::Values request(Field field) {
    return applied(
        [field](Job& job, const std::string& file, const SourceLocation& where) {
            field(job)->file = file;
            field(job)->location = where;
            return success();
        },
        true);
}

Status set_deep_channels(Job& job, const std::vector<RenderSetting::Item>& items) {
    job.outputs.deep.channels.clear();
    for (const RenderSetting::Item& item : items) job.outputs.deep.channels.push_back(item.text);
    return success();
}

Status set_atlas_words(Job& job, const std::string& text, const SourceLocation& where) {
    return set_atlas_rules(text, where, job.outputs.atlas);
}

Status add_viewer(Job& job, const std::string& text, const SourceLocation& where) {
    auto address = display::tev_address(text, where);
    if (!address) return address.error();
    job.outputs.drivers.push_back({"tev", std::move(*address)});
    return success();
}

Status add_driver(Job& job, const std::string& text, const SourceLocation& where) {
    auto request = display::parse_driver_request(text, where);
    if (!request) return request.error();
    job.outputs.drivers.push_back(std::move(*request));
    return success();
}

/// Adds the previews to the job. The first plain preview replaces the job's.
Status add_previews(Job& job, const std::vector<RenderSetting::Item>& items) {
    bool first = true;
    for (const RenderSetting::Item& item : items) {
        display::DriverRequest request = preview_request(item.text, item.location);
        const bool is_of_job = item.location.line > 0;  // a file name, whatever letters it has
        const bool plain = is_of_job || request.parameters.parameters.size() == 1;
        if (plain && first) job.preview = item.text;
        else job.outputs.drivers.push_back(std::move(request));
        first = first && !plain;
    }
    return success();
}

Status set_display(Job& job, const std::string& name, const SourceLocation&) {
    job.display = name;
    job.view.clear();
    return success();
}

Status add_sample_filter(Job& job, const std::string& text, const SourceLocation& where) {
    auto request = parse_object_request(text, display::sample_filter_registry(), "sample filter", where);
    if (!request) return request.error();
    job.settings.channels.sample_filters.push_back(
        {{}, std::move(request->name), std::move(request->parameters), where});
    return success();
}

Status add_display_filter(Job& job, const std::string& text, const SourceLocation& where) {
    auto request = parse_object_request(text, display::display_filter_registry(), "display filter", where);
    if (!request) return request.error();
    job.outputs.filters.push_back(std::move(*request));
    return success();
}

std::vector<RenderSetting> deep_settings() {
    return {
        {"--deep", "deep.file", "", "OUT.exr", rare, "also writes a deep image with Z, ZBack, A and the beauty",
         request([](Job& job) { return &job.outputs.deep; })},
        {"--deep-channels", "deep.channels", "", "NAME[,NAME...]", rare,
         "further layers of light, or filtered layers, for the deep image", texts(set_deep_channels, true)},
        {"--deep-samples", "deep.samples", "", "N", rare, "maximum number of deep samples in a pixel",
         whole(1, 4096, [](Job& job) { return &job.outputs.deep.options.most_samples; })},
        {"--deep-tolerance", "deep.tolerance", "", "X", rare,
         "merges deep samples whose depths differ by less than this fraction",
         real(1.2e-7, 1, [](Job& job) { return &job.outputs.deep.options.tolerance; })},
        {"--deep-tidy", "deep.tidy", "", "", rare, "splits volume spans so that no deep samples overlap",
         on_or_off([](Job& job) { return &job.outputs.deep.options.tidy; })},
        {"--deep-storage", "deep.storage", "", "'TYPE COMPRESSION'", rare,
         "colours as half or float, and compression none, rle or zips",
         parsed(display::parse_deep_storage, [](Job& job) { return &job.outputs.deep.storage; })},
    };
}

std::vector<RenderSetting> atlas_settings() {
    return {
        {"--atlas", "atlas.file", "atlas", "OUT.atlas.exr", often,
         "also writes a path atlas: the light of every path string (kind of path), from which 'raylex ask' makes new "
         "layers without another render",
         request([](Job& job) { return &job.outputs.atlas; })},
        {"--atlas-by", "atlas.by", "", "label,lobe,group,straight,technique", rare,
         "properties that distinguish path strings, besides the types of events",
         has_empty(applied(set_atlas_words, false, display::to_string(display::PathStringRules())))},
        {"--atlas-length", "atlas.length", "", "N", rare,
         "longest path strings stored whole, in scattering events; default: the render's maximum depth, at most 64",
         whole(1, display::PathStringRules::most_length, [](Job& job) { return &job.outputs.atlas.rules.length; })},
        {"--atlas-budget", "atlas.budget", "", "SIZE", rare,
         "memory limit of the atlas; beyond it the path strings with the least light are merged",
         parsed(
             display::parse_memory_size, [](Job& job) { return &job.outputs.atlas.budget; },
             display::memory_text(AtlasRequest().budget))},
    };
}

}  // namespace

std::vector<RenderSetting> file_settings() {
    std::vector<RenderSetting> settings{
        {"-o,--output", "output.file", "output", "OUT.exr", often,
         "image file; default: the name of the scene or job with .exr, in the current folder",
         text([](Job& job) { return &job.output; }, true)},
        {"--exr", "exr.KIND", "", "KIND='TYPE COMPRESSION'|PRESET|single", rare,
         "number type and compression of a kind of channel (light, color, normal, position, value, id or all). Types: "
         "half, float. Compressions: none, rle, zips, zip, piz; light and color also allow the lossy dwaa:LEVEL and "
         "dwab:LEVEL. A preset replaces the storage of all kinds: nuke (half light, all zips), blender (half light, "
         "color and normal, zip) or archive (float zip). 'single' writes all layers into one part instead of one part "
         "each (multi)",
         each(set_storage)},
        {"--denoise", "output.denoise", "denoise", "", often,
         "denoises the beauty and all layers of partitions so that they still sum, adds albedo and Nn as guides, and "
         "adds the estimated error of each layer as NAME_error",
         on_or_off([](Job& job) { return &job.outputs.denoise; })},
        {"--keep-noisy", "output.keep_noisy", "", "", rare,
         "with --denoise: keeps noisy layers as NAME_noisy, and their statistics",
         on_or_off([](Job& job) { return &job.outputs.keep_noisy; })},
        {"--tev", "output.tev", "", "HOST[:PORT]", rare,
         "shows every layer in a running tev viewer during the render; default port 14158", each(add_viewer)},
        {"--driver", "driver", "", "NAME:KEY=VALUE,...", rare,
         "adds a display driver: " + registry_summary(display::display_driver_registry()), each(add_driver)},
        {"--stats", "output.stats", "", "OUT.json", often,
         "also writes statistics (times, ray counts and more) as JSON; -: writes them to standard output, and messages "
         "to standard error",
         text([](Job& job) { return &job.statistics; }, true)},
    };
    settings[4].values.type = RenderSetting::Type::string;  // a job has one viewer
    for (const auto& more : {deep_settings(), atlas_settings()})
        settings.insert(settings.end(), more.begin(), more.end());
    return settings;
}

std::vector<RenderSetting> color_settings() {
    std::vector<RenderSetting> settings{
        {"--preview", "output.preview", "", "[LAYER=]OUT.png", often,
         "also writes the beauty, or the layer LAYER, as a PNG. Light is shown through the display's view, geometry in "
         "false colours",
         texts(add_previews)},
        {"--display", "color.display", "", "NAME", rare, "display in the colour config, for previews",
         applied(set_display)},
        {"--view", "color.view", "", "NAME", rare, "view of that display; default: the config's default view",
         text([](Job& job) { return &job.view; })},
        {"--exposure", "color.exposure", "", "STOPS", rare, "exposure of previews of light, in stops",
         real(-largest_exposure, largest_exposure, [](Job& job) { return &job.exposure; })},
        {"--texture-rules", "color.texture_rules", "", "", rare,
         "converts image textures by the file rules of the colour config; default: pbrt's rules",
         on_or_off([](Job& job) { return &job.texture_rules; })},
        {"--ocio", "color.ocio", "", "FILE", rare, "OpenColorIO config; default: $OCIO, else raylex's own",
         text([](Job& job) { return &job.ocio_config; }, true)},
        {"--rendering-space", "color.rendering_space", "", "NAME", rare,
         "scene-linear space of the config in which to render; default: the scene's",
         text([](Job& job) { return &job.rendering_space; })},
    };
    settings.front().values.type = RenderSetting::Type::string;  // a job has one preview
    settings.front().values.is_path = true;
    return settings;
}

std::vector<RenderSetting> filter_settings() {
    return {
        {"--sample-filter", "sample_filter", "sample_filters", "NAME:KEY=VALUE,...", rare,
         "changes samples before the pixel filter, in the order given: " +
             registry_summary(display::sample_filter_registry()),
         each(add_sample_filter)},
        {"--display-filter", "display_filter", "", "NAME:KEY=VALUE,...", rare,
         "changes pixels before display and output, in the order given: " +
             registry_summary(display::display_filter_registry()),
         each(add_display_filter)},
    };
}

}  // namespace raylex::experiments
