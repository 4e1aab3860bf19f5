// Runs the built program like a user: in its own folder, with captured output.
#pragma once

#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"
#include "tests/support/folder.h"

namespace raylex::test {

struct Outcome {
    int code = -1;  ///< exit code; 128 + signal if a signal ended it
    std::string out, err;
};

/// Runs a line of bash in `folder`; $RAYLEX is the program.
Outcome run_shell(const Folder& folder, const std::string& line);
/// Runs the program with `arguments` as parsed by bash.
Outcome run_raylex(const Folder& folder, const std::string& arguments);
/// Checks that the program ends with 2, that its message has all of `words`, and that the folder is unchanged.
void check_refused(const Folder& folder, const std::string& arguments, const std::vector<std::string>& words);
/// Returns whether `part` is in `text`, which is shown if the check around it fails.
bool contains(const std::string& text, const std::string& part);
/// Regular expressions (ECMAScript), compiled only in this file: whether the whole text matches; how often a part of it
/// matches; the matches in order, each followed by its groups.
bool matches(const std::string& text, const std::string& pattern);
std::size_t count_matches(const std::string& text, const std::string& pattern);
std::vector<std::vector<std::string>> all_matches(const std::string& text, const std::string& pattern);

/// Returns the values of a plane that must exist.
std::vector<float> plane(const display::ExrImage& image, const std::string& layer, const std::string& name);

/// Returns every value of every layer of an image that must exist, and the names of the layers.
std::string image_bits(const std::string& path);

/// A plane under a point light and an area light, 16x16 pixels, 4 samples.
std::string small_scene();

/// A folder with that scene as room.pbrt.
struct SceneFolder : Folder {
    SceneFolder() { write("room.pbrt", small_scene()); }
};

}  // namespace raylex::test
