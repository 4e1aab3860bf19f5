// Rules: Loop 1987, "Smooth subdivision surfaces based on triangles", with Warren's weights for vertices inside and the
// cubic B-spline's along boundaries; limits and tangents: Hoppe et al. 1994, "Piecewise smooth surface reconstruction",
// and "Physically Based Rendering", 3rd edition, section 3.8, whose parameters these are.
//
// Tangents use masks of the last level's control points, not of the limit points as in pbrt-v4: these masks give the
// tangents of the limit surface, and the difference shrinks with every level. As in pbrt, the outside is the side from
// which faces go around clockwise.
#include "transport/import/shapes/loop_subdivision.h"

#include <algorithm>
#include <numbers>
#include <string>
#include <tuple>

#include "display/services/elementary.h"
#include "lpe/input/budgets.h"
#include "transport/import/shapes/shape_parameters.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {
namespace {

constexpr std::uint32_t nobody = 0xffffffffu;

/// The edges of a mesh, and whether each vertex lies on a boundary.
struct Topology {
    struct Edge {
        std::uint32_t low, high;
        std::array<std::uint32_t, 2> opposite{nobody, nobody};  ///< the second is absent at a boundary
        [[nodiscard]] bool boundary() const { return opposite[1] == nobody; }
    };
    std::vector<Edge> edges;
    std::vector<std::array<std::uint32_t, 3>> face_edges;  ///< [face]: edge from corner k to corner k + 1
    std::vector<std::uint32_t> valence;
    std::vector<std::uint8_t> boundary;  ///< [vertex]
    std::size_t odd_edges = 0;           ///< of more than two faces, or of two with opposite orientations
};

/// One direction of an edge of a face.
struct HalfEdge {
    std::uint32_t low, high, face, corner;
    bool upwards;
};

Result<Topology> topology_of(std::size_t vertices, const std::vector<MeshFace>& faces, const SourceLocation& where) {
    std::vector<HalfEdge> halves;
    halves.reserve(3 * faces.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = faces[f][k], b = faces[f][(k + 1) % 3];
            if (a == b)
                return error_at(where, "face " + std::to_string(f) + " has vertex " + std::to_string(a) +
                                           " twice; expected three different ones");
            halves.push_back({std::min(a, b), std::max(a, b), f, k, a < b});
        }
    std::sort(halves.begin(), halves.end(), [](const HalfEdge& a, const HalfEdge& b) {
        return std::tie(a.low, a.high, a.face, a.corner) < std::tie(b.low, b.high, b.face, b.corner);
    });
    Topology t;
    t.face_edges.resize(faces.size());
    t.valence.resize(vertices);
    t.boundary.resize(vertices);
    for (std::size_t i = 0; i < halves.size();) {
        const HalfEdge &one = halves[i], *other = i + 1 < halves.size() ? &halves[i + 1] : nullptr;
        // Among three or more faces at an edge the first two are paired, and so on, as in pbrt.
        const std::size_t end = other != nullptr && other->low == one.low && other->high == one.high ? i + 2 : i + 1;
        const bool third = i > 0 && halves[i - 1].low == one.low && halves[i - 1].high == one.high;
        t.odd_edges += third || (end == i + 2 && one.upwards == other->upwards);
        Topology::Edge edge{one.low, one.high, {nobody, nobody}};
        for (std::size_t k = i; k < end; ++k) {
            edge.opposite[k - i] = faces[halves[k].face][(halves[k].corner + 2) % 3];
            t.face_edges[halves[k].face][halves[k].corner] = static_cast<std::uint32_t>(t.edges.size());
        }
        for (const std::uint32_t v : {edge.low, edge.high}) {
            ++t.valence[v];
            if (edge.boundary()) t.boundary[v] = 1;
        }
        t.edges.push_back(edge);
        i = end;
    }
    return t;
}

/// (1 - n w) p + w (sum of n neighbours): all neighbours in the interior, and the two along the boundary on it.
std::vector<DVec3> smoothed(const std::vector<DVec3>& p, const Topology& t, double boundary_weight,
                            double (*inner_weight)(std::uint32_t valence)) {
    std::vector<DVec3> sums(p.size());
    for (const Topology::Edge& edge : t.edges) {
        if (edge.boundary() || t.boundary[edge.low] == 0) sums[edge.low] = sums[edge.low] + p[edge.high];
        if (edge.boundary() || t.boundary[edge.high] == 0) sums[edge.high] = sums[edge.high] + p[edge.low];
    }
    std::vector<DVec3> result(p.size());
    for (std::size_t v = 0; v < p.size(); ++v) {
        const double n = t.boundary[v] != 0 ? 2 : t.valence[v];
        const double w = t.boundary[v] != 0 ? boundary_weight : inner_weight(t.valence[v]);
        result[v] = p[v] * (1 - n * w) + sums[v] * w;
    }
    return result;
}

double even_weight(std::uint32_t valence) {
    return valence == 3 ? 3.0 / 16 : 3.0 / (8.0 * valence);
}
double limit_weight(std::uint32_t valence) {
    return 1 / (valence + 3 / (8 * even_weight(valence)));
}

/// The topology of the faces that refine() makes, without a search: edge e becomes 2 e at its low end and 2 e + 1 at
/// the high one. After these, face f has the edges 3 f + k across its corner k.
Topology refined_topology(const Topology& t, std::size_t vertices, const std::vector<MeshFace>& faces,
                          const std::vector<MeshFace>& finer) {
    const auto first = static_cast<std::uint32_t>(vertices), inner = static_cast<std::uint32_t>(2 * t.edges.size());
    Topology next;
    next.valence = t.valence;
    next.boundary = t.boundary;
    next.edges.reserve(inner + 3 * faces.size());
    for (std::uint32_t e = 0; e < t.edges.size(); ++e) {
        const Topology::Edge& edge = t.edges[e];
        next.edges.push_back({edge.low, first + e});
        next.edges.push_back({edge.high, first + e});
        next.valence.push_back(edge.boundary() ? 4 : 6);
        next.boundary.push_back(edge.boundary() ? 1 : 0);
    }
    next.face_edges.reserve(finer.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        const auto& e = t.face_edges[f];
        const auto half = [&](std::size_t k, std::size_t corner) {
            return 2 * e[k] + (t.edges[e[k]].low == faces[f][corner] ? 0 : 1);
        };
        const std::uint32_t across = inner + 3 * f;
        for (std::uint32_t k = 0; k < 3; ++k) {
            next.edges.push_back({first + e[k], first + e[(k + 2) % 3]});
            next.face_edges.push_back({half(k, k), across + k, half((k + 2) % 3, k)});
        }
        next.face_edges.push_back({across + 1, across + 2, across});
    }
    for (std::size_t f = 0; f < finer.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) {
            auto& opposite = next.edges[next.face_edges[f][k]].opposite;
            opposite[opposite[0] == nobody ? 0 : 1] = finer[f][(k + 2) % 3];
        }
    return next;
}

void refine(std::vector<DVec3>& p, std::vector<MeshFace>& faces, Topology& t) {
    std::vector<DVec3> next = smoothed(p, t, 1.0 / 8, even_weight);
    next.reserve(p.size() + t.edges.size());
    for (const Topology::Edge& e : t.edges)
        next.push_back(e.boundary() ? (p[e.low] + p[e.high]) * 0.5
                                    : (p[e.low] + p[e.high]) * 0.375 + (p[e.opposite[0]] + p[e.opposite[1]]) * 0.125);
    std::vector<MeshFace> finer;
    finer.reserve(4 * faces.size());
    const auto first = static_cast<std::uint32_t>(p.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const MeshFace &c = faces[f], &e = t.face_edges[f];
        for (std::size_t k = 0; k < 3; ++k) finer.push_back({c[k], first + e[k], first + e[(k + 2) % 3]});
        finer.push_back({first + e[0], first + e[1], first + e[2]});
    }
    t = refined_topology(t, p.size(), faces, finer);
    p = std::move(next);
    faces = std::move(finer);
}

/// The neighbours of each vertex in the order in which faces go around it. On a boundary the order runs from one end of
/// the boundary to the other.
class Rings {
  public:
    Rings(std::size_t vertices, const std::vector<MeshFace>& faces) : begin_(vertices + 1) {
        for (const MeshFace& face : faces)
            for (const std::uint32_t v : face) ++begin_[v + 1];
        for (std::size_t v = 0; v < vertices; ++v) begin_[v + 1] += begin_[v];
        std::vector<std::size_t> at(begin_.begin(), begin_.end() - 1);
        steps_.resize(begin_.back());
        for (const MeshFace& face : faces)
            for (std::size_t k = 0; k < 3; ++k) steps_[at[face[k]]++] = {face[(k + 1) % 3], face[(k + 2) % 3]};
    }

    /// Writes the neighbours to `ring`; returns false if the faces around the vertex are not one fan.
    bool read(std::uint32_t vertex, std::vector<std::uint32_t>& ring) {
        const auto first = steps_.begin() + static_cast<std::ptrdiff_t>(begin_[vertex]),
                   last = steps_.begin() + static_cast<std::ptrdiff_t>(begin_[vertex + 1]);
        // Sorted, since thousands of faces may meet at a vertex.
        std::sort(first, last,
                  [](const Step& a, const Step& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
        ends_.clear();
        for (auto each = first; each != last; ++each) ends_.push_back(each->to);
        std::sort(ends_.begin(), ends_.end());
        const auto begins = [&](std::uint32_t v) {
            const auto found =
                std::lower_bound(first, last, v, [](const Step& s, std::uint32_t w) { return s.from < w; });
            return found != last && found->from == v ? found : last;
        };
        auto step = first;
        for (auto each = first; each != last; ++each)
            if (!std::binary_search(ends_.begin(), ends_.end(), each->from)) step = each;
        ring = {step->from};
        for (; step != last && ring.size() <= static_cast<std::size_t>(last - first); step = begins(step->to))
            ring.push_back(step->to);
        const bool closed = ring.back() == ring.front();
        if (closed) ring.pop_back();
        return static_cast<std::size_t>(last - first) == ring.size() - (closed ? 0 : 1);
    }

  private:
    struct Step {
        std::uint32_t from, to;
    };
    std::vector<std::size_t> begin_;
    std::vector<Step> steps_;
    std::vector<std::uint32_t> ends_;  // of one vertex
};

/// The directions of n neighbours around a vertex, kept for the next vertex: most have as many.
class Turns {
  public:
    struct Turn {
        double sine, cosine;
    };
    const std::vector<Turn>& of(std::size_t n) {
        if (turns_.size() == n) return turns_;
        turns_.clear();
        for (std::size_t j = 0; j < n; ++j) {
            const auto [sine, cosine] =
                elementary::sin_cos(2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(n));
            turns_.push_back({sine, cosine});
        }
        return turns_;
    }

  private:
    std::vector<Turn> turns_;
};

/// The normal across two tangents of the limit surface. pbrt's ring runs the other way, and so does its normal.
DVec3 limit_normal(const DVec3& p, const std::vector<DVec3>& ring, bool boundary, Turns& turns) {
    const std::size_t n = ring.size();
    DVec3 s, t;
    if (!boundary) {
        const auto& turn = turns.of(n);
        for (std::size_t j = 0; j < n; ++j) {
            s = s + ring[j] * turn[j].cosine;
            t = t + ring[j] * turn[j].sine;
        }
        return cross(t, s);
    }
    s = ring[n - 1] - ring[0];
    if (n == 2) {
        t = ring[0] + ring[1] - p * 2;
    } else if (n == 3) {
        t = ring[1] - p;
    } else if (n == 4) {
        t = ring[1] * 2 + ring[2] * 2 - ring[0] - ring[3] - p * 2;
    } else {
        const double theta = std::numbers::pi / static_cast<double>(n - 1);
        const auto [sine, cosine] = elementary::sin_cos(theta);
        t = (ring[0] + ring[n - 1]) * -sine;
        for (std::size_t k = 1; k + 1 < n; ++k)
            t = t + ring[k] * ((2 - 2 * cosine) * elementary::sin(static_cast<double>(k) * theta));
    }
    return cross(s, t);
}

std::vector<StoredVec3> limit_normals(const std::vector<DVec3>& p, const std::vector<MeshFace>& faces,
                                      const std::vector<std::uint8_t>& boundary) {
    Rings rings(p.size(), faces);
    std::vector<DVec3> by_faces(p.size());
    for (const MeshFace& f : faces) {
        const DVec3 n = cross(p[f[2]] - p[f[0]], p[f[1]] - p[f[0]]);
        for (const std::uint32_t v : f) by_faces[v] = by_faces[v] + n;
    }
    std::vector<StoredVec3> normals;
    normals.reserve(p.size());
    std::vector<std::uint32_t> ring;
    std::vector<DVec3> around;
    Turns turns;
    for (std::uint32_t v = 0; v < p.size(); ++v) {
        DVec3 n = by_faces[v];
        if (rings.read(v, ring)) {
            around.clear();
            for (const std::uint32_t each : ring) around.push_back(p[each]);
            if (const DVec3 limit = limit_normal(p[v], around, boundary[v] != 0, turns); dot(limit, limit) > 0)
                n = limit;
        }
        // It is finite, and not 0 unless all faces around have no area: those are omitted, and the normal with them.
        normals.push_back(dot(n, n) > 0 ? to_float(normalize(n).to_real()) : StoredVec3{0, 0, 1});
    }
    return normals;
}

/// Renumbers the vertices that faces use, in their order, and returns them.
std::vector<DVec3> used_vertices(const std::vector<StoredVec3>& positions, std::vector<MeshFace>& faces) {
    std::vector<std::uint32_t> number(positions.size(), nobody);
    for (const MeshFace& face : faces)
        for (const std::uint32_t v : face) number[v] = 0;
    std::vector<DVec3> used;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        if (number[v] == nobody) continue;
        number[v] = static_cast<std::uint32_t>(used.size());
        used.emplace_back(positions[v]);
    }
    for (MeshFace& face : faces)
        for (std::uint32_t& v : face) v = number[v];
    return used;
}

}  // namespace

Result<SubdividedMesh> loop_subdivision(const std::vector<StoredVec3>& positions, const std::vector<MeshFace>& faces,
                                        int levels, const SourceLocation& where) {
    const std::uint64_t most = budget(Budget::tessellated_triangles);
    std::uint64_t triangles = faces.size();
    for (int level = 0; level < levels && triangles <= most; ++level) triangles *= 4;
    if (triangles > most)
        return over_budget(Budget::tessellated_triangles,
                           std::to_string(levels) + " levels make more triangles of " + std::to_string(faces.size()) +
                               " faces than the budget allows",
                           where.file, where.line, where.column);
    std::vector<MeshFace> current = faces;
    std::vector<DVec3> p = used_vertices(positions, current);
    Result<Topology> t = topology_of(p.size(), current, where);
    if (!t) return t.error();
    SubdividedMesh mesh;
    mesh.odd_edges = t->odd_edges;
    for (int level = 0; level < levels; ++level) refine(p, current, *t);
    mesh.positions.reserve(p.size());
    for (const DVec3& limit : smoothed(p, *t, 1.0 / 5, limit_weight))
        mesh.positions.push_back(to_float(limit.to_real()));
    // The edges are no longer needed, and the next step needs as much memory again.
    const std::vector<std::uint8_t> boundary = std::move(t->boundary);
    *t = Topology();
    mesh.normals = limit_normals(p, current, boundary);
    mesh.indices.reserve(3 * current.size());
    for (const MeshFace& face : current) mesh.indices.insert(mesh.indices.end(), face.begin(), face.end());
    return mesh;
}

Result<std::vector<SceneShape>> make_loop_subdivision(const ParameterSet& set, const ShapeContext& context,
                                                      std::vector<Error>& warnings) {
    const Result<std::string> scheme = set.string_or("scheme", "loop");
    if (!scheme) return scheme.error();
    if (*scheme != "loop")
        return error_at(location_of(set, "scheme"), "'scheme' of a loopsubdiv is '" + *scheme + "'; expected loop");
    const Result<std::int64_t> levels = set.integer_or("levels", 3);
    if (!levels) return levels.error();
    if (*levels < 0 || *levels > 16)
        return error_at(location_of(set, "levels"),
                        "'levels' of a loopsubdiv is " + std::to_string(*levels) + "; expected 0 to 16");
    const Result<std::vector<StoredVec3>> positions = triples(set, "P", ParameterType::point3, "point3");
    if (!positions) return positions.error();
    if (positions->empty()) return error_at(set.location, "loopsubdiv has no vertices; expected \"point3 P\"");
    const Result<std::vector<std::uint32_t>> indices = indices_of(set, positions->size(), 3, warnings);
    if (!indices) return indices.error();
    std::vector<MeshFace> faces(indices->size() / 3);
    for (std::size_t i = 0; i < indices->size(); ++i) faces[i / 3][i % 3] = (*indices)[i];
    Result<SubdividedMesh> mesh =
        loop_subdivision(*positions, faces, static_cast<int>(*levels), location_of(set, "indices"));
    if (!mesh) return mesh.error();
    if (mesh->odd_edges > 0)
        warnings.push_back(
            error_at(location_of(set, "indices"),
                     std::to_string(mesh->odd_edges) +
                         " edges of a loopsubdiv belong to more than two faces, or to two that go around "
                         "in opposite directions; the surface is not smooth there"));
    SceneShape shape;
    shape.location = set.location;
    shape.positions = std::move(mesh->positions);
    shape.normals = std::move(mesh->normals);
    shape.indices = std::move(mesh->indices);
    return finish_mesh(std::move(shape), "the subdivided mesh", context, warnings);
}

}  // namespace raylex::transport
