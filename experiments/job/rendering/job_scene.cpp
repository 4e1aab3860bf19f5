#include "experiments/job/rendering/job_scene.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "display/services/hash64.h"
#include "experiments/job/parameter_check.h"
#include "experiments/job/rendering/provenance.h"
#include "transport/color/color_space.h"
#include "transport/import/apply_effects.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/integrators/integrator.h"
#include "transport/plugins/plugin_loader.h"
#include "transport/render/film.h"

namespace raylex::experiments {
namespace {

std::string file_hash(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return hash_text(hash64(std::string{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}));
}

/// Makes the parts that do not depend on the scene.
Result<std::unique_ptr<JobScene>> begin_job_scene(const Job& job) {
    if (Status known = check_parameters(job); !known) return known.error();
    auto loaded = std::make_unique<JobScene>();
    auto color = open_color(job);
    if (!color) return color.error();
    loaded->color = std::move(*color);
    if (!loaded->color.warning.empty()) loaded->warnings.push_back(loaded->color.warning);
    return loaded;
}

Result<std::unique_ptr<JobScene>> finish_job_scene(const Job& job, std::unique_ptr<JobScene> loaded) {
    for (const Error& warning : loaded->scene.warnings) loaded->warnings.push_back(warning.to_string());
    if (Status labelled = transport::apply_label_rules(loaded->scene, job.label_rules); !labelled)
        return labelled.error();
    auto primaries = choose_rendering_space(job, loaded->color, loaded->scene);
    if (!primaries) return primaries.error();
    loaded->primaries = *primaries;
    loaded->effects = transport::analyse_effects(loaded->scene);
    if (Status applied = transport::apply_effects(loaded->scene, job.effects); !applied) return applied.error();
    return loaded;
}

}  // namespace

Result<std::unique_ptr<JobScene>> load_job_scene(const Job& job, transport::LoadingProgress* progress) {
    auto loaded = begin_job_scene(job);
    if (!loaded) return loaded;
    auto scene = transport::import_pbrt(job.scene_file, {job.missing, job.settings.machine.threads, progress});
    if (!scene) return scene.error();
    (*loaded)->scene = std::move(*scene);
    return finish_job_scene(job, *std::move(loaded));
}

Result<std::unique_ptr<JobScene>> prepare_job_scene(const Job& job, transport::SceneDescription scene) {
    auto loaded = begin_job_scene(job);
    if (!loaded) return loaded;
    (*loaded)->scene = std::move(scene);
    return finish_job_scene(job, *std::move(loaded));
}

void ask_for_film_layers(const transport::SceneEntity& film, Job& job) {
    const auto has = [](const auto& requests, const std::string& name) {
        return std::any_of(requests.begin(), requests.end(), [&](const auto& each) { return each.name == name; });
    };
    for (const std::string& layer : transport::gbuffer_layers(film))
        if (!has(job.aovs, layer) && !has(job.expressions, layer)) job.aovs.push_back({layer, film.location});
}

std::optional<std::string> ask_for_film_clamp(const transport::SceneDescription& scene, Job& job) {
    const Parameter* limit = scene.film.parameters.find("maxcomponentvalue");
    if (limit == nullptr || !job.settings.channels.sample_filters.empty()) return std::nullopt;
    const std::string ignored = "the film's maxcomponentvalue is ignored: ";
    if (!job.settings.channels.beauty) return ignored + "it limits the beauty of a sample, and there is no beauty";
    if (!job.outputs.atlas.file.empty()) return ignored + "an atlas stores unfiltered light";
    const auto only_splats = [&](const std::optional<transport::SceneEntity>& method) {
        const auto chosen = transport::choose_integrator(transport::integrator_for(method, scene.integrator),
                                                         job.settings.paths.max_depth);
        return chosen && chosen->integrator->traits().raster_splats && !chosen->integrator->traits().pixel_samples;
    };
    if (only_splats(job.settings.paths.integrator) ||
        std::any_of(job.passes.begin(), job.passes.end(),
                    [&](const PassRequest& pass) { return only_splats(pass.method); }))
        return ignored + "splatted light has no samples";
    transport::SceneEntity clamp;
    clamp.type = "clamp";
    clamp.location = clamp.parameters.location = limit->location;
    clamp.parameters.parameters.push_back(*limit);
    clamp.parameters.parameters.back().name = "component";
    const transport::Matrix3 to_measured =
        transport::multiply(scene.color.measured, transport::inverse(scene.color.rendering_from_scene));
    Parameter measure;
    measure.name = "measure";
    measure.type = ParameterType::real;
    measure.location = limit->location;
    for (const auto& row : to_measured) measure.numbers.insert(measure.numbers.end(), row.begin(), row.end());
    clamp.parameters.parameters.push_back(std::move(measure));
    job.settings.channels.sample_filters.push_back(std::move(clamp));
    return std::nullopt;
}

display::RecordIdentity checkpoint_identity(const Job& job, const ColorSetup& color) {
    display::RecordIdentity identity{
        {"raylex", raylex_version() + " " + raylex_revision() + ", " + build_description()},
        {"colour config", color.description},
        {"texture rules", job.texture_rules ? "true" : "false"}};
    for (const transport::LoadedPlugin& each : transport::loaded_plugins())
        identity.emplace_back("plugin " + std::filesystem::path(each.path).filename().string(), file_hash(each.path));
    for (const lpe::LobeOption& each : job.lobe_options) identity.emplace_back("lobe slot " + each.slot, each.names);
    return identity;
}

display::ImageDescription image_description(const Job& job, const JobScene& scene,
                                            const transport::RenderOutput& output,
                                            const std::vector<display::PartitionDeclaration>& partitions,
                                            const std::map<std::string, std::string>& attributes) {
    display::ImageDescription description;
    description.attributes = attributes;
    if (const std::vector<std::string>& missing = scene.scene.placeholders; !missing.empty()) {
        std::string& list = description.attributes["raylex/placeholders"];
        list = std::to_string(missing.size()) + " files are missing:";
        for (const std::string& file : missing) list += "\n" + file;
    }
    description.partitions = partitions;
    description.chromaticities = scene.primaries;
    for (const geoaovs::Cryptomatte& matte : output.cryptomatte)
        description.data_parts.push_back(
            {matte.name(), matte.planes(), matte.attributes(),
             [&matte](const display::PixelRegion& rows) { return matte.values(rows.y0, rows.y1); }});
    description.world_to_camera = output.view.world_to_camera;
    description.world_to_screen = output.view.world_to_screen;
    description.complete = output.samples.complete;
    description.storage = job.outputs.storage;
    description.single_part = job.outputs.single_part;
    description.data_window = output.view.crop;
    return description;
}

}  // namespace raylex::experiments
