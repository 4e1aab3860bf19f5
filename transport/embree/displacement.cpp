#include "transport/embree/displacement.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "display/services/short_number.h"
#include "lpe/input/budgets.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {
namespace {

/// The sums of the face normals around each vertex, weighted by area.
std::vector<DVec3> sums_of_faces(const std::vector<StoredVec3>& positions, const std::vector<std::uint32_t>& indices) {
    std::vector<DVec3> sums(positions.size());
    for (std::size_t i = 0; i + 3 <= indices.size(); i += 3) {
        const std::uint32_t* k = indices.data() + i;
        const DVec3 a(positions[k[0]]);
        const DVec3 n = cross(DVec3(positions[k[1]]) - a, DVec3(positions[k[2]]) - a);
        for (int corner = 0; corner < 3; ++corner) sums[k[corner]] = sums[k[corner]] + n;
    }
    return sums;
}

StoredVec3 unit_or(const DVec3& v, const StoredVec3& fallback) {
    const double l = length(v);
    return l > 0 && std::isfinite(l) ? to_float((v * (1 / l)).to_real()) : fallback;
}

/// Halves edges in rounds: each round halves all edges that are too long, each with one new vertex.
class EdgeHalver {
  public:
    EdgeHalver(SceneShape& mesh, const Transform& placement) : mesh_(mesh), to_world_(placement.matrix()) {}

    Status halve_all() {
        if (least_triangles() > static_cast<double>(budget(Budget::tessellated_triangles))) return too_many();
        while (find_long()) {
            // Each halved edge adds one triangle to each of its faces.
            if (mesh_.indices.size() / 3 + halves_ > budget(Budget::tessellated_triangles)) return too_many();
            const std::size_t before = mesh_.positions.size();
            for (const std::uint64_t edge : long_) add_middle(edge);
            std::vector<std::uint32_t> finer;
            finer.reserve(2 * mesh_.indices.size());
            for (std::size_t i = 0; i < mesh_.indices.size(); i += 3) cut(mesh_.indices.data() + i, before, finer);
            mesh_.indices = std::move(finer);
        }
        return success();
    }

  private:
    /// A lower bound on the number of triangles, by area: a triangle with edges of at most l has at most sqrt(3) / 4
    /// l^2.
    [[nodiscard]] double least_triangles() const {
        double area = 0;
        for (std::size_t i = 0; i < mesh_.indices.size(); i += 3) {
            const std::uint32_t* k = mesh_.indices.data() + i;
            const DVec3 a(mesh_.positions[k[0]]), b(mesh_.positions[k[1]]), c(mesh_.positions[k[2]]);
            area += length(cross(to_world_.vector(b - a), to_world_.vector(c - a))) / 2;
        }
        const double edge = mesh_.edge_length;
        return area / (0.433 * edge * edge);
    }
    [[nodiscard]] Error too_many() const {
        std::array<char, 32> shown{};
        const auto end = std::to_chars(shown.data(), shown.data() + shown.size(), mesh_.edge_length);
        return over_budget(Budget::tessellated_triangles,
                           "edges of at most " + std::string(shown.data(), end.ptr) +
                               " ('edgelength') need more triangles of the displaced mesh than the budget allows",
                           mesh_.location.file, mesh_.location.line, mesh_.location.column);
    }
    static std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
        return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
    }
    [[nodiscard]] double length_of(std::uint32_t a, std::uint32_t b) const {
        return length(to_world_.vector(DVec3(mesh_.positions[a]) - DVec3(mesh_.positions[b])));
    }
    /// The edges of this round, sorted.
    bool find_long() {
        long_.clear();
        for (std::size_t i = 0; i < mesh_.indices.size(); i += 3)
            for (std::size_t k = 0; k < 3; ++k) {
                // Both faces list the edge in the same order, so that they round alike.
                const std::uint32_t a = mesh_.indices[i + k], b = mesh_.indices[i + (k + 1) % 3];
                if (length_of(std::min(a, b), std::max(a, b)) > double{mesh_.edge_length})
                    long_.push_back(key_of(a, b));
            }
        halves_ = long_.size();
        std::sort(long_.begin(), long_.end());
        long_.erase(std::unique(long_.begin(), long_.end()), long_.end());
        return !long_.empty();
    }
    void add_middle(std::uint64_t edge) {
        const auto a = static_cast<std::size_t>(edge >> 32), b = static_cast<std::size_t>(edge & 0xffffffffu);
        const auto middle = [](const StoredVec3& p, const StoredVec3& q) {
            return to_float(((DVec3(p) + DVec3(q)) * 0.5).to_real());
        };
        mesh_.positions.push_back(middle(mesh_.positions[a], mesh_.positions[b]));
        const DVec3 n = DVec3(mesh_.normals[a]) + DVec3(mesh_.normals[b]);
        mesh_.normals.push_back(unit_or(n, mesh_.normals[a]));
        if (mesh_.uvs.empty()) return;
        const StoredVec2 s = mesh_.uvs[a], t = mesh_.uvs[b];
        mesh_.uvs.push_back({0.5f * (s.x + t.x), 0.5f * (s.y + t.y)});
    }
    void cut(const std::uint32_t* corners, std::size_t first_middle, std::vector<std::uint32_t>& out) const {
        std::array<std::uint32_t, 3> c{corners[0], corners[1], corners[2]}, m{};
        std::array<bool, 3> is_long{};
        int count = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t key = key_of(c[k], c[(k + 1) % 3]);
            const auto found = std::lower_bound(long_.begin(), long_.end(), key);
            is_long[k] = found != long_.end() && *found == key;
            m[k] = static_cast<std::uint32_t>(first_middle + static_cast<std::size_t>(found - long_.begin()));
            count += is_long[k] ? 1 : 0;
        }
        const auto add = [&out](std::uint32_t a, std::uint32_t b, std::uint32_t d) {
            out.insert(out.end(), {a, b, d});
        };
        if (count == 0) return add(c[0], c[1], c[2]);
        if (count == 3) {
            for (std::size_t k = 0; k < 3; ++k) add(c[k], m[k], m[(k + 2) % 3]);
            return add(m[0], m[1], m[2]);
        }
        // Rotates the triangle so that edge 0 is the long one, or the first of two, or so that the short edge comes
        // last.
        std::size_t turn = 0;
        while (!(is_long[turn] && !is_long[(turn + 2) % 3])) ++turn;
        const auto at = [turn](const std::array<std::uint32_t, 3>& of, std::size_t k) { return of[(turn + k) % 3]; };
        const std::uint32_t a = at(c, 0), b = at(c, 1), d = at(c, 2), ab = at(m, 0), bd = at(m, 1);
        if (count == 1) {
            add(a, ab, d);
            return add(ab, b, d);
        }
        add(ab, b, bd);
        if (length_of(ab, d) < length_of(a, bd)) {
            add(a, ab, d);
            add(ab, bd, d);
        } else {
            add(a, ab, bd);
            add(a, bd, d);
        }
    }

    SceneShape& mesh_;
    Matrix34 to_world_;
    std::vector<std::uint64_t> long_;
    std::size_t halves_ = 0;  ///< edges halved in this round; those of two faces count twice
};

Status move_vertices(SceneShape& mesh, const Transform& placement, const TextureTable& textures) {
    const auto texture = textures.named_real(mesh.displacement_texture, mesh.location);
    if (!texture) return texture.error();
    // ReverseOrientation turns normals when the mesh is read; displacement follows the normals of the file.
    const double sign = mesh.flip_normal != mesh.object_to_world.swaps_handedness() ? -1 : 1;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        TexturePoint at;
        if (!mesh.uvs.empty()) at.u = mesh.uvs[i].x, at.v = mesh.uvs[i].y;
        at.position = placement.point(mesh.positions[i]);
        const double by = sign * static_cast<double>(textures.real(*texture, at));
        const DVec3 moved = DVec3(mesh.positions[i]) + DVec3(mesh.normals[i]) * by;
        mesh.positions[i] = to_float(moved.to_real());
        if (!is_finite(mesh.positions[i]))
            return error_at(mesh.location, "the displacement of vertex " + std::to_string(i) + " is " +
                                               short_number(by, 6) + "; expected a value that leaves it finite");
    }
    return success();
}

}  // namespace

Result<SceneShape> displaced_mesh(const SceneShape& shape, const Transform& placement, const TextureTable& textures) {
    SceneShape mesh = shape;
    const bool reverse = shape.flip_normal != shape.object_to_world.swaps_handedness();
    if (mesh.normals.empty())
        for (const DVec3& n : sums_of_faces(mesh.positions, mesh.indices))
            mesh.normals.push_back(unit_or(reverse ? n * -1 : n, {0, 0, 1}));
    else
        for (StoredVec3& n : mesh.normals) n = unit_or(DVec3(n), n);
    if (Status s = EdgeHalver(mesh, placement).halve_all(); !s) return s.error();
    if (Status s = move_vertices(mesh, placement, textures); !s) return s.error();
    const std::vector<DVec3> sums = sums_of_faces(mesh.positions, mesh.indices);
    for (std::size_t i = 0; i < sums.size(); ++i) {
        // On the side of the previous normal: some files list the corners of a face the other way around.
        const bool turned = dot(sums[i], DVec3(mesh.normals[i])) < 0;
        mesh.normals[i] = unit_or(turned ? sums[i] * -1 : sums[i], mesh.normals[i]);
    }
    mesh.displacement_texture.clear();
    return mesh;
}

}  // namespace raylex::transport
