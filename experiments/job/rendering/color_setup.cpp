#include "experiments/job/rendering/color_setup.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "display/output/color/color_names.h"
#include "display/output/color/primaries.h"

namespace raylex::experiments {
namespace {

Status require_listed(const char* what, const std::string& name, const std::vector<std::string>& known) {
    if (name.empty() || std::find(known.begin(), known.end(), name) != known.end()) return success();
    std::string list;
    for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
    return error_at({}, std::string("unknown ") + what + " '" + name + "'; expected one of: " + list,
                    near_miss(name, known));
}

}  // namespace

display::Chromaticities chromaticities_of(transport::ColorSpace space) {
    switch (space) {
        case transport::ColorSpace::srgb:
            return display::rec709_primaries();
        case transport::ColorSpace::dci_p3:
            return display::p3d65_primaries();
        case transport::ColorSpace::rec2020:
            return display::rec2020_primaries();
        case transport::ColorSpace::aces2065_1:
            return display::aces_ap0_primaries();
    }
    return display::rec709_primaries();
}

Result<ColorSetup> open_color(const Job& job) {
    ColorSetup setup;
    auto manager = display::ColorManager::open(job.ocio_config);
    if (!manager) {
        const bool pictures =
            !job.preview.empty() || std::any_of(job.outputs.drivers.begin(), job.outputs.drivers.end(),
                                                [](const auto& driver) { return driver.name == "png"; });
        if (!job.ocio_config.empty() || pictures || job.texture_rules || !job.rendering_space.empty())
            return manager.error();
        setup.description = "none: " + manager.error().message;
        setup.warning = manager.error().to_string();
        return setup;
    }
    setup.description = manager->description();
    for (const Status& status :
         {display::check_view(*manager, job.display, job.view),
          require_listed("rendering space", job.rendering_space, manager->scene_linear_spaces())})
        if (!status) return status.error();
    if (job.texture_rules)
        for (const std::string& warning : manager->warnings())
            setup.warning += (setup.warning.empty() ? "" : "; ") + warning;
    setup.manager = std::move(*manager);
    return setup;
}

Result<display::Chromaticities> choose_rendering_space(const Job& job, const ColorSetup& color,
                                                       transport::SceneDescription& scene) {
    const display::Chromaticities native = chromaticities_of(scene.color.scene_space);
    if (job.texture_rules)
        scene.color.file_color = [&color, native](const std::string& path) -> Result<transport::FileColorConversion> {
            auto rule = color.manager->file_color(path, native);
            if (!rule) return rule.error();
            std::string& list = *color.texture_spaces;
            list +=
                (list.empty() ? "" : "; ") + path + ": " + rule->space + (rule->by_default ? " (no rule fits)" : "");
            return rule->convert;
        };
    if (job.rendering_space.empty()) return native;
    auto matrix = color.manager->matrix_to(job.rendering_space, native);
    if (!matrix) return matrix.error();
    auto primaries = color.manager->chromaticities(job.rendering_space);
    if (!primaries) return primaries.error();
    scene.color.rendering_from_scene = *matrix;
    return *primaries;
}

}  // namespace raylex::experiments
