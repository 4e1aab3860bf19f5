#include "transport/render/built_scene.h"

#include <algorithm>
#include <set>

#include "transport/render/clock.h"
#include "transport/render/dark_lights.h"
#include "transport/textures/tee.h"

namespace raylex::transport {

namespace {

/// Adds the interior media of materials, under the material's name. Returns, for each material, the index or -1.
std::vector<std::int32_t> add_interiors(const SceneDescription& scene, const MaterialTable& materials,
                                        MediumTable& media) {
    std::vector<std::uint8_t> used(materials.size(), 0);
    const auto use = [&](const std::vector<SceneShape>& shapes) {
        for (const SceneShape& shape : shapes) used[static_cast<std::size_t>(std::max(shape.material, 0))] = 1;
    };
    use(scene.shapes);
    for (const SceneObject& object : scene.objects) use(object.shapes);
    std::vector<std::int32_t> result(materials.size(), -1);
    for (std::size_t i = 0; i < result.size(); ++i)
        if (const Medium* interior = materials.material(i)->interior(); interior != nullptr && used[i] != 0)
            result[i] = media.add(*interior, scene.materials[i].name.empty() ? "subsurface" : scene.materials[i].name);
    return result;
}

/// Grids that may extend beyond all shapes: those around the camera and outside of interfaces.
std::set<std::int32_t> open_grids(const EmbreeScene& geometry, const MediumTable& media) {
    std::set<std::int32_t> open{media.camera()};
    for (const ShapeGeometry& shape : geometry.shapes())
        if (shape.inside_medium != shape.outside_medium) open.insert(shape.outside_medium);
    std::erase_if(open, [&](std::int32_t index) { return index < 0 || media[index].grid == nullptr; });
    return open;
}

/// Light can come from all of these grids, so the bounds of lit space contain them.
void extend_lit_bounds(EmbreeScene& geometry, const MediumTable& media) {
    for (const std::int32_t index : open_grids(geometry, media)) {
        Bounds box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
        for (const DVec3& corner : media[index].grid->corners()) {
            const Vec3 at = corner.to_real();
            box.lower = {std::min(box.lower.x, at.x), std::min(box.lower.y, at.y), std::min(box.lower.z, at.z)};
            box.upper = {std::max(box.upper.x, at.x), std::max(box.upper.y, at.y), std::max(box.upper.z, at.z)};
        }
        geometry.extend_lit_bounds(box);
    }
}

Error swapped_shutter(const SceneDescription& description) {
    const Parameter* open = description.camera.parameters.find("shutteropen");
    const Parameter* close = description.camera.parameters.find("shutterclose");
    return error_at((open != nullptr ? open : close)->location,
                    "'shutteropen' is later than 'shutterclose'; the two are swapped, as in pbrt-v4");
}

void copy_settings(const SceneDescription& description, BuiltScene& scene) {
    scene.camera = description.camera;
    scene.film = description.film;
    scene.filter = description.filter;
    scene.sampler = description.sampler;
    scene.integrator = description.integrator;
    scene.file = description.file;
}

void warn_of_unused(const SceneEntity& entity, const std::string& kind, std::vector<Error>& warnings) {
    for (const Parameter* p : entity.parameters.unused())
        warnings.push_back(
            error_at(p->location, kind + " '" + entity.type + "' has no parameter '" + p->name + "'; it is ignored"));
}

}  // namespace

Result<std::shared_ptr<const BuiltScene>> BuiltScene::build(const SceneDescription& description,
                                                            const MachineSettings& machine, LoadingProgress* progress) {
    const Stopwatch watch;
    std::shared_ptr<BuiltScene> scene(new BuiltScene());
    auto patterns = texture_channels(description);
    if (!patterns) return patterns.error();
    scene->pattern_channels_ = *std::move(patterns);
    const RenderSpace space = RenderSpace::of(description);
    auto textures = TextureTable::build(description, space, machine.threads, progress);
    if (!textures) return textures.error();
    scene->textures_ = std::move(*textures);
    auto materials = MaterialTable::build(description, scene->textures_);
    if (!materials) return materials.error();
    scene->materials_ = std::move(*materials);
    const auto shutter = shutter_span(description);
    if (!shutter) return shutter.error();
    const auto begin = [&](const char* what) {
        if (progress != nullptr) progress->begin(what);
    };
    begin("acceleration structure");
    auto geometry =
        EmbreeScene::build(description, scene->textures_,
                           {machine.isa, machine.threads, space, *shutter, scene->materials_.surface_shares()});
    if (!geometry) return geometry.error();
    scene->geometry_ = std::make_unique<EmbreeScene>(*std::move(geometry));
    scene->warnings = scene->textures_.warnings();
    const std::vector<Error>& dropped = scene->geometry_->warnings();
    scene->warnings.insert(scene->warnings.end(), dropped.begin(), dropped.end());
    if (shutter->swapped) scene->warnings.push_back(swapped_shutter(description));
    if (scene->materials_.size() == 0)
        return error_at({description.file, 0, 0},
                        "the scene has no material; expected at least the default one at index 0");
    begin("media");
    auto media = MediumTable::build(description, scene->warnings, &space);
    if (!media) return media.error();
    scene->media_ = *std::move(media);
    const std::vector<std::int32_t> interiors = add_interiors(description, scene->materials_, scene->media_);
    for (ShapeGeometry& shape : scene->geometry_->shapes())
        if (const std::int32_t interior = interiors[static_cast<std::size_t>(shape.material)]; interior >= 0)
            shape.inside_medium = interior;
    extend_lit_bounds(*scene->geometry_, scene->media_);
    begin("lights");
    auto lights = LightTable::build(description, *scene->geometry_, scene->warnings);
    if (!lights) return lights.error();
    scene->lights_ = *std::move(lights);
    scene->dark_lights = find_dark_lights(description, scene->lights_, scene->media_);
    scene->general_code_ = description.general_code;
    if (scene->materials_.disperses() || description.general_code.contains(Effect::dispersion))
        scene->wavelengths_ = std::make_unique<const WavelengthDistribution>(description.color);

    scene->surface_names_ = SurfaceNames(description);
    copy_settings(description, *scene);
    if (Status s = scene->place_camera(description, *shutter); !s) return s.error();
    for (const SceneLight& light : description.lights) warn_of_unused(light, "light", scene->warnings);
    for (const SceneAreaLight& light : description.area_lights) warn_of_unused(light, "area light", scene->warnings);
    scene->build_seconds = watch.wall();
    scene->build_cpu_seconds = watch.process_cpu();
    return std::shared_ptr<const BuiltScene>(std::move(scene));
}

Status BuiltScene::place_camera(const SceneDescription& description, const ShutterSpan& shutter) {
    moves_ = is_moving(description, shutter);
    camera_to_world = description.camera_to_world;
    const auto motion = motion_of_camera(description);
    if (!motion) return motion.error();
    if (!*motion) return success();
    camera_to_world = (*motion)->at(shutter.first);
    if (moves_) camera_motion = std::make_shared<const CameraMotion>(**motion, shutter, space());
    return success();
}

namespace {

/// The events that a scene's surfaces add to its alphabet.
struct SurfaceEvents {
    std::set<std::string> labels;
    std::set<std::pair<std::string, LobeId>> scattering;  ///< by label
    std::set<std::string> straight;                       ///< labels of pass-through surfaces
    std::vector<std::uint8_t> used_area_lights;           ///< [area light]; those on instances do not emit

    SurfaceEvents(const SceneDescription& scene, const MaterialTable& materials, bool regularizes)
        : used_area_lights(scene.area_lights.size(), 0), regularizes_(regularizes) {
        for (const SceneShape& shape : scene.shapes) {
            add(scene, materials, shape, shape.label);
            if (shape.area_light >= 0 && static_cast<std::size_t>(shape.area_light) < used_area_lights.size())
                used_area_lights[static_cast<std::size_t>(shape.area_light)] = 1;
        }
        std::set<std::pair<int, std::string>> seen;
        for (const SceneInstance& instance : scene.instances) {
            if (instance.object < 0 || static_cast<std::size_t>(instance.object) >= scene.objects.size()) continue;
            // There may be millions of instances, and objects have thousands of shapes.
            if (!seen.emplace(instance.object, instance.label).second) continue;
            for (const SceneShape& shape : scene.objects[static_cast<std::size_t>(instance.object)].shapes)
                add(scene, materials, shape, instance.label.empty() ? shape.label : instance.label);
        }
    }

  private:
    void add(const SceneDescription& scene, const MaterialTable& materials, const SceneShape& shape,
             const std::string& label) {
        labels.insert(label);
        const auto material = static_cast<std::size_t>(std::max(shape.material, 0));
        const bool interface = material < scene.materials.size() && (scene.materials[material].type == "interface" ||
                                                                     scene.materials[material].type.empty());
        const bool mixed = material < materials.size() && materials.material(material)->surface_share() >= 0;
        if (interface || mixed || shape.alpha < 1 || !shape.alpha_texture.empty()) straight.insert(label);
        if (interface || material >= materials.size()) return;
        std::vector<LobeId> lobes;
        append_lobes(*materials.material(material), regularizes_, lobes);
        for (const LobeId lobe : lobes) scattering.insert({label, lobe});
    }

    bool regularizes_;
};

}  // namespace

namespace {

SceneAlphabet alphabet_of(const SceneDescription& scene, const MaterialTable& materials, const MediumTable& media,
                          std::vector<display::ChannelDefinition> pattern_channels, const lpe::LobeSlots& slots,
                          bool regularizes) {
    const SurfaceEvents surfaces(scene, materials, regularizes);
    std::set<std::string> groups;

    SceneAlphabet alphabet;
    alphabet.pattern_channels = std::move(pattern_channels);
    std::set<std::pair<bool, std::string>> terminals;
    for (std::size_t i = 0; i < scene.area_lights.size(); ++i)
        if (surfaces.used_area_lights[i]) terminals.insert({false, scene.area_lights[i].group});
    for (const SceneLight& light : scene.lights) terminals.insert({light.type == "infinite", light.group});
    for (const auto& [infinite, group] : terminals) {
        (infinite ? alphabet.has_background : alphabet.has_lights) = true;
        groups.insert(group);
        alphabet.terminals.push_back(terminal_event(infinite, group));
    }
    bool medium_emits = false;
    for (std::size_t i = 0; i < media.size(); ++i) {
        const Medium& medium = media[static_cast<std::int32_t>(i)];
        if (medium.scatters) alphabet.scattering.push_back(phase_event(media.names()[i]));
        medium_emits = medium_emits || medium.emits;
    }
    if (medium_emits) alphabet.terminals.push_back(emission_event());
    for (const auto& [label, lobe] : surfaces.scattering)
        alphabet.scattering.push_back(scattering_event(label, lobe_kinds()[lobe], slots));
    for (const std::string& label : surfaces.straight) alphabet.scattering.push_back(straight_event(label));
    alphabet.has_straight = !surfaces.straight.empty();
    alphabet.object_labels.assign(surfaces.labels.begin(), surfaces.labels.end());
    alphabet.light_groups.assign(groups.begin(), groups.end());
    return alphabet;
}

}  // namespace

Result<SceneAlphabet> scene_alphabet(const SceneDescription& scene, const lpe::LobeSlots& slots, bool regularizes) {
    auto textures = TextureTable::build(scene);
    if (!textures) return textures.error();
    auto materials = MaterialTable::build(scene, *textures);
    if (!materials) return materials.error();
    std::vector<Error> unused;  // the render reports warnings
    auto media = MediumTable::build(scene, unused);
    if (!media) return media.error();
    add_interiors(scene, *materials, *media);
    auto patterns = texture_channels(scene);
    if (!patterns) return patterns.error();
    return alphabet_of(scene, *materials, *media, *std::move(patterns), slots, regularizes);
}

SceneAlphabet scene_alphabet(const SceneDescription& description, const BuiltScene& built, const lpe::LobeSlots& slots,
                             bool regularizes) {
    const SceneView view = built.view();
    const auto patterns = built.pattern_channels();
    return alphabet_of(description, *view.materials, *view.media, {patterns.begin(), patterns.end()}, slots,
                       regularizes);
}

}  // namespace raylex::transport
