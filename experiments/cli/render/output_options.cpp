#include "experiments/cli/render/output_options.h"

#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/drivers/tev_driver.h"
#include "display/filters/display_filter.h"
#include "display/services/samples/sample_filter.h"
#include "experiments/report/png_driver.h"
#include "experiments/report/preview.h"

namespace raylex::experiments {
namespace {

std::string driver_list() {
    register_png_driver();
    return registry_summary(display::display_driver_registry());
}

Status apply_filters(const OutputOptions& options, Job& job) {
    for (const std::string& text : options.sample_filters) {
        auto request =
            parse_object_request(text, display::sample_filter_registry(), "sample filter", {"--sample-filter", 0, 0});
        if (!request) return request.error();
        transport::SceneEntity filter;
        filter.type = std::move(request->name);
        filter.parameters = std::move(request->parameters);
        filter.location = {"--sample-filter", 0, 0};
        job.settings.channels.sample_filters.push_back(std::move(filter));
    }
    for (const std::string& text : options.display_filters) {
        auto request = parse_object_request(text, display::display_filter_registry(), "display filter",
                                            {"--display-filter", 0, 0});
        if (!request) return request.error();
        job.outputs.filters.push_back(std::move(*request));
    }
    return success();
}

Status apply_deep(const OutputOptions& options, DeepRequest& deep) {
    if (!options.deep.empty()) {
        deep.file = options.deep;
        deep.location = {"--deep", 0, 0};
    }
    const bool any = options.deep_tidy || options.deep_samples || options.deep_tolerance ||
                     !options.deep_channels.empty() || !options.deep_storage.empty();
    if (any && deep.file.empty())
        return error_at({"--deep", 0, 0}, "deep settings without a deep image; expected --deep FILE.exr as well");
    if (!options.deep_channels.empty()) deep.channels = options.deep_channels;
    if (options.deep_tidy) deep.options.tidy = true;
    if (options.deep_samples) deep.options.most_samples = *options.deep_samples;
    if (options.deep_tolerance) deep.options.tolerance = *options.deep_tolerance;
    if (options.deep_storage.empty()) return success();
    auto storage = display::parse_deep_storage(options.deep_storage, {"--deep-storage", 0, 0});
    if (!storage) return storage.error();
    deep.storage = *storage;
    return success();
}

Status apply_atlas(const OutputOptions& options, AtlasRequest& atlas) {
    if (!options.atlas.empty()) {
        if (atlas.file.empty()) atlas.rules.length = 0;  // the job has no [atlas] with a length
        atlas.file = options.atlas;
        atlas.location = {"--atlas", 0, 0};
    }
    if ((options.atlas_by || options.atlas_length || !options.atlas_budget.empty()) && atlas.file.empty())
        return error_at({"--atlas", 0, 0}, "atlas settings without an atlas; expected --atlas FILE.exr as well");
    if (options.atlas_by)
        if (Status set = set_atlas_rules(*options.atlas_by, {"--atlas-by", 0, 0}, atlas); !set) return set;
    if (options.atlas_length) atlas.rules.length = *options.atlas_length;
    if (options.atlas_budget.empty()) return success();
    auto budget = display::parse_memory_size(options.atlas_budget, {"--atlas-budget", 0, 0});
    if (!budget) return budget.error();
    atlas.budget = *budget;
    return success();
}

/// Adds the previews to the job. The first plain preview replaces the job's.
void apply_previews(const OutputOptions& options, Job& job) {
    bool first = true;
    for (const std::string& text : options.previews) {
        display::DriverRequest request = preview_request(text, {"--preview", 0, 0});
        const bool plain = request.parameters.parameters.size() == 1;
        if (plain && first) job.preview = text;
        else job.outputs.drivers.push_back(std::move(request));
        first = first && !plain;
    }
}

}  // namespace

void add_file_options(const OptionGroup& group, OutputOptions& options) {
    group.add_repeated(
        "--exr", options.storage, "KIND='TYPE COMPRESSION'|single",
        "number type and compression of a kind of channel (light, color, normal, position, value, id or all). Types: "
        "half, float. Compressions: none, rle, zips, zip, piz; light and color also allow the lossy dwaa:LEVEL and "
        "dwab:LEVEL. 'single' writes all layers into one part instead of one part each (multi)");
    group.add("--deep", options.deep, "OUT.exr", "also writes a deep image with Z, ZBack, A and the beauty");
    group
        .add_repeated("--deep-channels", options.deep_channels, "NAME[,NAME...]",
                      "further layers of light, or filtered layers, for the deep image")
        ->delimiter(',');
    group.add("--deep-samples", options.deep_samples, "N", "maximum number of deep samples in a pixel; default 32")
        ->check(CLI::Range(1, 4096));
    group
        .add("--deep-tolerance", options.deep_tolerance, "X",
             "merges deep samples whose depths differ by less than this fraction; default 0.0039")
        ->check(CLI::Range(1.2e-7, 1.0));
    group.add_flag("--deep-tidy", options.deep_tidy, "splits volume spans so that no deep samples overlap");
    group.add("--deep-storage", options.deep_storage, "'TYPE COMPRESSION'",
              "colours as half or float, and compression none, rle or zips");
    group.add(
        "--atlas", options.atlas, "OUT.atlas.exr",
        "also writes a path atlas: the light of every path string (kind of path), from which 'raylex ask' makes new "
        "layers without another render");
    group.add("--atlas-by", options.atlas_by, "label,lobe,group,straight,technique",
              "properties that distinguish path strings, besides the types of events; default label,lobe,group");
    group
        .add("--atlas-length", options.atlas_length, "N",
             "longest path strings stored whole, in scattering events; default: the render's maximum depth, at most 64")
        ->check(CLI::Range(1, display::WordRules::most_length));
    group.add("--atlas-budget", options.atlas_budget, "SIZE",
              "memory limit of the atlas, default 2GiB; beyond it the path strings with the least light are merged");
    group.add_repeated("--tev", options.viewers, "HOST[:PORT]",
                       "shows every layer in a running tev viewer during the render; default port 14158");
    group.add_repeated("--driver", options.drivers, "NAME:KEY=VALUE,...", "adds a display driver: " + driver_list());
}

void add_preview_options(const OptionGroup& group, OutputOptions& options) {
    group.add_repeated("--preview", options.previews, "[LAYER=]OUT.png",
                       "also writes the beauty, or the layer LAYER, as a PNG. Light is shown through the display's "
                       "view, geometry in false colours");
    group.add("--display", options.display, "NAME", "display in the colour config, for previews");
    group.add("--view", options.view, "NAME", "view of that display; default: the config's default view");
    group.add("--exposure", options.exposure, "STOPS", "exposure of previews of light, in stops; default 0")
        ->check(CLI::Range(-largest_exposure, largest_exposure));
    group.add_flag("--texture-rules", options.texture_rules,
                   "converts image textures by the file rules of the colour config; default: pbrt's rules");
}

void add_filter_options(const OptionGroup& group, OutputOptions& options) {
    group.add_repeated("--sample-filter", options.sample_filters, "NAME:KEY=VALUE,...",
                       "changes samples before the pixel filter, in the order given: " +
                           registry_summary(display::sample_filter_registry()));
    group.add_repeated("--display-filter", options.display_filters, "NAME:KEY=VALUE,...",
                       "changes pixels before display and output, in the order given: " +
                           registry_summary(display::display_filter_registry()));
}

Status apply_output_options(const OutputOptions& options, Job& job) {
    apply_previews(options, job);
    if (!options.display.empty()) {
        job.display = options.display;
        job.view.clear();
    }
    if (!options.view.empty()) job.view = options.view;
    if (options.exposure) job.exposure = *options.exposure;
    if (options.texture_rules) job.texture_rules = true;
    if (Status filters = apply_filters(options, job); !filters) return filters;
    for (const std::string& text : options.viewers) {
        auto address = display::tev_address(text, {"--tev", 0, 0});
        if (!address) return address.error();
        job.outputs.drivers.push_back({"tev", std::move(*address)});
    }
    for (const std::string& text : options.drivers) {
        auto request = display::parse_driver_request(text, {"--driver", 0, 0});
        if (!request) return request.error();
        job.outputs.drivers.push_back(std::move(*request));
    }
    for (const std::string& text : options.storage) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos) {
            if (Status parts = set_exr_parts(job.outputs, text, {"--exr", 0, 0}); !parts) return parts;
            continue;
        }
        Status status = display::override_exr_storage(job.outputs.storage, text.substr(0, equals),
                                                      text.substr(equals + 1), {"--exr", 0, 0});
        if (!status) return status;
    }
    if (!options.memory_limit.empty()) {
        auto limit = display::parse_memory_size(options.memory_limit, {"--memory-limit", 0, 0});
        if (!limit) return limit.error();
        job.outputs.memory_limit = *limit;
    }
    if (Status atlas = apply_atlas(options, job.outputs.atlas); !atlas) return atlas;
    return apply_deep(options, job.outputs.deep);
}

}  // namespace raylex::experiments
