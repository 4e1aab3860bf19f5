// Labels and light groups for scenes that do not define any.
#include <catch2/catch.hpp>

#include "tests/transport/import_support.h"

using namespace import_test;
using namespace raylex::transport;
using Selector = LabelRule::Selector;

namespace {

const std::string mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]\n";

SceneDescription labelled_scene() {
    SceneDescription scene = scene_of(R"(WorldBegin
        MakeNamedMaterial "wall" "string type" "diffuse"  MakeNamedMaterial "walnut" "string type" "diffuse"
        MakeNamedMaterial "lamp" "string type" "diffuse"
        LightSource "spot" LightSource "infinite" LightSource "spot"
        NamedMaterial "wall" )" + mesh +
                                      "NamedMaterial \"walnut\" " + mesh + R"( Material "diffuse" )" + mesh + R"(
        AttributeBegin NamedMaterial "lamp" AreaLightSource "diffuse" )" +
                                      mesh + R"( AttributeEnd
        AttributeBegin NamedMaterial "wall" AreaLightSource "diffuse" )" +
                                      mesh + R"( AttributeEnd
        ObjectBegin "tree" NamedMaterial "walnut" )" +
                                      mesh + R"( ObjectEnd
        ObjectInstance "tree" ObjectInstance "tree")");
    scene.shapes[2].source_file = "dragon.ply";
    return scene;
}

LabelRule rule(Selector selector, const std::string& pattern, const std::string& label) {
    return {selector, pattern, label, {"job.toml", 4, 2}};
}

void apply(SceneDescription& scene, const std::vector<LabelRule>& rules) {
    const auto status = apply_label_rules(scene, rules);
    if (!status) FAIL(status.error().to_string());
}

}  // namespace

TEST_CASE("without rules an object's label is its named material", "[labels]") {
    SceneDescription scene = labelled_scene();
    apply(scene, {});
    CHECK(scene.shapes[0].label == "wall");
    CHECK(scene.shapes[2].label.empty());
    CHECK(scene.objects[0].shapes[0].label == "walnut");
    CHECK(scene.lights[0].group.empty());
}

TEST_CASE("the first rule that matches wins, over materials and mesh files alike", "[labels]") {
    SceneDescription scene = labelled_scene();
    apply(scene, {rule(Selector::material, "wal?", "plaster"), rule(Selector::mesh_file, "*.ply", "beast"),
                  rule(Selector::material, "wal*", "rest")});
    CHECK(scene.shapes[0].label == "plaster");
    CHECK(scene.shapes[1].label == "rest");
    CHECK(scene.shapes[2].label == "beast");
    CHECK(scene.shapes[3].label == "lamp");
    CHECK(scene.objects[0].shapes[0].label == "rest");
}

TEST_CASE("instances are matched by their object's name and number", "[labels]") {
    SceneDescription scene = labelled_scene();
    apply(scene, {rule(Selector::instance, "tree:1", "second"), rule(Selector::instance, "tree", "all")});
    CHECK(scene.instances[0].label == "all");
    CHECK(scene.instances[1].label == "second");
}

TEST_CASE("lights are matched by kind and number in file order, area lights also by their shape's material",
          "[labels]") {
    SceneDescription scene = labelled_scene();
    apply(scene, {rule(Selector::light, "spot:1", "rim"), rule(Selector::light, "spot", "key"),
                  rule(Selector::area_light_material, "la*", "practical"), rule(Selector::light, "area*", "area"),
                  rule(Selector::light, "infinite", "sky")});
    CHECK(scene.lights[0].group == "key");
    CHECK(scene.lights[1].group == "sky");
    CHECK(scene.lights[2].group == "rim");
    CHECK(scene.area_lights[0].group == "practical");
    CHECK(scene.area_lights[1].group == "area");
    SceneDescription other = labelled_scene();
    apply(other, {rule(Selector::light, "area:0", "first")});
    CHECK(other.area_lights[0].group == "first");
    CHECK(other.area_lights[1].group.empty());
}

TEST_CASE("a rule that matches nothing is an error with close matches", "[labels][law7]") {
    struct Case {
        LabelRule rule;
        const char* hint;
    };
    for (const Case& c : {Case{rule(Selector::material, "wallnut", "x"), "'walnut'"},
                          Case{rule(Selector::light, "spot:2", "x"), "'spot:0'"},
                          Case{rule(Selector::mesh_file, "dargon.ply", "x"), "'dragon.ply'"},
                          Case{rule(Selector::instance, "trees", "x"), "'tree'"},
                          Case{rule(Selector::area_light_material, "lmap", "x"), "'lamp'"}}) {
        SceneDescription scene = labelled_scene();
        const auto status = apply_label_rules(scene, {c.rule});
        REQUIRE_FALSE(status);
        INFO(status.error().to_string());
        CHECK(status.error().file == "job.toml");
        CHECK(status.error().line == 4);
        CHECK(status.error().column == 2);
        CHECK(contains(status.error().hint, c.hint));
    }
}

TEST_CASE("a rule whose objects all have labels is a warning, not an error", "[labels]") {
    SceneDescription scene = labelled_scene();
    apply(scene, {rule(Selector::material, "*", "all"), rule(Selector::material, "wall", "late")});
    CHECK(scene.shapes[0].label == "all");
    REQUIRE(scene.warnings.size() == 1);
    CHECK(contains(scene.warnings[0].message, "'wall'"));
}
