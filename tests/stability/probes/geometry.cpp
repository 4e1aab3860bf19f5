// Rays and surfaces: rays that leave a surface, and hits compared with closed forms.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/stability/probes/geometry_support.h"
#include "tests/stability/probes/probes.h"
#include "transport/lights/light.h"
#include "transport/render/tiles.h"

namespace raylex::experiments {
namespace {

using namespace geometry_probe;

/// Returns 200 triangles of size `scale` at a distance of `away` times `scale`; two of their edges have the ratio 1 to
/// `aspect`.
SceneShape random_triangles(RandomNumbers& random, Real scale, Real away, double aspect) {
    SceneShape shape;
    const DVec3 center(random.point(away * scale));
    for (std::uint32_t i = 0; i < 600; i += 3) {
        const DVec3 at = center + DVec3(random.point(scale));
        const DVec3 a(random.point(scale)), b(random.point(scale));
        for (const DVec3& p : {at, at + a, at + a * (1 - aspect) * 0.5 + b * aspect})
            shape.positions.push_back(stored(p));
        for (std::uint32_t k = 0; k < 3; ++k) shape.indices.push_back(i + k);
    }
    return shape;
}

/// Returns a direction at an angle of asin(`sine`) to the plane; any direction for 0.
Vec3 direction_at(RandomNumbers& random, const Vec3& normal, double sine) {
    const Vec3 any = random.direction();
    if (sine == 0) return any;
    const DVec3 n(normal), d(any), flat = normalize(d - n * dot(n, d));
    return normalize(flat * std::sqrt(1 - sine * sine) + n * std::copysign(sine, dot(n, d))).to_real();
}

/// Row 1. Counts rays that leave a triangle and hit it again.
Result<ProbeResult> rehits(const ProbeInput& input) {
    const auto scale = static_cast<Real>(input.number("scale", 1)), away = static_cast<Real>(input.number("away", 0));
    const double aspect = input.number("aspect", 1), sine = input.number("sine", 0);
    const auto rays = static_cast<std::uint64_t>(input.number("rays", 20000));
    RandomNumbers random(1);
    const SceneShape mesh = random_triangles(random, scale, away, aspect);
    std::optional<Transform> place;
    if (input.number("instanced", 0) != 0)
        place = Transform::translate(3 * scale, -scale, 2 * scale) * Transform::rotate(31, 1, 2, 3) *
                Transform::scale(0.3, 2, 1);
    const auto built = geometry_of({mesh}, place);
    if (!built) return built.error();
    const Transform to_world = place.value_or(Transform());
    std::uint64_t again = 0, tested = 0;
    for (std::uint64_t tries = 0; tested < rays && tries < 50 * rays; ++tries) {
        const std::size_t t = 3 * random.below(200);
        const auto corner = [&](std::size_t k) { return DVec3(Vec3(mesh.positions[t + k])); };
        const Real r = std::sqrt(random()), s = random();
        const DVec3 target = corner(0) * (1 - r) + corner(1) * (r * (1 - s)) + corner(2) * (r * s);
        const Vec3 at = DVec3(to_world.point_in_double({target.x, target.y, target.z})).to_real();
        const Vec3 toward = random.direction();
        const Found f = find(*built, ray_from(at - toward * (scale * (random() + Real(0.01))), toward));
        if (!f.hit.valid()) continue;
        const Ray next = leaving(f, direction_at(random, f.point.geometric_normal, sine));
        // Within 2^-20 of the plane, rounding of the direction decides the side.
        if (sine == 0 && std::abs(dot(next.direction, f.point.geometric_normal)) < 0x1p-20f) continue;
        ++tested;
        const Found second = find(*built, next);
        again += second.hit.valid() && second.hit.primitive == f.hit.primitive;
    }
    ProbeResult result;
    result.measured = static_cast<double>(again);
    result.expected = 0;
    result.note = std::to_string(tested) + " rays";
    if (tested < rays / 2) return error_at(input.where(), "only " + result.note + " met the triangles");
    return result;
}

/// Row 2. Counts rays from the lower of two planes that the upper plane does not stop.
Result<ProbeResult> gap_leaks(const ProbeInput& input) {
    const double gap = input.number("gap");  // relative to the planes' distance from the origin
    const auto rays = static_cast<std::uint64_t>(input.number("rays", 20000));
    if (Status s = input.status(); !s) return s.error();
    const Transform turn = Transform::rotate(input.number("degrees", 33), 1, 2, 0.5);
    const DVec3 n(turn.point_in_double({0, 1, 0})), x(turn.point_in_double({1, 0, 0})),
        z(turn.point_in_double({0, 0, 1}));
    std::vector<SceneShape> planes;
    for (const double height : {1.0, 1 + gap}) {
        SceneShape plane;
        for (const auto& [a, b] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}})
            plane.positions.push_back(stored(n * height + (x * a + z * b) * 0.5));
        plane.indices = {0, 2, 1, 0, 3, 2};
        planes.push_back(plane);
    }
    const auto built = geometry_of(std::move(planes));
    if (!built) return built.error();
    RandomNumbers random(2);
    std::uint64_t leaks = 0;
    for (std::uint64_t i = 0; i < rays; ++i) {
        const DVec3 target = n + x * (0.2 * double(random.signed_unit())) + z * (0.2 * double(random.signed_unit()));
        const Found f = find(*built, ray_from((target - n * 0.5).to_real(), n.to_real()));
        if (!f.hit.valid() || f.hit.shape != 0) {
            ++leaks;
            continue;
        }
        // Up to 84 degrees, so that the ray stays within 10 gaps of its origin.
        DVec3 d(random.direction());
        d = d - n * dot(d, n);
        d = normalize(n + normalize(d) * (9.9 * double(random())));
        const Found g = find(*built, leaving(f, d.to_real()));
        leaks += !g.hit.valid() || g.hit.shape != 1;
    }
    return never(leaks);
}

/// Row 3. Counts shadow rays between two facing emitters that appear blocked.
Result<ProbeResult> emitters_blocked(const ProbeInput& input) {
    const auto scale = input.number("scale", 1);
    const auto rays = static_cast<std::uint64_t>(input.number("rays", 2e5));
    std::vector<SceneShape> plates;
    RandomNumbers random(4);
    const DVec3 center = DVec3(random.point(1)) * (scale * input.number("away", 0));
    const Transform turn = Transform::rotate(20, 1, 1, 0);
    for (const double y : {0.0, 0.7}) {
        SceneShape plate;
        for (const auto& [x, z] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}})
            plate.positions.push_back(stored(center + DVec3(turn.point_in_double({double(x), y, double(z)})) * scale));
        plate.indices = {0, 1, 2, 0, 2, 3};
        plates.push_back(plate);
    }
    const auto built = geometry_of(std::move(plates));
    if (!built) return built.error();
    const auto point_on = [&](std::uint32_t shape) {
        Found f;
        f.hit.shape = shape;
        f.hit.primitive = random() < 0.5f ? 0 : 1;
        const Real r = std::sqrt(random()), s = random();
        f.hit.u = r * (1 - s);
        f.hit.v = r * s;
        const Ray none{};
        built->surfaces({&none, 1}, {&f.hit, 1}, {&f.point, 1}, {&f.source, 1});
        return f;
    };
    std::uint64_t blocked_count = 0;
    for (std::uint64_t i = 0; i < rays; ++i) {
        const Found a = point_on(0), b = point_on(1);
        LightSample sample;
        sample.target = b.point.position;
        sample.target_normal = b.point.geometric_normal;
        sample.target_offset = b.source.offset;
        sample.wi = normalize(b.point.position - a.point.position);
        const Ray ray = shadow_ray(a.point.position, a.point.geometric_normal, a.source.offset.here, sample);
        std::uint8_t blocked = 0;
        built->occluded({&ray, 1}, {&blocked, 1});
        blocked_count += blocked;
    }
    return never(blocked_count);
}

SceneShape unit_sphere() {
    SceneShape sphere;
    sphere.kind = ShapeKind::sphere;
    return sphere;
}

/// Rows 47, 54. Counts lines for which the hit of a unit sphere differs from the closed form in long double for the
/// same ray.
Result<ProbeResult> sphere_hits(const ProbeInput& input) {
    const double distance = input.number("distance"), speed = input.number("length", 1);
    const auto rays = static_cast<std::uint64_t>(input.number("rays", 20000));
    if (Status s = input.status(); !s) return s.error();
    const auto built = geometry_of({unit_sphere()});
    if (!built) return built.error();
    RandomNumbers random(5);
    std::uint64_t wrong = 0, met = 0;
    for (std::uint64_t i = 0; i < rays; ++i) {
        const DVec3 axis(random.direction());
        const DVec3 side = normalize(cross(axis, DVec3(random.direction())));
        const DVec3 from = axis * -distance;
        const Ray ray = ray_from(from.to_real(), (normalize(side * (1.5 * double(random())) - from) * speed).to_real());
        using Long = long double;
        const Long o[3] = {ray.origin.x, ray.origin.y, ray.origin.z},
                   d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
        Long dd = 0, od = 0, oo = 0;
        for (int k = 0; k < 3; ++k) dd += d[k] * d[k], od += o[k] * d[k], oo += o[k] * o[k];
        const Long discriminant = od * od - dd * (oo - 1);
        // Skips lines that pass a tangent within the rounding error of the closest point.
        if (std::abs(discriminant) <= Long(0x1p-47) * std::sqrt(oo) * dd) continue;
        const Long root = discriminant > 0 ? std::sqrt(discriminant) : Long(0), t0 = (-od - root) / dd,
                   t1 = (-od + root) / dd;
        const Long t = discriminant <= 0 ? Long(-1) : t0 > 0 ? t0 : t1;
        if (std::abs(t) < Long(1e-12)) continue;
        const Found f = find(*built, ray);
        met += f.hit.valid();
        const Long error = std::abs(Long(f.hit.t) - t);
        wrong += f.hit.valid() != (t > 0) || (t > 0 && !(error <= Long(0x1p-23) * t));
    }
    return never(wrong, std::to_string(met) + " of " + std::to_string(rays) + " met it");
}

/// Row 53. Returns the largest distance of visible points and normals from a unit sphere's surface, seen by a distant
/// camera, in units in the last place of 1.
Result<ProbeResult> sphere_profile(const ProbeInput& input) {
    const double distance = input.number("distance");
    const auto rays = static_cast<std::uint64_t>(input.number("rays", 20000));
    if (Status s = input.status(); !s) return s.error();
    const auto built = geometry_of({unit_sphere()});
    if (!built) return built.error();
    RandomNumbers random(53);
    double worst = 0;
    for (std::uint64_t i = 0; i < rays; ++i) {
        const DVec3 from(0, 0, -distance), to(random.signed_unit(), random.signed_unit(), 0);
        const Found f = find(*built, ray_from(from.to_real(), normalize(to - from).to_real()));
        if (!f.hit.valid()) continue;
        const DVec3 p(f.point.position), n(f.point.geometric_normal);
        worst = std::max({worst, std::abs(length(p) - 1), length(n - normalize(p))});
    }
    ProbeResult result;
    result.measured = worst * 0x1p23;
    result.expected = 0;
    result.ulp = 1;
    return result;
}

/// Row 51. Counts pixels of a film with `side` pixels per side whose tile does not contain them, or whose tile index is
/// not unique.
Result<ProbeResult> film_indices(const ProbeInput& input) {
    const auto side = static_cast<int>(input.number("side"));
    const auto pixels = static_cast<std::uint64_t>(input.number("pixels", 20000));
    if (Status s = input.status(); !s) return s.error();
    TileGrid grid;
    grid.width = grid.height = side;
    grid.padding_x = grid.padding_y = 2;
    RandomNumbers random(51);
    std::uint64_t wrong = 0;
    std::map<std::uint64_t, std::pair<int, int>> seen;
    for (std::uint64_t i = 0; i < pixels; ++i) {
        const auto any = [&] { return static_cast<int>(random.below(static_cast<std::size_t>(side))); };
        const int x = i == 0 ? side - 1 : any(), y = i == 0 ? side - 1 : any();
        const std::uint64_t tile = grid.tile_of(x, y);
        const display::PixelRegion held = grid.pixels_of(tile);
        wrong += tile >= grid.count() || x < held.x0 || x >= held.x1 || y < held.y0 || y >= held.y1;
        const auto [known, is_new] = seen.try_emplace(tile, held.x0, held.y0);
        wrong += known->second != std::pair(held.x0, held.y0);
    }
    return never(wrong);
}

/// Row 8. Counts rays that miss a quadrilateral tiled by a fan of slivers.
Result<ProbeResult> sliver_holes(const ProbeInput& input) {
    const double aspect = input.number("aspect");
    const auto rays = static_cast<std::uint64_t>(input.number("rays", 20000));
    if (Status s = input.status(); !s) return s.error();
    const Transform turn = Transform::rotate(input.number("degrees", 29), 3, 1, 2);
    // From the corner (0, 0) to points on the opposite sides, half of them `aspect` from the diagonal's end.
    std::vector<DVec3> rim{{1, 0, 0}};
    constexpr int slivers = 64;
    for (int i = slivers; i > 0; --i) rim.push_back({1, 1 - aspect * i, 0});
    rim.push_back({1, 1, 0});
    for (int i = 1; i <= slivers; ++i) rim.push_back({1 - aspect * i, 1, 0});
    rim.push_back({0, 1, 0});
    SceneShape fan;
    fan.positions.push_back({0, 0, 0});
    for (const DVec3& p : rim) fan.positions.push_back(stored(DVec3(turn.point_in_double({p.x, p.y, p.z}))));
    for (std::uint32_t i = 1; i < rim.size(); ++i) fan.indices.insert(fan.indices.end(), {0, i, i + 1});
    const auto built = geometry_of({fan});
    if (!built) return built.error();
    RandomNumbers random(8);
    std::uint64_t holes = 0, broken = 0;
    for (std::uint64_t i = 0; i < rays; ++i) {
        // Half of the rays go along the diagonal, where the slivers are.
        const double a = 0.01 + 0.98 * double(random()),
                     b = i % 2 == 0 ? 0.01 + 0.98 * double(random())
                                    : std::clamp(a * (1 + aspect * 70 * double(random.signed_unit())), 0.01, 0.99);
        const DVec3 target(turn.point_in_double({a, b, 0})), d(random.direction());
        if (std::abs(dot(d, DVec3(turn.point_in_double({0, 0, 1})))) < 0.05) continue;
        const Found f = find(*built, ray_from((target - d).to_real(), d.to_real()));
        holes += !f.hit.valid();
        if (f.hit.valid()) broken += !is_finite(f.point.geometric_normal) || !(f.source.offset.here < Real(0.1));
    }
    return never(holes + broken, std::to_string(holes) + " holes, " + std::to_string(broken) +
                                     " without a normal or with a far offset");
}

}  // namespace

std::span<const NamedProbe> geometry_probes() {
    static constexpr NamedProbe table[] = {
        {"rehits",
         "number of rays that leave a triangle and hit it again; scale, away (scales), aspect, sine (to the plane, 0 "
         "any), "
         "instanced, rays",
         rehits},
        {"gap_leaks",
         "number of rays from one of two planes that the other does not stop; gap (of their distance to the origin), "
         "degrees, rays",
         gap_leaks},
        {"emitters_blocked",
         "number of shadow rays between facing plates that appear blocked; scale, away (scales), rays",
         emitters_blocked},
        {"sphere_hits",
         "number of rays whose hit of a unit sphere differs from the closed form; distance of the origin, length of "
         "the direction, "
         "rays",
         sphere_hits},
        {"sphere_profile",
         "largest distance of visible points and normals from a unit sphere's, in ulps of 1; distance, rays",
         sphere_profile},
        {"film_indices", "number of pixels outside their tile; side of the film in pixels, number of tested pixels",
         film_indices},
        {"sliver_holes", "number of rays that miss a quadrilateral tiled by slivers; aspect, degrees, rays",
         sliver_holes},
    };
    return table;
}

}  // namespace raylex::experiments
