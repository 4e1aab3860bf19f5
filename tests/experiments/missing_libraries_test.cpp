// What CMake prints if a library is missing or cannot be used. CMake runs the file that finds it as a script, with
// libraries that the test writes.
#include <catch2/catch.hpp>

#include "support.h"
#include "tests/support/paths.h"

using namespace raylex::test;

namespace {

/// A folder of libraries.
struct FoundFolder : Folder {
    void add_embree(const std::string& version, const std::string& lacking) const {
        const std::string stem = "lib/cmake/embree-" + version + "/embree-config";
        std::string config;
        for (const char* feature : {"RAY_MASK", "GEOMETRY_TRIANGLE", "GEOMETRY_CURVE", "GEOMETRY_USER"})
            config += std::string("set(EMBREE_") + feature + (feature == lacking ? " OFF)\n" : " ON)\n");
        if (lacking == "BACKFACE_CULLING") config += "set(EMBREE_BACKFACE_CULLING ON)\n";
        write(stem + ".cmake", config);
        write(stem + "-version.cmake", "set(PACKAGE_VERSION " + version + ")\nif(PACKAGE_FIND_VERSION_MAJOR EQUAL " +
                                           version.substr(0, 1) +
                                           ")\n  set(PACKAGE_VERSION_COMPATIBLE TRUE)\nendif()\n");
    }
    /// Runs a CMake file of raylex's, and returns what it printed, with every gap as one blank.
    [[nodiscard]] std::string run(const std::string& file, const std::string& options = {}) const {
        const Outcome outcome =
            run_shell(*this,
                      "cmake -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF -DCMAKE_FIND_USE_SYSTEM_ENVIRONMENT_PATH=OFF "
                      "-DCMAKE_PREFIX_PATH=\"$PWD\" " +
                          options + " -P '" + file + "' 2>&1 | tr -s ' \\n' ' '");
        return outcome.out;
    }
};

const std::string embree_file = source_dir() + "/transport/cmake/raylexEmbree.cmake";

}  // namespace

TEST_CASE("CMake chooses the newest Embree, or the requested one", "[build]") {
    const FoundFolder folder;
    folder.add_embree("3.13.5", "");
    CHECK(contains(folder.run(embree_file), "Found Embree 3.13.5: "));
    folder.add_embree("4.3.3", "");
    CHECK(contains(folder.run(embree_file), "Found Embree 4.3.3: "));
    CHECK(contains(folder.run(embree_file, "-DRAYLEX_EMBREE=3"), "Found Embree 3.13.5: "));
    CHECK(contains(folder.run(embree_file, "-DRAYLEX_EMBREE=4"), "Found Embree 4.3.3: "));
    CHECK(contains(folder.run(embree_file, "-DRAYLEX_EMBREE=5"), "RAYLEX_EMBREE is '5'; expected 3, 4 or nothing"));
}

TEST_CASE("an Embree that is missing or lacks a feature is named with what to do", "[build][law7]") {
    for (const char* lacking : {"RAY_MASK", "GEOMETRY_TRIANGLE", "GEOMETRY_CURVE", "GEOMETRY_USER"}) {
        const FoundFolder folder;
        folder.add_embree("4.3.3", lacking);
        CHECK(contains(folder.run(embree_file), std::string("was built without EMBREE_") + lacking + ", which raylex"));
    }
    const FoundFolder folder;
    CHECK(contains(folder.run(embree_file),
                   "Embree 4 or 3.13 was not found. Debian and Ubuntu: apt-get install libembree-dev"));
    folder.add_embree("2.17.7", "");
    CHECK(contains(folder.run(embree_file), "Embree 4 or 3.13 was not found, only 2.17.7."));
    folder.add_embree("3.13.5", "BACKFACE_CULLING");
    CHECK(contains(folder.run(embree_file), "-DEMBREE_BACKFACE_CULLING=OFF"));
}

TEST_CASE("a missing library is named with its Debian package", "[build][law7]") {
    const FoundFolder folder;
    for (const char* wanted : {"package TBB CONFIG", "path STB stb_image.h", "library BLOSC blosc"}) {
        const std::string script = folder.write("find.cmake", "include(\"" + source_dir() +
                                                                  "/display/cmake/raylexRequire.cmake\")\n"
                                                                  "raylex_require(libmissing-dev " +
                                                                  wanted + ")\n");
        CAPTURE(wanted);
        CHECK(contains(folder.run(script), "Debian and Ubuntu: apt-get install libmissing-dev;"));
    }
}
