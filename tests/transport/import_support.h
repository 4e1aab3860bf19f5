// Helpers of the tests of scene import: short ways to a scene or its error.
#pragma once

#include <filesystem>
#include <string>

#include "tests/support/folder.h"
#include "tests/support/paths.h"
#include "transport/geometry/shapes/placed_mesh.h"
#include "transport/import/pbrt/pbrt_importer.h"

namespace import_test {

namespace fs = std::filesystem;
using raylex::test::Folder;

/// The scene of `text`; on failure the test's output contains the error.
inline raylex::transport::SceneDescription scene_of(const std::string& text, const std::string& path = "test.pbrt") {
    auto scene = raylex::transport::import_pbrt_text(text, path);
    if (!scene) FAIL(scene.error().to_string());
    return std::move(*scene);
}

inline raylex::Error error_of(const std::string& text, const std::string& path = "test.pbrt") {
    auto scene = raylex::transport::import_pbrt_text(text, path);
    if (scene) FAIL("accepted: " + text);
    return scene.error();
}

/// The mesh after its transform, in single precision.
inline raylex::transport::PlacedMesh placed(const raylex::transport::SceneShape& shape) {
    auto mesh = raylex::transport::place_mesh(shape, shape.object_to_world);
    if (!mesh) FAIL(mesh.error().to_string());
    return *std::move(mesh);
}

inline bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace import_test
