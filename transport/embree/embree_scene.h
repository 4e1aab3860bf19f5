// The scene's shapes and the acceleration structure over them. This is the only interface to Embree: only
// embree_scene.cpp and the sources beside it include its headers, so a new version of Embree affects this folder alone.
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

/// A Shape directive in the form that rendering uses. Meshes point into vertex buffers that Embree owns.
struct ShapeGeometry {
    ShapeKind kind = ShapeKind::triangle_mesh;
    const StoredVec3* positions = nullptr;
    std::vector<Triangle> triangles;
    std::uint32_t primitive_count = 0;
    std::vector<StoredVec3> normals;
    std::vector<StoredVec2> uvs;
    std::vector<StoredVec3> patch_positions;  ///< of bilinear meshes, which Embree does not store
    std::vector<std::uint32_t> patch_indices;
    Quadric quadric;
    CurveBatch curves;
    Matrix34 to_object;  ///< for meshes: from the space of the stored vertices to the space of the shape's parameters
    bool flip_normal = false;
    int material = 0;
    int area_light = -1;  ///< index into SceneDescription::area_lights; -1 also for instanced shapes
    int inside_medium = -1, outside_medium = -1;  ///< indices into MediumTable; -1 = none
    TextureId alpha = -1;                         ///< opacity; -1 = opaque everywhere
    bool interface = false;                       ///< not a surface: rays pass, and no area light shines there
    bool border = false;                          ///< rays that pass change media: interfaces, also mixed ones
    bool hidden = false;                          ///< alpha is 0 everywhere: no ray stops here
    /// The place and normal of a hit depend on the ray's direction (flat curves and tubes), so subpaths of opposite
    /// directions find different points.
    bool faces_rays = false;
    int label = 0;                          ///< index into object_labels()
    bool holdout = false;                   ///< see LabelRule
    std::uint32_t first_light = Hit::none;  ///< set by the light table: the light of primitive 0

    [[nodiscard]] BilinearPatch patch(std::uint32_t primitive) const;
    struct Interval {
        double lower, upper;
    };
    /// Whether the shape is a quadric or patch, which raylex intersects instead of Embree.
    [[nodiscard]] bool is_user() const { return kind != ShapeKind::triangle_mesh && kind != ShapeKind::curves; }
    /// Finds the nearest hit of a patch or quadric within `range` of distances.
    bool intersect(unsigned primitive, const DVec3& origin, const DVec3& direction, const Interval& range, double& t,
                   double& u, double& v) const;
    /// The largest absolute coordinate.
    [[nodiscard]] double extent() const;
    /// The largest distance from the origin at which rays towards this shape may begin. Embree multiplies a triangle's
    /// distance to the ray origin by two of its edges, in single precision.
    [[nodiscard]] double reach_of_rays() const;
    /// The medium that a ray in `direction` enters at a surface whose `normal` points outside, from the medium
    /// `current`. A surface with the same medium on both sides is not a border: rays stay in their medium (pbrt's
    /// rule).
    [[nodiscard]] std::int32_t medium_towards(const Vec3& normal, const Vec3& direction, std::int32_t current) const {
        if (inside_medium == outside_medium) return current;
        return dot(normal, direction) > 0 ? outside_medium : inside_medium;
    }
};

/// SurfacePoint::u and v of a point on a triangle, patch or quadric; `at` contains u and v of the Hit.
[[nodiscard]] Vec2 texture_coordinates(const ShapeGeometry& shape, std::uint32_t primitive, const Vec2& at);

struct ShapeInstance {
    Placement placement;
    std::uint32_t first_shape = 0;    ///< of the placed object
    int label = -1;                   ///< overrides the label of the shapes unless -1
    std::optional<bool> holdout{};    ///< overrides the holdout flag of the shapes
    std::uint32_t first_surface = 0;  ///< surface number of the object's first shape, minus 1
    /// index into the scene's motions, where `placement` is that of time 0; -1: no motion
    std::int32_t motion = -1;
};

/// The source of a surface point: data that integrators need in addition to the SurfacePoint.
struct SurfaceSource {
    OffsetBound offset{};        ///< the distance off the surface at which a leaving ray starts; see ray.h
    std::int32_t label = 0;      ///< index into object_labels()
    std::int32_t object_id = 0;  ///< 1-based: top-level shapes first, then instances
};

/// Data of a hit that only geometric AOVs need, in world space unless noted.
struct SurfaceDetails {
    Vec3 dpdv;                  ///< the derivative by the second texture coordinate; SurfacePoint::dpdu is the first
    Vec3 object_position;       ///< in the space of the shape's parameters
    Real curvature = 0;         ///< mean curvature; positive where the surface bulges towards SurfacePoint::wo
    std::array<Vec3, 8> edges;  ///< of the triangle or patch: start and end of each edge
    int edge_count = 0;         ///< 0 for quadrics and curves
};

/// A length-3 interval in world space.
struct Bounds {
    Vec3 lower, upper;
    [[nodiscard]] Vec3 center() const { return (lower + upper) * 0.5f; }
    [[nodiscard]] Real radius() const { return length(upper - lower) * 0.5f; }
};

/// Rays in the order in which they were traced, batch by batch.
struct RayLog {
    struct Batch {
        std::size_t count = 0;
        bool shadow = false;  ///< traced by occluded()
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
        std::string isa;      ///< one of display::instruction_sets(); "" = the widest that this machine supports
        int threads = 0;      ///< that build the scene; 0 = all
        RenderSpace space{};  ///< the space in which everything is placed, called "world" in this class
        ShutterSpan shutter{};
        /// [material] of MaterialTable; empty: every material is either a surface or an interface
        std::vector<TextureId> surface_shares{};
    };

    /// Builds the scene. Errors name the shape or instance: vertices that are not finite or beyond largest_coordinate,
    /// indices out of range, transforms that are singular or cannot be inverted in float, and Embree's own errors.
    static Result<EmbreeScene> build(const SceneDescription& scene, TextureTable& textures, const Options& options);
    ~EmbreeScene();
    EmbreeScene(EmbreeScene&&) noexcept;
    EmbreeScene& operator=(EmbreeScene&&) noexcept;

    /// Finds the closest hits over (0, t_max). Embree chooses the primitive; raylex computes the place on it, with the
    /// same result on all processors. A ray with a coordinate or direction beyond largest_coordinate, or with NaN, hits
    /// nothing; a shadow ray of that kind counts as blocked. untraced_rays() counts both.
    void intersect(std::span<const Ray> rays, std::span<Hit> hits) const;
    /// Sets blocked[i] to 1 if an opaque shape lies on (0, t_max) of rays[i]; shapes with alpha do not count.
    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const;
    [[nodiscard]] std::uint64_t untraced_rays() const;
    /// Appends every later ray of intersect() and occluded() to `log`, so that a benchmark can trace it again; null
    /// stops the log. For one thread only.
    void record(RayLog* log) const { log_ = log; }
    /// Traces the rays of a log again with nothing but rtcIntersect1 and rtcOccluded1, with the same flags and in the
    /// same order, and returns the number of hits. It omits finish_hits(), which computes the place of each hit.
    [[nodiscard]] std::uint64_t trace_bare(const RayLog& log) const;
    /// Finds the closest hit among the shapes with alpha, for shadow rays that walk through them.
    void intersect_alpha(const Ray& ray, Hit& hit) const;

    /// Converts valid hits to surface points (without random_key) and their sources. `rays[i]` found `hits[i]`.
    void surfaces(std::span<const Ray> rays, std::span<const Hit> hits, std::span<SurfacePoint> points,
                  std::span<SurfaceSource> sources) const;

    /// The tangents at a valid hit, whose point surfaces() computed.
    [[nodiscard]] SurfaceTangents tangents(const Hit& hit, const SurfacePoint& point) const;
    /// The details of a valid hit, whose point surfaces() computed.
    [[nodiscard]] SurfaceDetails details(const Hit& hit, const SurfacePoint& point) const;

    /// The number of the hit surface, from 1: top-level shapes, then the shapes of every instance.
    [[nodiscard]] std::int32_t surface_number(const Hit& hit) const {
        if (hit.instance == Hit::none) return static_cast<std::int32_t>(hit.shape) + 1;
        const ShapeInstance& instance = instances_[hit.instance];
        return static_cast<std::int32_t>(instance.first_surface + (hit.shape - instance.first_shape)) + 1;
    }

    /// Whether rays can pass through any shape (alpha or an interface).
    [[nodiscard]] bool has_alpha() const { return has_alpha_; }
    /// Whether any object is a holdout; with a hit: whether that hit is on one.
    [[nodiscard]] bool has_holdouts() const { return has_holdouts_; }
    [[nodiscard]] bool is_holdout(const Hit& hit) const {
        const bool own = shapes_[hit.shape].holdout;
        return hit.instance == Hit::none ? own : instances_[hit.instance].holdout.value_or(own);
    }
    [[nodiscard]] std::span<const ShapeGeometry> shapes() const { return shapes_; }
    [[nodiscard]] std::span<ShapeGeometry> shapes() { return shapes_; }
    [[nodiscard]] std::span<const ShapeInstance> instances() const { return instances_; }
    [[nodiscard]] std::size_t top_level_shapes() const { return top_level_shapes_; }
    /// All labels in use; [0] is the empty label.
    [[nodiscard]] const std::vector<std::string>& object_labels() const { return labels_; }
    [[nodiscard]] const Bounds& bounds() const { return bounds_; }
    /// The bounds of everything that light can reach, including media.
    [[nodiscard]] const Bounds& lit_bounds() const { return lit_bounds_; }
    void extend_lit_bounds(const Bounds& box);
    [[nodiscard]] const std::string& isa() const { return isa_; }
    [[nodiscard]] const RenderSpace& space() const { return space_; }
    [[nodiscard]] const ShutterSpan& shutter() const { return shutter_; }
    /// Warnings about parts that building omitted.
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
    /// An object of instances: its first shape, and the pivot, from which the coordinates of its shapes are stored.
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
    /// The placement of the instance of a hit at the hit's time; null at the top level. `room` stores the placement of
    /// moving instances.
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
    std::vector<InstanceMotion> motions_;  // of the instances that move
    std::vector<std::string> labels_;
    std::size_t top_level_shapes_ = 0;
    Bounds bounds_;
    Bounds lit_bounds_;
    bool is_lit_ = false;  // false: lit_bounds_ is empty
    Real ray_limit_ =
        largest_coordinate;  // bound on a ray's coordinates that keeps them in range in every instance's own space
    std::string isa_;
    RenderSpace space_;
    ShutterSpan shutter_;
    std::vector<Error> warnings_;
    mutable RayLog* log_ = nullptr;  // tested once per batch; never part of a result
    std::vector<TextureId> surface_shares_;
    bool has_alpha_ = false, has_holdouts_ = false;
    /// Whether shadow rays go to Embree 3 as streams; Embree 4 has none. Occlusion depends on one ray and one triangle
    /// at a time, so streams give the results of single rays, whatever the other rays of the stream
    /// (geometry_test.cpp). Closest hits use single rays, since the first of equal hits wins. On narrower machines
    /// streams are slower.
    bool streams_ = false;
};

}  // namespace raylex::transport
