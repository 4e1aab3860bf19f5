#include "transport/embree/embree_scene.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "display/services/processor.h"
#include "transport/embree/displacement.h"
#include "transport/embree/embree_device.h"
#include "transport/embree/scene_limits.h"
#include "transport/geometry/shapes/placed_mesh.h"

namespace raylex::transport {
namespace {

constexpr std::uint64_t most_surfaces = 0x7fffffff;  // the largest object id in an image
void report_error(void* user, RTCError, const char* text) {
    auto* log = static_cast<EmbreeErrorLog*>(user);
    const std::lock_guard lock(log->mutex);
    if (log->message.empty()) log->message = text ? text : "unknown error";
}

}  // namespace

EmbreeScene::EmbreeScene() : labels_{std::string()} {}
EmbreeScene::~EmbreeScene() = default;
EmbreeScene::EmbreeScene(EmbreeScene&&) noexcept = default;
EmbreeScene& EmbreeScene::operator=(EmbreeScene&&) noexcept = default;

BilinearPatch ShapeGeometry::patch(std::uint32_t primitive) const {
    const std::uint32_t* i = patch_indices.data() + 4 * static_cast<std::size_t>(primitive);
    return {DVec3(patch_positions[i[0]]), DVec3(patch_positions[i[1]]), DVec3(patch_positions[i[2]]),
            DVec3(patch_positions[i[3]])};
}

int EmbreeScene::label_index(const std::string& label) {
    const auto found = std::find(labels_.begin(), labels_.end(), label);
    if (found != labels_.end()) return static_cast<int>(found - labels_.begin());
    labels_.push_back(label);
    return static_cast<int>(labels_.size()) - 1;
}

/// Sets the opacity, interface and media of a shape from its material and alpha.
Status EmbreeScene::add_surface(const SceneShape& shape, const SceneDescription& scene, TextureTable& textures,
                                ShapeGeometry& g) {
    const auto material = static_cast<std::size_t>(g.material);
    if (material >= scene.materials.size() && material > 0)
        return error_at(shape.location, "the shape's material is not defined");
    g.interface = material < scene.materials.size() &&
                  (scene.materials[material].type == "interface" || scene.materials[material].type.empty());
    if (g.interface) {
        g.alpha = textures.add_constant(Rgb(0));
    } else if (!shape.alpha_texture.empty()) {
        auto id = textures.named_real(shape.alpha_texture, shape.location);
        if (!id) return id.error();
        g.alpha = *id;
    } else if (shape.alpha < 1) {
        g.alpha = textures.add_constant(Rgb(std::max(shape.alpha, Real(0))));
    }
    if (const TextureId share = material < surface_shares_.size() ? surface_shares_[material] : -1; share >= 0)
        if (Status s = mix_in_interface(shape, share, textures, g); !s) return s;
    g.border = g.border || g.interface;
    has_alpha_ = has_alpha_ || g.alpha >= 0;
    g.hidden = !g.interface && g.alpha >= 0 && textures.is_constant(g.alpha) && textures.real(g.alpha, {}) <= 0;
    return success();
}

/// Makes the share of the material that is an interface transparent to rays, like a cutout.
Status EmbreeScene::mix_in_interface(const SceneShape& shape, TextureId share, TextureTable& textures,
                                     ShapeGeometry& g) {
    g.border = true;
    if (g.alpha < 0) {
        g.alpha = share;
        return success();
    }
    // Only the part that a ray passes, cutout or interface, decides whether it changes media; shadow rays cannot
    // separate them.
    if (g.inside_medium != g.outside_medium)
        return error_at(shape.location,
                        "the shape has 'alpha', a mix with an interface and other media on its two sides; expected two "
                        "of these three at most");
    auto both = textures.add_mix(textures.add_constant(Rgb(0)), g.alpha, share);
    if (!both) return error_at(shape.location, "alpha and a mix with an interface: " + both.error().message);
    g.alpha = *both;
    return success();
}

/// Makes the geometry of a mesh with its vertices in the world; `made` stays null for a mesh without faces, and for
/// patches, which are user geometry.
Status EmbreeScene::add_mesh(const SceneShape& shape, const Transform& placement, const TextureTable& textures,
                             ShapeGeometry& g, RTCGeometryTy*& made) {
    const std::size_t corners = shape.kind == ShapeKind::triangle_mesh ? 3 : 4;
    if (Status s = check_mesh(shape, corners); !s) return s;
    if (!shape.displacement_texture.empty()) {
        const auto displaced = displaced_mesh(shape, placement, textures);
        if (!displaced) return displaced.error();
        return add_mesh(*displaced, placement, textures, g, made);
    }
    auto mesh = place_mesh(shape, placement);
    if (!mesh) return mesh.error();
    if (Status s = check_extent(shape, mesh->positions); !s) return s;
    if (mesh->dropped > 0)
        warnings_.push_back(error_at(shape.location, std::to_string(mesh->dropped) + " of the faces of " +
                                                         mesh_name(shape) +
                                                         " have no area in single precision at their place and are "
                                                         "left out"));
    g.normals = std::move(mesh->normals);
    g.uvs = shape.uvs;
    g.primitive_count = static_cast<std::uint32_t>(mesh->indices.size() / corners);
    if (shape.kind == ShapeKind::bilinear_mesh) {
        g.patch_positions = std::move(mesh->positions);
        g.patch_indices = std::move(mesh->indices);
        return success();
    }
    if (g.primitive_count == 0) return success();
    RTCGeometry geometry = rtcNewGeometry(device_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(StoredVec3),
                                             mesh->positions.size());
    if (!vertices) {
        rtcReleaseGeometry(geometry);
        return error_at(shape.location, "not enough memory for the mesh");
    }
    std::memcpy(vertices, mesh->positions.data(), mesh->positions.size() * sizeof(StoredVec3));
    g.positions = static_cast<const StoredVec3*>(vertices);
    g.triangles.reserve(g.primitive_count);
    for (const std::uint32_t* i = mesh->indices.data(); g.triangles.size() < g.primitive_count; i += 3)
        g.triangles.push_back(make_triangle({i[0], i[1], i[2]}, g.positions));
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, g.triangles.data(),
                               offsetof(Triangle, corners), sizeof(Triangle), g.primitive_count);
    made = geometry;
    return success();
}

/// Makes the geometry of curves; `made` stays null if no segment is left.
Status EmbreeScene::add_curves(const SceneShape& shape, const Transform& placement, ShapeGeometry& g,
                               RTCGeometryTy*& made) {
    auto placed = place_curves(shape, placement);
    if (!placed) return placed.error();
    if (Status s = check_extent(shape, placed->extent); !s) return s;
    if (placed->widths_are_means)
        warnings_.push_back(
            error_at(shape.location,
                     "the transform of curves does not keep circles; their widths are scaled by the mean of "
                     "its scales"));
    if (placed->dropped > 0)
        warnings_.push_back(error_at(shape.location, std::to_string(placed->dropped) +
                                                         " segments of curves have no length or no width and are left "
                                                         "out"));
    g.curves.type = shape.curve_type;
    g.faces_rays = shape.curve_type != CurveType::ribbon;
    g.curves.first_points = placed->first_points;
    g.curves.splits = placed->splits;
    g.curves.extent = placed->extent;
    g.curves.mirrored = placement.swaps_handedness();
    g.curves.reversed = shape.flip_normal != g.curves.mirrored;
    g.primitive_count = static_cast<std::uint32_t>(g.curves.first_points.size()) * placed->splits;
    if (g.primitive_count == 0) return success();
    constexpr RTCGeometryType types[] = {RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE, RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE,
                                         RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BEZIER_CURVE};
    RTCGeometry geometry = rtcNewGeometry(device_->device, types[static_cast<std::size_t>(shape.curve_type)]);
    PlacedCurves split;
    if (placed->splits > 1) split = split_curves(*placed);
    const PlacedCurves& traced = placed->splits > 1 ? split : *placed;
    const auto fill = [&](RTCBufferType type, RTCFormat format, const auto& values) -> const void* {
        const std::size_t each = sizeof values[0];
        void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, each, values.size());
        if (buffer) std::memcpy(buffer, values.data(), values.size() * each);
        return buffer;
    };
    const void *points = fill(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, traced.points), *normals = points;
    if (!traced.normals.empty()) normals = fill(RTC_BUFFER_TYPE_NORMAL, RTC_FORMAT_FLOAT3, traced.normals);
    if (!points || !normals || !fill(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, traced.first_points)) {
        rtcReleaseGeometry(geometry);
        return error_at(shape.location, "not enough memory for the curves");
    }
    if (placed->splits > 1) {
        g.curves.own_points = std::move(placed->points);
        g.curves.own_normals = std::move(placed->normals);
        points = g.curves.own_points.data();
        normals = g.curves.own_normals.data();
    }
    g.curves.points = static_cast<const CurvePoint*>(points);
    if (shape.curve_type == CurveType::ribbon) g.curves.normals = static_cast<const StoredVec3*>(normals);
    if (shape.curve_type == CurveType::flat)
        rtcSetGeometryTessellationRate(geometry, static_cast<float>(placed->pieces));
    made = geometry;
    return success();
}

Status EmbreeScene::add_shape(const SceneShape& shape, const Transform& placement, const SceneDescription& scene,
                              TextureTable& textures, bool instanced) {
    ShapeGeometry g;
    g.kind = shape.kind;
    g.flip_normal = shape.flip_normal;
    g.material = std::max(shape.material, 0);
    g.area_light = instanced ? -1 : shape.area_light;
    g.inside_medium = shape.inside_medium;
    g.outside_medium = shape.outside_medium;
    g.label = label_index(shape.label);
    g.holdout = shape.holdout;
    has_holdouts_ = has_holdouts_ || shape.holdout;
    if (Status s = add_surface(shape, scene, textures, g); !s) return s;
    g.to_object = Placement(placement).to_object;
    RTCGeometry geometry = nullptr;
    if (shape.kind == ShapeKind::triangle_mesh || shape.kind == ShapeKind::bilinear_mesh) {
        if (Status s = add_mesh(shape, placement, textures, g, geometry); !s) return s;
    } else if (shape.kind == ShapeKind::curves) {
        if (Status s = add_curves(shape, placement, g, geometry); !s) return s;
    } else {
        if (Status s = check_quadric(shape); !s) return s;
        g.primitive_count = 1;
        g.quadric = Quadric(shape, placement);
        if (Status s = check_extent(shape, g.quadric.extent()); !s) return s;
    }
    if (g.primitive_count > 0 && g.is_user()) { geometry = new_user_geometry(device_->device, g.primitive_count); }
    if (geometry) rtcSetGeometryMask(geometry, g.alpha >= 0 ? alpha_mask : opaque_mask);
    shapes_.push_back(std::move(g));
    device_->geometries.push_back(geometry);
    return success();
}

/// Checks placements before instances are made.
Status EmbreeScene::check_placements(const SceneDescription& scene, const InstancePlacements& placements,
                                     double extent) {
    std::vector<std::optional<Bounds>> objects;
    for (RTCScene object : device_->objects) {
        RTCBounds b{};
        rtcGetSceneBounds(object, &b);
        const bool empty = !(b.lower_x <= b.upper_x);
        objects.push_back(
            empty ? std::nullopt
                  : std::optional<Bounds>({{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}}));
    }
    auto limit = limit_of_rays(scene, {shapes_, objects, placements}, extent);
    if (!limit) return limit.error();
    ray_limit_ = *limit;
    return success();
}

/// Starts Embree with the requested instruction set, or with the widest one of this machine that works.
Status EmbreeScene::start_device(const Options& options) {
    std::vector<std::string> sets = display::instruction_sets();
    if (options.isa.empty()) std::erase_if(sets, [](const std::string& set) { return !display::supports(set); });
    else if (std::find(sets.begin(), sets.end(), options.isa) == sets.end())
        return error_at(
            {"--isa", 0, 0},
            "unknown instruction set '" + options.isa + "'; expected " + std::string(display::instruction_set_names),
            near_miss(options.isa, sets));
    else sets = {options.isa};
    device_ = std::make_unique<Device>();
    // The instruction set that Embree would choose is requested by name, so that the recorded name gives the same bits
    // later.
    for (const std::string& isa : sets) {
        std::string config = "set_affinity=0,isa=" + isa;
        if (options.threads > 0) config += ",threads=" + std::to_string(options.threads);
        isa_ = isa;
        device_->device = rtcNewDevice(config.c_str());
        if (device_->device) break;
    }
    streams_ = isa_ == "avx2" || isa_ == "avx512";
    if (!device_->device)
        return error_at({}, "Embree could not be started (error " + std::to_string(rtcGetDeviceError(nullptr)) +
                                "); does this machine offer the instruction set '" + isa_ + "'?");
    rtcSetDeviceErrorFunction(device_->device, report_error, &device_->log);
    return check_features(device_->device);
}

/// Adds all shapes, top level first; `objects` receives the shapes of each object.
Status EmbreeScene::add_shapes(const SceneDescription& scene, TextureTable& textures,
                               std::vector<PlacedObject>& objects) {
    std::size_t total = scene.shapes.size();
    for (const SceneObject& object : scene.objects) total += object.shapes.size();
    shapes_.reserve(total);  // Embree keeps pointers to the elements: attach()
    top_level_shapes_ = scene.shapes.size();
    for (const SceneShape& shape : scene.shapes)
        if (Status s = add_shape(shape, space_.placed(shape.object_to_world), scene, textures, false); !s) return s;
    for (const SceneObject& object : scene.objects) {
        const RenderSpace around{pivot_of(object)};
        objects.push_back({static_cast<std::uint32_t>(shapes_.size()), around.origin});
        for (const SceneShape& shape : object.shapes)
            if (Status s = add_shape(shape, around.placed(shape.object_to_world), scene, textures, true); !s) return s;
    }
    return success();
}

/// Attaches the shapes [first, first + count) to `target`, numbered from 0.
void EmbreeScene::attach(RTCSceneTy* target, std::size_t first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        RTCGeometry geometry = device_->geometries[first + i];
        if (!geometry) continue;
        rtcSetGeometryUserData(geometry, &shapes_[first + i]);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(target, geometry, static_cast<unsigned>(i));
    }
}

/// Adds an instance after the previous ones; `surfaces` is the number of surfaces so far.
Status EmbreeScene::add_instance(const SceneDescription& scene, std::span<const PlacedObject> objects,
                                 const SceneInstance& instance, const Transform& placement, std::int32_t motion,
                                 std::uint64_t& surfaces) {
    if (instance.object < 0 || static_cast<std::size_t>(instance.object) >= objects.size())
        return error_at(instance.location, "instance of an object that is not defined");
    if (!instance.to_world.invertible()) return error_at(instance.location, "the instance's transform has no inverse");
    const auto object = static_cast<std::size_t>(instance.object);
    ShapeInstance placed{Placement(placement),
                         objects[object].first_shape,
                         instance.label.empty() ? -1 : label_index(instance.label),
                         instance.holdout,
                         static_cast<std::uint32_t>(surfaces),
                         motion};
    surfaces += scene.objects[object].shapes.size();
    if (surfaces > most_surfaces)
        return error_at(instance.location, "the instances hold more than " + std::to_string(most_surfaces) +
                                               " shapes; expected no more in a scene");
    has_holdouts_ = has_holdouts_ || instance.holdout.value_or(false);
    RTCGeometry geometry = rtcNewGeometry(device_->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, device_->objects[object]);
    const auto set_transform = [&](std::size_t step, const Matrix34& to_world) {
        float columns[12];
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t r = 0; r < 3; ++r) columns[3 * c + r] = static_cast<float>(to_world.m[r][c]);
        rtcSetGeometryTransform(geometry, static_cast<unsigned>(step), RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
    };
    if (motion >= 0) {
        const std::vector<Matrix34>& keys = motions_[static_cast<std::size_t>(motion)].keys();
        rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(keys.size()));
        for (std::size_t step = 0; step < keys.size(); ++step) set_transform(step, keys[step]);
    } else {
        set_transform(0, placed.placement.to_world);
    }
    rtcSetGeometryMask(geometry, any_mask);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(device_->scene, geometry, static_cast<unsigned>(top_level_shapes_ + instances_.size()));
    rtcReleaseGeometry(geometry);
    instances_.push_back(placed);
    return success();
}

/// Returns, for each instance, its index in motions_ or -1; an empty vector if nothing moves.
Result<std::vector<std::int32_t>> EmbreeScene::add_motions(const SceneDescription& scene,
                                                           std::span<const PlacedObject> objects) {
    std::vector<std::int32_t> motions;
    if (std::none_of(scene.instances.begin(), scene.instances.end(),
                     [](const SceneInstance& each) { return each.motion >= 0; }))
        return motions;
    motions.assign(scene.instances.size(), -1);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const SceneInstance& instance = scene.instances[i];
        const auto object = static_cast<std::size_t>(instance.object);
        if (instance.motion < 0 || instance.object < 0 || object >= objects.size()) continue;
        const auto motion = motion_of(scene, instance);
        if (!motion) return motion.error();
        RTCBounds b{};
        rtcGetSceneBounds(device_->objects[object], &b);
        const DBounds box{{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
        motions[i] = static_cast<std::int32_t>(motions_.size());
        motions_.emplace_back(
            [&](double time) { return space_.placed((*motion)->at(shutter_.way(time)), objects[object].pivot); }, box);
    }
    return motions;
}

/// Adds all instances after their placements have been checked.
Status EmbreeScene::add_instances(const SceneDescription& scene, std::span<const PlacedObject> objects) {
    if (Status apart = check_coincident(scene); !apart) return apart;
    double extent = extent_without_shapes(scene, space_);
    for (std::size_t i = 0; i < top_level_shapes_; ++i) extent = std::max(extent, shapes_[i].extent());
    const auto motions = add_motions(scene, objects);
    if (!motions) return motions.error();
    const auto motion = [&](std::size_t i) { return motions->empty() ? -1 : (*motions)[i]; };
    const auto placement = [&](std::size_t i, std::size_t step) {
        if (motion(i) >= 0) return motions_[static_cast<std::size_t>(motion(i))].keys()[step].transform();
        const SceneInstance& instance = scene.instances[i];
        const auto object = static_cast<std::size_t>(instance.object);
        const bool defined = instance.object >= 0 && object < objects.size();
        return space_.placed(instance.to_world, defined ? objects[object].pivot : DVec3());
    };
    const auto count = [&](std::size_t i) {
        return motion(i) < 0 ? 1 : motions_[static_cast<std::size_t>(motion(i))].keys().size();
    };
    if (Status s = check_placements(scene, {placement, count}, extent); !s) return s;
    std::uint64_t surfaces = top_level_shapes_;
    instances_.reserve(scene.instances.size());
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        if (Status s = add_instance(scene, objects, scene.instances[i], placement(i, 0), motion(i), surfaces); !s)
            return s;
    return success();
}

Result<EmbreeScene> EmbreeScene::build(const SceneDescription& scene, TextureTable& textures, const Options& options) {
    EmbreeScene result;
    result.space_ = options.space;
    result.shutter_ = options.shutter;
    result.surface_shares_ = options.surface_shares;
    if (Status s = result.start_device(options); !s) return s.error();
    std::vector<PlacedObject> objects;
    if (Status s = result.add_shapes(scene, textures, objects); !s) return s.error();
    Device& device = *result.device_;
    device.scene = device.new_scene();
    result.attach(device.scene, 0, result.top_level_shapes_);
    for (std::size_t k = 0; k < objects.size(); ++k) {
        device.objects.push_back(device.new_scene());
        result.attach(device.objects.back(), objects[k].first_shape, scene.objects[k].shapes.size());
        rtcCommitScene(device.objects.back());
    }
    if (Status s = result.add_instances(scene, objects); !s) return s.error();
    rtcCommitScene(device.scene);
    RTCBounds b{};
    rtcGetSceneBounds(device.scene, &b);
    if (b.lower_x <= b.upper_x) {
        result.bounds_ = {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
        result.extend_lit_bounds(result.bounds_);
    }
    if (!device.log.message.empty()) return error_at({scene.file, 0, 0}, "Embree: " + device.log.message);
    return result;
}

void EmbreeScene::extend_lit_bounds(const Bounds& box) {
    const auto each = [](const Vec3& a, const Vec3& b, auto pick) {
        return Vec3{pick(a.x, b.x), pick(a.y, b.y), pick(a.z, b.z)};
    };
    const Bounds before = is_lit_ ? lit_bounds_ : box;
    lit_bounds_ = {each(before.lower, box.lower, [](Real a, Real b) { return std::min(a, b); }),
                   each(before.upper, box.upper, [](Real a, Real b) { return std::max(a, b); })};
    is_lit_ = true;
}

}  // namespace raylex::transport
