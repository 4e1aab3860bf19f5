// A shape: a regular polygon around the origin, across z, as triangles around its centre.
#include <cmath>
#include <numbers>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;

Result<std::vector<SceneShape>> make_polygon(const ParameterSet& parameters, const ShapeContext& context,
                                             std::vector<Error>& warnings) {
    const Result<std::int64_t> sides = parameters.integer_or("sides", 6);
    if (!sides) return sides.error();
    const Result<double> radius = parameters.real_or("radius", 1);
    if (!radius) return radius.error();
    if (*sides < 3 || *sides > 10000)
        return error_at(parameters.location, "'sides' is " + std::to_string(*sides) + "; expected 3 to 10000");
    SceneShape mesh;
    mesh.kind = ShapeKind::triangle_mesh;
    mesh.location = parameters.location;
    mesh.positions.push_back({0, 0, 0});
    const auto count = static_cast<std::uint32_t>(*sides);
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count;
        mesh.positions.push_back(
            {static_cast<float>(*radius * std::cos(angle)), static_cast<float>(*radius * std::sin(angle)), 0});
        mesh.indices.insert(mesh.indices.end(), {0, 1 + i, 1 + (i + 1) % count});
    }
    return finish_mesh(std::move(mesh), "the polygon", context, warnings);
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_shape({"polygon",
                    "a regular polygon across z",
                    {{"sides", ParameterType::integer, "6", "3 to 10000"},
                     {"radius", ParameterType::real, "1", "of the circle around it"}},
                    make_polygon});
}
