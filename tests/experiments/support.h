// Runs the built program as a user does: in a folder of its own, with captured output.
#pragma once

#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"
#include "tests/support/folder.h"

namespace raylex::test {

struct Outcome {
    int code = -1;  ///< exit code; 128 + signal when a signal ended it
    std::string out, err;
};

/// Runs a line of bash in `folder`; $RAYLEX is the program.
Outcome run_shell(const Folder& folder, const std::string& line);
/// Runs the program with `arguments` as bash reads them.
Outcome run_raylex(const Folder& folder, const std::string& arguments);
/// Checks that the program ends with 2, names all of `words`, and leaves the folder as it was.
void check_refused(const Folder& folder, const std::string& arguments, const std::vector<std::string>& words);
/// Whether `part` is in `text`, which is shown when the check around it fails.
bool contains(const std::string& text, const std::string& part);
/// Regular expressions (ECMAScript), compiled here alone: the whole text matches; how often a part of it does; what
/// matches in turn, each with its groups behind it.
bool matches(const std::string& text, const std::string& pattern);
std::size_t count_matches(const std::string& text, const std::string& pattern);
std::vector<std::vector<std::string>> all_matches(const std::string& text, const std::string& pattern);

/// The values of a plane that must be there.
std::vector<float> plane(const display::ExrImage& image, const std::string& layer, const std::string& name);

/// Every number of every layer of an image that must be there, and which layers there are.
std::string image_bits(const std::string& path);

/// A plane under a point light and an area light, 16x16 pixels, 4 samples.
std::string small_scene();

/// A folder with that scene as room.pbrt.
struct SceneFolder : Folder {
    SceneFolder() { write("room.pbrt", small_scene()); }
};

}  // namespace raylex::test
