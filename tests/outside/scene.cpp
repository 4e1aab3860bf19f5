// Builds a scene in code through the installed transport component, renders it, writes it as a file and reads it back.
#include <cmath>
#include <cstdio>

#include "transport/import/builder/scene_builder.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/render/render.h"

using namespace raylex;
using namespace raylex::transport;
using namespace raylex::transport::typed;

namespace {

Result<SceneDescription> make_scene() {
    SceneBuilder scene("outside");
    if (Status s = scene.set_film("rgb", {integer("xresolution", 8), integer("yresolution", 8)}); !s) return s.error();
    const Transform view = Transform::look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
    if (Status s = scene.set_camera("perspective", {real("fov", 20)}, view); !s) return s.error();
    if (Status s = scene.add_light("infinite", {rgb("L", {1, 1, 1})}); !s) return s.error();
    const Result<MaterialHandle> grey = scene.add_material("diffuse", {rgb("reflectance", {0.5, 0.5, 0.5})});
    if (!grey) return grey.error();
    if (Status s = scene.add_shape("sphere", {real("radius", 1)}, {.material = *grey}); !s) return s.error();
    return scene.finish();
}

Result<double> centre_of(const SceneDescription& scene) {
    RenderSettings settings;
    settings.samples.per_pixel = 16;
    auto output = render(scene, settings);
    if (!output) return output.error();
    return output->frame_buffer.resolve(output->beauty)[(4 * 8 + 4) * 3];
}

int fail(const Error& error) {
    std::fprintf(stderr, "%s\n", error.to_string().c_str());
    return 1;
}

}  // namespace

int main() {
    const auto scene = make_scene();
    if (!scene) return fail(scene.error());
    const auto again = import_pbrt_text(pbrt_text(*scene).text, "outside.pbrt");
    if (!again) return fail(again.error());
    const auto centre = centre_of(*scene), twin = centre_of(*again);
    if (!centre) return fail(centre.error());
    if (!twin) return fail(twin.error());
    std::printf("centre pixel %g, expected 0.5; written and read again %g\n", *centre, *twin);
    // A convex Lambert object under a constant sky: every sample is 0.5 up to float rounding of cos / pdf.
    return std::abs(*centre - 0.5) < 1e-3 && *centre == *twin ? 0 : 1;
}
