// Emitters with cutouts: every strategy must find the same light.
#include "transport/render_support.h"

using namespace render_test;

namespace {

/// A floor below one emitter of the given shape and alpha, without other light; the camera sees only the floor.
std::string lit_floor(const std::string& alpha, const std::string& two_sided, const std::string& shape) {
    return film + R"(
Integrator "path" "integer maxdepth" 1
LookAt 0 0.4 0  0 0 0  0 0 1
Camera "perspective" "float fov" 60
WorldBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 0 9 9 0 9 9 0 -9 -9 0 -9]
Texture "holes" "float" "checkerboard" "float uscale" 3 "float vscale" 2 "float tex1" 0.9 "float tex2" 0.1
Material "diffuse" "rgb reflectance" [0 0 0]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [4 4 4] "bool twosided" )" +
           two_sided + "\n  Translate 0.3 1.5 0\n  Rotate 90 1 0 0\n  Shape " + shape + " " + alpha +
           "\nAttributeEnd\n";
}

struct Emitter {
    const char *name, *shape;
};
const Emitter emitters[] = {
    {"triangles", R"("trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]
                     "point2 uv" [0 0 1 0 1 1 0 1])"},
    {"patch", R"("bilinearmesh" "point3 P" [-1 -1 0 1 -1 0 -1 1 0.3 1 1 0])"},
    {"disk", R"("disk" "float radius" 0.8)"},
    {"sphere", R"("sphere" "float radius" 0.6)"},
    {"cylinder", R"("cylinder" "float radius" 0.4)"},
};

Estimate with_strategy(const std::string& text, const char* strategy) {
    transport::SceneDescription scene = scene_of(text);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 256;
    auto integrator = path_with(text_parameter("strategy", strategy));
    settings.paths.integrator = integrator;
    settings.paths.max_depth = 1;
    return estimate(render_of(scene, settings));
}

}  // namespace

TEST_CASE("An emitter with a textured cutout has the same light with every strategy", "[law1][gate]") {
    for (const Emitter& emitter : emitters)
        for (const char* two_sided : {"false", "true"}) {
            const std::string text = lit_floor(R"("texture alpha" "holes")", two_sided, emitter.shape);
            const Estimate mis = with_strategy(text, "mis"), light = with_strategy(text, "light"),
                           scattering = with_strategy(text, "scattering");
            INFO(emitter.name << ", two-sided " << two_sided << ": mis " << mis.mean << " +- " << mis.error
                              << ", light " << light.mean << " +- " << light.error << ", scattering " << scattering.mean
                              << " +- " << scattering.error);
            // Some one-sided emitters face away: all three must be 0 then.
            if (scattering.mean == 0) {
                CHECK(mis.mean == 0);
                CHECK(light.mean == 0);
                continue;
            }
            CHECK(deviation(mis, scattering) < 4.5);
            CHECK(deviation(light, scattering) < 4.5);
        }
}

TEST_CASE("An area light with alpha 0 is invisible and emits like an opaque one", "[law1]") {
    const std::string shape = emitters[0].shape;
    const Estimate hidden = with_strategy(lit_floor(R"("float alpha" 0)", "true", shape), "mis"),
                   whole = with_strategy(lit_floor("", "true", shape), "mis");
    INFO("hidden " << hidden.mean << " +- " << hidden.error << ", whole " << whole.mean << " +- " << whole.error);
    REQUIRE(whole.mean > 0);
    CHECK(deviation(hidden, whole) < 4.5);

    // The camera looks straight at it and sees nothing.
    transport::SceneDescription scene = scene_of(film + R"(
LookAt 0 0 -3  0 0 0  0 1 0
Camera "perspective" "float fov" 10
WorldBegin
AreaLightSource "diffuse" "rgb L" [4 4 4] "bool twosided" true
Shape "sphere" "float alpha" 0
)");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    CHECK(estimate(render_of(scene, settings)).mean == 0);
}
