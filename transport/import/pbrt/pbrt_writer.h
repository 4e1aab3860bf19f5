// Writes a SceneDescription as one pbrt-v4 file, with names resolved and Include, Attribute and similar directives
// applied.
//
// Importing the file gives the same scene: the same geometry, numbers and order, and so the same bits of every image.
// Numbers are written with the digits that are read back exactly; parameters name files by their absolute paths. A mesh
// that came from a file is written to a PLY file of the same base name, which label rules and cryptomattes use; other
// meshes are written inline.
//
// Where pbrt's blocks cannot share a material without a name, or an area light, among several shapes, it is written
// again for each: the image is the same, but there are more of them (`scene_hash` differs). Light groups, labels and
// holdouts, which label rules set, have no form in pbrt files: PbrtText::left_out lists them.
#pragma once

#include <string>
#include <vector>

#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct PbrtText {
    struct MeshFile {
        std::string path;  ///< in the text, relative to the file of the text
        std::string content;
    };
    std::string text;
    std::vector<MeshFile> meshes;
    std::vector<std::string> left_out;  ///< features that pbrt files cannot express, one sentence each
};

/// `mesh_folder` is the folder of the meshes' files, relative to the file of the text.
PbrtText pbrt_text(const SceneDescription& scene, const std::string& mesh_folder = "meshes");

/// Writes FILE.pbrt, and its meshes to the folder FILE.meshes beside it. Each file is written completely or not at all;
/// the scene is written last. Returns the features that were omitted.
Result<std::vector<std::string>> write_pbrt(const SceneDescription& scene, const std::string& path);

}  // namespace raylex::transport
