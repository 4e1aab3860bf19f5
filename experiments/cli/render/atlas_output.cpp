#include "experiments/cli/render/atlas_output.h"

#include <algorithm>
#include <utility>

#include "display/output/atomic_file.h"
#include "display/output/splits/stored_precision.h"
#include "experiments/atlas/scene_record.h"
#include "experiments/cli/render/rescue.h"

namespace raylex::experiments {

Status AtlasOutput::prepare(Job& job, const ScenePathStrings& scene) {
    const AtlasRequest& request = job.outputs.atlas;
    if (request.file.empty()) return success();
    request_ = &request;
    if (!job.settings.channels.beauty)
        return error_at(request.location,
                        "an atlas splits the beauty, and --no-beauty renders none; expected a render with beauty");
    if (!job.settings.channels.sample_filters.empty())
        return error_at(request.location,
                        "an atlas stores unfiltered light, and sample filter '" +
                            job.settings.channels.sample_filters.front().type +
                            "' changes the samples, so the path strings would not sum to the beauty",
                        "leave out the sample filters or the atlas");
    if (job.settings.labels.picked_lobes)
        return error_at(request.location,
                        "an atlas stores exact shares, and this render picks one lobe at random; expected a render "
                        "without picked lobes");
    job.settings.labels.words = request.rules;
    // By default words are stored whole. Few paths continue beyond 64 scattering events.
    constexpr int default_longest = 64;
    if (request.rules.length == 0)
        job.settings.labels.words->length =
            std::clamp(static_cast<int>(scene.words.max_depth.value_or(default_longest)), 1, default_longest);
    scene_record_ = scene_record(scene);
    return success();
}

Status AtlasOutput::make(const Job& job, const transport::RenderPlan& plan) {
    if (request_ == nullptr) return success();
    if (plan.splat)
        return error_at(request_->location,
                        "an atlas needs samples that belong to one pixel, and filter mode splat shares samples between "
                        "pixels; expected filter mode importance");
    const display::ChannelDefinition& beauty = plan.channels[static_cast<std::size_t>(plan.beauty)];
    if (beauty.rule != display::FilterRule::filter)
        return error_at(request_->location,
                        "an atlas needs a beauty made by the pixel filter, and the beauty has another rule; expected "
                        "no rule for it");
    negative_ = plan.filter->has_negative_lobes() ? display::SignedLight::weights
                : plan.signed_light               ? display::SignedLight::light
                                                  : display::SignedLight::none;
    alphabet_ = plan.words;
    display::PathAtlas::Settings settings{plan.width, plan.height, beauty.scale_exponent, request_->budget, nullptr};
    if (plan.raster) {
        raster_filter_ = std::make_unique<display::PixelFilter>(*plan.filter);
        settings.raster = raster_filter_.get();
    }
    buffer_ = std::make_unique<display::PathAtlas>(settings);
    static_cast<void>(job);
    return display::check_writable(request_->file);
}

Status AtlasOutput::write(const transport::RenderOutput& output, const display::ImageDescription& description) {
    if (!buffer_) return success();
    display::ImageDescription of_atlas = description;
    of_atlas.attributes["atlas/scene"] = scene_record_;
    const auto source = display::atlas_of_render(*buffer_, *alphabet_, output.frame_buffer, output.beauty, negative_);
    const auto write_to = [&](const std::string& path) { return display::write_atlas(path, *source, of_atlas); };
    Status written = write_to(request_->file);
    return written ? written : rescued(written.error(), "the atlas", request_->file, write_to);
}

Result<std::optional<display::AtlasCheck>> AtlasOutput::run_checks() const {
    if (!buffer_) return std::optional<display::AtlasCheck>();
    auto file = display::AtlasFile::open(request_->file);
    if (!file) return file.error();
    (*file)->read_parts(false);
    auto result = display::check_atlas(**file, display::light_magnitude_of((*file)->description().attributes));
    if (!result) return result.error();
    return std::optional<display::AtlasCheck>(*result);
}

}  // namespace raylex::experiments
