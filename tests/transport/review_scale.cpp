// The same scene in other units, and far from the origin.
#include "transport/render_support.h"

using namespace render_test;

namespace {

/// A room with an area light, in units of `s` (its walls 2 apart), around (x, 0, 0). No light that has a unit of
/// length.
std::string room_at(double s, double x) {
    const auto n = [](double v) {
        char text[32];
        std::snprintf(text, sizeof text, "%.9g ", v);
        return std::string(text);
    };
    const auto p = [&](double a, double b, double c) { return n(x + s * a) + n(s * b) + n(s * c); };
    const auto quad = [&](const std::string& points) {
        return "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [" + points + "]\n";
    };
    std::string text = film + "Integrator \"path\" \"integer maxdepth\" 5\nLookAt " + p(0, 1, 3.9) + p(0, 1, 0) +
                       "0 1 0\nCamera \"perspective\" \"float fov\" 39\nWorldBegin\n"
                       "Material \"diffuse\" \"rgb reflectance\" [0.6 0.6 0.6]\n";
    text += quad(p(-1, 0, 1) + p(1, 0, 1) + p(1, 0, -1) + p(-1, 0, -1));
    text += quad(p(-1, 2, -1) + p(1, 2, -1) + p(1, 2, 1) + p(-1, 2, 1));
    text += quad(p(-1, 0, -1) + p(1, 0, -1) + p(1, 2, -1) + p(-1, 2, -1));
    text += quad(p(-1, 0, 1) + p(-1, 0, -1) + p(-1, 2, -1) + p(-1, 2, 1));
    text += "Shape \"bilinearmesh\" \"point3 P\" [" + p(1, 0, -1) + p(1, 0, 1) + p(1, 2, -1) + p(1, 2, 1) + "]\n";
    text += "AttributeBegin\nTranslate " + p(0.3, 0.4, 0.2) + "Scale " + n(s) + n(s) + n(s) +
            "Shape \"sphere\" \"float radius\" 0.4\nAttributeEnd\n";
    text += "AreaLightSource \"diffuse\" \"rgb L\" [8 8 8]\n";
    return text + quad(p(-0.4, 1.98, -0.4) + p(0.4, 1.98, -0.4) + p(0.4, 1.98, 0.4) + p(-0.4, 1.98, 0.4));
}

}  // namespace

TEST_CASE("The unit of length does not show", "[law6]") {
    const Estimate expected = estimate(render_of(scene_of(room_at(1, 0))));
    for (const double s : {1e-8, 1e-6, 1e-3, 1e3, 1e6, 1e8}) {
        const Estimate scaled = estimate(render_of(scene_of(room_at(s, 0))));  // counts no invalid sample
        INFO("scale " << s << ": " << scaled.mean << " +- " << scaled.error << ", expected " << expected.mean);
        CHECK(deviation(scaled, expected) < 4.5);
    }
}

TEST_CASE("Triangles of 1e-10 have a normal", "[law6]") {
    // The squared length of their edges' cross product is below the smallest float. One bounce off a wall that fills
    // the view, under a sky of 1: the albedo, exactly but for single roundings.
    const Estimate e = estimate(render_of(scene_of(film + R"(
Integrator "path" "integer maxdepth" 1
LookAt 0 0 -1e-10  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
    "point3 P" [-1e-10 -1e-10 1e-10  1e-10 -1e-10 1e-10  1e-10 1e-10 1e-10  -1e-10 1e-10 1e-10]
)")));
    CHECK(e.mean == Approx(0.5).epsilon(1e-6));
}

TEST_CASE("A room far from the origin keeps its light", "[law6]") {
    // At 1e5 a float steps by 2^-7, so a room of 200 is built of coordinates exact to 4e-5 of it: the image's mean
    // moves by less than its standard error of half a percent.
    const Estimate expected = estimate(render_of(scene_of(room_at(100, 0)))),
                   far = estimate(render_of(scene_of(room_at(100, 1e5))));
    INFO(far.mean << " +- " << far.error << ", expected " << expected.mean << " +- " << expected.error);
    CHECK(deviation(far, expected) < 4.5);
}
