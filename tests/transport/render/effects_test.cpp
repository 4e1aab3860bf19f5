// The effects that a scene uses, and the images with effects forced on and off.
#include <catch2/catch.hpp>

#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

#include "tests/transport/render_support.h"
#include "transport/color/spectrum.h"
#include "transport/import/apply_effects.h"
#include "transport/scene/effects/effects.h"
#include "transport/scene/scene_hash.h"

using namespace render_test;
using namespace raylex::transport;
using import_test::contains;

namespace {

// A floor under one lamp or light: parts of it are replaced to use one effect each.
constexpr const char* plain_camera = "Camera \"perspective\" \"float fov\" 40";
constexpr const char* plain_material = "Material \"diffuse\" \"rgb reflectance\" [0.5 0.4 0.3]";
constexpr const char* plain_shape = "Shape \"sphere\" \"float radius\" 0.5";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    REQUIRE(at != std::string::npos);
    return text.replace(at, what.size(), by);
}

std::string effects_scene(const std::string& extra = {}) {
    return std::string(
               "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 12\n"
               "PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5\n"
               "Sampler \"zsobol\" \"integer pixelsamples\" 4\nIntegrator \"path\" \"integer maxdepth\" 6\n"
               "LookAt 0 1 4  0 0.4 0  0 1 0\n") +
           plain_camera + "\nWorldBegin\n" + extra + "\n" + plain_material +
           "\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" "
           "[-3 0 3 3 0 3 3 0 -3 -3 0 -3] \"point2 uv\" [0 0 1 0 1 1 0 1]\n"
           "AttributeBegin\nTranslate 0 0.5 0\n" +
           plain_shape + "\nAttributeEnd\n";
}

const std::string fog =
    "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0.05 0.1 0.1] "
    "\"rgb sigma_s\" [0.2 0.2 0.1]\n";
const std::string lamp = "LightSource \"point\" \"rgb I\" [5 6 7] \"point3 from\" [1 3 2]";

const std::string dispersive_glass = "Material \"dielectric\" \"spectrum eta\" [400 1.7 700 1.4]";

/// The mean index with all its digits.
std::string mean_index_of(const std::string& material) {
    const SceneDescription scene = scene_of(replaced(effects_scene(), plain_material, material));
    const auto mean = mean_of_spectrum(scene.materials.back().parameters.parameters.front(), scene.color);
    REQUIRE(mean.ok());
    std::ostringstream text;
    text << std::setprecision(17) << static_cast<double>(*mean);
    return text.str();
}

/// A scene that uses a single effect, and the same scene written without it. Both have the same lights, except for
/// effects that are lights, which are written without any.
struct Example {
    Effect effect;
    std::string with, without;
};

std::vector<Example> examples(const std::string& image) {
    const std::string mesh =
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [-1 0.1 1 1 0.1 1 0 1 -1]";
    const std::string shining = "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [9 8 7]\nTranslate 0 2 0\n" +
                                std::string(plain_shape) + "\nAttributeEnd\n";
    const std::string dark = "AttributeBegin\nTranslate 0 2 0\n" + std::string(plain_shape) + "\nAttributeEnd\n";
    const std::string with_texture =
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + image +
        "\" \"string encoding\" \"linear\" \"string filter\" \"unfiltered\" \"float uscale\" 40 \"float vscale\" 40\n" +
        lamp;
    const std::string textured = "Material \"diffuse\" \"texture reflectance\" \"t\"";
    const auto material = [&](const std::string& text) { return replaced(effects_scene(lamp), plain_material, text); };
    const auto shape = [&](const std::string& text) { return replaced(effects_scene(lamp), plain_shape, text); };
    return {
        {Effect::media, replaced(effects_scene(lamp), "Camera", fog + "MediumInterface \"\" \"fog\"\nCamera"),
         effects_scene(lamp)},
        {Effect::depth_of_field,
         replaced(effects_scene(lamp), plain_camera,
                  std::string(plain_camera) + " \"float lensradius\" 0.1 \"float focaldistance\" 3"),
         effects_scene(lamp)},
        {Effect::depth_of_field,
         replaced(effects_scene(lamp), plain_camera,
                  "Camera \"orthographic\" \"float lensradius\" 0.1 \"float focaldistance\" 3"),
         replaced(effects_scene(lamp), plain_camera, "Camera \"orthographic\" \"float focaldistance\" 3")},
        {Effect::image_textures, replaced(effects_scene(with_texture), plain_material, textured),
         // The image is black and white, with shares of three quarters and a quarter.
         replaced(effects_scene(lamp), plain_material, "Material \"diffuse\" \"rgb reflectance\" [0.25 0.25 0.25]")},
        {Effect::texture_filtering,
         replaced(replaced(effects_scene(with_texture), plain_material, textured), "unfiltered", "trilinear"),
         replaced(effects_scene(with_texture), plain_material, textured)},
        {Effect::alpha, shape(std::string(plain_shape) + " \"float alpha\" 0.6"), effects_scene(lamp)},
        {Effect::shading_normals, shape(mesh + " \"normal N\" [0 1 1 0 1 0 1 1 0]"), shape(mesh)},
        {Effect::bump,
         replaced(effects_scene("Texture \"h\" \"float\" \"checkerboard\"\n" + lamp), plain_material,
                  std::string(plain_material) + " \"texture displacement\" \"h\""),
         effects_scene("Texture \"h\" \"float\" \"checkerboard\"\n" + lamp)},
        {Effect::transmission, material("Material \"dielectric\""), material("Material \"interface\"")},
        {Effect::transmission,
         material(
             "Material \"diffusetransmission\" \"rgb reflectance\" [0.5 0.4 0.3] \"rgb transmittance\" [0.2 0.2 0.2]"),
         effects_scene(lamp)},
        {Effect::media,
         material("Material \"subsurface\" \"float eta\" 1.4 \"float mfp\" 0.1 \"rgb reflectance\" [0.5 0.4 0.3] "
                  "\"float roughness\" 0.3"),
         material("Material \"dielectric\" \"float eta\" 1.4 \"float roughness\" 0.3")},
        {Effect::coats,
         material("Material \"coateddiffuse\" \"rgb reflectance\" [0.5 0.4 0.3] \"float roughness\" 0.1"),
         effects_scene(lamp)},
        {Effect::coats,
         material("Material \"coatedconductor\" \"float conductor.roughness\" 0.3 \"float interface.roughness\" 0.1"),
         material("Material \"conductor\" \"float roughness\" 0.3")},
        {Effect::facet_compensation,
         material("Material \"conductor\" \"float roughness\" 0.5 \"bool raylex:compensate\" true"),
         material("Material \"conductor\" \"float roughness\" 0.5")},
        {Effect::varying_media,
         replaced(
             effects_scene(lamp), "Camera",
             "MakeNamedMedium \"fog\" \"string type\" \"rgbgrid\" \"integer nx\" 2 \"rgb sigma_a\" [0 0 0 1 2 4] "
             "\"rgb sigma_s\" [.5 .5 .5 1.5 .5 .5] \"rgb Le\" [0 0 0 1 1 1]\nMediumInterface \"\" \"fog\"\nCamera"),
         replaced(effects_scene(lamp), "Camera",
                  "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.5 1 2] "
                  "\"rgb sigma_s\" [1 .5 .5]\nMediumInterface \"\" \"fog\"\nCamera")},
        {Effect::emissive_meshes, effects_scene(shining), effects_scene(dark)},
        {Effect::delta_lights, effects_scene(lamp), effects_scene()},
        {Effect::delta_lights,
         effects_scene("AttributeBegin\nTranslate 2 3 4\nLightSource \"goniometric\" \"string filename\" \"" + image +
                       "\"\nAttributeEnd"),
         effects_scene()},
        {Effect::environment, effects_scene("LightSource \"infinite\" \"rgb L\" [0.5 0.6 0.7]"), effects_scene()},
        {Effect::instances,
         effects_scene(lamp + "\nObjectBegin \"ball\"\n" + plain_shape +
                       "\nObjectEnd\nAttributeBegin\nTranslate 1 0.5 0\nObjectInstance \"ball\"\nAttributeEnd\n"),
         effects_scene(lamp)},
        {Effect::dispersion, shape(dispersive_glass + "\n" + plain_shape),
         shape("Material \"dielectric\" \"float eta\" " + mean_index_of(dispersive_glass) + "\n" + plain_shape)},
        {Effect::motion,
         replaced(effects_scene(lamp), plain_camera,
                  std::string("ActiveTransform StartTime Translate -0.125 0 0 ActiveTransform EndTime Translate 0.125 "
                              "0 0 ActiveTransform All\n") +
                      plain_camera),
         effects_scene(lamp)},
    };
}

/// Two by two texels: three black, one white, so that the mean is exactly a quarter.
std::string quarter_image(const import_test::Folder& folder) {
    std::string text = "PF\n2 2\n-1.0\n";
    for (const float texel : {0.0f, 0.0f, 0.0f, 1.0f})
        for (int c = 0; c < 3; ++c) text.append(reinterpret_cast<const char*>(&texel), sizeof texel);
    folder.write("quarter.pfm", text);
    return folder.path("quarter.pfm");
}

bool called_for(const EffectFindings& found, Effect effect) {
    return found[static_cast<std::size_t>(effect)].called_for;
}

SceneDescription forced(SceneDescription scene, Effect effect, bool on) {
    EffectChoices choices;
    choices[effect] = on;
    const raylex::Status applied = apply_effects(scene, choices);
    INFO((applied ? std::string() : applied.error().to_string()));
    REQUIRE(applied.ok());
    return scene;
}

/// All layers of an image by one integrator: beauty, parts of the light, a statistic, geometry.
std::vector<std::vector<double>> layers_of(const SceneDescription& scene, const std::string& integrator) {
    RenderSettings settings;
    settings.machine.threads = 1;
    settings.paths.integrator.emplace();
    settings.paths.integrator->type = integrator;
    settings.channels.list = {lpe_channel("direct", "C<RD>L"), lpe_channel("rest", "C.+[LOB]"), aov("Nn"), aov("z"),
                              aov("albedo")};
    const RenderOutput output = render_of(scene, settings);
    std::vector<std::vector<double>> layers;
    for (std::size_t i = 0; i < output.frame_buffer.channels().size(); ++i)
        layers.push_back(output.frame_buffer.resolve(static_cast<display::ChannelId>(i)));
    layers.push_back(output.frame_buffer.resolve_alpha());
    return layers;
}

}  // namespace

TEST_CASE("effects: the analysis finds exactly the effects that a scene uses", "[effects]") {
    const import_test::Folder folder;
    for (const Example& each : examples(quarter_image(folder))) {
        const EffectFindings with = analyse_effects(scene_of(each.with)),
                             without = analyse_effects(scene_of(each.without));
        for (const EffectInfo& info : effect_catalogue()) {
            CAPTURE(effect_info(each.effect).name, info.name);
            if (info.effect == each.effect) {
                CHECK(called_for(with, info.effect));
                CHECK_FALSE(called_for(without, info.effect));
            } else {
                CHECK(called_for(with, info.effect) == called_for(without, info.effect));
            }
            CHECK_FALSE(with[static_cast<std::size_t>(info.effect)].why.empty());
        }
    }
}

TEST_CASE("effects: the catalogue is in the order of Effect, and names map to their effects", "[effects]") {
    CHECK(effect_catalogue().size() == effect_count);
    for (std::size_t i = 0; i < effect_count; ++i) {
        const EffectInfo& info = effect_catalogue()[i];
        CHECK(static_cast<std::size_t>(info.effect) == i);
        const auto named = effect_named(info.name, {});
        REQUIRE(named.ok());
        CHECK(*named == info.effect);
    }
    const auto slip = effect_named("medai", {"job.toml", 3, 5});
    REQUIRE_FALSE(slip.ok());
    CHECK(contains(slip.error().to_string(), "job.toml:3:5"));
    CHECK(contains(slip.error().to_string(), "did you mean 'media'?"));
    const auto absent = effect_named("polarisation", {"job.toml", 3, 5});
    REQUIRE_FALSE(absent.ok());
    CHECK(contains(absent.error().message, "does not simulate 'polarisation'"));
}

TEST_CASE("effects: forced off, the scene renders bit for bit like a scene without the effect", "[effects]") {
    const import_test::Folder folder;
    for (const Example& each : examples(quarter_image(folder))) {
        CAPTURE(effect_info(each.effect).name);
        const SceneDescription off = forced(scene_of(each.with), each.effect, false);
        CHECK_FALSE(called_for(analyse_effects(off), each.effect));
        const auto image = layers_of(off, "path");
        CHECK((image == layers_of(scene_of(each.without), "path")));
        // Without any light both are black; otherwise the effect must be visible.
        CHECK((image != layers_of(scene_of(each.with), "path")));
    }
}

TEST_CASE("effects: forcing on an unused effect changes no bit of any layer", "[effects][gate]") {
    const import_test::Folder folder;
    std::vector<std::string> scenes{effects_scene(lamp), room};
    for (const Example& each : examples(quarter_image(folder)))
        if (each.effect == Effect::media || each.effect == Effect::alpha || each.effect == Effect::transmission)
            scenes.push_back(each.with);
    for (const std::string& text : scenes) {
        SceneDescription scene = scene_of(text);
        // As many rows as the time of the suite allows.
        scene.film.parameters.parameters[0].numbers = {16};
        scene.film.parameters.parameters[1].numbers = {12};
        scene.sampler.parameters.parameters[0].numbers = {4};
        const EffectFindings found = analyse_effects(scene);
        for (const char* integrator : {"path", "bdpt", "lighttracer"}) {
            const auto analysed = layers_of(scene, integrator);
            for (const EffectInfo& info : effect_catalogue()) {
                CAPTURE(text, integrator, info.name);
                CHECK((layers_of(forced(scene, info.effect, true), integrator) == analysed));
                if (called_for(found, info.effect)) continue;
                const SceneDescription off = forced(scene, info.effect, false);
                CHECK(scene_hash(off) == scene_hash(scene));
            }
        }
    }
}

TEST_CASE("effects: forced on runs the general code", "[effects]") {
    // The test for cutouts adds a shadow ray for each one that arrives: the only count that shows it.
    const SceneDescription scene = scene_of(effects_scene(lamp));
    const RenderOutput analysed = render_of(scene), general = render_of(forced(scene, Effect::alpha, true));
    CHECK(general.statistics.shadow_rays > analysed.statistics.shadow_rays);
}

TEST_CASE("effects: glass in a mix becomes a sheet that passes all light", "[effects]") {
    const std::string text =
        replaced(effects_scene(lamp), plain_material,
                 "MakeNamedMaterial \"glass\" \"string type\" \"dielectric\"\n"
                 "MakeNamedMaterial \"grey\" \"string type\" \"diffuse\"\n"
                 "Material \"mix\" \"string materials\" [\"grey\" \"glass\"] \"float amount\" 0.5");
    const std::string without = replaced(text, "\"string type\" \"dielectric\"",
                                         "\"string type\" \"raylex:sheet\" \"rgb transmittance\" [1 1 1]");
    CHECK((layers_of(forced(scene_of(text), Effect::transmission, false), "path") ==
           layers_of(scene_of(without), "path")));
}

TEST_CASE("effects: without cutouts invisible shapes are removed, and invisible emitters become visible", "[effects]") {
    const std::string hidden =
        "AttributeBegin\nTranslate 0 2 0\nShape \"sphere\" \"float radius\" 0.3 \"float alpha\" 0\nAttributeEnd\n";
    const SceneDescription gone = forced(scene_of(effects_scene(lamp + "\n" + hidden)), Effect::alpha, false);
    CHECK(scene_hash(gone) == scene_hash(scene_of(effects_scene(lamp))));
    const std::string shining = replaced(hidden, "Shape", "AreaLightSource \"diffuse\"\nShape");
    const SceneDescription seen = forced(scene_of(effects_scene(shining)), Effect::alpha, false);
    REQUIRE(seen.shapes.size() == 3);
    CHECK(seen.shapes[0].alpha == 1);
    CHECK(seen.shapes[0].area_light == 0);
}

TEST_CASE("effects: a missing image whose mean is needed is an error that names it", "[effects]") {
    const import_test::Folder folder;
    const std::string image = quarter_image(folder);
    SceneDescription scene;
    for (const Example& each : examples(image))
        if (each.effect == Effect::image_textures) scene = scene_of(each.with);
    REQUIRE(import_test::fs::remove(image));
    EffectChoices choices;
    choices[Effect::image_textures] = false;
    const raylex::Status applied = apply_effects(scene, choices);
    REQUIRE_FALSE(applied.ok());
    CHECK(contains(applied.error().to_string(), "quarter.pfm"));
    CHECK(applied.error().line > 0);
}
