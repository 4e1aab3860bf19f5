// Counts the contents of a scene, for `raylex scene info`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/job/text/json.h"
#include "transport/render/built_scene.h"
#include "transport/scene/effects/effects.h"

namespace raylex::experiments {

/// The number of items of one kind.
struct KindCount {
    std::string kind;
    std::uint64_t count = 0;
};

/// A medium that paths can meet, by the label of its events.
struct MediumFact {
    std::string name;
    bool scatters = false, emits = false;
};

struct SceneFacts {
    std::string file;
    std::vector<KindCount> shapes;      ///< directives by kind; those of an object count once
    std::vector<KindCount> primitives;  ///< triangles, patches, curves, quadrics in memory
    std::uint64_t rendered = 0;         ///< primitives as rays see them: those of an object count once per instance
    std::uint64_t objects = 0, instances = 0;
    std::vector<KindCount> materials, textures, media, lights;  ///< by type; area lights are "area"
    /// number of items that light sampling chooses from: each primitive of an area light counts
    std::uint64_t emitters = 0;
    std::vector<std::string> labels, light_groups;
    std::uint64_t mesh_bytes = 0;  ///< vertices, normals, texture coordinates and indices from files
    std::string camera, film, filter, sampler, integrator;  ///< types; "" if the file names none
    int width = 0, height = 0;                              ///< 0 if the film has an error
    transport::EffectFindings effects;
    std::vector<std::string> warnings;

    // Facts of the built scene; unset before add_built_facts().
    bool is_built = false;
    double lower[3] = {0, 0, 0}, upper[3] = {0, 0, 0};  ///< world space
    bool is_empty = false;                              ///< rays can hit nothing
    double read_seconds = 0, build_seconds = 0;
    std::uint64_t peak_bytes = 0;  ///< peak of the process so far, including temporary memory of the build
    std::uint64_t grid_bytes = 0;  ///< size of media grids in the renderer's format
    std::vector<MediumFact> media_by_name;
};

SceneFacts scene_facts(const transport::SceneDescription& scene);
/// Adds the facts that need the built scene.
void add_built_facts(const transport::BuiltScene& built, SceneFacts& facts);

/// Returns the facts as lines of text for people.
std::vector<std::string> lines_of(const SceneFacts& facts);
Json json_of(const SceneFacts& facts);

}  // namespace raylex::experiments
