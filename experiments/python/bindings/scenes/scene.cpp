// Scenes: loading, inspection, writing.
#include "experiments/python/bindings/scenes/scene.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>

#include "display/output/atomic_file.h"
#include "experiments/inspect/scene_facts.h"
#include "experiments/job/channels/scene_path_strings.h"
#include "experiments/job/job.h"
#include "experiments/job/text/json.h"
#include "experiments/python/bindings/bindings.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/plugins/plugin_loader.h"
#include "transport/render/built_scene.h"

namespace raylex::python {

using namespace pybind11::literals;

transport::SceneDescription labelled(const Scene& scene) {
    transport::SceneDescription description = *scene.description;
    take(transport::apply_label_rules(description, scene.label_rules));
    return description;
}

namespace {

Scene load(const std::filesystem::path& path) {
    return unlocked([&] {
        auto description = take(transport::import_pbrt(path.string()));
        return Scene{std::make_shared<const transport::SceneDescription>(std::move(description))};
    });
}

/// Returns the contents of `raylex scene info --json` as Python values.
py::object facts_of(const Scene& scene, bool build) {
    const std::string text = unlocked([&] {
        const transport::SceneDescription description = labelled(scene);
        experiments::SceneFacts facts = experiments::scene_facts(description);
        if (build) experiments::add_built_facts(*take(transport::BuiltScene::build(description)), facts);
        return experiments::json_text(experiments::json_of(facts));
    });
    return py::module_::import("json").attr("loads")(text);
}

lpe::PathStrings path_strings_of(const Scene& scene) {
    return unlocked([&] { return take(experiments::scene_path_strings(experiments::Job(), labelled(scene))).words; });
}

Scene with_rule(const Scene& scene, const std::string& selector, const std::string& pattern, const std::string& label) {
    using Selector = transport::LabelRule::Selector;
    constexpr std::array<std::pair<const char*, Selector>, 5> selectors{
        {{"material", Selector::material},
         {"mesh", Selector::mesh_file},
         {"instance", Selector::instance},
         {"light", Selector::light},
         {"area_light_material", Selector::area_light_material}}};
    for (const auto& [name, value] : selectors) {
        if (selector != name) continue;
        Scene changed = scene;
        transport::LabelRule rule;
        rule.selector = value;
        rule.pattern = pattern;
        rule.label = label;
        rule.location = {selector + "='" + pattern + "'", 0, 0};
        changed.label_rules.push_back(std::move(rule));
        labelled(changed);  // reports a rule that matches nothing now, not when it is rendered
        return changed;
    }
    fail("'" + selector + "' selects nothing; expected material, mesh, instance, light or area_light_material");
}

}  // namespace

void add_scene(py::module_& module) {
    py::class_<Scene>(module, "Scene",
                      "A scene, loaded or built. It is immutable; label() and group() return another one.")
        .def(py::init(&load), "path"_a, "Loads a pbrt-v4 scene file.")
        .def_property_readonly(
            "file", [](const Scene& scene) { return scene.description->file; }, "name of the scene in messages")
        .def("info", &facts_of, "build"_a = true,
             "The contents of the scene, as in `raylex scene info --json`: shapes, primitives, materials, lights, "
             "labels,\n"
             "light_groups, film (type, width and height in pixels), and with build=True bounds (world units), memory "
             "and\n"
             "times (seconds).")
        .def("words", &path_strings_of, "The light paths that the scene can produce: lpe.Words.")
        .def("label", &with_rule, "selector"_a, "pattern"_a, "label"_a,
             "Returns the scene with this LPE label on objects selected by 'material', 'mesh' or 'instance', or with "
             "this light group on\nlights selected by 'light' (\"area:0\", \"spot\") or 'area_light_material'; names "
             "may contain * and ?; the first matching rule applies.")
        .def(
            "write",
            [](const Scene& scene, const std::filesystem::path& path) {
                return unlocked([&] { return take(transport::write_pbrt(labelled(scene), path.string())); });
            },
            "path"_a,
            "Writes the scene as a pbrt-v4 file, which reads back as the same scene. Returns a list of the contents "
            "that such a file cannot "
            "say.")
        .def_property_readonly("warnings",
                               [](const Scene& scene) {
                                   std::vector<std::string> all;
                                   for (const Error& each : scene.description->warnings)
                                       all.push_back(each.to_string());
                                   return all;
                               })
        .def("__repr__", [](const Scene& scene) {
            return "Scene('" + scene.description->file + "': " + std::to_string(scene.description->shapes.size()) +
                   " shapes, " +
                   std::to_string(scene.description->lights.size() + scene.description->area_lights.size()) +
                   " lights)";
        });
}

}  // namespace raylex::python
