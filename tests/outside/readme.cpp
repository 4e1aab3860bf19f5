// The C++ of README.md, as it stands there, built against an installed raylex: renders, and its file has that layer.
#include <cstdio>
#include <string>

#include "display/output/reader/exr_reader.h"
#include "display/output/writer/exr_writer.h"
#include "transport/import/builder/scene_builder.h"
#include "transport/render/render.h"

#include "readme_code.h"

int main() {
    const std::string file = "glass.exr";
    if (const raylex::Status done = glass_over_floor(file); !done)
        return std::fprintf(stderr, "%s\n", done.error().to_string().c_str()), 1;
    const auto image = raylex::display::read_exr(file);
    if (!image) return std::fprintf(stderr, "%s\n", image.error().to_string().c_str()), 1;
    double light = 0;
    for (const auto& layer : image->layers)
        if (layer.name == "floor")
            for (const auto& plane : layer.planes)
                for (const float value : plane.values) light += static_cast<double>(value);
    std::printf("README's glass ball: the floor's layer sums to %g, expected more than 0\n", light);
    return light > 0 ? 0 : 1;
}
