// Leaves effects out: changes the scene so that it no longer uses them.
#include "transport/import/apply_effects.h"

#include <algorithm>
#include <map>
#include <set>

#include "transport/scene/effects/material_kinds.h"
#include "transport/scene/motion.h"
#include "transport/scene/typed_parameters.h"
#include "transport/scene/used_surfaces.h"
#include "transport/textures/image_mean.h"

namespace raylex::transport {
namespace {

template <class Test>
void erase_shapes(SceneDescription& scene, const Test& test) {
    std::erase_if(scene.shapes, test);
    for (SceneObject& object : scene.objects) std::erase_if(object.shapes, test);
}

void leave_out_media(SceneDescription& scene) {
    for_each_shape(scene, [](SceneShape& shape) { shape.inside_medium = shape.outside_medium = -1; });
    scene.camera_medium = -1;
    scene.media.clear();
    for (SceneEntity& material : scene.materials) {
        if (!is_subsurface(material)) continue;
        material.type = "dielectric";
        std::erase_if(material.parameters.parameters, [](const Parameter& each) {
            static const std::set<std::string> of_the_surface{
                "eta", "roughness", "uroughness", "vroughness", "remaproughness", "displacement", "normalmap"};
            return !of_the_surface.contains(each.name);
        });
    }
    erase_shapes(scene, [&](const SceneShape& shape) { return is_interface(scene, shape) && shape.area_light < 0; });
}

/// Replaces a grid of colours by their mean.
void take_mean(Parameter& grid) {
    std::vector<double> mean(3, 0.0);
    const std::size_t count = grid.numbers.size() / 3;
    for (std::size_t i = 0; i < 3 * count; ++i) mean[i % 3] += grid.numbers[i] / static_cast<double>(count);
    if (count > 0) grid.numbers = std::move(mean);
}

void leave_out_varying_media(SceneDescription& scene) {
    static const std::set<std::string> kept{"sigma_a", "sigma_s", "preset", "scale", "g"};
    for (SceneMedium& medium : scene.media) {
        if (!is_grid(medium)) continue;
        std::vector<Parameter>& parameters = medium.parameters.parameters;
        std::erase_if(parameters, [](const Parameter& each) { return !kept.contains(each.name); });
        if (medium.type == "rgbgrid")
            for (Parameter& each : parameters)
                if (each.type == ParameterType::rgb) take_mean(each);
        medium.type = "homogeneous";
    }
}

void leave_out_lens(SceneDescription& scene) {
    std::erase_if(scene.camera.parameters.parameters, [](const Parameter& each) { return each.name == "lensradius"; });
}

/// Turns textures that scale an image by a constant into that image with the factor as its own, which look-ups apply,
/// so that the image's mean includes the factor.
void fold_scales(SceneDescription& scene) {
    std::vector<SceneTexture>& textures = scene.textures;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        if (textures[i].type != "scale") continue;
        const Parameter *image = textures[i].parameters.find("tex"), *scale = textures[i].parameters.find("scale");
        if (image == nullptr || image->type != ParameterType::texture || image->strings.size() != 1) continue;
        if (scale != nullptr && (scale->type != ParameterType::real || scale->numbers.size() != 1)) continue;
        const double by = scale != nullptr ? scale->numbers[0] : 1;
        const auto scaled = std::find_if(
            textures.rend() - static_cast<std::ptrdiff_t>(i), textures.rend(), [&](const SceneTexture& each) {
                return each.name == image->strings.front() && each.spectrum == textures[i].spectrum;
            });
        if (scaled == textures.rend() || scaled->type != "imagemap") continue;
        SceneTexture folded = *scaled;
        folded.name = textures[i].name;
        std::vector<Parameter>& parameters = folded.parameters.parameters;
        const auto own = std::find_if(parameters.begin(), parameters.end(),
                                      [](const Parameter& each) { return each.name == "scale"; });
        if (own == parameters.end()) parameters.push_back(typed::real("scale", by));
        else
            for (double& number : own->numbers) number *= by;
        textures[i] = std::move(folded);
    }
}

Status leave_out_images(SceneDescription& scene) {
    fold_scales(scene);
    for (SceneTexture& texture : scene.textures) {
        if (texture.type != "imagemap") continue;
        auto mean = mean_of_image(texture, scene.color);
        if (!mean) return mean.error();
        Parameter value;
        value.name = "value";
        value.type = texture.spectrum ? ParameterType::rgb : ParameterType::real;
        value.numbers = texture.spectrum ? std::vector<double>{mean->at(0), mean->at(1), mean->at(2)}
                                         : std::vector<double>{mean->at(0)};
        value.location = texture.location;
        texture.type = "constant";
        texture.parameters.parameters = {std::move(value)};
    }
    return success();
}

void leave_out_cutouts(SceneDescription& scene) {
    const auto invisible = [&, mixed = mixes_with_interface(scene)](const SceneShape& shape) {
        return has_cutouts(scene, shape, mixed) && shape.alpha_texture.empty() && !(shape.alpha > 0) &&
               shape.area_light < 0;
    };
    erase_shapes(scene, invisible);
    for_each_shape(scene, [](SceneShape& shape) {
        shape.alpha = 1;
        shape.alpha_texture.clear();
    });
    // In a mix with an interface, the other part is everywhere; mixes use materials defined before them.
    std::set<std::string> interfaces;
    for (SceneEntity& material : scene.materials) {
        if (is_interface(material)) interfaces.insert(material.name);
        if (material.type != "mix") continue;
        for (Parameter& each : material.parameters.parameters) {
            if (each.name != "materials" || each.strings.size() != 2) continue;
            const bool first = interfaces.contains(each.strings[0]), second = interfaces.contains(each.strings[1]);
            if (first && second) interfaces.insert(material.name);
            else if (first) each.strings[0] = each.strings[1];
            else if (second) each.strings[1] = each.strings[0];
        }
    }
}

/// Removes transmission. A sheet that passes all light remains as a part of a mix; other materials are replaced.
void leave_out_transmission(SceneDescription& scene) {
    std::set<std::string> mixed;
    for (const SceneEntity& material : scene.materials)
        for (const Parameter& each : material.parameters.parameters)
            if (material.type == "mix" && each.name == "materials")
                mixed.insert(each.strings.begin(), each.strings.end());
    for (SceneEntity& material : scene.materials) {
        if (!lets_light_through(material)) continue;
        if (material.type == "diffusetransmission") {
            material.type = "diffuse";
            std::erase_if(material.parameters.parameters,
                          [](const Parameter& each) { return each.name != "reflectance" && !is_bump(each); });
            continue;
        }
        material.parameters.parameters.clear();
        material.type = "interface";
        if (material.name.empty() || !mixed.contains(material.name)) continue;
        material.type = "raylex:sheet";
        Parameter all;
        all.name = "transmittance";
        all.type = ParameterType::rgb;
        all.numbers = {1, 1, 1};
        all.location = material.location;
        material.parameters.parameters.push_back(std::move(all));
    }
}

void leave_out_coats(SceneDescription& scene) {
    // Names of a coat's parameters -> names of the same parameters of the base alone.
    static const std::map<std::string, std::string> of_diffuse{
        {"reflectance", "reflectance"}, {"displacement", "displacement"}, {"normalmap", "normalmap"}};
    static const std::map<std::string, std::string> of_metal{{"reflectance", "reflectance"},
                                                             {"conductor.eta", "eta"},
                                                             {"conductor.k", "k"},
                                                             {"conductor.roughness", "roughness"},
                                                             {"conductor.uroughness", "uroughness"},
                                                             {"conductor.vroughness", "vroughness"},
                                                             {"remaproughness", "remaproughness"},
                                                             {"displacement", "displacement"},
                                                             {"normalmap", "normalmap"}};
    for (SceneEntity& material : scene.materials) {
        if (!is_coated(material)) continue;
        const bool metal = material.type == "coatedconductor";
        material.type = metal ? "conductor" : "diffuse";
        const auto& names = metal ? of_metal : of_diffuse;
        std::vector<Parameter>& parameters = material.parameters.parameters;
        std::erase_if(parameters, [&](const Parameter& each) { return !names.contains(each.name); });
        for (Parameter& each : parameters) each.name = names.at(each.name);
    }
}

void leave_out_compensation(SceneDescription& scene) {
    for (SceneEntity& material : scene.materials)
        std::erase_if(material.parameters.parameters,
                      [](const Parameter& each) { return each.name == "raylex:compensate"; });
}

Status leave_out_dispersion(SceneDescription& scene) {
    for (SceneEntity& material : scene.materials) {
        const Parameter* varying = varying_index(material);
        if (varying == nullptr) continue;
        const Result<Real> mean = mean_of_spectrum(*varying, scene.color);
        if (!mean) return mean.error();
        for (Parameter& each : material.parameters.parameters) {
            if (&each != varying) continue;
            each.type = ParameterType::real;
            each.numbers = {static_cast<double>(*mean)};
            each.strings.clear();
        }
    }
    return success();
}

void leave_out_emission(SceneDescription& scene) {
    for_each_shape(scene, [](SceneShape& shape) { shape.area_light = -1; });
    scene.area_lights.clear();
}

Status leave_out(SceneDescription& scene, Effect effect) {
    switch (effect) {
        case Effect::media:
            leave_out_media(scene);
            break;
        case Effect::depth_of_field:
            leave_out_lens(scene);
            break;
        case Effect::image_textures:
            return leave_out_images(scene);
        case Effect::alpha:
            leave_out_cutouts(scene);
            break;
        case Effect::shading_normals:
            for_each_shape(scene, [](SceneShape& shape) {
                // normals of ribbons define their orientation
                if (shape.kind != ShapeKind::curves) shape.normals.clear();
            });
            break;
        case Effect::bump:
            for (SceneEntity& material : scene.materials) std::erase_if(material.parameters.parameters, is_bump);
            break;
        case Effect::transmission:
            leave_out_transmission(scene);
            break;
        case Effect::coats:
            leave_out_coats(scene);
            break;
        case Effect::facet_compensation:
            leave_out_compensation(scene);
            break;
        case Effect::emissive_meshes:
            leave_out_emission(scene);
            break;
        case Effect::delta_lights:
            std::erase_if(scene.lights, is_delta_light);
            break;
        case Effect::environment:
            std::erase_if(scene.lights, is_environment);
            break;
        case Effect::instances:
            scene.instances.clear();
            scene.objects.clear();
            scene.moved_to.clear();
            break;
        case Effect::texture_filtering:
            read_images_unfiltered(scene);
            break;
        case Effect::varying_media:
            leave_out_varying_media(scene);
            break;
        case Effect::motion:
            return stop_motion(scene);
        case Effect::dispersion:
            return leave_out_dispersion(scene);
    }
    return success();
}

}  // namespace

Status apply_effects(SceneDescription& scene, const EffectChoices& choices) {
    if (!choices.any()) return success();
    const EffectFindings found = analyse_effects(scene);
    for (const EffectInfo& each : effect_catalogue()) {
        const std::optional<bool>& choice = choices[each.effect];
        if (!choice) continue;
        if (*choice) scene.general_code.insert(each.effect);
        else if (found[static_cast<std::size_t>(each.effect)].called_for)
            if (Status done = leave_out(scene, each.effect); !done) return done;
    }
    return success();
}

}  // namespace raylex::transport
