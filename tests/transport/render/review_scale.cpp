// One scene in other units, and far from the origin.
#include "transport/render_support.h"

using namespace render_test;

namespace {

std::string number(double v) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g ", v);
    return text;
}

/// A room with an area light, in units of `s` (its walls are 2 apart), around (x, 0, 0). It has no light that depends
/// on the unit of length.
std::string room_at(double s, double x) {
    const auto p = [&](double a, double b, double c) { return number(x + s * a) + number(s * b) + number(s * c); };
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
    text += "AttributeBegin\nTranslate " + p(0.3, 0.4, 0.2) + "Scale " + number(s) + number(s) + number(s) +
            "Shape \"sphere\" \"float radius\" 0.4\nAttributeEnd\n";
    text += "AreaLightSource \"diffuse\" \"rgb L\" [8 8 8]\n";
    return text + quad(p(-0.4, 1.98, -0.4) + p(0.4, 1.98, -0.4) + p(0.4, 1.98, 0.4) + p(-0.4, 1.98, 0.4));
}

}  // namespace

TEST_CASE("The unit of length does not affect the image", "[law6]") {
    const Estimate expected = estimate(render_of(scene_of(room_at(1, 0))));
    for (const double s : {1e-8, 1e-6, 1e-3, 1e3, 1e6, 1e8}) {
        const Estimate scaled = estimate(render_of(scene_of(room_at(s, 0))));  // counts no invalid sample
        INFO("scale " << s << ": " << scaled.mean << " +- " << scaled.error << ", expected " << expected.mean);
        CHECK(deviation(scaled, expected) < 4.5);
    }
}

TEST_CASE("Triangles of 1e-10 have a normal", "[law6]") {
    // The squared length of their edges' cross product is below the smallest float. One bounce off a wall that fills
    // the view, under a sky of radiance 1: exactly the albedo, except for single roundings.
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

TEST_CASE("A room far from the origin has the same light", "[law6]") {
    // At 1e5 the spacing of floats is 2^-7, so a room of size 200 has coordinates exact to 4e-5 of it. The image's mean
    // changes by less than its standard error of half a percent.
    const Estimate expected = estimate(render_of(scene_of(room_at(100, 0)))),
                   far = estimate(render_of(scene_of(room_at(100, 1e5))));
    INFO(far.mean << " +- " << far.error << ", expected " << expected.mean << " +- " << expected.error);
    CHECK(deviation(far, expected) < 4.5);
}

TEST_CASE("The weights of bidirectional strategies do not depend on the unit of length", "[bdpt][mis]") {
    // Every kind of light has units of its own: emission is per area across the beam for a light at infinity, per
    // steradian for one without extent, and per both for an area light. A weight that confuses them is right in at most
    // one unit of length.
    const auto image = [](int exponent, const std::string& channel) {
        const double unit = std::ldexp(1, exponent);
        const auto point = [&](double x, double y, double z) {
            return number(unit * x) + number(unit * y) + number(unit * z);
        };
        const std::string intensity = number(3 * unit * unit), scale = number(unit);
        transport::RenderSettings settings;
        settings.samples.per_pixel = 16;
        transport::SceneEntity bdpt;
        bdpt.type = "bdpt";
        settings.paths.integrator = bdpt;
        settings.paths.max_depth = 3;
        settings.channels.beauty = false;
        settings.channels.list = {lpe_channel("c", channel)};
        settings.channels.list[0].statistics = false;
        const std::string text = film + "LookAt " + point(0, 1, 4) + point(0, 0.5, 0) + R"( 0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [0.3 0.3 0.3]
LightSource "distant" "rgb L" [1 1 1] "point3 from" [1 2 1] "point3 to" [0 0 0]
LightSource "point" "rgb I" [)" + intensity +
                                 intensity + intensity + R"(] "point3 from" [)" + point(-1, 2, 1) + R"(]
Scale )" + scale + scale + scale +
                                 R"(
Material "diffuse" "rgb reflectance" [0.7 0.7 0.7]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 3 3 0 3 3 0 -3 -3 0 -3]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 -1.5 3 0 -1.5 3 3 -1.5 -3 3 -1.5]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [3 3 3]
  Translate 1 1 0
  Shape "sphere" "float radius" 0.3
AttributeEnd
)";
        return render_of(scene_of(text), settings).frame_buffer.resolve(0);
    };
    for (const char* channel : {"s0t3;C.L", "s1t2;C.L", "s2t1;C.L", "s0t4;C..L", "s1t3;C..L", "s2t2;C..L", "s3t1;C..L",
                                "s3t2;C...L", "s4t1;C...L"}) {
        const std::vector<double> expected = image(0, channel);
        double largest = 0;
        for (const double value : expected) largest = std::max(largest, value);
        CHECK(largest > 0);
        for (const int exponent : {-8, 8}) {
            CAPTURE(channel, exponent);
            const std::vector<double> found = image(exponent, channel);
            double worst = 0;
            for (std::size_t i = 0; i < found.size(); ++i) worst = std::max(worst, std::abs(found[i] - expected[i]));
            INFO(worst << " of " << largest);
            CHECK(worst == 0);
        }
    }
}
