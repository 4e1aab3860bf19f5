// The module raylex._raylex. The package raylex around it is written in Python (experiments/python/raylex).
#include "experiments/job/rendering/provenance.h"
#include "experiments/python/bindings/bindings.h"

PYBIND11_MODULE(_raylex, module) {
    module.doc() = "The C++ part of `import raylex`.";
    module.attr("version") = raylex::experiments::raylex_version();
    module.attr("revision") = raylex::experiments::raylex_revision();
    module.attr("build") = raylex::experiments::build_description();
    pybind11::module_::import("atexit").attr("register")(pybind11::cpp_function(&raylex::python::Call::end_all));
    raylex::python::add_errors(module);
    raylex::python::add_lpe(module);
    raylex::python::add_lpe_relations(module);
    raylex::python::add_scene(module);
    raylex::python::add_scene_builder(module);
    raylex::python::add_image(module);
    raylex::python::add_checks(module);
    raylex::python::add_atlas(module);
    raylex::python::add_render(module);
    raylex::python::add_study(module);
    raylex::python::add_plugins(module);
    raylex::python::add_integrators(module);
    raylex::python::add_points(module);
}
