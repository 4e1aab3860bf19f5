// What a scene holds, counted: for `raylex scene info`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/job/text/json.h"
#include "transport/render/built_scene.h"
#include "transport/scene/effects/effects.h"

namespace raylex::experiments {

/// How many there are of a kind.
struct KindCount {
    std::string kind;
    std::uint64_t count = 0;
};

/// A medium that paths meet, by the name that its events have as label.
struct MediumFact {
    std::string name;
    bool scatters = false, emits = false;
};

struct SceneFacts {
    std::string file;
    std::vector<KindCount> shapes;      ///< directives by kind, those of objects once
    std::vector<KindCount> primitives;  ///< triangles, patches, curves, quadrics, as memory holds them
    std::uint64_t rendered = 0;         ///< primitives as rays meet them: those of an object once an instance
    std::uint64_t objects = 0, instances = 0;
    std::vector<KindCount> materials, textures, media, lights;  ///< by type; area lights as "area"
    std::uint64_t emitters = 0;  ///< what a light is chosen from: an area light's primitives each
    std::vector<std::string> labels, light_groups;
    std::uint64_t mesh_bytes = 0;  ///< vertices, normals, texture coordinates and indices as read
    std::string camera, film, filter, sampler, integrator;  ///< types; "" where the file names none
    int width = 0, height = 0;                              ///< 0 where what the film says is an error
    transport::EffectFindings effects;
    std::vector<std::string> warnings;

    // Of the scene as it was built; unset before.
    bool is_built = false;
    double lower[3] = {0, 0, 0}, upper[3] = {0, 0, 0};  ///< world space
    bool is_empty = false;                              ///< nothing that a ray could hit
    double read_seconds = 0, build_seconds = 0;
    std::uint64_t peak_bytes = 0;  ///< of the process so far, what building took for a while included
    std::uint64_t grid_bytes = 0;  ///< of the grids of media, as they are rendered
    std::vector<MediumFact> media_by_name;
};

SceneFacts scene_facts(const transport::SceneDescription& scene);
/// Adds what only the built scene tells.
void add_built_facts(const transport::BuiltScene& built, SceneFacts& facts);

/// For people, a line each.
std::vector<std::string> lines_of(const SceneFacts& facts);
Json json_of(const SceneFacts& facts);

}  // namespace raylex::experiments
