// Closed meshes: rays at their edges and corners, bounces inside them, lines through them.
#include <array>
#include <cmath>
#include <map>

#include "tests/stability/probes/geometry_support.h"
#include "tests/stability/probes/probes.h"

namespace raylex::experiments {
namespace {

using namespace geometry_probe;

struct Mesh {
    std::vector<DVec3> positions;
    std::vector<std::array<std::uint32_t, 3>> faces;
};

Mesh icosphere(int levels) {
    const double g = (1 + std::sqrt(5.0)) / 2;
    Mesh m;
    for (const auto& [a, b] : {std::pair{1.0, g}, std::pair{-1.0, g}, std::pair{1.0, -g}, std::pair{-1.0, -g}}) {
        m.positions.push_back(normalize(DVec3(0, a, b)));
        m.positions.push_back(normalize(DVec3(a, b, 0)));
        m.positions.push_back(normalize(DVec3(b, 0, a)));
    }
    // Faces: all triples of vertices at the icosahedron's edge length, facing outwards.
    const double edge = 4 / (1 + g * g) * 1.0001;
    const auto close = [&](std::size_t i, std::size_t j) {
        const DVec3 d = m.positions[i] - m.positions[j];
        return dot(d, d) < edge;
    };
    for (std::uint32_t i = 0; i < 12; ++i)
        for (std::uint32_t j = i + 1; j < 12; ++j)
            for (std::uint32_t k = j + 1; k < 12; ++k) {
                if (!close(i, j) || !close(j, k) || !close(i, k)) continue;
                const DVec3 n = cross(m.positions[j] - m.positions[i], m.positions[k] - m.positions[i]);
                if (dot(n, m.positions[i]) > 0) m.faces.push_back({i, j, k});
                else m.faces.push_back({i, k, j});
            }
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        std::vector<std::array<std::uint32_t, 3>> finer;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [found, is_new] =
                middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(m.positions.size()));
            if (is_new) m.positions.push_back(normalize(m.positions[a] + m.positions[b]));
            return found->second;
        };
        for (const auto& [a, b, c] : m.faces) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            for (const std::array<std::uint32_t, 3>& face :
                 {std::array{a, ab, ca}, std::array{b, bc, ab}, std::array{c, ca, bc}, std::array{ab, bc, ca}})
                finer.push_back(face);
        }
        m.faces = std::move(finer);
    }
    return m;
}

/// Returns the box [-1, 1]^3. `fan`: the sides consist of slivers, triangles around points with distance `aspect` from
/// a corner's edge.
Mesh box(double aspect) {
    Mesh m;
    for (int i = 0; i < 8; ++i) m.positions.push_back({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
    const std::array<std::array<std::uint32_t, 4>, 6> sides{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& side : sides) {
        if (aspect >= 1) {
            m.faces.push_back({side[0], side[1], side[2]});
            m.faces.push_back({side[0], side[2], side[3]});
            continue;
        }
        const DVec3 &a = m.positions[side[0]], &b = m.positions[side[1]], &c = m.positions[side[2]];
        const auto inner = static_cast<std::uint32_t>(m.positions.size());
        m.positions.push_back((a + b) * 0.5 + (c - b) * aspect);
        for (std::size_t k = 0; k < 4; ++k) m.faces.push_back({side[k], side[(k + 1) % 4], inner});
    }
    return m;
}

Result<Mesh> mesh_named(const ProbeInput& input) {
    const std::string name = input.word("mesh");
    if (name == "icosphere") return icosphere(static_cast<int>(input.number("levels", 3)));
    if (name == "box") return box(1);
    if (name == "slivers") return box(input.number("aspect", 1e-6));
    return error_at(input.where(), "unknown mesh '" + name + "'; expected icosphere, box or slivers");
}

/// Returns the mesh as a shape, rotated so that no edge is parallel to an axis, and rounded.
SceneShape shape_of(const Mesh& mesh, double scale, const DVec3& center) {
    const Transform turn = Transform::rotate(17, 1, 2, 3);
    SceneShape shape;
    for (const DVec3& p : mesh.positions)
        shape.positions.push_back(stored(center + DVec3(turn.point_in_double({p.x, p.y, p.z})) * scale));
    for (const auto& face : mesh.faces) shape.indices.insert(shape.indices.end(), face.begin(), face.end());
    return shape;
}

/// Returns a point on an edge (in one of four cases a corner), as exactly as floats allow.
DVec3 edge_point(RandomNumbers& random, const SceneShape& shape) {
    const std::size_t face = 3 * random.below(shape.indices.size() / 3), k = random.below(3);
    const DVec3 a(Vec3(shape.positions[shape.indices[face + k]])),
        b(Vec3(shape.positions[shape.indices[face + (k + 1) % 3]]));
    const Real s = random() < 0.25f ? Real(0) : random();
    return a * (1 - s) + b * s;
}

/// Row 4. Counts rays at the edges and corners of a closed convex mesh that miss it.
Result<ProbeResult> escapes(const ProbeInput& input) {
    const double scale = input.number("scale", 1);
    const auto rays = static_cast<std::uint64_t>(input.number("rays", 1e5));
    const bool inside = input.number("inside", 1) != 0, aimed = input.number("aimed", 1) != 0;
    const auto mesh = mesh_named(input);
    if (!mesh) return mesh.error();
    RandomNumbers random(static_cast<std::uint64_t>(input.number("seed", 6)));
    const DVec3 center = DVec3(random.point(1)) * (scale * input.number("away", 0));
    const SceneShape shape = shape_of(*mesh, scale, center);
    const auto built = geometry_of({shape});
    if (!built) return built.error();
    constexpr std::size_t batch = 256;
    std::vector<Ray> all(batch);
    std::vector<Hit> hits(batch);
    std::uint64_t missed = 0;
    for (std::uint64_t done = 0; done < rays; done += batch) {
        for (Ray& ray : all) {
            const DVec3 within = center + DVec3(random.point(Real(0.4))) * scale,
                        target = aimed ? edge_point(random, shape) : within + DVec3(random.direction()) * scale;
            const DVec3 line = normalize(target - within);
            // From outside: through the target into the mesh, starting at an equal distance before it.
            ray = ray_from((inside ? within : target + line * scale).to_real(), (inside ? line : line * -1).to_real());
        }
        built->intersect(all, hits);
        const std::size_t count = std::min<std::uint64_t>(batch, rays - done);
        for (std::size_t i = 0; i < count; ++i) missed += !hits[i].valid();
    }
    return never(missed, std::to_string(rays) + " rays");
}

/// Rows 1, 4. Counts diffuse bounces in a closed mesh after which the ray is outside or hits nothing.
Result<ProbeResult> bounce_leaks(const ProbeInput& input) {
    const double scale = input.number("scale", 1);
    const auto bounces = static_cast<std::uint64_t>(input.number("bounces", 1e5));
    const auto mesh = mesh_named(input);
    if (!mesh) return mesh.error();
    RandomNumbers random(static_cast<std::uint64_t>(input.number("seed", 7)));
    const DVec3 center = DVec3(random.point(1)) * (scale * input.number("away", 0));
    const SceneShape shape = shape_of(*mesh, scale, center);
    std::optional<Transform> place;
    if (input.number("instanced", 0) != 0) place = Transform::rotate(50, 3, 1, 2);
    const auto built = geometry_of({shape}, place);
    if (!built) return built.error();
    const DVec3 middle = place ? DVec3(place->point_in_double({center.x, center.y, center.z})) : center;
    const auto start = [&] { return ray_from(middle.to_real(), random.direction()); };
    Ray ray = start();
    std::uint64_t leaks = 0;
    for (std::uint64_t i = 0; i < bounces; ++i) {
        const Found f = find(*built, ray);
        // The faces point outwards, so a hit against the normal comes from outside.
        if (!f.hit.valid() || dot(f.point.geometric_normal, ray.direction) < 0) {
            ++leaks;
            ray = start();
            continue;
        }
        const Frame frame = Frame::from_normal(-f.point.geometric_normal);
        ray = leaving(f, normalize(frame.to_world(sample_cosine_hemisphere({random(), random()}))));
    }
    return never(leaks, std::to_string(bounces) + " bounces");
}

/// Row 5. Counts lines through nested closed meshes whose entries and exits do not alternate.
Result<ProbeResult> parity(const ProbeInput& input) {
    const auto lines = static_cast<std::uint64_t>(input.number("lines", 2e4));
    const bool at_edges = input.number("edges", 0) != 0;
    const auto mesh = mesh_named(input);
    if (!mesh) return mesh.error();
    RandomNumbers random(5);
    const DVec3 center = DVec3(random.point(1)) * input.number("away", 0);
    std::vector<SceneShape> shells;
    for (const double size : {1.0, 0.7, 0.49}) shells.push_back(shape_of(*mesh, size, center));
    const auto built = geometry_of(shells);
    if (!built) return built.error();
    std::uint64_t broken = 0;
    for (std::uint64_t i = 0; i < lines; ++i) {
        const DVec3 target =
            at_edges ? edge_point(random, shells[random.below(3)]) : center + DVec3(random.point(Real(0.9)));
        const Vec3 direction = random.direction();
        Ray ray = ray_from((target - DVec3(direction) * 4).to_real(), direction);
        std::array<int, 3> depth{};
        bool wrong = false;
        for (int k = 0; k < 16 && !wrong; ++k) {
            const Found f = find(*built, ray);
            if (!f.hit.valid()) break;
            int& in = depth[f.hit.shape];
            in += dot(f.point.geometric_normal, direction) < 0 ? 1 : -1;
            wrong = in < 0 || in > 1;
            ray = leaving(f, direction);
        }
        wrong = wrong || depth != std::array<int, 3>{};
        broken += wrong;
    }
    return never(broken, std::to_string(lines) + " lines");
}

}  // namespace

std::span<const NamedProbe> closed_mesh_probes() {
    static constexpr NamedProbe table[] = {
        {"escapes",
         "number of rays at edges and corners of a closed mesh (aimed = 0: in any direction) that miss it; mesh "
         "(icosphere, box, "
         "slivers), levels, aspect, scale, away (scales), inside, aimed, seed, rays",
         escapes},
        {"bounce_leaks",
         "number of diffuse bounces in a closed mesh that end outside; mesh, levels, aspect, scale, away (scales), "
         "instanced, "
         "seed, bounces",
         bounce_leaks},
        {"parity",
         "number of lines through three nested closed meshes whose entries and exits do not alternate; mesh, levels, "
         "aspect, away, edges, lines",
         parity},
    };
    return table;
}

}  // namespace raylex::experiments
