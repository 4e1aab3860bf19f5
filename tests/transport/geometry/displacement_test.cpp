// Displaced meshes against closed forms.
#include <catch2/catch.hpp>

#include <cmath>
#include <set>

#include "tests/support/budget_guard.h"
#include "transport/embree/displacement.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/import_support.h"
#include "transport/math/matrix34.h"
#include "transport/scene/scene_hash.h"

using namespace raylex;
using namespace raylex::transport;
using import_test::contains;
using import_test::error_of;

namespace {

const std::string displaced_square =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n";

SceneDescription displaced_scene(const import_test::Folder& folder, const std::string& text,
                                 const std::string& ply = displaced_square) {
    folder.write("a.ply", ply);
    auto scene = import_pbrt(folder.write("s.pbrt", "WorldBegin\n" + text));
    if (!scene) FAIL(scene.error().to_string());
    return *std::move(scene);
}

Result<SceneShape> displaced_of(const SceneDescription& scene) {
    auto textures = TextureTable::build(scene);
    if (!textures) FAIL(textures.error().to_string());
    return displaced_mesh(scene.shapes.at(0), scene.shapes.at(0).object_to_world, *textures);
}

double area_of(const SceneShape& mesh) {
    double area = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const DVec3 a(mesh.positions[mesh.indices[i]]);
        area += 0.5 * length(cross(DVec3(mesh.positions[mesh.indices[i + 1]]) - a,
                                   DVec3(mesh.positions[mesh.indices[i + 2]]) - a));
    }
    return area;
}

double longest_edge(const SceneShape& mesh) {
    double longest = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
        const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
        longest = std::max(longest,
                           length(DVec3(mesh.positions[mesh.indices[i]]) - DVec3(mesh.positions[mesh.indices[next]])));
    }
    return longest;
}

}  // namespace

TEST_CASE("displacement by a constant is an offset, with short edges and without holes", "[displacement]") {
    const import_test::Folder folder;
    const SceneDescription scene =
        displaced_scene(folder,
                        "Texture \"up\" \"float\" \"constant\" \"float value\" 0.25\n"
                        "Shape \"plymesh\" \"string filename\" \"a.ply\" \"texture displacement\" \"up\" "
                        "\"float edgelength\" 0.1");
    REQUIRE(scene.shapes.size() == 1);
    CHECK(scene.shapes[0].kind == ShapeKind::triangle_mesh);
    const auto mesh = displaced_of(scene);
    REQUIRE(mesh);
    CHECK(longest_edge(*mesh) <= 0.1);
    CHECK(area_of(*mesh) == Approx(1).epsilon(1e-6));  // some thousand roundings of 6e-8, up and down
    for (std::size_t i = 0; i < mesh->positions.size(); ++i) {
        CHECK(mesh->positions[i].z == 0.25f);
        CHECK(mesh->normals[i] == StoredVec3{0, 0, 1});
        CHECK(mesh->uvs[i] == StoredVec2{mesh->positions[i].x, mesh->positions[i].y});  // halves are exact
    }
    // No holes: an inner edge has two faces with opposite directions; other edges lie on the square's boundary.
    std::multiset<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::size_t i = 0; i < mesh->indices.size(); ++i)
        edges.insert({mesh->indices[i], mesh->indices[i % 3 == 2 ? i - 2 : i + 1]});
    std::size_t alone = 0;
    for (const auto& [a, b] : edges) {
        REQUIRE(edges.count({a, b}) == 1);
        if (edges.count({b, a}) == 1) continue;
        ++alone;
        const StoredVec3 &p = mesh->positions[a], &q = mesh->positions[b];
        CHECK(((p.x == q.x && (p.x == 0 || p.x == 1)) || (p.y == q.y && (p.y == 0 || p.y == 1))));
    }
    CHECK(alone == 4 * 16);  // sides of 1, halved to at most 0.1
}

TEST_CASE("displacement follows the file's normals, in object units; edges are measured in the world",
          "[displacement]") {
    const import_test::Folder folder;
    for (const bool reverse : {false, true}) {
        const SceneDescription scene = displaced_scene(
            folder, std::string("Texture \"up\" \"float\" \"constant\" \"float value\" 0.25\nScale 4 4 4\n") +
                        (reverse ? "ReverseOrientation\n" : "") +
                        "Shape \"plymesh\" \"string filename\" \"a.ply\" \"texture displacement\" \"up\"");
        const auto mesh = displaced_of(scene);
        REQUIRE(mesh);
        CHECK(longest_edge(*mesh) == Approx(0.25).epsilon(0.42));  // 4 sqrt 2 halved repeatedly: at most 1 in the world
        CHECK(longest_edge(*mesh) <= 0.25);
        for (std::size_t i = 0; i < mesh->positions.size(); ++i) {
            CHECK(mesh->positions[i].z == 0.25f);
            CHECK(mesh->normals[i].z == (reverse ? -1.0f : 1.0f));
        }
    }
}

TEST_CASE("normals of a displaced mesh are those of the displaced surface", "[displacement]") {
    const import_test::Folder folder;
    const SceneDescription scene = displaced_scene(
        folder,
        "Texture \"high\" \"float\" \"checkerboard\" \"float tex1\" 0.125 \"float tex2\" 0 \"float uscale\" 1 \"float "
        "vscale\" 1\n"
        "Shape \"plymesh\" \"string filename\" \"a.ply\" \"texture displacement\" \"high\" \"float edgelength\" 0.05");
    const auto mesh = displaced_of(scene);
    REQUIRE(mesh);
    // Inside the unit square the checkerboard is one tile, and its edges at 1 belong to others: a table with two
    // slopes.
    std::size_t table = 0, slope = 0;
    for (std::size_t i = 0; i < mesh->positions.size(); ++i) {
        const StoredVec2 uv = mesh->uvs[i];
        const bool other = (uv.x == 1) != (uv.y == 1);
        CHECK(mesh->positions[i].z == (other ? 0.0f : 0.125f));
        if (uv.x < 0.9f && uv.y < 0.9f) {
            ++table;
            CHECK(mesh->normals[i] == StoredVec3{0, 0, 1});
        } else if (mesh->normals[i].z < 0.9f) {
            ++slope;
        }
    }
    CHECK(table > 100);
    CHECK(slope > 20);
}

TEST_CASE("displacement: mistakes are errors at their line, and too many triangles exceed a budget",
          "[displacement][law7]") {
    const import_test::Folder folder;
    folder.write("a.ply", displaced_square);
    std::string bare = displaced_square;
    for (const char* name : {"property float u\n", "property float v\n"}) {
        const std::size_t at = bare.find(name);
        bare.erase(at, std::string(name).size());
    }
    bare = bare.substr(0, bare.find("0 0 0 0 0")) + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    folder.write("bare.ply", bare);
    const std::string up = "WorldBegin Texture \"up\" \"float\" \"constant\" \"float value\" 0.25\n";
    const auto error = [&](const std::string& file, const std::string& text) {
        const auto scene =
            import_pbrt(folder.write("s.pbrt", up + "Shape \"plymesh\" \"string filename\" \"" + file + "\" " + text));
        REQUIRE_FALSE(scene);
        CHECK(scene.error().line == 2);
        return scene.error().message;
    };
    CHECK(contains(error("a.ply", "\"float displacement\" 1"), "expected one \"texture displacement\""));
    CHECK(contains(error("a.ply", "\"texture displacement\" \"down\""), "no float texture is called 'down'"));
    CHECK(contains(error("a.ply", "\"texture displacement\" \"up\" \"float edgelength\" 0"), "expected a length"));
    CHECK(contains(error("bare.ply", "\"texture displacement\" \"up\""), "has no texture coordinates"));
    const SceneDescription scene =
        displaced_scene(folder, up.substr(11) +
                                    "Shape \"plymesh\" \"string filename\" \"a.ply\" \"texture displacement\" \"up\" "
                                    "\"float edgelength\" 0.001");
    const test::BudgetGuard guard("tessellated_triangles=1000");
    const auto mesh = displaced_of(scene);
    REQUIRE_FALSE(mesh);
    CHECK(contains(mesh.error().message, "the budget tessellated_triangles is 1000"));
    CHECK(mesh.error().line == 3);
    // Refused by the area of its triangles: halving until there are too many takes a second.
    const SceneDescription absurd =
        displaced_scene(folder, up.substr(11) +
                                    "Shape \"plymesh\" \"string filename\" \"a.ply\" \"texture displacement\" \"up\" "
                                    "\"float edgelength\" 1e-9");
    const auto refused = displaced_of(absurd);
    REQUIRE_FALSE(refused);
    CHECK(contains(refused.error().message, "edges of at most 1e-09 ('edgelength')"));
}

TEST_CASE("a displaced mesh that is written is read as the same mesh", "[displacement][pbrt-writer]") {
    const import_test::Folder folder;
    const SceneDescription scene =
        displaced_scene(folder,
                        "Texture \"up\" \"float\" \"constant\" \"float value\" 0.25\n"
                        "Shape \"plymesh\" \"string filename\" \"a.ply\" \"texture displacement\" \"up\" "
                        "\"float edgelength\" 0.1");
    const auto written = write_pbrt(scene, folder.path("again.pbrt"));
    REQUIRE(written);
    CHECK(written->empty());
    const auto again = import_pbrt(folder.path("again.pbrt"));
    REQUIRE(again);
    CHECK(scene_hash(*again) == scene_hash(scene));
}
