// Integrators in Python: transport/integrators/integrator.h with batches as arrays.
#include <pybind11/stl.h>

#include <utility>

#include "experiments/python/bindings/plugins/batch.h"
#include "experiments/python/bindings/plugins/python_object.h"
#include "experiments/python/bindings/plugins/services.h"

namespace raylex::python {

using namespace pybind11::literals;

namespace {

class PythonIntegrator final : public transport::Integrator {
  public:
    PythonIntegrator(py::object object, std::optional<std::int64_t> max_depth)
        : object_(std::move(object)), max_depth_(max_depth), control_(RunControl::current()) {}

    [[nodiscard]] transport::IntegratorTraits traits() const override {
        transport::IntegratorTraits traits;
        traits.max_depth = max_depth_;
        traits.saved_state = transport::SavedState::none;  // a sample depends only on its number
        return traits;
    }
    Status prepare(const transport::IntegratorContext& context) override {
        context_ = context;
        return success();
    }
    [[nodiscard]] std::vector<transport::Omission> omissions() const override {
        std::vector<transport::Omission> all;
        if (context_.scene.asks_for_media()) all.push_back({"media: rays of Python integrators ignore them"});
        return all;
    }
    void integrate(const transport::CameraBatch& camera, transport::IntegratorThread& thread,
                   transport::ThreadServices& services) const override {
        guarded_call(control_, [&] {
            const auto batch = std::make_shared<Batch>(camera, context_, thread, services);
            const std::unique_ptr<Batch, void (*)(Batch*)> ends(batch.get(), [](Batch* b) { b->end(); });
            (*object_).attr("integrate")(batch);
        });
    }

  private:
    Held object_;
    std::optional<std::int64_t> max_depth_;
    std::shared_ptr<RunControl> control_;
    transport::IntegratorContext context_;
};

Result<std::unique_ptr<transport::Integrator>> make_integrator(const PythonClass& python,
                                                               const transport::SceneEntity& entity,
                                                               std::optional<std::int64_t> max_depth) {
    const Callback locked;
    transport::ParameterReader reader(entity.parameters);
    std::vector<std::pair<std::string, std::int64_t>> more;
    if (max_depth) more.emplace_back("maxdepth", *max_depth);
    auto object = make_instance(python, reader, more);
    if (!object) return object.error();
    std::optional<std::int64_t> depth;
    if (python.defaults.contains("maxdepth")) {
        auto written = entity.parameters.integer_or("maxdepth", python.defaults["maxdepth"].cast<std::int64_t>());
        if (!written) return written.error();
        depth = max_depth.value_or(*written);
    }
    return std::unique_ptr<transport::Integrator>(std::make_unique<PythonIntegrator>(*std::move(object), depth));
}

void register_integrator(const std::string& name, const py::object& type, const std::string& help,
                         const py::dict& defaults) {
    auto& registry = transport::integrator_registry();
    const auto python = describe_class("integrator", name, help, type, defaults);
    claim_name("integrator", name, registry.find(name) != nullptr);
    registry.add({name, help, python->parameters,
                  [python](const transport::SceneEntity& entity, std::optional<std::int64_t> max_depth) {
                      return make_integrator(*python, entity, max_depth);
                  }});
}

/// Adds light that no point emits: environments in the directions that hit nothing. `throughput` has shape (rows,).
void add_background(Batch& batch, const Points& points, const py::object& throughput) {
    const Triples factor(throughput, points.missed.size(), "throughput");
    batch.check_own(points);
    const transport::LightTable& lights = *batch.scene().lights;
    for (const std::uint32_t light : lights.environments())
        for (std::size_t i = 0; i < points.missed.size(); ++i) {
            const transport::Ray& ray = points.missed_rays[i];
            const transport::Rgb value = factor[i] * lights.environment_radiance(light, ray.origin, ray.direction);
            if (!value.is_black()) batch.contribute(points.missed[i], nullptr, i, nullptr, light, value);
        }
}

void add_emission(Batch& batch, const Points& points, const py::object& throughput) {
    const Triples factor(throughput, points.count(), "throughput");
    batch.check_own(points);
    const transport::LightTable& lights = *batch.scene().lights;
    for (std::size_t i = 0; i < points.count(); ++i) {
        const std::uint32_t light = points.light(i);
        if (light == transport::Hit::none) continue;
        const transport::Rgb value = factor[i] * lights.emitted(light, points.points[i], points.points[i].wo);
        if (!value.is_black()) batch.contribute(points.rows[i], nullptr, i, nullptr, light, value);
    }
}

void add_light(Batch& batch, const Points& points, const Evaluation& f, const LightSamples& lights,
               const py::object& value) {
    if (f.values.size() != points.count() || lights.samples.size() != points.count())
        fail("evaluation and light samples have " + std::to_string(f.values.size()) + " and " +
             std::to_string(lights.samples.size()) + " points; expected " + std::to_string(points.count()));
    const Triples values(value, points.count(), "value");
    batch.check_own(points);
    batch.check_own(*lights.from);  // light indices belong to this scene
    for (std::size_t i = 0; i < points.count(); ++i) {
        const transport::Rgb light = values[i];
        if (!(lights.samples[i].pdf > 0) || light.is_black()) continue;
        batch.contribute(points.rows[i], &points, i, &f.values[i].lobes, lights.samples[i].light, light);
    }
}

void add_batch(py::module_& module) {
    py::class_<Batch, std::shared_ptr<Batch>>(
        module, "Batch",
        "Camera rays of one call of integrate(); row i is one sample of one pixel. It is invalid after the call.")
        .def("__len__", &Batch::count)
        .def_property_readonly(
            "origins",
            [](const Batch& b) {
                return triples_of(b.count(), [&](std::size_t i) { return b.camera().rays[i].origin; });
            },
            "float32 (rows, 3) in render space, which differs from world space in its origin")
        .def_property_readonly(
            "directions",
            [](const Batch& b) {
                return triples_of(b.count(), [&](std::size_t i) { return b.camera().rays[i].direction; });
            },
            "float32 (rows, 3)")
        .def_property_readonly(
            "pixels",
            [](const Batch& b) {
                std::vector<std::int32_t> xy;
                for (const display::CameraRow& row : b.camera().rows) xy.insert(xy.end(), {row.pixel_x, row.pixel_y});
                return owning_array(std::move(xy), {static_cast<py::ssize_t>(b.count()), 2});
            },
            "int32 (rows, 2): x, y")
        .def_property_readonly(
            "samples",
            [](const Batch& b) {
                return column_of<std::uint64_t>(b.count(), [&](std::size_t i) { return b.camera().rows[i].sample; });
            },
            "uint64 (rows,): index of the sample in its pixel")
        .def("numbers", &Batch::numbers, "dimension"_a, "rows"_a = py::none(),
             "float32 (rows,) in [0, 1): one random number per sample. Equal dimensions give equal numbers, so use "
             "each dimension once.")
        .def("numbers_2d", &Batch::numbers_2d, "dimension"_a, "rows"_a = py::none(), "float32 (rows, 2) in [0, 1)^2.")
        .def("trace", py::overload_cast<>(&Batch::trace), "Points hit by the camera's rays. Call it once.")
        .def("trace", &Batch::trace_rays, "origins"_a, "directions"_a, "rows"_a = py::none(),
             "Points hit by other rays: origins and unit directions (n, 3); rows (n,) are the rows of the batch that "
             "they belong to.")
        .def("live", &Batch::live, "bool (rows,): whether light that the path can still find matters.")
        .def(
            "scatter", [](Batch& b, const Points& p, const Sample& s) { b.scatter(p, s.lobes()); }, "points"_a,
            "sample"_a, "Adds to the words of the paths the scattering event of the sample at these points.")
        .def("add_emission", &add_emission, "points"_a, "throughput"_a,
             "Adds throughput (points, 3) times the light that the points' surfaces emit along their paths.")
        .def("add_background", &add_background, "points"_a, "throughput"_a,
             "Adds throughput (missed, 3) times the light of infinite lights along rays that hit nothing "
             "(points.missed).")
        .def("add_light", &add_light, "points"_a, "evaluation"_a, "lights"_a, "value"_a,
             "Adds value (points, 3): the light of these samples, scattered at the points as evaluated. Light path "
             "expressions receive it by its words.");
}

}  // namespace

void add_integrators(py::module_& module) {
    add_batch(module);
    add_services(module);
    module.def("_register_integrator", &register_integrator, "name"_a, "type"_a, "help"_a, "defaults"_a);
}

}  // namespace raylex::python
