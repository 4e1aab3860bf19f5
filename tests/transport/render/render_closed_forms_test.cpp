// Renders against closed forms. Each scene is tiny; tolerances are standard errors of the render itself.
#include <numbers>

#include "transport/enclosure.h"

using namespace render_test;

TEST_CASE("a point light over a plane has its closed-form mean", "[render]") {
    // reference: E = I cos / d^2 = 10 h / (h^2 + r^2)^1.5, L = E / (2 pi); mean over the image 0.221335 with a box
    // filter.
    auto scene = scene_of(R"(
Film "rgb" "integer xresolution" 50 "integer yresolution" 50
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "zsobol" "integer pixelsamples" 64
Integrator "path" "integer maxdepth" 1
LookAt 0 4 0.001  0 0 0  0 0 -1
Camera "perspective" "float fov" 50
WorldBegin
LightSource "point" "rgb I" [10 10 10] "point3 from" [0 2 0]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-5 0 5 5 0 5 5 0 -5 -5 0 -5]
)");
    // Only the ray's position in the pixel is random: 160,000 stratified rays have an error below 1e-5.
    CHECK(estimate(render_of(scene)).mean == Approx(0.221335).margin(1e-5));
}

TEST_CASE("a convex diffuse object in a uniform sky reflects albedo times sky", "[render]") {
    auto scene = scene_of(film + R"(
Integrator "path" "integer maxdepth" 8
LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" 10
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "sphere" "float radius" 1
)");
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("once", "C<RD>B"), lpe_channel("more", "C<RD>[DS]+B")};
    const auto output = render_of(scene, settings);
    // The camera sees only the sphere; every path is 0.5 exactly, up to float rounding of one product.
    CHECK(estimate(output).mean == Approx(0.5).epsilon(1e-6));
    CHECK(estimate(output, 1).mean == Approx(0.5).epsilon(1e-6));
    CHECK(estimate(output, 2).mean == 0);  // row F: a convex object never sees itself
}

TEST_CASE("in a furnace of emitting walls every path string has its own power of the albedo", "[render]") {
    // Row D: L = sum of 0.5^k, k <= 6; the path string with k reflections contributes 0.5^k.
    auto scene = scene_of(film + R"(
Integrator "path" "integer maxdepth" 6
LookAt 0 0 0  0 0 -1  0 1 0
Camera "perspective" "float fov" 60
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
ReverseOrientation
Shape "sphere" "float radius" 2
)");
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("k0", "C[<L.>O]"), lpe_channel("k1", "C<RD>[<L.>O]"),
                              lpe_channel("k2", "C<RD>D[<L.>O]"), lpe_channel("k6", "CD{6}[<L.>O]"),
                              lpe_channel("even", "C(DD)*[<L.>O]")};
    settings.samples.per_pixel = 256;
    const auto output = render_of(scene, settings);
    const double expected[] = {2 - std::pow(0.5, 6), 1, 0.5, 0.25, std::pow(0.5, 6), 1 + 0.25 + 0.0625 + 1.0 / 64};
    for (display::ChannelId id = 0; id < 6; ++id) {
        const Estimate e = estimate(output, id);
        INFO("channel " << id << " mean " << e.mean << " +- " << e.error);
        CHECK(std::abs(e.mean - expected[id]) <= 4.5 * e.error + 1e-6 * expected[id]);
        CHECK(e.error < 0.03 * expected[id] + 1e-9);  // so that the check can fail
    }
}

TEST_CASE("a mirror box multiplies by its reflectance, also for each path string", "[render]") {
    // Row A with kd = 0.5, ks = 0.3 in a sphere: L = Le / (1 - kd - ks) = 5 except for a remainder of 0.8^100.
    const auto scene = scene_of(enclosure(0.5, 0.3));
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("dsd", "CDSD[<L.>O]"), lpe_channel("s-first", "CSD*[<L.>O]")};
    settings.samples.per_pixel = 256;
    settings.paths.max_depth = 100;
    const auto output = render_of(scene, settings);
    const double expected[] = {5, 0.5 * 0.3 * 0.5, 0.3 / (1 - 0.5)};
    for (display::ChannelId id = 0; id < 3; ++id) {
        const Estimate e = estimate(output, id);
        INFO("channel " << id << " mean " << e.mean << " +- " << e.error);
        CHECK(std::abs(e.mean - expected[id]) <= 4.5 * e.error + 1e-5);
        CHECK(e.error < 0.03 * expected[id]);
    }
}

TEST_CASE("cutouts blend front and back, for camera rays and shadow rays", "[render]") {
    // A card of opacity 0.25 and albedo 0 before a wall lit by a distant light that also passes a second card of 0.5:
    // the radiance of the wall is 0.75 * 0.5 * albedo / pi * E.
    auto scene = scene_of(film + R"(
Integrator "path" "integer maxdepth" 2
LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" 20
WorldBegin
LightSource "distant" "rgb L" [2 2 2] "point3 from" [0 1 0.1] "point3 to" [0 0 0]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 -9 0 9 -9 0 9 9 0 -9 9 0]
Material "diffuse" "rgb reflectance" [0 0 0]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 -9 4 9 -9 4 9 9 4 -9 9 4] "float alpha" 0.25
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 3 0 9 3 0 9 3 3 -9 3 3] "float alpha" 0.5
)");
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("direct", "C<RD>L")};
    const auto output = render_of(scene, settings);
    const double cosine = 0.1 / std::sqrt(1.01), expected = 0.75 * 0.5 * 0.5 / std::numbers::pi * 2 * cosine;
    const Estimate e = estimate(output);
    CHECK(std::abs(e.mean - expected) <= 4.5 * e.error + 1e-6);
    CHECK(e.error < 0.02 * expected);
    CHECK(estimate(output, 1).mean == e.mean);  // a pass-through leaves no event in this dialect
    for (const double alpha : output.frame_buffer.resolve_alpha()) CHECK(alpha == Approx(1));
}
