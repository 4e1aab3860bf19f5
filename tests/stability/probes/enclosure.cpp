// Closed rooms of several shapes whose walls emit 1, scatter kd diffusely and ks as a mirror. Radiance is the same
// along every ray, and the value of an expression follows from its automaton (lpe/truth.h).
#include <array>
#include <cmath>
#include <map>

#include "experiments/invariants/random_expression.h"
#include "lpe/channels/lobe_slots.h"
#include "lpe/truth.h"
#include "tests/stability/probes/probes.h"
#include "transport/import/builder/scene_builder.h"
#include "transport/render/built_scene.h"

namespace raylex::experiments {
namespace {

using namespace transport::typed;
using transport::MeshData;
using transport::StoredVec3;
using transport::Transform;

MeshData box() {
    MeshData mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back({(i & 1) != 0 ? 1.f : -1.f, (i & 2) != 0 ? 1.f : -1.f, (i & 4) != 0 ? 1.f : -1.f});
    mesh.indices = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                    2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5};
    return mesh;
}

MeshData tetrahedron() {
    return {.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
            .indices = {0, 1, 2, 0, 1, 3, 0, 2, 3, 1, 2, 3}};
}

/// An L-shaped room of height 2 with an inner corner that blocks the view. Faces share edges, so there are no gaps.
MeshData corner_room() {
    constexpr std::array<std::array<float, 2>, 6> floor{{{0, 0.3f}, {0, 1}, {-1, 1}, {-1, -1}, {1, -1}, {1, 0.3f}}};
    MeshData mesh;
    for (const float z : {-1.f, 1.f})
        for (const auto& p : floor) mesh.positions.push_back({p[0], p[1], z});
    for (std::uint32_t i = 0; i < 6; ++i) {
        const std::uint32_t next = (i + 1) % 6;
        mesh.indices.insert(mesh.indices.end(), {i, next, next + 6, i, next + 6, i + 6});
        if (i == 0 || i == 5) continue;
        mesh.indices.insert(mesh.indices.end(), {0, i, i + 1 < 6 ? i + 1 : 5, 6, i + 6, i + 7});
    }
    return mesh;
}

/// An icosahedron with each face divided into 16, projected to a sphere of radius 1.
MeshData icosphere() {
    const float a = 0.525731112f, b = 0.850650808f;
    MeshData mesh;
    mesh.positions = {{-a, b, 0},  {a, b, 0},  {-a, -b, 0}, {a, -b, 0}, {0, -a, b},  {0, a, b},
                      {0, -a, -b}, {0, a, -b}, {b, 0, -a},  {b, 0, a},  {-b, 0, -a}, {-b, 0, a}};
    mesh.indices = {0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4,  11, 10, 2,  10, 7, 6, 7, 1, 8,
                    3, 9,  4, 3, 4, 2, 3, 2, 6, 3, 6, 8,  3, 8,  9,  4, 9, 5, 2, 4,  11, 6,  2,  10, 8,  6, 7, 9, 8, 1};
    for (int times = 0; times < 2; ++times) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t i, std::uint32_t k) {
            const auto [found, fresh] =
                middles.emplace(std::minmax(i, k), static_cast<std::uint32_t>(mesh.positions.size()));
            if (fresh) {
                const StoredVec3 &p = mesh.positions[i], &q = mesh.positions[k];
                const StoredVec3 sum{p.x + q.x, p.y + q.y, p.z + q.z};
                const float length = std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
                mesh.positions.push_back({sum.x / length, sum.y / length, sum.z / length});
            }
            return found->second;
        };
        std::vector<std::uint32_t> finer;
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            const std::uint32_t p = mesh.indices[i], q = mesh.indices[i + 1], r = mesh.indices[i + 2];
            const std::uint32_t pq = middle(p, q), qr = middle(q, r), rp = middle(r, p);
            finer.insert(finer.end(), {p, pq, rp, q, qr, pq, r, rp, qr, pq, qr, rp});
        }
        mesh.indices = std::move(finer);
    }
    return mesh;
}

struct Room {
    std::string shape;
    double kd, ks, scale, offset;
    double sheets, kt;  ///< number of sheets, equally spaced from wall to centre, and the transmittance of each

    [[nodiscard]] std::vector<double> radii() const {
        std::vector<double> radii;
        for (double i = 1; i <= sheets; ++i) radii.push_back(i / (sheets + 1));
        return radii;
    }
};

Result<transport::SceneDescription> scene_of(const Room& room, const SourceLocation& where) {
    const Transform place = Transform::translate(0.8 * room.offset * room.scale, -0.5 * room.offset * room.scale,
                                                 0.3 * room.offset * room.scale) *
                            Transform::scale(room.scale, room.scale, room.scale);
    transport::SceneBuilder scene("enclosure");
    const auto fails = [](const Status& status) { return !status.ok(); };
    if (Status s = scene.set_film("rgb", {integer("xresolution", 6), integer("yresolution", 6)}); fails(s))
        return s.error();
    if (Status s = scene.set_sampler("independent", {}); fails(s)) return s.error();
    if (Status s = scene.set_filter("box", {}); fails(s)) return s.error();
    const Transform view = Transform::look_at({0.1, 0.05, 0.1}, {-0.2, -0.3, -1}, {0, 1, 0}) * place.inverse();
    if (Status s = scene.set_camera("perspective", {real("fov", 100)}, view); fails(s)) return s.error();
    const auto walls = scene.add_material("raylex:diffuse-mirror", {rgb("diffuse", {room.kd, room.kd, room.kd}),
                                                                    rgb("specular", {room.ks, room.ks, room.ks})});
    if (!walls) return walls.error();
    const auto light = scene.add_area_light("diffuse", {rgb("L", {1, 1, 1}), boolean("twosided", true)});
    if (!light) return light.error();
    const transport::ShapePlacement placement{.to_world = place, .material = *walls, .area_light = *light};
    Status added = success();
    if (room.shape == "sphere") added = scene.add_shape("sphere", {real("radius", 1)}, placement);
    else if (room.shape == "box") added = scene.add_mesh(box(), placement);
    else if (room.shape == "tetrahedron") added = scene.add_mesh(tetrahedron(), placement);
    else if (room.shape == "icosphere") added = scene.add_mesh(icosphere(), placement);
    else if (room.shape == "corner") added = scene.add_mesh(corner_room(), placement);
    else
        return error_at(where, "unknown shape of an enclosure '" + room.shape +
                                   "'; expected box, sphere, icosphere, tetrahedron or corner");
    if (!added) return added.error();
    const auto sheet = scene.add_material("raylex:sheet", {rgb("transmittance", {room.kt, room.kt, room.kt})});
    if (!sheet) return sheet.error();
    for (const double radius : room.radii())
        if (Status s = scene.add_shape("sphere", {real("radius", radius)}, {.to_world = place, .material = *sheet});
            fails(s))
            return s.error();
    return scene.finish();
}

lpe::Enclosure enclosure_of(const Room& room, std::uint64_t max_depth) {
    const lpe::LobeSlots slots;
    lpe::Enclosure enclosure;
    const auto event = [&](lpe::EventType type, lpe::Scatter scatter, const char* lobe, double albedo) {
        return lpe::WeightedEvent{{type, scatter, slots.number(scatter, lobe), {"", lobe}}, albedo};
    };
    enclosure.scattering = {event(lpe::EventType::reflection, lpe::Scatter::diffuse, "diffuse", room.kd),
                            event(lpe::EventType::reflection, lpe::Scatter::singular, "mirror", room.ks)};
    enclosure.sheets = {event(lpe::EventType::transmission, lpe::Scatter::singular, "sheet", room.kt), room.radii()};
    enclosure.terminals = {{{lpe::EventType::light, lpe::Scatter::none, 0, {""}}, 1}};
    enclosure.max_depth = max_depth;
    return enclosure;
}

/// Removes paths that the light tracer cannot find, which the camera sees in a mirror.
std::string found_by(const std::string& integrator, const std::string& expression) {
    return integrator == "lighttracer" ? "(" + expression + ")-C<RS>.*" : expression;
}

/// Returns the `index`-th of the random expressions that match some but not all light.
Result<std::string> random_one(double index, const std::string& integrator, const lpe::Enclosure& enclosure) {
    const auto first = static_cast<std::uint64_t>(index) * 1000;
    for (std::uint64_t seed = first; seed < first + 1000; ++seed) {
        const std::string expression = found_by(integrator, random_expression(seed));
        lpe::ChannelSource source;
        source.expression = expression;
        const auto truth = lpe::enclosure_truth(source, enclosure);
        if (truth && truth->value > 0.01 && truth->value < 1.9) return expression;
    }
    return error_at({}, "no random expression matches only a part of the light");
}

Result<ProbeResult> enclosure(const ProbeInput& input) {
    const Room room{input.word("shape", "box"), input.number("kd", 0.4),   input.number("ks", 0.2),
                    input.number("scale", 1),   input.number("offset", 0), input.number("sheets", 0),
                    input.number("kt", 0.8)};
    if (room.sheets > 0 && room.shape != "sphere")
        return error_at(input.where(), "sheets are supported only in a 'sphere', not in a '" + room.shape + "'");
    const std::string integrator = input.word("integrator", "path");
    const auto depth = static_cast<std::int64_t>(input.number("depth", 6));
    const lpe::Enclosure truth_of = enclosure_of(room, static_cast<std::uint64_t>(depth));
    const double random = input.number("random", -1);
    Result<std::string> expression =
        random >= 0 ? random_one(random, integrator, truth_of) : found_by(integrator, input.word("expression", "C.*L"));
    if (!expression) return expression.error();
    lpe::ChannelSource source;
    source.expression = *expression;
    const auto truth = lpe::enclosure_truth(source, truth_of);
    if (!truth) return truth.error();
    const auto scene = scene_of(room, input.where());
    if (!scene) return scene.error();
    const auto built = transport::BuiltScene::build(*scene, {.threads = 1});
    if (!built) return built.error();

    transport::RenderSettings settings;
    settings.machine.threads = 1;
    settings.samples.per_pixel = static_cast<std::uint64_t>(input.number("spp", 128));
    settings.paths.max_depth = depth;
    settings.paths.integrator.emplace().type = integrator;
    settings.channels.beauty = false;
    display::ChannelDefinition& channel = settings.channels.list.emplace_back();
    channel.name = "expression";
    channel.style = display::ChannelStyle::expression;
    channel.expression = *expression;
    channel.statistics = false;
    const auto seeds = static_cast<std::uint64_t>(input.number("seeds", 8));
    std::vector<double> means;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        settings.samples.seed = seed;
        const auto output = transport::render(**built, settings);
        if (!output) return output.error();
        double sum = 0;
        const std::vector<double> image = output->frame_buffer.resolve(0);
        for (const double value : image) sum += value;
        means.push_back(sum / double(image.size()));
    }
    ProbeResult result;
    for (const double mean : means) result.measured += mean / double(means.size());
    double squares = 0;
    for (const double mean : means) squares += (mean - result.measured) * (mean - result.measured);
    result.standard_error = std::sqrt(squares / (double(means.size()) * double(means.size() - 1)));
    result.degrees = double(means.size() - 1);
    result.expected = truth->value;
    result.note = *expression;
    return result;
}

}  // namespace

std::span<const NamedProbe> enclosure_probes() {
    static constexpr NamedProbe table[] = {
        {"enclosure",
         "value of an expression in a closed room that emits 1 everywhere; shape (box, sphere, icosphere, "
         "tetrahedron, corner), kd, ks, scale, offset in sizes of the room, sheets (number of spheres in the sphere), "
         "kt (transmittance of each), integrator, expression or random (its "
         "number), depth, spp, seeds",
         enclosure}};
    return table;
}

}  // namespace raylex::experiments
