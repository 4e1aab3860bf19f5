// Renders a pbrt scene held in memory through the installed transport component.
#include <cmath>
#include <cstdio>

#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/render.h"

int main() {
    using namespace raylex;
    const char* text = R"(
        LookAt 0 0 4  0 0 0  0 1 0
        Camera "perspective" "float fov" 20
        Film "rgb" "integer xresolution" 8 "integer yresolution" 8
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1]
        Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
        Shape "sphere" "float radius" 1
    )";
    auto scene = transport::import_pbrt_text(text, "outside.pbrt");
    if (!scene) return std::fprintf(stderr, "%s\n", scene.error().to_string().c_str()), 1;
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    auto output = transport::render(*scene, settings);
    if (!output) return std::fprintf(stderr, "%s\n", output.error().to_string().c_str()), 1;
    const double centre = output->frame_buffer.resolve(output->beauty)[(4 * 8 + 4) * 3];
    std::printf("centre pixel %g, expected 0.5\n", centre);
    // A convex Lambert object under a constant sky: every sample is 0.5 up to float rounding of cos / pdf.
    return std::abs(centre - 0.5) < 1e-3 ? 0 : 1;
}
