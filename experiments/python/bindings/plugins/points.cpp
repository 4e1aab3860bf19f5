// Points, sampled directions and light samples for integrators in Python.
#include "experiments/python/bindings/plugins/batch.h"

namespace raylex::python {

using namespace pybind11::literals;

namespace {

using transport::Rgb;

std::array<float, 3> numbers(const Rgb& rgb) {
    return {transport::to_float(rgb.r), transport::to_float(rgb.g), transport::to_float(rgb.b)};
}

/// Returns a property of points with three numbers each.
template <class Value>
auto triple(Value value) {
    return
        [value](const Points& p) { return triples_of(p.count(), [&](std::size_t i) { return value(p.points[i]); }); };
}

py::array_t<float> positions_2d(const Points& p) {
    std::vector<float> uv;
    for (const transport::SurfacePoint& each : p.points)
        uv.insert(uv.end(), {transport::to_float(each.u), transport::to_float(each.v)});
    return owning_array(std::move(uv), {static_cast<py::ssize_t>(p.count()), 2});
}

py::array_t<double> world_positions(const Points& p) {
    const auto& origin = p.batch->scene().geometry->space().origin;
    std::vector<double> xyz;
    for (const transport::SurfacePoint& each : p.points)
        xyz.insert(xyz.end(),
                   {static_cast<double>(each.position.x) + origin.x, static_cast<double>(each.position.y) + origin.y,
                    static_cast<double>(each.position.z) + origin.z});
    return owning_array(std::move(xyz), {static_cast<py::ssize_t>(p.count()), 3});
}

void add_point_properties(py::class_<Points, std::shared_ptr<Points>>& points) {
    using Point = transport::SurfacePoint;
    points
        .def_property_readonly(
            "rows",
            [](const Points& p) { return column_of<std::int64_t>(p.count(), [&](auto i) { return p.rows[i]; }); },
            "int64 (points,): the rows of the batch that they belong to")
        .def_property_readonly(
            "missed",
            [](const Points& p) {
                return column_of<std::int64_t>(p.missed.size(), [&](auto i) { return p.missed[i]; });
            },
            "int64 (missed,): the rows of the batch whose rays hit nothing")
        .def_property_readonly(
            "distance",
            [](const Points& p) { return column_of<float>(p.count(), [&](auto i) { return p.hits[i].t; }); },
            "float32 (points,): distance, in world units if directions have unit length")
        .def_property_readonly("position", triple([](const Point& p) { return p.position; }),
                               "float32 (points, 3) in render space, for trace()")
        .def_property_readonly("world_position", &world_positions, "float64 (points, 3), world space")
        .def_property_readonly("normal", triple([](const Point& p) { return p.geometric_normal; }),
                               "float32 (points, 3), unit vectors on the shape's outside")
        .def_property_readonly("shading_normal", triple([](const Point& p) { return p.shading_normal; }),
                               "float32 (points, 3), unit")
        .def_property_readonly("wo", triple([](const Point& p) { return p.wo; }),
                               "float32 (points, 3), unit vectors towards the origin of the ray")
        .def_property_readonly("uv", &positions_2d, "float32 (points, 2): texture coordinates")
        .def_property_readonly("emitted", &Points::emitted, "float32 (points, 3): radiance emitted along wo")
        .def_property_readonly(
            "albedo",
            [](const Points& p) {
                p.batch->check();  // closures may refer to tables of the scene
                return triples_of(p.count(), [&](auto i) {
                    const Rgb albedo = p.bsdfs[i].albedo(p.points[i].wo);
                    return numbers(albedo);
                });
            },
            "float32 (points, 3): rough estimate of the albedo");
}

void add_samples(py::module_& module) {
    py::class_<Evaluation, std::shared_ptr<Evaluation>>(module, "Evaluation", "Scattering towards given directions.")
        .def_property_readonly(
            "value",
            [](const Evaluation& e) {
                return triples_of(e.values.size(), [&](auto i) { return numbers(e.values[i].value); });
            },
            "float32 (points, 3): f |cos|, 1 / sr; 0 for mirrors")
        .def_property_readonly(
            "pdf",
            [](const Evaluation& e) {
                return column_of<float>(e.values.size(), [&](auto i) { return e.values[i].pdf; });
            },
            "float32 (points,): density of sample() for the direction, 1 / sr");
    py::class_<Sample, std::shared_ptr<Sample>>(module, "Sample", "A sampled direction at each point.")
        .def_property_readonly(
            "wi", [](const Sample& s) { return triples_of(s.samples.size(), [&](auto i) { return s.samples[i].wi; }); },
            "float32 (points, 3), unit")
        .def_property_readonly(
            "weight",
            [](const Sample& s) {
                return triples_of(s.samples.size(), [&](auto i) { return numbers(s.samples[i].weight); });
            },
            "float32 (points, 3): f |cos| / pdf")
        .def_property_readonly(
            "pdf",
            [](const Sample& s) {
                return column_of<float>(s.samples.size(), [&](auto i) { return s.samples[i].pdf; });
            },
            "float32 (points,): density in 1 / sr, for mirrors a probability; 0 without a direction")
        .def_property_readonly(
            "delta",
            [](const Sample& s) { return truths_of(s.samples.size(), [&](auto i) { return s.samples[i].delta; }); },
            "bool (points,): mirror or smooth glass, whose light no light sample can find");
    py::class_<LightSamples, std::shared_ptr<LightSamples>>(module, "LightSamples",
                                                            "A direction towards a light at each point.")
        .def_property_readonly(
            "wi",
            [](const LightSamples& l) { return triples_of(l.samples.size(), [&](auto i) { return l.samples[i].wi; }); },
            "float32 (points, 3), unit")
        .def_property_readonly(
            "radiance",
            [](const LightSamples& l) {
                return triples_of(l.samples.size(), [&](auto i) { return numbers(l.samples[i].radiance); });
            },
            "float32 (points, 3): unoccluded radiance, to be divided by pdf")
        .def_property_readonly(
            "pdf",
            [](const LightSamples& l) {
                return column_of<float>(l.samples.size(), [&](auto i) { return l.samples[i].pdf; });
            },
            "float32 (points,): density in 1 / sr, including the probability of the light; 0 without a light")
        .def("visible", &visible, "bool (points,): whether the light is unoccluded. Traces one shadow ray per point.");
}

}  // namespace

void add_points(py::module_& module) {
    add_samples(module);
    py::class_<Points, std::shared_ptr<Points>> points(module, "Points", "Surface points hit by rays of a batch.");
    points.def("__len__", &Points::count);
    add_point_properties(points);
    points
        .def("evaluate", &Points::evaluate, "wi"_a, "Evaluation of scattering towards the unit vectors wi (points, 3).")
        .def("sample", &Points::sample, "choice"_a, "numbers"_a,
             "Sample: directions sampled from the materials, by random numbers (points,) and (points, 2) in [0, 1).")
        .def("sample_light", &Points::sample_light, "choice"_a, "numbers"_a,
             "LightSamples: a light for each point, by random numbers (points,) and (points, 2) in [0, 1).")
        .def("occluded", &Points::occluded, "directions"_a, "distance"_a = std::numeric_limits<double>::infinity(),
             "bool (points,): whether there is a surface within `distance` (world units) along the unit directions "
             "(points, "
             "3).")
        .def("go_on", &Points::go_on, "sample"_a, "keep"_a = py::none(),
             "Points hit along the sampled directions; keep: bool (points,), which directions to follow.");
}

}  // namespace raylex::python
