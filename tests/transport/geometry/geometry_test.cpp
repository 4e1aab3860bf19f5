#include <catch2/catch.hpp>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "display/services/split_mix.h"
#include "support/skip.h"
#include "transport/embree/embree_scene.h"
#include "transport/math/sampling.h"
#include "transport/samplers/pixel_sampler.h"

using namespace raylex;
using namespace raylex::transport;

namespace {

/// Reproducible uniform numbers.
class RandomPoints {
  public:
    explicit RandomPoints(std::uint64_t seed) : state_(seed) {}
    float operator()() { return unit_float(mix_bits(state_ += golden_gamma)); }
    float signed_unit() { return 2 * (*this)() - 1; }
    Vec3 direction() { return sample_uniform_sphere({(*this)(), (*this)()}); }
    Vec3 point(float extent) { return {extent * signed_unit(), extent * signed_unit(), extent * signed_unit()}; }

  private:
    std::uint64_t state_;
};

SceneDescription empty_scene() {
    SceneDescription scene;
    SceneEntity material;
    material.type = "diffuse";
    scene.materials.push_back(material);
    return scene;
}

EmbreeScene build_geometry(const SceneDescription& scene) {
    TextureTable textures;
    auto built = EmbreeScene::build(scene, textures, {});
    INFO((built ? std::string() : built.error().to_string()));
    REQUIRE(built.ok());
    return *std::move(built);
}

struct Found {
    Hit hit;
    SurfacePoint point;
    SurfaceSource source;
};
Found find(const EmbreeScene& scene, const Ray& ray) {
    Found f;
    scene.intersect({&ray, 1}, {&f.hit, 1});
    if (f.hit.valid()) scene.surfaces({&ray, 1}, {&f.hit, 1}, {&f.point, 1}, {&f.source, 1});
    return f;
}

SceneShape quadric(ShapeKind kind, const Transform& transform) {
    SceneShape shape;
    shape.kind = kind;
    shape.object_to_world = transform;
    shape.material = 0;
    return shape;
}

SceneShape quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    SceneShape shape;
    shape.positions = {a, b, c, d};
    shape.indices = {0, 1, 2, 0, 2, 3};
    shape.material = 0;
    return shape;
}

}  // namespace

TEST_CASE("rays that leave axis-aligned planes through zero do not hit them again", "[geometry]") {
    RandomPoints random(2);
    SceneDescription scene = empty_scene();
    scene.shapes.push_back(quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}));
    const EmbreeScene built = build_geometry(scene);
    int again = 0;
    for (int i = 0; i < 20000; ++i) {
        Ray ray;
        ray.origin = {random.signed_unit(), 1, random.signed_unit()};
        ray.direction = normalize(Vec3{random.signed_unit(), 0, random.signed_unit()} * 0.9f - ray.origin);
        const Found f = find(built, ray);
        if (!f.hit.valid()) continue;
        Ray leaving;
        leaving.direction = random.direction();
        leaving.origin =
            offset_ray_origin(f.point.position, f.point.geometric_normal, f.source.offset.here, leaving.direction);
        again += find(built, leaving).hit.valid();
    }
    CHECK(again == 0);
}

TEST_CASE("a ray's hit depends on the ray alone, to the bit, for batches of any size and order",
          "[geometry][law3][law4]") {
    RandomPoints random(7);
    SceneDescription scene = empty_scene();
    for (int i = 0; i < 12; ++i)
        scene.shapes.push_back(quad(random.point(2), random.point(2), random.point(2), random.point(2)));
    scene.shapes.push_back(quadric(ShapeKind::sphere, Transform::scale(0.5f, 0.3f, 0.4f)));
    scene.objects.push_back({"object", {quad({-1, 0, 1}, {1, 0.2f, 1}, {1, 0, -1}, {-1, 0.1f, -1})}});
    SceneInstance instance;
    instance.object = 0;
    instance.to_world = Transform::translate(0.3f, 1, -0.2f) * Transform::rotate(31, 1, 2, 3);
    scene.instances.push_back(instance);
    const EmbreeScene built = build_geometry(scene);

    std::vector<Ray> rays(5001);  // odd: the last triangle has no partner
    for (Ray& ray : rays) {
        ray.origin = random.point(3);
        ray.direction = random.direction();
    }
    // Aimed at an edge, where hits are moved inwards.
    for (std::size_t i = 0; i < rays.size(); i += 7)
        rays[i].direction = normalize(Vec3(scene.shapes[i % 12].positions[0]) - rays[i].origin);
    for (std::size_t i = 0; i < rays.size(); i += 5) rays[i].direction = normalize(random.point(0.5f) - rays[i].origin);
    std::vector<Hit> hits(rays.size());
    built.intersect(rays, hits);
    std::vector<Ray> hitting;
    std::vector<Hit> found;
    std::size_t different = 0, instanced = 0, quadrics = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Hit alone = find(built, rays[i]).hit;
        different += alone.valid() != hits[i].valid();
        if (!hits[i].valid()) continue;
        different += alone.shape != hits[i].shape || alone.primitive != hits[i].primitive ||
                     alone.instance != hits[i].instance || alone.t != hits[i].t || alone.u != hits[i].u ||
                     alone.v != hits[i].v;
        hitting.push_back(rays[i]);
        found.push_back(hits[i]);
        instanced += hits[i].instance != Hit::none;
        quadrics += built.shapes()[hits[i].shape].kind == ShapeKind::sphere;
    }
    CHECK(different == 0);
    CHECK(found.size() > 1000);
    CHECK(instanced > 50);
    CHECK(quadrics > 20);
    std::vector<SurfacePoint> points(found.size());
    std::vector<SurfaceSource> sources(found.size());
    built.surfaces(hitting, found, points, sources);
    for (std::size_t i = 0; i < found.size(); ++i) {
        const Found alone = find(built, hitting[i]);
        different += alone.point.position != points[i].position ||
                     alone.point.geometric_normal != points[i].geometric_normal ||
                     alone.source.offset.here != sources[i].offset.here;
    }
    CHECK(different == 0);
}

TEST_CASE("occlusion depends on the ray alone: streams of any size and order, with every instruction set",
          "[geometry][law3][law4]") {
    const std::string isa = GENERATE("", "sse2", "avx", "avx2", "avx512");
    RandomPoints random(11);
    SceneDescription scene = empty_scene();
    // A bumpy sheet seen edge-on and from above, random triangles, and user geometry.
    SceneShape sheet;
    sheet.material = 0;
    constexpr std::uint32_t side = 24;
    for (std::uint32_t y = 0; y <= side; ++y)
        for (std::uint32_t x = 0; x <= side; ++x)
            sheet.positions.push_back({Real(x) / 8 - 1.5f, 0.2f * random.signed_unit(), Real(y) / 8 - 1.5f});
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) {
            const std::uint32_t a = y * (side + 1) + x, b = a + side + 1;
            for (const std::uint32_t corner : {a, a + 1, b, b, a + 1, b + 1}) sheet.indices.push_back(corner);
        }
    scene.shapes.push_back(sheet);
    for (int i = 0; i < 12; ++i)
        scene.shapes.push_back(quad(random.point(2), random.point(2), random.point(2), random.point(2)));
    scene.shapes.push_back(quadric(ShapeKind::sphere, Transform::scale(0.5f, 0.3f, 0.4f)));
    scene.shapes.push_back(quad({-1, 1, 1}, {1, 1.2f, 1}, {1, 1, -1}, {-1, 1.3f, -1}));
    scene.shapes.back().kind = ShapeKind::bilinear_mesh;
    scene.shapes.back().indices = {0, 1, 2, 3};
    scene.objects.push_back(
        {"object", {quadric(ShapeKind::disk, {}), quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0})}});
    SceneInstance instance;
    instance.object = 0;
    instance.to_world = Transform::translate(0.3f, -1, -0.2f) * Transform::rotate(31, 1, 2, 3);
    scene.instances.push_back(instance);
    TextureTable textures;
    EmbreeScene::Options options;
    options.isa = isa;
    auto started = EmbreeScene::build(scene, textures, options);
    if (!started && !isa.empty()) RAYLEX_SKIP("this machine does not offer " + isa);
    REQUIRE(started.ok());
    const EmbreeScene& built = *started;

    // Neighbours begin close to each other and aim at points on the same edges.
    std::vector<Ray> rays(60001);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Vec3 from = i % 64 == 0 || i % 3 == 0 ? random.point(3) : rays[i - 1].origin;
        const std::uint32_t k = 3 * static_cast<std::uint32_t>((i / 64 * 7 + i % 5) % (sheet.indices.size() / 3));
        const Vec3 a(sheet.positions[sheet.indices[k]]), b(sheet.positions[sheet.indices[k + 1]]);
        rays[i].origin = from;
        rays[i].direction = (i % 4 == 0 ? random.point(2) : a + (b - a) * random()) - from;
        rays[i].t_max = i % 2 == 0 ? infinity : 1 - 0x1p-20f;
    }
    rays[17].origin.x = infinity;  // an invalid ray counts as blocked and does not affect its neighbours
    std::vector<std::uint8_t> blocked(rays.size(), 2);
    built.occluded(rays, blocked);
    CHECK(blocked[17] == 1);
    std::vector<Hit> hits(rays.size());
    built.intersect(rays, hits);
    std::size_t unlike_hits = 0, unlike_alone = 0, count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        std::uint8_t alone = 2;
        built.occluded({&rays[i], 1}, {&alone, 1});
        unlike_alone += alone != blocked[i];
        unlike_hits += i != 17 && hits[i].valid() != (blocked[i] == 1);
        count += blocked[i];
    }
    CHECK(unlike_alone == 0);
    CHECK(unlike_hits == 0);
    CHECK(count > 10000);
    CHECK(count < 55000);
    // Shuffled locally, then with two of three rays omitted.
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < rays.size(); ++i) order.push_back(i);
    for (std::size_t i = 0; i + 100 < order.size(); ++i)
        std::swap(order[i], order[i + static_cast<std::size_t>(random() * 100)]);
    for (const std::size_t keep : {1, 3}) {
        std::vector<Ray> some;
        std::vector<std::size_t> from;
        for (std::size_t i = 0; i < order.size(); i += keep) some.push_back(rays[order[i]]), from.push_back(order[i]);
        std::vector<std::uint8_t> found(some.size());
        built.occluded(some, found);
        std::size_t different = 0;
        for (std::size_t i = 0; i < some.size(); ++i) different += found[i] != blocked[from[i]];
        CHECK(different == 0);
    }
}

TEST_CASE("a pass-through ray makes progress, wherever rounding puts its hit", "[geometry]") {
    RandomPoints random(5);
    int stuck = 0;
    for (int i = 0; i < 100000; ++i) {
        const float scale = std::pow(10.0f, 6 * random.signed_unit());
        Ray ray;
        ray.origin = random.point(scale);
        ray.direction = random.direction();
        // Before and behind the origin, by as much as rounding and by more; the normal is almost perpendicular.
        const Vec3 hit = ray.origin + ray.direction * (scale * random.signed_unit() * (i % 2 == 0 ? 1e-7f : 1e-2f));
        const Vec3 n =
            normalize(cross(ray.direction, random.direction()) + ray.direction * (1e-7f * static_cast<float>(i % 3)));
        const float t = scale * 1e-3f * (random.signed_unit() + 1);
        const Vec3 next = straight_ray_origin(ray, t, hit, n, 3e-7f * scale);
        const double progress = dot(DVec3(next) - DVec3(ray.origin), DVec3(ray.direction));
        stuck += !(progress > 0 && progress >= 0.499 * t);
    }
    CHECK(stuck == 0);
}

TEST_CASE("rays that leave a quadric or patch outwards do not hit it again, with and without instances", "[geometry]") {
    RandomPoints random(3);
    for (const float scale : {1e-6f, 1e-3f, 1.0f, 1e3f, 1e6f})
        for (const bool instanced : {false, true}) {
            const Transform place = Transform::translate(3 * scale, -scale, 2 * scale) *
                                    Transform::rotate(31, 1, 2, 3) * Transform::scale(scale, scale, scale);
            for (const ShapeKind kind :
                 {ShapeKind::sphere, ShapeKind::disk, ShapeKind::cylinder, ShapeKind::bilinear_mesh}) {
                SceneDescription scene = empty_scene();
                SceneShape shape = quadric(kind, instanced ? Transform() : place);
                if (kind == ShapeKind::bilinear_mesh) {
                    for (const Vec3& p : {Vec3{-1, -1, 0}, Vec3{1, -1, 0}, Vec3{-1, 1, 0}, Vec3{1, 1, 0}})
                        shape.positions.push_back(p);
                    shape.indices = {0, 1, 2, 3};
                }
                if (instanced) {
                    scene.objects.push_back({"object", {shape}});
                    SceneInstance instance;
                    instance.object = 0;
                    instance.to_world = place;
                    scene.instances.push_back(instance);
                } else {
                    scene.shapes.push_back(shape);
                }
                const EmbreeScene built = build_geometry(scene);
                const Vec3 center = place.point({0, 0, 0});
                int again = 0, tested = 0;
                for (int i = 0; i < 20000; ++i) {
                    Ray ray;
                    ray.origin = center + random.direction() * (5 * scale);
                    ray.direction = normalize(center + random.point(scale) - ray.origin);
                    const Found f = find(built, ray);
                    if (!f.hit.valid()) continue;
                    Ray leaving;
                    leaving.direction = random.direction();
                    if (kind == ShapeKind::cylinder || kind == ShapeKind::sphere)  // from outside: it curves away
                        leaving.direction = face_forward(leaving.direction, f.point.geometric_normal);
                    if (abs_dot(leaving.direction, f.point.geometric_normal) < 1e-6f) continue;
                    leaving.origin = offset_ray_origin(f.point.position, f.point.geometric_normal, f.source.offset.here,
                                                       leaving.direction);
                    ++tested;
                    again += find(built, leaving).hit.valid();
                }
                INFO("kind " << int(kind) << " scale " << scale << " instanced " << instanced);
                CHECK(tested > 2000);
                CHECK(again == 0);
            }
        }
}

TEST_CASE("a distant sphere is hit exactly if the line passes through it", "[geometry]") {
    // Row 47: up to 1e7 radii away. The reference is the distance of the line, constructed to an accuracy of 1e-9.
    RandomPoints random(5);
    const Quadric sphere(quadric(ShapeKind::sphere, Transform()), Transform());
    int wrong = 0;
    for (const double distance : {2.0, 1e2, 1e4, 1e7})
        for (int i = 0; i < 5000; ++i) {
            const DVec3 axis = normalize(DVec3(random.direction()));
            const DVec3 side = normalize(cross(axis, DVec3(random.direction())));
            const double miss = 1.5 * random();
            if (std::abs(miss - 1) < 1e-7) continue;
            double t, u, v;
            const bool hit = sphere.intersect(side * miss - axis * distance, axis, 0, 1e300, t, u, v);
            wrong += hit != (miss < 1);
        }
    CHECK(wrong == 0);
}

TEST_CASE("surface parameterisation and orientation are pbrt's", "[geometry]") {
    SceneDescription scene = empty_scene();
    scene.shapes.push_back(quadric(ShapeKind::sphere, Transform::translate(0, 0, 0)));
    scene.shapes.push_back(quadric(ShapeKind::disk, Transform::translate(10, 0, 0)));
    SceneShape cylinder = quadric(ShapeKind::cylinder, Transform::translate(20, 0, 0));
    scene.shapes.push_back(cylinder);
    SceneShape triangle;
    triangle.positions = {{30, 0, 0}, {31, 0, 0}, {30, 1, 0}};
    triangle.indices = {0, 1, 2};
    triangle.material = 0;
    scene.shapes.push_back(triangle);
    SceneShape patch;
    patch.kind = ShapeKind::bilinear_mesh;
    patch.positions = {{40, 0, 0}, {41, 0, 0}, {40, 1, 0}, {41, 1, 0}};
    patch.indices = {0, 1, 2, 3};
    patch.material = 0;
    patch.flip_normal = true;
    scene.shapes.push_back(patch);
    const EmbreeScene built = build_geometry(scene);
    const auto at = [&](const Vec3& origin, const Vec3& direction) {
        Ray ray;
        ray.origin = origin;
        ray.direction = direction;
        const Found f = find(built, ray);
        REQUIRE(f.hit.valid());
        return f.point;
    };
    const auto close = [](const Vec3& a, const Vec3& b) { return length(a - b) < 1e-6f * std::max(1.0f, length(b)); };

    // Sphere: u = phi / 2 pi, v = 0 at -z and 1 at +z, dp/du = 2 pi (-y, x, 0), normal outwards.
    SurfacePoint p = at({0, 5, 0}, {0, -1, 0});
    CHECK(p.u == Approx(0.25));
    CHECK(p.v == Approx(0.5));
    CHECK(close(p.geometric_normal, {0, 1, 0}));
    CHECK(close(p.dpdu, {-2 * pi, 0, 0}));
    CHECK(at({0, 0, -5}, {0, 0, 1}).v == Approx(0).margin(1e-6));
    // Disk: v = 0 at the rim, normal +z.
    p = at({10, 0.25f, 5}, {0, 0, -1});
    CHECK(p.u == Approx(0.25));
    CHECK(p.v == Approx(0.75));
    CHECK(close(p.geometric_normal, {0, 0, 1}));
    // Cylinder: v from zmin to zmax.
    p = at({15, 0, 0.5f}, {1, 0, 0});
    CHECK(p.u == Approx(0.5));
    CHECK(p.v == Approx(0.75));
    CHECK(close(p.geometric_normal, {-1, 0, 0}));
    // Triangle without uvs: (0,0), (1,0), (1,1); normal by the order of vertices.
    p = at({30.25f, 0.5f, 5}, {0, 0, -1});
    CHECK(p.u == Approx(0.75));
    CHECK(p.v == Approx(0.5));
    CHECK(close(p.geometric_normal, {0, 0, 1}));
    CHECK(close(p.dpdu, {1, 0, 0}));
    // Patch: (u, v) along p10 - p00 and p01 - p00; flipped here.
    p = at({40.25f, 0.5f, 5}, {0, 0, -1});
    CHECK(p.u == Approx(0.25));
    CHECK(p.v == Approx(0.5));
    CHECK(close(p.geometric_normal, {0, 0, -1}));
}

TEST_CASE("partial quadrics end where their parameters say", "[geometry]") {
    SceneDescription scene = empty_scene();
    SceneShape half = quadric(ShapeKind::sphere, Transform());
    half.phi_max = 180;
    scene.shapes.push_back(half);
    SceneShape ring = quadric(ShapeKind::disk, Transform::translate(10, 0, 0));
    ring.inner_radius = 0.5f;
    scene.shapes.push_back(ring);
    const EmbreeScene built = build_geometry(scene);
    Ray ray;
    ray.origin = {0.1f, -5, 0};
    ray.direction = {0, 1, 0};
    const Found f = find(built, ray);  // the near half is missing: the ray hits the far half from inside
    REQUIRE(f.hit.valid());
    CHECK(f.hit.t > 5);
    ray.origin = {10.2f, 0, 5};
    ray.direction = {0, 0, -1};
    CHECK_FALSE(find(built, ray).hit.valid());
    ray.origin = {10.7f, 0, 5};
    CHECK(find(built, ray).hit.valid());
}

TEST_CASE("instances move shapes and override their label", "[geometry]") {
    SceneDescription scene = empty_scene();
    SceneShape sphere = quadric(ShapeKind::sphere, Transform());
    sphere.label = "ball";
    scene.objects.push_back({"object", {sphere}});
    for (const float x : {-5.0f, 5.0f}) {
        SceneInstance instance;
        instance.object = 0;
        instance.to_world = Transform::translate(x, 0, 0) * Transform::scale(2, 1, 1);
        instance.label = x > 0 ? "right" : "";
        scene.instances.push_back(instance);
    }
    const EmbreeScene built = build_geometry(scene);
    Ray ray;
    ray.origin = {-5, 5, 0};
    ray.direction = {0, -1, 0};
    Found f = find(built, ray);
    REQUIRE(f.hit.valid());
    CHECK(length(f.point.position - Vec3{-5, 1, 0}) < 1e-6f);
    CHECK(built.object_labels()[static_cast<std::size_t>(f.source.label)] == "ball");
    CHECK(f.source.object_id == 1);
    ray.origin = {20, 0, 0};
    ray.direction = {-1, 0, 0};
    f = find(built, ray);
    REQUIRE(f.hit.valid());
    CHECK(length(f.point.position - Vec3{7, 0, 0}) < 1e-6f);
    CHECK(length(f.point.geometric_normal - Vec3{1, 0, 0}) < 1e-6f);
    CHECK(built.object_labels()[static_cast<std::size_t>(f.source.label)] == "right");
    CHECK(f.source.object_id == 2);
}

TEST_CASE("broken shapes are errors at their directive", "[geometry]") {
    TextureTable textures;
    SceneDescription scene = empty_scene();
    SceneShape shape = quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    shape.location = {"scene.pbrt", 12, 1};
    shape.positions[2].y = NAN;
    scene.shapes = {shape};
    auto built = EmbreeScene::build(scene, textures, {});
    REQUIRE_FALSE(built.ok());
    CHECK(built.error().line == 12);
    shape.positions[2].y = 1;
    shape.indices[1] = 9;
    scene.shapes = {shape};
    CHECK_FALSE(EmbreeScene::build(scene, textures, {}).ok());
    scene.shapes = {quadric(ShapeKind::sphere, Transform::scale(1, 0, 1))};
    CHECK_FALSE(EmbreeScene::build(scene, textures, {}).ok());
    scene.shapes.clear();
    auto isa = EmbreeScene::build(scene, textures, {"avx3", 0});
    REQUIRE_FALSE(isa.ok());
    CHECK(isa.error().message.find("avx2") != std::string::npos);
}
