#include "experiments/inspect/scene_facts.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>

#include "experiments/job/rendering/effect_report.h"
#include "experiments/program/console.h"
#include "transport/render/film.h"
#include "transport/scene/sampler.h"
#include "transport/scene/surface_names.h"

namespace raylex::experiments {
namespace {

using transport::SceneDescription;
using transport::SceneShape;
using transport::ShapeKind;

/// Counts kinds, in the order in which they first appear.
class KindCounter {
  public:
    void add(const std::string& kind, std::uint64_t count = 1) {
        const auto [at, fresh] = place_.try_emplace(kind, counts_.size());
        if (fresh) counts_.push_back({kind, 0});
        counts_[at->second].count += count;
    }
    [[nodiscard]] std::vector<KindCount> take() { return std::move(counts_); }

  private:
    std::map<std::string, std::size_t> place_;
    std::vector<KindCount> counts_;
};

std::uint64_t primitive_count(const SceneShape& shape) {
    if (shape.kind == ShapeKind::triangle_mesh) return shape.indices.size() / 3;
    if (shape.kind == ShapeKind::bilinear_mesh) return shape.indices.size() / 4;
    if (shape.kind == ShapeKind::curves) return shape.indices.size();
    return 1;
}

const char* primitive_name(ShapeKind kind) {
    if (kind == ShapeKind::triangle_mesh) return "triangle";
    if (kind == ShapeKind::curves) return "curve";
    return kind == ShapeKind::bilinear_mesh ? "patch" : "quadric";
}

template <class Entities>
std::vector<KindCount> by_type(const Entities& entities) {
    KindCounter counter;
    for (const auto& each : entities) counter.add(each.type.empty() ? "interface" : each.type);
    return counter.take();
}

void add_shapes(const SceneDescription& scene, SceneFacts& facts) {
    KindCounter shapes, primitives;
    std::set<std::string> labels;
    const auto add = [&](const SceneShape& shape) {
        shapes.add(transport::shape_type_name(shape.kind));
        primitives.add(primitive_name(shape.kind), primitive_count(shape));
        if (!shape.label.empty()) labels.insert(shape.label);
        facts.mesh_bytes += (shape.positions.size() + shape.normals.size()) * sizeof(transport::StoredVec3) +
                            (shape.uvs.size() + shape.curve_widths.size()) * sizeof(transport::StoredVec2) +
                            shape.indices.size() * sizeof(std::uint32_t);
    };
    for (const SceneShape& shape : scene.shapes) {
        add(shape);
        facts.rendered += primitive_count(shape);
        if (shape.area_light >= 0) facts.emitters += primitive_count(shape);
    }
    std::vector<std::uint64_t> of_object;
    for (const transport::SceneObject& object : scene.objects) {
        std::uint64_t count = 0;
        for (const SceneShape& shape : object.shapes) add(shape), count += primitive_count(shape);
        of_object.push_back(count);
    }
    for (const transport::SceneInstance& instance : scene.instances) {
        if (instance.object >= 0) facts.rendered += of_object[static_cast<std::size_t>(instance.object)];
        if (!instance.label.empty()) labels.insert(instance.label);
    }
    facts.shapes = shapes.take();
    facts.primitives = primitives.take();
    facts.labels.assign(labels.begin(), labels.end());
}

std::string kinds_text(const std::vector<KindCount>& kinds) {
    std::string text;
    for (const KindCount& each : kinds)
        text += (text.empty() ? "" : ", ") + std::to_string(each.count) + " " + each.kind;
    return text.empty() ? "none" : text;
}

std::string names_text(const std::vector<std::string>& names, std::size_t most) {
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i > 0 ? ", " : "") + names[i];
    if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
    return text.empty() ? "none" : text;
}

std::string or_default(const std::string& type) {
    return type.empty() ? "not given" : type;
}

std::string point_text(const double (&p)[3]) {
    return "(" + number_text(p[0], 6) + ", " + number_text(p[1], 6) + ", " + number_text(p[2], 6) + ")";
}

/// Returns the materials in use: all, but without the default material if every shape has another one.
std::span<const transport::SceneEntity> materials_in_use(const SceneDescription& scene) {
    const auto by_default = [](const SceneShape& shape) { return shape.material <= 0; };
    bool used = std::any_of(scene.shapes.begin(), scene.shapes.end(), by_default);
    for (const transport::SceneObject& object : scene.objects)
        used = used || std::any_of(object.shapes.begin(), object.shapes.end(), by_default);
    return std::span(scene.materials).subspan(used || scene.materials.empty() ? 0 : 1);
}

/// Returns a coordinate of a bound. The intersector moves bounds at 0 by the smallest float.
double coordinate(float rendered, double origin) {
    return (std::abs(rendered) <= std::numeric_limits<float>::min() ? 0.0 : double{rendered}) + origin;
}

std::string medium_text(const MediumFact& medium) {
    if (!medium.emits) return medium.name + (medium.scatters ? " (scatters)" : " (absorbs)");
    return medium.name + (medium.scatters ? " (scatters, emits)" : " (emits)");
}

/// Returns all media in use except vacuum and the insides of subsurface materials.
std::vector<MediumFact> named_media(const transport::MediumTable& media) {
    std::vector<MediumFact> facts;
    for (std::size_t i = 0; i < media.size(); ++i) {
        const transport::Medium& medium = media[static_cast<std::int32_t>(i)];
        const bool is_vacuum = medium.grid == nullptr && medium.sigma_t == Rgb{} && !medium.emits;
        if (!medium.in_body && !is_vacuum) facts.push_back({media.names()[i], medium.scatters, medium.emits});
    }
    return facts;
}

Json json_of(const std::vector<KindCount>& kinds) {
    Json json = Json::object();
    for (const KindCount& each : kinds) json[each.kind] = each.count;
    return json;
}

}  // namespace

SceneFacts scene_facts(const SceneDescription& scene) {
    SceneFacts facts;
    facts.file = scene.file;
    facts.objects = scene.objects.size();
    facts.instances = scene.instances.size();
    add_shapes(scene, facts);
    facts.materials = by_type(materials_in_use(scene));
    facts.textures = by_type(scene.textures);
    facts.media = by_type(scene.media);
    facts.lights = by_type(scene.lights);
    if (!scene.area_lights.empty()) facts.lights.push_back({"area", scene.area_lights.size()});
    facts.emitters += scene.lights.size();
    std::set<std::string> groups;
    for (const transport::SceneLight& light : scene.lights) groups.insert(light.group);
    for (const transport::SceneAreaLight& light : scene.area_lights) groups.insert(light.group);
    groups.erase("");
    facts.light_groups.assign(groups.begin(), groups.end());
    facts.camera = scene.camera.type;
    facts.film = scene.film.type;
    facts.filter = scene.filter.type;
    facts.sampler = scene.sampler.type;
    if (const auto choice = transport::choose_sampler(scene.sampler); choice && choice->stands_in)
        facts.sampler += " (rendered with " + choice->name + ")";
    facts.integrator = scene.integrator.type;
    std::vector<Error> ignored;  // the render reports these errors
    if (const auto film = transport::read_film(scene.film, std::nullopt, ignored))
        facts.width = film->width, facts.height = film->height;
    facts.effects = transport::analyse_effects(scene);
    for (const Error& warning : scene.warnings) facts.warnings.push_back(warning.to_string());
    return facts;
}

void add_built_facts(const transport::BuiltScene& built, SceneFacts& facts) {
    facts.is_built = true;
    const transport::EmbreeScene& geometry = *built.view().geometry;
    const transport::Bounds& bounds = geometry.bounds();
    facts.is_empty = facts.rendered == 0;
    const transport::DVec3& origin = built.space().origin;
    const double to_world[3] = {origin.x, origin.y, origin.z};
    for (int i = 0; i < 3; ++i) {
        facts.lower[i] = coordinate(bounds.lower[i], to_world[i]);
        facts.upper[i] = coordinate(bounds.upper[i], to_world[i]);
    }
    facts.build_seconds = built.build_seconds;
    facts.grid_bytes = built.view().media->grid_bytes();
    facts.media_by_name = named_media(*built.view().media);
    for (const Error& warning : built.warnings) {
        const std::string text = warning.to_string();
        if (std::find(facts.warnings.begin(), facts.warnings.end(), text) == facts.warnings.end())
            facts.warnings.push_back(text);
    }
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    facts.peak_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::vector<std::string> lines_of(const SceneFacts& facts) {
    std::vector<std::string> lines{facts.file};
    const auto line = [&](std::string name, const std::string& value) {
        name.resize(14, ' ');
        lines.push_back("  " + name + value);
    };
    line("shapes", kinds_text(facts.shapes));
    line("primitives", kinds_text(facts.primitives) + "; rays meet " + std::to_string(facts.rendered));
    line("instances", counted(facts.instances, "instance") + " of " + counted(facts.objects, "object"));
    if (facts.is_built)
        line("bounds", facts.is_empty ? "nothing to hit" : point_text(facts.lower) + " to " + point_text(facts.upper));
    line("materials", kinds_text(facts.materials));
    line("textures", kinds_text(facts.textures));
    line("media", kinds_text(facts.media));
    if (!facts.media_by_name.empty()) {
        std::vector<std::string> media;
        for (const MediumFact& each : facts.media_by_name) media.push_back(medium_text(each));
        line("medium names", names_text(media, 12));
    }
    line("lights", kinds_text(facts.lights) + "; " + counted(facts.emitters, "emitter") + " for light sampling");
    line("labels", names_text(facts.labels, 12));
    line("light groups", names_text(facts.light_groups, 12));
    std::string film = or_default(facts.film);
    if (facts.width > 0 && facts.height > 0)
        film += " " + std::to_string(facts.width) + "x" + std::to_string(facts.height);
    line("image", "camera " + or_default(facts.camera) + ", film " + film + ", filter " + or_default(facts.filter));
    line("sampling", "sampler " + or_default(facts.sampler) + ", integrator " + or_default(facts.integrator));
    line("memory",
         size_text(static_cast<double>(facts.mesh_bytes)) + " of meshes" +
             (facts.grid_bytes > 0 ? ", " + size_text(static_cast<double>(facts.grid_bytes)) + " of grids of media"
                                   : std::string()) +
             (facts.is_built
                  ? ", " + size_text(static_cast<double>(facts.peak_bytes)) + " peak while reading and building"
                  : std::string()));
    if (facts.is_built)
        line("time",
             duration_text(facts.read_seconds) + " to read, " + duration_text(facts.build_seconds) + " to build");
    for (const std::string& each : effect_summary(facts.effects, {})) lines.push_back("  " + each);
    line("warnings", facts.warnings.empty() ? "none" : std::to_string(facts.warnings.size()));
    return lines;
}

Json json_of(const SceneFacts& facts) {
    Json json;
    json["file"] = facts.file;
    json["shapes"] = json_of(facts.shapes);
    json["primitives"] = json_of(facts.primitives);
    json["primitives_rendered"] = facts.rendered;
    json["objects"] = facts.objects;
    json["instances"] = facts.instances;
    json["materials"] = json_of(facts.materials);
    json["textures"] = json_of(facts.textures);
    json["media"] = json_of(facts.media);
    json["lights"] = json_of(facts.lights);
    json["emitters"] = facts.emitters;
    json["labels"] = facts.labels;
    json["light_groups"] = facts.light_groups;
    json["camera"] = facts.camera;
    json["film"] = {{"type", facts.film}, {"width", facts.width}, {"height", facts.height}};
    json["filter"] = facts.filter;
    json["sampler"] = facts.sampler;
    json["integrator"] = facts.integrator;
    json["mesh_bytes"] = facts.mesh_bytes;
    json["effects"] = effects_json(facts.effects, {});
    json["warnings"] = facts.warnings;
    if (facts.is_built) {
        json["bounds"] = nullptr;
        if (!facts.is_empty) json["bounds"] = {{"lower", facts.lower}, {"upper", facts.upper}};
        json["read_seconds"] = facts.read_seconds;
        json["build_seconds"] = facts.build_seconds;
        json["peak_bytes"] = facts.peak_bytes;
        json["grid_bytes"] = facts.grid_bytes;
        json["media_by_name"] = Json::object();
        for (const MediumFact& each : facts.media_by_name)
            json["media_by_name"][each.name] = {{"scatters", each.scatters}, {"emits", each.emits}};
    }
    return json;
}

}  // namespace raylex::experiments
