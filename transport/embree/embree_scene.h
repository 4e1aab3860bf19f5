// The scene's shapes and the acceleration structure over them. The only door to Embree: its headers are included by
// embree_scene.cpp and nowhere else, so that moving to another version touches one file.
//
// Calls take batches, but rays are traced one by one (rtcIntersect1, rtcOccluded1, one flag): packet and stream calls
// may break ties between equal distances differently, and then a pixel would depend on which rays happened to share its
// batch (Law 3).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lpe/result.h"
#include "transport/geometry/ray.h"
#include "transport/geometry/render_space.h"
#include "transport/geometry/shapes/bilinear.h"
#include "transport/geometry/shapes/curve.h"
#include "transport/geometry/shapes/instance_motion.h"
#include "transport/geometry/shapes/quadric.h"
#include "transport/geometry/shapes/triangle.h"
#include "transport/geometry/surface_point.h"
#include "transport/scene/motion.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/texture.h"

struct RTCGeometryTy;  // Embree's
struct RTCSceneTy;

namespace raylex::transport {

/// One Shape directive as rendering sees it. Meshes point into vertex buffers that Embree owns.
struct ShapeGeometry {
    ShapeKind kind = ShapeKind::triangle_mesh;
    const StoredVec3* positions = nullptr;
    std::vector<Triangle> triangles;
    std::uint32_t primitive_count = 0;
    std::vector<StoredVec3> normals;
    std::vector<StoredVec2> uvs;
    std::vector<StoredVec3> patch_positions;  ///< bilinear meshes keep their own
    std::vector<std::uint32_t> patch_indices;
    Quadric quadric;
    CurveBatch curves;
    Matrix34 to_object;  ///< meshes: from where their vertices stand to the space they were written in
    bool flip_normal = false;
    int material = 0;
    int area_light = -1;  ///< index into SceneDescription::area_lights; -1 also for instanced shapes
    int inside_medium = -1, outside_medium = -1;  ///< indices into MediumTable; -1 = none
    TextureId alpha = -1;                         ///< opacity; -1 = opaque everywhere
    bool interface = false;                       ///< no surface at all: rays pass, and no area light shines there
    bool border = false;                          ///< what passes it changes media: interfaces, also mixed ones
    bool hidden = false;                          ///< alpha is 0 everywhere: no ray ever stops here
    /// Where it is hit and how it is turned depends on where the ray comes from (flat curves and tubes), so that what a
    /// subpath finds there one of the other direction does not.
    bool faces_rays = false;
    int label = 0;                          ///< index into object_labels()
    bool holdout = false;                   ///< see LabelRule
    std::uint32_t first_light = Hit::none;  ///< set by the light table: the light of primitive 0

    [[nodiscard]] BilinearPatch patch(std::uint32_t primitive) const;
    struct Interval {
        double lower, upper;
    };
    /// Whether Embree leaves it to us: quadrics and patches.
    [[nodiscard]] bool is_user() const { return kind != ShapeKind::triangle_mesh && kind != ShapeKind::curves; }
    /// Of a patch or quadric, which are not Embree's own: the nearest hit within `range` of distances.
    bool intersect(unsigned primitive, const DVec3& origin, const DVec3& direction, const Interval& range, double& t,
                   double& u, double& v) const;
    /// The largest coordinate.
    [[nodiscard]] double extent() const;
    /// How far from the origin rays to this shape may begin. For a triangle Embree multiplies the distance of the ray
    /// by two of its edges, in single precision.
    [[nodiscard]] double reach_of_rays() const;
    /// The medium into which a ray leaves the surface, whose outside `normal` points to, out of `current`. A surface
    /// with the same medium on both sides is no border: rays stay in whatever they came through (pbrt's rule).
    [[nodiscard]] std::int32_t medium_towards(const Vec3& normal, const Vec3& direction, std::int32_t current) const {
        if (inside_medium == outside_medium) return current;
        return dot(normal, direction) > 0 ? outside_medium : inside_medium;
    }
};

/// Of a point on a triangle, patch or quadric, `at` being Hit's u and v: what SurfacePoint::u and v are there.
[[nodiscard]] Vec2 texture_coordinates(const ShapeGeometry& shape, std::uint32_t primitive, const Vec2& at);

struct ShapeInstance {
    Placement placement;
    std::uint32_t first_shape = 0;    ///< of the object it places
    int label = -1;                   ///< overrides the shapes' own unless -1
    std::optional<bool> holdout{};    ///< overrides the shapes' own
    std::uint32_t first_surface = 0;  ///< surface number of the object's first shape, less 1
    std::int32_t motion = -1;         ///< index into the scene's motions: `placement` is then that of time 0
};

/// Where a surface point came from: what integrators need beside the SurfacePoint.
struct SurfaceSource {
    OffsetBound offset{};        ///< how far a leaving ray starts off the surface; see ray.h
    std::int32_t label = 0;      ///< index into object_labels()
    std::int32_t object_id = 0;  ///< 1-based: top-level shapes first, then instances
};

/// What only geometric AOVs ask of a hit. World space, unless it says otherwise.
struct SurfaceDetails {
    Vec3 dpdv;                  ///< beside SurfacePoint::dpdu: by the second texture coordinate
    Vec3 object_position;       ///< in the space that the shape's parameters were written in
    Real curvature = 0;         ///< mean curvature; positive where the surface bulges towards SurfacePoint::wo
    std::array<Vec3, 8> edges;  ///< of the triangle or patch: start and end by turns
    int edge_count = 0;         ///< 0 for quadrics and curves
};

/// A length-3 interval in world space.
struct Bounds {
    Vec3 lower, upper;
    [[nodiscard]] Vec3 center() const { return (lower + upper) * 0.5f; }
    [[nodiscard]] Real radius() const { return length(upper - lower) * 0.5f; }
};

/// Rays in the order they were traced, batch by batch.
struct RayLog {
    struct Batch {
        std::size_t count = 0;
        bool shadow = false;  ///< of occluded()
    };
    std::vector<Ray> rays;
    std::vector<Batch> batches;

    void add(std::span<const Ray> batch, bool shadow) {
        rays.insert(rays.end(), batch.begin(), batch.end());
        batches.push_back({batch.size(), shadow});
    }
};

struct InstancePlacements;  // scene_limits.h

class EmbreeScene {
  public:
    struct Options {
        std::string isa;  ///< "sse2", "sse4.2", "avx", "avx2", "avx512"; "" = the widest of them that this machine has
        int threads = 0;  ///< for building; 0 = all
        RenderSpace space{};  ///< where everything is placed; this class's "world"
        ShutterSpan shutter{};
        std::vector<TextureId> surface_shares{};  ///< [material] MaterialTable's; none: all are surfaces, or interfaces
    };

    /// Vertices that are not finite or beyond largest_coordinate, indices out of range, transforms that are singular or
    /// beyond what floats invert, and Embree's own errors are Errors at the shape or instance.
    static Result<EmbreeScene> build(const SceneDescription& scene, TextureTable& textures, const Options& options);
    ~EmbreeScene();
    EmbreeScene(EmbreeScene&&) noexcept;
    EmbreeScene& operator=(EmbreeScene&&) noexcept;

    /// Closest hits over (0, t_max): which primitive is Embree's choice, where on it is computed here, the same on all
    /// processors. A ray that begins or points beyond largest_coordinate, or is not of numbers, hits
    /// nothing, and what it asks is taken for blocked; untraced_rays() counts them.
    void intersect(std::span<const Ray> rays, std::span<Hit> hits) const;
    /// 1 where an opaque shape lies on (0, t_max); shapes with alpha do not count.
    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const;
    [[nodiscard]] std::uint64_t untraced_rays() const;
    /// Appends every later ray of intersect() and occluded() to `log`, for a benchmark to trace again; null ends it.
    /// One thread only.
    void record(RayLog* log) const { log_ = log; }
    /// Traces a log's rays again by nothing but rtcIntersect1 and rtcOccluded1, with the flags and in the order that
    /// they were traced, and returns how many of them hit. What is left out is finish_hits(): where on a primitive a
    /// hit is.
    [[nodiscard]] std::uint64_t trace_bare(const RayLog& log) const;
    /// The closest hit among the shapes with alpha, for the walk that shadow rays take through them.
    void intersect_alpha(const Ray& ray, Hit& hit) const;

    /// Turns valid hits into surface points (all but random_key) and their sources. `rays[i]` found `hits[i]`.
    void surfaces(std::span<const Ray> rays, std::span<const Hit> hits, std::span<SurfacePoint> points,
                  std::span<SurfaceSource> sources) const;

    /// Of a valid hit and the point that surfaces() made of it.
    [[nodiscard]] SurfaceTangents tangents(const Hit& hit, const SurfacePoint& point) const;
    /// Of a valid hit and the point that surfaces() made of it.
    [[nodiscard]] SurfaceDetails details(const Hit& hit, const SurfacePoint& point) const;

    /// Surfaces count from 1: top-level shapes, then the shapes of every instance in turn.
    [[nodiscard]] std::int32_t surface_number(const Hit& hit) const {
        if (hit.instance == Hit::none) return static_cast<std::int32_t>(hit.shape) + 1;
        const ShapeInstance& instance = instances_[hit.instance];
        return static_cast<std::int32_t>(instance.first_surface + (hit.shape - instance.first_shape)) + 1;
    }

    /// Whether any shape can be passed straight through (alpha or an interface).
    [[nodiscard]] bool has_alpha() const { return has_alpha_; }
    /// Whether any object is a holdout, and whether this hit is on one.
    [[nodiscard]] bool has_holdouts() const { return has_holdouts_; }
    [[nodiscard]] bool is_holdout(const Hit& hit) const {
        const bool own = shapes_[hit.shape].holdout;
        return hit.instance == Hit::none ? own : instances_[hit.instance].holdout.value_or(own);
    }
    [[nodiscard]] std::span<const ShapeGeometry> shapes() const { return shapes_; }
    [[nodiscard]] std::span<ShapeGeometry> shapes() { return shapes_; }
    [[nodiscard]] std::span<const ShapeInstance> instances() const { return instances_; }
    [[nodiscard]] std::size_t top_level_shapes() const { return top_level_shapes_; }
    /// Labels in use; [0] is the empty label.
    [[nodiscard]] const std::vector<std::string>& object_labels() const { return labels_; }
    [[nodiscard]] const Bounds& bounds() const { return bounds_; }
    /// Of all that light may meet: media too.
    [[nodiscard]] const Bounds& lit_bounds() const { return lit_bounds_; }
    void extend_lit_bounds(const Bounds& box);
    [[nodiscard]] const std::string& isa() const { return isa_; }
    [[nodiscard]] const RenderSpace& space() const { return space_; }
    [[nodiscard]] const ShutterSpan& shutter() const { return shutter_; }
    /// What building left out.
    [[nodiscard]] const std::vector<Error>& warnings() const { return warnings_; }

  private:
    EmbreeScene();
    struct Device;
    Status add_shape(const SceneShape& shape, const Transform& placement, const SceneDescription& scene,
                     TextureTable& textures, bool instanced);
    Status add_surface(const SceneShape& shape, const SceneDescription& scene, TextureTable& textures,
                       ShapeGeometry& geometry);
    static Status mix_in_interface(const SceneShape& shape, TextureId share, TextureTable& textures, ShapeGeometry& g);
    Status add_mesh(const SceneShape& shape, const Transform& placement, const TextureTable& textures,
                    ShapeGeometry& geometry, RTCGeometryTy*& made);
    Status add_curves(const SceneShape& shape, const Transform& placement, ShapeGeometry& geometry,
                      RTCGeometryTy*& made);
    /// An object of instances: its first shape, and the point around which its shapes are kept.
    struct PlacedObject {
        std::uint32_t first_shape = 0;
        DVec3 pivot;
    };
    Status start_device(const Options& options);
    Status add_shapes(const SceneDescription& scene, TextureTable& textures, std::vector<PlacedObject>& objects);
    void attach(RTCSceneTy* target, std::size_t first, std::size_t count);
    Status add_instance(const SceneDescription& scene, std::span<const PlacedObject> objects,
                        const SceneInstance& instance, const Transform& placement, std::int32_t motion,
                        std::uint64_t& surfaces);
    Status add_instances(const SceneDescription& scene, std::span<const PlacedObject> objects);
    Result<std::vector<std::int32_t>> add_motions(const SceneDescription& scene, std::span<const PlacedObject> objects);
    Status check_placements(const SceneDescription& scene, const InstancePlacements& placements, double extent);
    /// Where the instance of a hit stands at its time; null at the top level. `room` is for what moves.
    [[nodiscard]] const Placement* placement_of(const Hit& hit, std::optional<Placement>& room) const {
        if (hit.instance == Hit::none) return nullptr;
        const ShapeInstance& instance = instances_[hit.instance];
        if (instance.motion < 0) [[likely]]
            return &instance.placement;
        return &room.emplace(motions_[static_cast<std::size_t>(instance.motion)].at(hit.time));
    }
    [[nodiscard]] bool traceable(const Ray& ray) const;
    void fetch_primitive(const Hit& hit) const;
    void finish_hits(std::span<const Ray> rays, std::span<Hit> hits) const;
    void finish_hit(const Ray& ray, Hit& hit) const;
    void finish_triangles(const std::array<const Ray*, 2>& rays, const std::array<Hit*, 2>& hits) const;
    int label_index(const std::string& label);
    std::unique_ptr<Device> device_;
    std::vector<ShapeGeometry> shapes_;  // top level, then those of every object in turn
    std::vector<ShapeInstance> instances_;
    std::vector<InstanceMotion> motions_;  // of some instances
    std::vector<std::string> labels_;
    std::size_t top_level_shapes_ = 0;
    Bounds bounds_;
    Bounds lit_bounds_;
    bool is_lit_ = false;  // false: those are of nothing
    Real ray_limit_ =
        largest_coordinate;  // of a ray's numbers, so that they stay in range in every instance's own space
    std::string isa_;
    RenderSpace space_;
    ShutterSpan shutter_;
    std::vector<Error> warnings_;
    mutable RayLog* log_ = nullptr;  // one test a batch; never part of a result
    std::vector<TextureId> surface_shares_;
    bool has_alpha_ = false, has_holdouts_ = false;
    /// Whether shadow rays go to Embree as streams. Whether anything lies on a ray is a matter of that ray and a
    /// triangle at a time, so the answers are those of single rays, whatever stands beside them (geometry_test.cpp).
    /// Closest hits, where the first of equals wins, keep to single rays. On narrower machines streams are slower.
    bool streams_ = false;
};

/// Flushes denormals to zero on the calling thread (row 32 of the hard cases: a throughput that underflows would
/// otherwise stick at a denormal and slow every multiplication).
void flush_denormals();

}  // namespace raylex::transport
