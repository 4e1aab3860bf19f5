#include "transport/integrators/omitted_paths.h"

#include <map>
#include <set>
#include <utility>

#include "lpe/language/glob.h"
#include "transport/scene/effects/material_kinds.h"

namespace raylex::transport {
namespace {

std::multimap<std::string, OmittedPaths>& declarations() {
    // A light path is joined to the camera at its last scattering, which a singular one cannot be.
    static std::multimap<std::string, OmittedPaths> all{{"lighttracer", {"C<.S>.*", lpe::Dialect::osl}}};
    return all;
}

/// The groups with a light that no ray hits.
std::set<std::string> groups_of_delta_lights(const SceneDescription& scene) {
    std::set<std::string> groups;
    for (const SceneLight& light : scene.lights)
        if (is_delta_light(light)) groups.insert(light.group);
    for (const SceneShape& shape : scene.shapes)
        if (shape.area_light >= 0 && shape.alpha <= 0 && shape.alpha_texture.empty())
            groups.insert(scene.area_lights[static_cast<std::size_t>(shape.area_light)].group);
    return groups;
}

}  // namespace

std::vector<OmittedPaths> omitted_paths(const std::string& integrator) {
    std::vector<OmittedPaths> paths;
    const auto [first, last] = declarations().equal_range(integrator);
    for (auto each = first; each != last; ++each) paths.push_back(each->second);
    return paths;
}

std::vector<OmittedPaths> omitted_paths(const SceneEntity& integrator, const SceneDescription& scene) {
    if (integrator.type == "pssmlt") {  // it samples the paths of another integrator
        SceneEntity walked;
        walked.type = "path";
        if (const Parameter* inner = integrator.parameters.find("integrator"); inner != nullptr)
            if (inner->strings.size() == 1) walked.type = inner->strings.front();
        return omitted_paths(walked, scene);
    }
    std::vector<OmittedPaths> paths = omitted_paths(integrator.type);
    const std::string singular = "<[RT][^DG]>", with_density = "[<RG><TG>DV]";
    const auto add = [&](std::string expression) { paths.push_back({std::move(expression), lpe::Dialect::renderman}); };
    if (integrator.type == "lighttracer") {
        add("C" + singular + ".*");
        add("C.+O");  // light paths start at lights, not in media that emit
    }
    for (const std::string& group : groups_of_delta_lights(scene)) {
        const std::string light = "(<L." + lpe::quoted_label(group) + ">-B)";  // L accepts B as well
        // No ray hits the light, so light sampling finds it, at a scattering with a density.
        if (integrator.type == "path") add("C(.*" + singular + ")?" + light);
        if (integrator.type == "lighttracer") add("C" + light);
        // Camera and light subpaths are joined between two vertices with densities.
        if (integrator.type == "bdpt") add("C(" + singular + "+(" + with_density + singular + "+)*)?" + light);
    }
    return paths;
}

void declare_omitted_paths(const std::string& integrator, OmittedPaths paths) {
    declarations().emplace(integrator, std::move(paths));
}

}  // namespace raylex::transport
