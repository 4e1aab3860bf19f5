#include "transport/scene/effects/effects.h"

#include <algorithm>
#include <vector>

#include "transport/scene/effects/material_kinds.h"
#include "transport/scene/motion.h"
#include "transport/scene/used_surfaces.h"

namespace raylex::transport {
namespace {

constexpr std::array<EffectInfo, effect_count> catalogue{{
    {Effect::media, "media",
     "a surface borders a medium, the camera is inside one, or a material scatters light below its surface",
     "vacuum; surfaces that only bordered media are removed; subsurface materials become glass",
     "paths and shadow rays test for media"},
    {Effect::depth_of_field, "depth-of-field", "the camera has a lens", "a pinhole in the middle of the lens",
     "camera rays begin on a lens of radius 0"},
    {Effect::image_textures, "image-textures", "a material or cutout in use reads an image", "the mean of the image",
     "materials evaluate constants as textures"},
    {Effect::alpha, "alpha", "a shape has an opacity below 1, or a texture for it",
     "opaque; shapes that are invisible everywhere and do not emit are removed",
     "hits and shadow rays are tested for cutouts"},
    {Effect::shading_normals, "shading-normals", "a mesh has vertex normals", "the normals of its faces", ""},
    {Effect::bump, "bump", "a material in use has a bump or normal map", "the normals without it", ""},
    {Effect::transmission, "transmission", "a material in use transmits light (glass, panes, sheets, leaves, skin)",
     "no surface: light passes straight through; leaves only reflect", ""},
    {Effect::coats, "coats", "a material in use is coated", "its base alone", ""},
    {Effect::facet_compensation, "facet-compensation", "a material in use has raylex:compensate",
     "facets scatter once, as in pbrt", ""},
    {Effect::emissive_meshes, "emissive-meshes", "a shape emits light", "no shape emits light", ""},
    {Effect::delta_lights, "delta-lights", "there is a point, spot, goniometric, projection or distant light",
     "they are dark", ""},
    {Effect::environment, "environment", "there is an infinite light", "black", ""},
    {Effect::instances, "instances", "an object is placed by instances", "the instances are removed", ""},
    {Effect::motion, "motion", "an object, a shape or the camera moves while the shutter is open",
     "everything stands at its place in the middle of the shutter interval",
     "each sample draws a time, which its rays carry"},
    {Effect::texture_filtering, "texture-filtering", "an image in use is filtered over the footprint of a pixel",
     "unfiltered look-ups", ""},
    {Effect::varying_media, "varying-media", "a medium in use differs from place to place",
     "a homogeneous medium without emission: density 1, or the mean of an rgbgrid", ""},
    {Effect::dispersion, "dispersion", "the index of refraction of a dielectric in use depends on the wavelength",
     "one index for all colours, the mean of its spectrum", "each sample draws a wavelength, which nothing uses"},
}};

constexpr std::array<AbsentEffect, 2> not_simulated{{
    {"polarisation", "interfaces treat light as unpolarised, whatever surfaces it has met"},
    {"fluorescence", "scattering changes the colour of light by absorption only"},
}};

std::string share(std::size_t count, std::size_t all, const char* things) {
    return std::to_string(count) + " of " + std::to_string(all) + " " + things;
}

/// A finding such as "2 of 5 materials in use", or that there is none.
EffectFinding finding(std::size_t count, std::size_t all, const char* things) {
    if (count == 0)
        return {false, all == 0 ? std::string("no ") + things : "none of " + std::to_string(all) + " " + things};
    return {true, share(count, all, things)};
}

template <class Test>
EffectFinding find_materials(const UsedSurfaces& used, const Test& test) {
    const auto count = std::count_if(used.materials().begin(), used.materials().end(),
                                     [&](const SceneEntity* each) { return test(*each); });
    return finding(static_cast<std::size_t>(count), used.materials().size(), "materials in use");
}

/// [medium] Whether a surface or the camera refers to it.
std::vector<std::uint8_t> used_media(const SceneDescription& scene, const UsedSurfaces& used) {
    std::vector<std::uint8_t> found(scene.media.size(), 0);
    const auto take = [&](int index) {
        if (index >= 0 && static_cast<std::size_t>(index) < found.size()) found[static_cast<std::size_t>(index)] = 1;
    };
    take(scene.camera_medium);
    for (const SceneShape* shape : used.shapes()) {
        take(shape->inside_medium);
        take(shape->outside_medium);
    }
    return found;
}

EffectFinding find_varying_media(const SceneDescription& scene, const UsedSurfaces& used) {
    const std::vector<std::uint8_t> found = used_media(scene, used);
    std::size_t count = 0;
    for (std::size_t i = 0; i < found.size(); ++i) count += found[i] != 0 && is_grid(scene.media[i]) ? 1 : 0;
    return finding(count, scene.media.size(), "media");
}

EffectFinding find_media(const SceneDescription& scene, const UsedSurfaces& used) {
    const std::vector<std::uint8_t> found = used_media(scene, used);
    const auto count = static_cast<std::size_t>(std::count(found.begin(), found.end(), 1));
    EffectFinding result = finding(count, scene.media.size(), "media");
    if (scene.camera_medium >= 0) result.why += ", one around the camera";
    const EffectFinding skin = find_materials(used, is_subsurface);
    if (skin.called_for) {
        result.why = (result.called_for ? result.why + "; " : std::string()) + skin.why + " with one inside";
        result.called_for = true;
    }
    return result;
}

EffectFinding find_lens(const SceneDescription& scene) {
    const std::string& type = scene.camera.type;
    if (type == "spherical") return {false, "a spherical camera"};
    if (!type.empty() && type != "perspective" && type != "orthographic")
        return {false, "camera '" + type + "' cannot be used without its lens"};
    const Result<double> radius = scene.camera.parameters.real_or("lensradius", 0);
    if (!radius || !(*radius > 0)) return {false, "a camera without a lens"};
    return {true, "a lens"};
}

EffectFinding find_images(const UsedSurfaces& used) {
    const auto& textures = used.textures();
    const auto images = std::count_if(textures.begin(), textures.end(),
                                      [](const SceneTexture* each) { return each->type == "imagemap"; });
    return finding(static_cast<std::size_t>(images), textures.size(), "textures in use");
}

EffectFinding find_filters(const UsedSurfaces& used) {
    const auto& textures = used.textures();
    const auto images = std::count_if(textures.begin(), textures.end(),
                                      [](const SceneTexture* each) { return is_filtered_image(*each); });
    return finding(static_cast<std::size_t>(images), textures.size(), "textures in use");
}

EffectFinding find_motion(const SceneDescription& scene) {
    const auto moving = static_cast<std::size_t>(std::count_if(
        scene.instances.begin(), scene.instances.end(), [](const SceneInstance& each) { return each.motion >= 0; }));
    const bool camera = scene.camera_moved_to.has_value();
    if (moving == 0 && !camera) return {false, "nothing moves"};
    const Result<ShutterSpan> span = shutter_span(scene);
    if (span && !span->moves()) return {false, "nothing moves while the shutter is open"};
    std::string why = moving == 0 ? std::string() : share(moving, scene.instances.size(), "placed objects");
    if (camera) why += why.empty() ? "the camera" : " and the camera";
    return {true, why};
}

template <class Test>
EffectFinding find_shapes(const UsedSurfaces& used, const Test& test) {
    const auto count =
        std::count_if(used.shapes().begin(), used.shapes().end(), [&](const SceneShape* each) { return test(*each); });
    return finding(static_cast<std::size_t>(count), used.shapes().size(), "shapes");
}

EffectFinding find_lights(const SceneDescription& scene, bool (*test)(const SceneEntity&)) {
    const auto count = std::count_if(scene.lights.begin(), scene.lights.end(), test);
    return finding(static_cast<std::size_t>(count), scene.lights.size(), "lights beside shapes");
}

}  // namespace

std::span<const EffectInfo> effect_catalogue() {
    return catalogue;
}
const EffectInfo& effect_info(Effect effect) {
    return catalogue[static_cast<std::size_t>(effect)];
}
std::span<const AbsentEffect> effects_not_simulated() {
    return not_simulated;
}

Result<Effect> effect_named(const std::string& name, const SourceLocation& where) {
    std::vector<std::string> names;
    std::string list;
    for (const EffectInfo& each : catalogue) {
        if (name == each.name) return each.effect;
        names.emplace_back(each.name);
        list += (list.empty() ? "" : ", ") + names.back();
    }
    for (const AbsentEffect& each : not_simulated)
        if (name == each.name)
            return error_at(
                where, "raylex does not simulate '" + name + "': " + each.consequence + "; expected one of: " + list);
    return error_at(where, "there is no effect '" + name + "'; expected one of: " + list, near_miss(name, names));
}

bool EffectChoices::any() const {
    return std::any_of(forced.begin(), forced.end(), [](const auto& each) { return each.has_value(); });
}

std::string EffectChoices::text() const {
    std::string text;
    for (const EffectInfo& each : catalogue)
        if (const std::optional<bool>& choice = (*this)[each.effect])
            text += (text.empty() ? "" : ", ") + std::string(each.name) + (*choice ? " on" : " off");
    return text;
}

EffectFindings analyse_effects(const SceneDescription& scene) {
    const UsedSurfaces used(scene);
    EffectFindings found;
    const auto put = [&](Effect effect, EffectFinding each) {
        found[static_cast<std::size_t>(effect)] = std::move(each);
    };
    put(Effect::media, find_media(scene, used));
    put(Effect::depth_of_field, find_lens(scene));
    put(Effect::image_textures, find_images(used));
    put(Effect::alpha, find_shapes(used, [&, mixed = mixes_with_interface(scene)](const SceneShape& each) {
            return has_cutouts(scene, each, mixed);
        }));
    put(Effect::shading_normals, find_shapes(used, [](const SceneShape& each) {
            return each.kind != ShapeKind::curves && !each.normals.empty();
        }));
    put(Effect::bump, find_materials(used, has_bumps));
    put(Effect::transmission, find_materials(used, lets_light_through));
    put(Effect::coats, find_materials(used, is_coated));
    put(Effect::facet_compensation, find_materials(used, asks_for_compensation));
    put(Effect::emissive_meshes, find_shapes(used, [](const SceneShape& each) { return each.area_light >= 0; }));
    put(Effect::delta_lights, find_lights(scene, is_delta_light));
    put(Effect::environment, find_lights(scene, is_environment));
    const std::size_t instances = scene.instances.size(), objects = scene.objects.size();
    put(Effect::instances,
        {instances > 0, instances == 0 ? std::string("no instances")
                                       : std::to_string(instances) + " of " + std::to_string(objects) +
                                             (objects == 1 ? " object" : " different objects")});
    put(Effect::motion, find_motion(scene));
    put(Effect::texture_filtering, find_filters(used));
    put(Effect::varying_media, find_varying_media(scene, used));
    put(Effect::dispersion,
        find_materials(used, [](const SceneEntity& each) { return varying_index(each) != nullptr; }));
    return found;
}

}  // namespace raylex::transport
