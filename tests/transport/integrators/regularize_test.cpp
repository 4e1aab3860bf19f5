// "regularize" of path: closures blurred behind a scattering that is not specular.
#include <catch2/catch.hpp>

#include <algorithm>

#include "tests/transport/materials_support.h"
#include "tests/transport/render_support.h"
#include "transport/materials/closures/closure.h"

using namespace render_test;
using namespace raylex::transport;

namespace {

/// The floor below a glass ball, in the light of a distant lamp: what comes through the ball no light sample finds.
const char* const ball_on_floor = R"(
Film "rgb" "integer xresolution" 12 "integer yresolution" 12
Sampler "independent" "integer pixelsamples" 256
LookAt 0 6 -6  0 0 0  0 1 0
Camera "perspective" "float fov" 30
WorldBegin
LightSource "distant" "point3 from" [0 1 0] "point3 to" [0 0 0] "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "disk" "float radius" 20
Material "dielectric"
Translate 0 1.2 0
Shape "sphere" "float radius" 1
)";

SceneDescription scene() {
    // A disk lies in z; the floor is to lie in y.
    std::string text = ball_on_floor;
    const std::string disk = "Shape \"disk\"";
    text.replace(text.find(disk), disk.size(), "AttributeBegin Rotate -90 1 0 0 " + disk);
    text.replace(text.find("20\n"), 3, "20\nAttributeEnd\n");
    return scene_of(text);
}

}  // namespace

TEST_CASE("regularized microfacets have pbrt's alphas, and are closures like others", "[materials]") {
    const auto wider = [](Real alpha) { return Ggx{alpha, alpha}.regularized().alpha_x; };
    CHECK(wider(0) == Real(0.1));
    CHECK(wider(Real(0.04)) == Real(0.1));
    CHECK(wider(Real(0.0625)) == Real(0.125));
    CHECK(wider(Real(0.25)) == Real(0.3));
    CHECK(wider(Real(0.3)) == Real(0.3));
    CHECK(wider(Real(0.5)) == Real(0.5));
    const Frame frame = raylex::test::tilted_frame();
    const Vec3 wo = frame.to_world(raylex::test::local_direction(0.8f)),
               wi = frame.to_world(raylex::test::local_direction(0.75f, 0.7f + 3.1f));
    Bsdf smooth, rough;
    smooth.set(frame, GlassClosure{{Ggx{0, 0}, Real(1.5)}});
    rough.set(frame, GlassClosure{{Ggx{Real(0.1), Real(0.1)}, Real(1.5)}});
    CHECK_FALSE(smooth.has_density());
    smooth.regularize();
    CHECK(smooth.has_density());
    CHECK(smooth.pdf(wo, wi) > 0);
    CHECK(smooth.pdf(wo, wi) == rough.pdf(wo, wi));
    CHECK(smooth.evaluate(wo, wi).value == rough.evaluate(wo, wi).value);
    Bsdf metal;
    metal.set(frame, ConductorClosure{Ggx{0, 0}, Rgb(1), Rgb(2), false});
    metal.regularize();
    CHECK(metal.has_density());
    Bsdf matched;  // turns no light, however rough
    matched.set(frame, GlassClosure{{Ggx{0, 0}, Real(1)}});
    matched.regularize();
    CHECK_FALSE(matched.has_density());
}

TEST_CASE("a regularized path finds what comes through glass, and its words are glossy behind the floor",
          "[render][law4][statistical]") {
    RenderSettings settings;
    settings.channels.list = {lpe_channel("through", "C<RD><TG>+L"), lpe_channel("any", "C<RD>T+L"),
                              lpe_channel("seen", "CT+<RD>L"), lpe_channel("seen blurred", "C<TG>T*<RD>L")};
    const RenderOutput plain = render_of(scene(), settings);
    const auto id = [](const RenderOutput& output, const std::string& name) {
        const auto channels = output.frame_buffer.channels();
        const auto found = std::find_if(channels.begin(), channels.end(),
                                        [&](const display::ChannelDefinition& each) { return each.name == name; });
        REQUIRE(found != channels.end());
        return static_cast<display::ChannelId>(found - channels.begin());
    };
    CHECK(estimate(plain, id(plain, "any")).mean == 0);
    settings.paths.integrator = path_with(flag_parameter("regularize", true));
    const RenderOutput blurred = render_of(scene(), settings);
    const Estimate through = estimate(blurred, id(blurred, "through"));
    CHECK(through.mean > 5 * through.error);
    CHECK(estimate(blurred, id(blurred, "any")).mean == through.mean);
    // Where the camera meets the ball first nothing is blurred.
    CHECK(estimate(blurred, id(blurred, "seen")).mean > 0);
    CHECK(estimate(blurred, id(blurred, "seen blurred")).mean == 0);
    // Where channels alone decide what is traced, they know that glass may be glossy (Law 4): 4 standard errors.
    settings.channels.beauty = false;
    settings.samples.seed = 7;
    const RenderOutput alone = render_of(scene(), settings);
    const Estimate pruned = estimate(alone, id(alone, "through"));
    CHECK(std::abs(pruned.mean - through.mean) < 4 * std::hypot(pruned.error, through.error));
}
