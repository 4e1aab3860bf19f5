// What camera and light subpaths must find alike, where it is easily not the same: lengths where bodies are not closed,
// media beyond all shapes, portals from behind, matrices with a last row, curves that face whoever looks.
#include <algorithm>

#include "tests/transport/image_file.h"
#include "transport/replicates.h"

using namespace render_test;

namespace {

transport::RenderSettings small(std::uint32_t depth, std::uint64_t samples) {
    transport::RenderSettings settings;
    settings.paths.max_depth = depth;
    settings.samples.per_pixel = samples;
    settings.film.resolution = {{12, 12}};
    return settings;
}

const std::string box_filter = "PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5\n";

using transport::Real;

/// Of all components of all pixels.
double sum_by(const std::string& integrator, const std::string& text, std::uint32_t depth) {
    transport::RenderSettings settings = small(depth, 16);
    settings.paths.integrator = integrator_named(integrator);
    const auto output = render_of(scene_of(text), settings);
    double sum = 0;
    for (const double value : output.frame_buffer.resolve(output.beauty)) sum += std::abs(value);
    return sum;
}

/// A grid around the camera that reaches beyond all shapes: a small ball, or none.
std::string open_grid(const std::string& world) {
    return plain_film + box_filter + R"(
        MakeNamedMedium "f" "string type" "uniformgrid" "integer nx" 2 "integer ny" 2 "integer nz" 2
            "float density" [0 1 2 .5 1 0 .3 3] "rgb sigma_a" [.3 .2 .1] "rgb sigma_s" [2 1.5 1] "float g" -.3
            "point3 p0" [-1.5 0 -1.5] "point3 p1" [1.5 2.5 1.5]
        MediumInterface "" "f"
        LookAt 0 1.5 5  0 0.8 0  0 1 0
        Camera "perspective" "float fov" 40
        WorldBegin
        LightSource "distant" "point3 from" [1 2 2] "rgb L" [1 1 1]
        LightSource "infinite" "rgb L" [.5 .5 .5]
        )" +
           world;
}

/// One strand of each kind across the view, lit from all sides.
std::string strands(const std::string& material) {
    std::string text =
        plain_film + box_filter +
        "LookAt 0 0 10  0 0 0  0 1 0 Camera \"orthographic\" \"float screenwindow\" [-1 1 -1 1]\nWorldBegin\n"
        "LightSource \"distant\" \"rgb L\" [2 2 2] \"point3 from\" [3 1 1]\n"
        "LightSource \"infinite\" \"rgb L\" [.6 .6 .6]\n"
        "Material \"diffuse\" Shape \"disk\" \"float radius\" 4 \"float height\" -2\n" +
        material;
    for (const char* type : {"flat", "cylinder", "ribbon"}) {
        text += std::string(" Translate 0 .4 0 Shape \"curve\" \"string type\" \"") + type +
                "\" \"point3 P\" [-1.5 -1 0  -.5 -.6 .3  .5 -1 -.3  1.5 -.8 0] \"float width\" 0.3";
        if (std::string(type) == "ribbon") text += " \"normal N\" [0 0 1  0 .6 .8]";
    }
    return text;
}

}  // namespace

TEST_CASE("bodies with holes, and the wrong way out, are as long to every method",
          "[bdpt][light-tracer][statistical][gate]") {
    const std::string shape =
        GENERATE("\"sphere\" \"float alpha\" .5", "\"sphere\" \"float zmin\" -.4 \"float zmax\" .3",
                 "\"disk\" \"float radius\" 1.5 \"float height\" .4");
    const std::string reverse = GENERATE("", "ReverseOrientation ");
    // Clear: where a body ends that has no inside is nobody's to say, and a medium there would differ.
    const std::string scene =
        plain_film + box_filter +
        "LookAt 0 2 4  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 35\nWorldBegin\n"
        "LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
        "LightSource \"distant\" \"rgb L\" [2 2 2] \"point3 from\" [1 2 1]\n"
        "Rotate -90 1 0 0 Material \"diffuse\" Shape \"disk\" \"float radius\" 3 \"float height\" -1.1\n"
        "Material \"subsurface\" \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [0 0 0] "
        "\"float roughness\" .4 " +
        reverse + "Shape " + shape;
    compare_with_path(scene, small(GENERATE(1, 2), 128), integrator_named("bdpt"), 12, 128, {"C<TD>.*[LB]", "C.*[LB]"});
}

TEST_CASE("light beyond all shapes reaches a medium there by every method",
          "[bdpt][light-tracer][media][statistical][gate]") {
    const std::string world = GENERATE("", "Translate 0 .3 0 Shape \"sphere\" \"float radius\" 0.2");
    const std::string integrator = GENERATE("bdpt", "lighttracer");
    compare_with_path(open_grid(world), small(3, 256), integrator_named(integrator), 12,
                      integrator == "bdpt" ? 128 : 1024, {"CVL", "CV+[LB]", "CV+B"});
}

TEST_CASE("what stands outside a portal has no light of it, by any method", "[bdpt][light-tracer][lights]") {
    // The portal looks away from the ball, the fog around it and the camera.
    const std::string outside = plain_film + box_filter + R"(
        LookAt 0 0 -5  0 0 0  0 1 0
        MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [.01 .01 .01] "rgb sigma_s" [.2 .2 .2]
        Camera "perspective" "float fov" 40
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1] "point3 portal" [-2 -1 2  2 -1 2  2 1 2  -2 1 2]
        Shape "sphere"
        MediumInterface "fog" "" Material "interface" Shape "sphere" "float radius" 1.9)";
    for (const char* integrator : {"path", "bdpt", "lighttracer"}) {
        CAPTURE(integrator);
        CHECK(sum_by(integrator, outside, 3) == 0);
    }
    // Turned around it shines on them.
    std::string inside = outside;
    inside.replace(inside.find("[-2 -1 2  2 -1 2  2 1 2  -2 1 2]"), 32, "[-2 1 2  2 1 2  2 -1 2  -2 -1 2]");
    CHECK(sum_by("lighttracer", inside, 3) > 0);
}

TEST_CASE("a sky under a matrix with a last row is one sky to every method",
          "[bdpt][light-tracer][lights][statistical][gate]") {
    std::vector<transport::Rgb> pixels;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            pixels.push_back({x > 3 ? Real(3) : Real(0.2), Real(0.5) + Real(y) / 5, y > 5 ? Real(4) : Real(0.1)});
    const ImageFile file(8, 8, pixels);
    const std::string scene =
        plain_film + box_filter +
        "LookAt 3.7 -3.5 3.3  3 -2.9 2.8  0 0 1 Camera \"perspective\" \"float fov\" 30\nWorldBegin\n"
        "AttributeBegin ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 8.87  0 0 0 1]\n"
        "LightSource \"infinite\"" +
        file.parameter() + "AttributeEnd Material \"diffuse\" Shape \"disk\" \"float radius\" 8\n";
    const std::string integrator = GENERATE("bdpt", "lighttracer");
    compare_with_path(scene, small(1, 64), integrator_named(integrator), 12, 256, {"C<RD>B"}, GENERATE(0, 2));
    const auto built = transport::BuiltScene::build(scene_of(scene));
    REQUIRE(built.ok());
    CHECK(std::any_of((*built)->warnings.begin(), (*built)->warnings.end(), [](const raylex::Error& warning) {
        return warning.to_string().find("is not 0 0 0 1") != std::string::npos;
    }));
}

TEST_CASE("bidirectional path tracing agrees on curves that face whoever looks", "[bdpt][curves][statistical][gate]") {
    const std::string material = GENERATE("Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]",
                                          "Material \"hair\" \"float eumelanin\" .5 \"float beta_n\" .4");
    compare_with_path(strands(material), small(3, 128), integrator_named("bdpt"), 12, 128,
                      {"C.[LB]", "C..[LB]", "C.*[LB]"});
}

TEST_CASE("light tracing says that such curves look otherwise, and nothing of ribbons", "[light-tracer][curves]") {
    transport::RenderSettings settings = small(1, 1);
    settings.paths.integrator = integrator_named("lighttracer");
    const auto warns = [&](const std::string& type) {
        const auto output =
            render_of(scene_of(plain_film +
                               "WorldBegin LightSource \"infinite\" Shape \"curve\" "
                               "\"point3 P\" [-1 0 5  -.5 0 5  .5 0 5  1 0 5] \"normal N\" [0 0 1 0 0 1] "
                               "\"string type\" \"" +
                               type + "\""),
                      settings);
        return std::any_of(output.warnings.begin(), output.warnings.end(), [](const raylex::Error& warning) {
            return warning.to_string().find("flat curves and tubes") != std::string::npos;
        });
    };
    CHECK(warns("flat"));
    CHECK(warns("cylinder"));
    CHECK_FALSE(warns("ribbon"));
}
