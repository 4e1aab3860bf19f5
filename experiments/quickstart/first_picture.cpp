// The first picture of experiments/quickstart.sh, made by the renderer alone while the rest of raylex is built: renders
// a scene with ever more samples, each time into the same PNG file.   first_picture SCENE.pbrt OUT.png SAMPLES...
#include <cstdio>
#include <cstdlib>

#include "display/output/color/color_manager.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/render.h"

namespace {

raylex::Status refine(const char* file, const char* picture, int count, char** samples) {
    using namespace raylex;
    const auto scene = transport::import_pbrt(file);
    if (!scene) return scene.error();
    const auto color = display::ColorManager::open();
    if (!color) return color.error();
    for (int i = 0; i < count; ++i) {
        transport::RenderSettings settings;
        settings.samples.per_pixel = std::strtoull(samples[i], nullptr, 10);
        const auto output = transport::render(*scene, settings);
        if (!output) return output.error();
        const std::vector<double> pixels = output->image().resolve(output->beauty);
        const std::vector<float> rgb(pixels.begin(), pixels.end());
        const auto shown = color->to_display(rgb, {}, {}, {});
        if (!shown) return shown.error();
        if (Status s = display::write_png(picture, output->view.width, output->view.height, *shown); !s) return s;
        std::printf("%s: %s samples per pixel\n", picture, samples[i]);
        std::fflush(stdout);
    }
    return success();
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) return std::fputs("usage: first_picture SCENE.pbrt OUT.png SAMPLES...\n", stderr), 2;
    const raylex::Status done = refine(argv[1], argv[2], argc - 3, argv + 3);
    if (!done) std::fprintf(stderr, "first_picture: %s\n", done.error().to_string().c_str());
    return done ? 0 : 2;
}
