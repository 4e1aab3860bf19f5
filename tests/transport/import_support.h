// Shared by the tests of the scene import: scratch files and short ways to a scene or its error.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "transport/import/pbrt_importer.h"
#include "tests/support/paths.h"

namespace import_test {

namespace fs = std::filesystem;

/// A folder of its own for every test; removed at its end.
class ScratchFolder {
  public:
    explicit ScratchFolder(const std::string& name) : path_(fs::path(raylex::test::binary_dir()) / "import_scratch" / name) {
        fs::remove_all(path_);
        fs::create_directories(path_);
    }
    ~ScratchFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::string write(const std::string& name, const std::string& content) const {
        const fs::path file = path_ / name;
        fs::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << content;
        return file.string();
    }
    [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }

  private:
    fs::path path_;
};

/// The scene of `text`; a failure shows the error in the test's output.
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

inline bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace import_test
