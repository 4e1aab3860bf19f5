#include "precision/measure.h"

#include <cstdio>
#include <cstdlib>
#include <string>

#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/render.h"

namespace raylex::test {
namespace {

std::vector<double> image_of(const std::string& text) {
    const auto scene = transport::import_pbrt_text(text, "precision.pbrt");
    transport::RenderSettings settings;
    settings.machine.threads = 2;
    const auto output = scene ? transport::render(*scene, settings) : scene.error();
    if (!output) {
        std::fprintf(stderr, "%s\n", output.error().to_string().c_str());
        std::abort();
    }
    return output->frame_buffer.resolve(output->beauty);
}

/// Within a sphere a light sample brings the same from everywhere, so that no estimate has any noise; seen through so
/// small an angle, next to nothing is left to light that the camera is found by.
std::string furnace(const std::string& integrator, double albedo, int pixels, int samples) {
    const std::string rho = std::to_string(albedo), size = std::to_string(pixels);
    return R"(
Film "rgb" "integer xresolution" )" +
           size + R"( "integer yresolution" )" + size + R"(
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "sobol" "integer pixelsamples" )" +
           std::to_string(samples) + "\nIntegrator " + integrator + R"(
LookAt 0 0 0  0 0 -1  0 1 0
Camera "perspective" "float fov" 0.1
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [)" +
           rho + " " + rho + " " + rho + R"(]
ReverseOrientation
Shape "sphere" "float radius" 2
)";
}

std::string room(const std::string& integrator) {
    return R"(
Film "rgb" "integer xresolution" 32 "integer yresolution" 32
PixelFilter "gaussian"
Sampler "sobol" "integer pixelsamples" 64
Integrator )" +
           integrator + R"(
LookAt 0 1 3.5  0 0.9 0  0 1 0
Camera "perspective" "float fov" 45
WorldBegin
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [0.1 0.2 0.3] "rgb sigma_s" [0.5 0.4 0.3] "float g" 0.3
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [10 9 8]
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.4 1.9 -0.4 0.4 1.9 -0.4 0.4 1.9 0.4 -0.4 1.9 0.4]
AttributeEnd
Material "diffuse" "rgb reflectance" [0.7 0.7 0.7]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 1 1 0 1 1 0 -1 -1 0 -1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 2 -1 1 2 -1 1 2 1 -1 2 1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 -1 1 0 -1 1 2 -1 -1 2 -1]
Material "diffuse" "rgb reflectance" [0.6 0.1 0.1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 1 -1 0 -1 -1 2 -1 -1 2 1]
Material "conductor" "float roughness" 0.3
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [1 0 -1 1 0 1 1 2 1 1 2 -1]
AttributeBegin
  Translate -0.4 0.4 0.1
  Material "dielectric"
  Shape "sphere" "float radius" 0.35
AttributeEnd
AttributeBegin
  Translate 0.45 0.35 0.3
  MediumInterface "fog" ""
  Material "interface"
  Shape "sphere" "float radius" 0.3
AttributeEnd
)";
}

}  // namespace

Measurements measure() {
    const std::string shortest = "\"integer maxdepth\" " + std::to_string(short_depth) + " \"bool roulette\" false";
    Measurements m;
    m.long_furnace =
        image_of(furnace("\"path\" \"string strategy\" \"scattering\" \"bool roulette\" false "
                         "\"integer maxdepth\" " +
                             std::to_string(long_depth),
                         long_albedo, 2, 4));
    m.path_furnace = image_of(furnace("\"path\" " + shortest, short_albedo, 4, 16));
    m.bdpt_furnace = image_of(furnace("\"bdpt\" " + shortest, short_albedo, 4, 16));
    m.path_room = image_of(room("\"path\" \"integer maxdepth\" 6"));
    m.bdpt_room = image_of(room("\"bdpt\" \"integer maxdepth\" 6"));
    return m;
}

}  // namespace raylex::test
