#include "transport/import/known_parameters.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "display/buffer/pixel_filter.h"
#include "transport/cameras/camera.h"
#include "transport/import/shapes/shapes.h"
#include "transport/integrators/integrator.h"
#include "transport/lights/light_table.h"
#include "transport/materials/material.h"
#include "transport/media/medium.h"
#include "transport/scene/sampler.h"
#include "transport/textures/pattern.h"

namespace raylex::transport {
namespace {

using Names = std::vector<std::string>;

/// A parameter that pbrt-v4 reads and raylex ignores.
struct Ignored {
    std::string name;
    Names honoured;  ///< values for which ignoring it changes nothing
    std::string why;
};

/// The parameters of a type beyond those that its registry entry declares.
struct Row {
    EntityKind kind;
    std::string type;
    Names taken;  ///< read, refused with a separate error, or without any effect on an image
    std::vector<Ignored> ignored;
};

std::vector<Ignored> all_ignored(const Names& names, const std::string& why) {
    std::vector<Ignored> list;
    for (const std::string& name : names) list.push_back({name, {}, why});
    return list;
}

const std::string in_rgb = "light is transported in RGB", scrambled = "points are always Owen-scrambled";

// The rows follow the file format of pbrt-v4 (pbrt.org/fileformat-v4) and the look-ups in its source.
std::vector<Row> camera_rows() {
    using enum EntityKind;
    const Names every_film{"xresolution", "yresolution", "cropwindow",   "pixelbounds",  "filename",         "diagonal",
                           "sensor",      "iso",         "exposuretime", "whitebalance", "maxcomponentvalue"};
    const std::vector<Ignored> values{{"savefp16", {"false"}, "[exr] of a job sets how values are stored"}};
    std::vector<Ignored> spectrum = values;
    for (const char* name : {"nbuckets", "lambdamin", "lambdamax"}) spectrum.push_back({name, {}, in_rgb});
    Names geometry = every_film;
    geometry.emplace_back("coordinatesystem");
    return {
        {camera, "spherical", {"frameaspectratio", "screenwindow", "lensradius", "focaldistance"}, {}},
        {film, "gbuffer", geometry, values},
        {film, "rgb", every_film, values},
        {film, "spectral", every_film, spectrum},
    };
}

std::vector<Row> method_rows() {
    using enum EntityKind;
    const std::string by_tree = "lights are chosen by a tree where there are many, else by their power",
                      as_path = "'path' is used instead of this integrator";
    const std::vector<Ignored> owen{{"randomization", {"owen", "fastowen"}, scrambled}};
    const Ignored light_choice{"lightsampler", {"bvh", "power", "uniform"}, by_tree},
        regularize{"regularize", {"false"}, "specular lobes are never blurred"};
    const std::string no_pictures = "channels with techniques (s2t1;C.*) show strategies and weights";
    return {
        {accelerator, "bvh", {"maxnodeprims", "splitmethod"}, {}},
        {accelerator, "kdtree", {"intersectcost", "traversalcost", "emptybonus", "maxprims", "maxdepth"}, {}},
        {integrator, "ambientocclusion", {"maxdepth"}, all_ignored({"cossample", "maxdistance"}, as_path)},
        {integrator,
         "bdpt",
         {"maxdepth"},
         {regularize, {"visualizestrategies", {"false"}, no_pictures}, {"visualizeweights", {"false"}, no_pictures}}},
        {integrator, "function", {"function", "imagefilename", "skipbad"}, {}},
        {integrator, "lightpath", {"maxdepth"}, {}},
        {integrator,
         "mlt",
         {"maxdepth", "bootstrapsamples", "chains", "largestepprobability", "mutationsperpixel", "sigma"},
         {regularize}},
        {integrator, "path", {}, {light_choice}},
        {integrator, "randomwalk", {"maxdepth"}, {}},
        {integrator, "simplepath", {"maxdepth", "samplebsdf", "samplelights"}, {}},
        {integrator, "simplevolpath", {"maxdepth"}, {}},
        {integrator,
         "sppm",
         {"maxdepth"},
         all_ignored({"photonsperiteration", "radius", "seed"}, "there are no photons")},
        {integrator, "volpath", {}, {light_choice}},
        {sampler, "halton", {}, {{"randomization", {"owen"}, scrambled}}},
        {sampler, "paddedsobol", {}, owen},
        {sampler, "sobol", {}, owen},
        {sampler, "stratified", {}, {{"jitter", {"true"}, scrambled}}},
        {sampler, "zsobol", {}, owen},
    };
}

std::vector<Row> content_rows() {
    using enum EntityKind;
    return {

        {material, "diffuse", {}, {{"sigma", {"0"}, "the surface is Lambertian"}}},
        {shape, "bilinearmesh", {"faceIndices", "emissionfilename"}, {}},
        {shape, "trianglemesh", {"faceIndices"}, {{"S", {}, "anisotropic materials follow the texture coordinates"}}},
        {shape, "curve", {}, {{"splitdepth", {"3"}, "Embree splits curves adaptively"}}},
    };
}

std::vector<Row> make_table() {
    std::vector<Row> table;
    for (const std::vector<Row>& rows : {camera_rows(), method_rows(), content_rows()})
        table.insert(table.end(), rows.begin(), rows.end());
    return table;
}

const Row* find_row(EntityKind kind, const std::string& type) {
    static const std::vector<Row> table = make_table();
    for (const Row& row : table)
        if (row.kind == kind && row.type == type) return &row;
    return nullptr;
}

template <typename Factory>
const std::vector<ParameterDescription>* declared_by(const Registry<Factory>& registry, const std::string& type) {
    const auto* entry = registry.find(type);
    return entry != nullptr ? &entry->parameters : nullptr;
}

const char* kind_name(EntityKind kind) {
    constexpr std::array<const char*, 12> names{"accelerator",  "area light", "camera",   "film",
                                                "integrator",   "light",      "material", "medium",
                                                "pixel filter", "sampler",    "shape",    "texture"};
    return names[static_cast<std::size_t>(kind)];
}

/// One value as a scene file writes it; empty when there are several.
std::string value_text(const Parameter& parameter) {
    if (parameter.strings.size() + parameter.booleans.size() + parameter.numbers.size() != 1) return {};
    if (!parameter.strings.empty()) return parameter.strings.front();
    if (!parameter.booleans.empty()) return parameter.booleans.front() != 0 ? "true" : "false";
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), parameter.numbers.front());
    return {text.data(), end.ptr};
}

template <class List>
bool holds(const List& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

const std::vector<ParameterDescription>* declared_parameters(EntityKind kind, const std::string& type) {
    switch (kind) {
        case EntityKind::area_light:
            return declared_by(area_light_registry(), type);
        case EntityKind::camera:
            return declared_by(camera_registry(), type);
        case EntityKind::integrator:
            return declared_by(integrator_registry(), type);
        case EntityKind::light:
            return declared_by(light_registry(), type);
        case EntityKind::material:
            return declared_by(material_registry(), type);
        case EntityKind::medium:
            return declared_by(medium_registry(), type);
        case EntityKind::pixel_filter:
            return declared_by(display::pixel_filter_registry(), type);
        case EntityKind::sampler:
            return declared_by(sampler_registry(), type);
        case EntityKind::shape:
            return declared_by(shape_registry(), type);
        case EntityKind::texture:
            return declared_by(pattern_registry(), type);
        default:
            return nullptr;
    }
}

Error unknown_parameter(const std::string& kind, const std::string& type, const Parameter& parameter,
                        const std::vector<std::string>& known) {
    std::string list;
    for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
    const std::string near = nearest_name(parameter.name, known);
    return error_at(parameter.location,
                    kind + " '" + type + "' has no parameter '" + parameter.name +
                        (list.empty() ? "'; it takes none" : "'; expected one of: " + list),
                    !near.empty()                                 ? "did you mean '" + near + "'?"
                    : kind == "film" && parameter.name == "scale" ? "pbrt-v4 has \"float iso\" now: 100 times the scale"
                                                                  : "");
}

Status ParameterChecker::check(EntityKind kind, const std::string& type, ParameterSet& set, std::size_t own,
                               std::vector<Error>& warnings) {
    const Row* row = find_row(kind, type);
    const std::vector<ParameterDescription>* entry = declared_parameters(kind, type);
    if (row == nullptr && entry == nullptr) return success();
    std::vector<std::string_view> read, known;  // runs for every shape of a scene
    if (entry != nullptr)
        for (const ParameterDescription& each : *entry) read.push_back(each.name);
    if (row != nullptr) read.insert(read.end(), row->taken.begin(), row->taken.end());
    if (kind == EntityKind::shape) read.emplace_back("alpha");  // of every shape: make_shapes()
    if (kind == EntityKind::camera)                             // of every camera: shutter_span()
        for (const char* name : {"shutteropen", "shutterclose"}) read.emplace_back(name);
    if (kind == EntityKind::material && takes_normal_detail(type))  // of a plugin's material too
        for (const ParameterDescription& each : normal_detail_parameters())
            if (!holds(read, each.name)) read.push_back(each.name);
    known = read;
    if (row != nullptr)
        for (const Ignored& each : row->ignored)
            if (!holds(read, each.name)) known.push_back(each.name);

    const auto warn = [&](const std::string& message, const SourceLocation& location) {
        if (said_.insert(message).second) warnings.push_back(error_at(location, message));
    };
    const bool no_surface = kind == EntityKind::material && type == "interface";
    const auto unknown = [&](const Parameter& each) { return !holds(known, each.name); };
    // In one pass, since Attribute may have set thousands for every shape.
    if (!no_surface) {
        const auto others = set.parameters.begin() + static_cast<std::ptrdiff_t>(own);
        set.parameters.erase(std::remove_if(others, set.parameters.end(), unknown), set.parameters.end());
    }
    for (const Parameter& parameter : set.parameters) {
        if (unknown(parameter)) {
            if (!no_surface) return unknown_parameter(kind_name(kind), type, parameter, {known.begin(), known.end()});
            // pbrt makes no material here, so it never checks these parameters.
            parameter.used = true;
            warn(std::string("parameter '") + parameter.name + "' of " + kind_name(kind) + " '" + type +
                     "' is ignored: there is no surface",
                 parameter.location);
            continue;
        }
        if (row == nullptr) continue;
        const auto ignored = std::find_if(row->ignored.begin(), row->ignored.end(),
                                          [&](const Ignored& each) { return each.name == parameter.name; });
        // A plugin may honour a parameter of a type of the same name that the built-in type ignores.
        if (ignored == row->ignored.end() || (ignored->honoured.empty() && holds(read, parameter.name))) continue;
        parameter.used = true;
        if (holds(ignored->honoured, value_text(parameter))) continue;
        warn(std::string("parameter '") + parameter.name + "' of " + kind_name(kind) + " '" + type +
                 "' is ignored: " + ignored->why,
             parameter.location);
    }
    return success();
}

}  // namespace raylex::transport
