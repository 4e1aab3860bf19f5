// Loop's subdivision against known properties of its limit.
#include <catch2/catch.hpp>

#include <chrono>
#include <cmath>
#include <numbers>
#include <set>

#include "transport/import/shapes/loop_subdivision.h"
#include "transport/import_support.h"
#include "transport/math/matrix34.h"

using namespace raylex;
using namespace raylex::transport;
using import_test::contains;
using import_test::error_of;
using import_test::scene_of;

namespace {

SubdividedMesh subdivided(const std::vector<StoredVec3>& positions, const std::vector<MeshFace>& faces, int levels) {
    auto mesh = loop_subdivision(positions, faces, levels, {"here", 3, 0});
    if (!mesh) FAIL(mesh.error().to_string());
    return *std::move(mesh);
}

/// A regular icosahedron of circumradius 1, faces counterclockwise from outside.
void icosahedron(std::vector<StoredVec3>& positions, std::vector<MeshFace>& faces) {
    const double g = (1 + std::sqrt(5.0)) / 2, r = std::hypot(1.0, g);
    const auto add = [&](double x, double y, double z) {
        positions.push_back(to_float(BasicVec3<double>{x / r, y / r, z / r}));
    };
    for (const double s : {1.0, -1.0})
        for (const double t : {1.0, -1.0}) {
            add(0, s, t * g);
            add(s, t * g, 0);
            add(t * g, 0, s);
        }
    for (std::uint32_t a = 0; a < 12; ++a)
        for (std::uint32_t b = a + 1; b < 12; ++b)
            for (std::uint32_t c = b + 1; c < 12; ++c) {
                const DVec3 p(positions[a]), q(positions[b]), s(positions[c]);
                const double edge = 2 / r, eps = 1e-5;
                if (std::abs(length(p - q) - edge) > eps || std::abs(length(q - s) - edge) > eps ||
                    std::abs(length(s - p) - edge) > eps)
                    continue;
                if (dot(cross(q - p, s - p), p) > 0) faces.push_back({a, b, c});
                else faces.push_back({a, c, b});
            }
}

/// A flat grid of (n + 1)^2 points around 0, and its faces.
void grid(int n, std::vector<StoredVec3>& positions, std::vector<MeshFace>& faces) {
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x) positions.push_back({static_cast<float>(x), static_cast<float>(y), 0});
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const auto a = static_cast<std::uint32_t>(y * (n + 1) + x), up = static_cast<std::uint32_t>(n + 1);
            faces.push_back({a, a + 1, a + up + 1});
            faces.push_back({a, a + up + 1, a + up});
        }
}

}  // namespace

TEST_CASE("subdivision of an icosahedron approaches a sphere, with the same limit from every level", "[loopsubdiv]") {
    std::vector<StoredVec3> positions;
    std::vector<MeshFace> faces;
    icosahedron(positions, faces);
    REQUIRE(faces.size() == 20);
    // A vertex of valence 5 moves to (1 - 5 w) + 5 w cos(its edge's angle), w = 1 / (5 + 3 / (8 beta)), beta = 3 / 40.
    // The cosine is 1 / sqrt 5, so the result is 0.5 + 0.5 / sqrt 5.
    const double corner = 0.5 + 0.5 / std::sqrt(5.0);
    for (const int levels : {0, 1, 4}) {
        const SubdividedMesh mesh = subdivided(positions, faces, levels);
        REQUIRE(mesh.indices.size() == 60u << (2 * levels));
        REQUIRE(mesh.positions.size() == 2 + (10u << (2 * levels)));  // Euler's V = F / 2 + 2
        double least = 2, most = 0, tilt = 0;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const DVec3 p(mesh.positions[v]), n(mesh.normals[v]);
            if (v < 12) {  // the limit of a vertex does not depend on the level
                CHECK(length(p) == Approx(corner).epsilon(1e-6));
                CHECK(dot(n, p) / length(p) == Approx(-1).epsilon(1e-6));  // faces are clockwise seen from outside
            }
            least = std::min(least, length(p));
            most = std::max(most, length(p));
            tilt = std::max(tilt, 1 + dot(n, p) / length(p));
        }
        // The limit surface has the icosahedron's symmetry and is a sphere to a few per cent; normals tilt by its
        // slope.
        CHECK(most / least < 1.05);
        CHECK(tilt < 0.005);
    }
}

TEST_CASE("normals of a subdivided mesh are the limit of its triangles' normals", "[loopsubdiv]") {
    std::vector<StoredVec3> positions;
    std::vector<MeshFace> faces;
    grid(4, positions, faces);
    for (StoredVec3& p : positions) p.z = 0.2f * p.x * p.x - 0.1f * p.y * p.y * p.y + 0.3f * p.x;
    double before = 0;
    for (const int levels : {3, 4, 5}) {
        const SubdividedMesh mesh = subdivided(positions, faces, levels);
        std::vector<DVec3> sums(mesh.positions.size());
        std::vector<int> count(mesh.positions.size());
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            const std::uint32_t* k = mesh.indices.data() + i;
            const DVec3 a(mesh.positions[k[0]]), b(mesh.positions[k[1]]), c(mesh.positions[k[2]]);
            for (int j = 0; j < 3; ++j) sums[k[j]] = sums[k[j]] + cross(c - a, b - a), ++count[k[j]];
        }
        double worst = 0;
        for (std::size_t v = 0; v < sums.size(); ++v)
            worst = std::max(worst, length(normalize(sums[v]) - DVec3(mesh.normals[v])));
        // Faces at a boundary lie on one side of their vertex: the difference is of first order in their size.
        CHECK(worst < 0.4 / (1 << levels));
        if (before > 0) CHECK(worst < 0.6 * before);
        before = worst;
    }
}

TEST_CASE("a flat mesh stays flat, and its boundary becomes the B-spline of its corners", "[loopsubdiv]") {
    std::vector<StoredVec3> positions;
    std::vector<MeshFace> faces;
    grid(3, positions, faces);
    positions.push_back({7, 7, 7});  // no face uses it
    const SubdividedMesh mesh = subdivided(positions, faces, 2);
    CHECK(mesh.odd_edges == 0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        CHECK(mesh.positions[v].z == 0);
        CHECK(mesh.normals[v] == StoredVec3{0, 0, -1});
    }
    // A cubic B-spline passes through (a + 4 b + c) / 6 at a control point's limit. Here boundaries are smoothed by 1/8
    // and end with 1/5: without levels, the limit for a corner (0, 0) between (1, 0) and (0, 1) is 1/5 of each.
    const SubdividedMesh coarse = subdivided(positions, faces, 0);
    CHECK(coarse.positions[0] == to_float(BasicVec3<double>{0.2, 0.2, 0}));
    CHECK(coarse.positions[1] == StoredVec3{1, 0, 0});
}

TEST_CASE("many levels and vertices of many faces take time linear in the triangles", "[loopsubdiv][release-only]") {
    const std::vector<StoredVec3> corners{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    const std::vector<MeshFace> tetrahedron{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    const auto seconds = [](const std::vector<StoredVec3>& positions, const std::vector<MeshFace>& faces, int levels) {
        const auto begin = std::chrono::steady_clock::now();
        CHECK(subdivided(positions, faces, levels).indices.size() == 3 * faces.size() << (2 * levels));
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    CHECK(seconds(corners, tetrahedron, 9) < 5);  // a million triangles
    std::vector<StoredVec3> around{{0, 0, 1}};
    std::vector<MeshFace> fan;
    constexpr std::uint32_t spokes = 100'000;
    for (std::uint32_t i = 0; i < spokes; ++i) {
        const double angle = 2 * std::numbers::pi * i / spokes;
        around.push_back(to_float(BasicVec3<double>{std::cos(angle), std::sin(angle), 0}));
        fan.push_back({0, i + 1, (i + 1) % spokes + 1});
    }
    CHECK(seconds(around, fan, 1) < 5);  // 100,000 squared steps take ten seconds
}

TEST_CASE("a point keeps its limit from level to level, also on folds and between faces of opposite orientation",
          "[loopsubdiv]") {
    // A triangle with two sides, and a tetrahedron with one face of opposite orientation.
    const std::vector<StoredVec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 0, 0},
                                            {4, 0, 0}, {3, 1, 0}, {3, 0, 2}};
    const std::vector<MeshFace> faces{{0, 1, 2}, {0, 2, 1}, {3, 4, 5}, {3, 5, 6}, {3, 6, 4}, {4, 5, 6}};
    const SubdividedMesh coarse = subdivided(positions, faces, 0);
    for (const int levels : {1, 2, 4}) {
        const SubdividedMesh fine = subdivided(positions, faces, levels);
        CHECK(fine.odd_edges == 3);
        REQUIRE(fine.indices.size() == coarse.indices.size() << (2 * levels));
        for (std::size_t v = 0; v < coarse.positions.size(); ++v) {
            CAPTURE(levels, v);
            CHECK(length(DVec3(fine.positions[v]) - DVec3(coarse.positions[v])) < 1e-6);
        }
    }
}

TEST_CASE("loopsubdiv: parameters, warnings and errors", "[loopsubdiv][import][law7]") {
    const std::string square = "\"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [0 1 2 0 2 3] ";
    const SceneDescription scene = scene_of("WorldBegin\nShape \"loopsubdiv\" " + square);
    REQUIRE(scene.shapes.size() == 1);
    CHECK(scene.shapes[0].indices.size() == 3 * 2 * 64);  // three levels
    CHECK(scene.warnings.empty());
    const SceneDescription folded = scene_of(
        "WorldBegin\nShape \"loopsubdiv\" \"integer levels\" 1 "
        "\"point3 P\" [0 0 0 1 0 0 0 1 0 0 -1 0 0 0 1] "
        "\"integer indices\" [0 1 2 1 0 3 0 1 4]");
    REQUIRE(folded.warnings.size() == 1);
    CHECK(contains(folded.warnings[0].message, "1 edges of a loopsubdiv belong to more than two faces"));
    struct Case {
        std::string text;
        const char* expected;
    };
    for (const Case& each :
         {Case{square + "\"integer levels\" -1", "expected 0 to 16"},
          Case{square + "\"integer levels\" 15", "the budget tessellated_triangles"},
          Case{square + "\"string scheme\" \"butterfly\"", "expected loop"}, Case{"", "has no vertices"},
          Case{"\"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 1]", "has vertex 1 twice"},
          Case{"\"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]", "out of range"}}) {
        INFO(each.text);
        const Error found = error_of("WorldBegin\nShape \"loopsubdiv\" " + each.text);
        CHECK(found.line == 2);
        INFO(found.to_string());
        CHECK(contains(found.message, each.expected));
    }
}
