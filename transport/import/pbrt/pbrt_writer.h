// A SceneDescription as a pbrt-v4 file: one file, names resolved, what Include, Attribute and the like did done.
//
// Imported again it is the same scene: same geometry, numbers and order, and so the same bits of every image. Numbers
// have the digits that read back as themselves; files that parameters name are named by their absolute path. A mesh
// that came from a file goes to a PLY file of the same base name, by which label rules and cryptomattes call it; others
// stand inline.
//
// A material without a name, or an area light, that several shapes share where pbrt's blocks cannot say so is written
// again for each: the same image, but more of them (`scene_hash` differs). Groups of lights, labels and holdouts, which
// label rules give, have no words in pbrt's files: PbrtText::left_out says so.
#pragma once

#include <string>
#include <vector>

#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct PbrtText {
    struct MeshFile {
        std::string path;  ///< as the text names it, relative to the text's own file
        std::string content;
    };
    std::string text;
    std::vector<MeshFile> meshes;
    std::vector<std::string> left_out;  ///< what pbrt's files cannot say, a sentence each
};

/// `mesh_folder`: where the text finds the files of meshes, relative to its own file.
PbrtText pbrt_text(const SceneDescription& scene, const std::string& mesh_folder = "meshes");

/// Writes FILE.pbrt, and its meshes to the folder FILE.meshes beside it. Each file appears whole or not at all; the
/// scene comes last. Returns what was left out.
Result<std::vector<std::string>> write_pbrt(const SceneDescription& scene, const std::string& path);

}  // namespace raylex::transport
