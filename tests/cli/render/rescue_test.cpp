// A full disk at the end of a render: the file that is written elsewhere, and the message about it.
#include <catch2/catch.hpp>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "display/output/atomic_file.h"
#include "experiments/cli/render/rescue.h"
#include "run_here.h"
#include "support.h"

using namespace raylex::test;
using raylex::display::FileCall;

namespace {

/// Sets $TMPDIR until it goes out of scope.
class TemporaryFolder {
  public:
    explicit TemporaryFolder(const std::string& path) {
        if (const char* before = std::getenv("TMPDIR")) before_ = before;
        setenv("TMPDIR", path.c_str(), 1);
    }
    ~TemporaryFolder() {
        if (before_) setenv("TMPDIR", before_->c_str(), 1);
        else unsetenv("TMPDIR");
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  private:
    std::optional<std::string> before_;
};

}  // namespace

TEST_CASE("a file that cannot be written is saved in the folder for temporary files", "[law7]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const std::string temporary = "temporary", place = folder.path("place") + "/", saved = folder.path(temporary) + "/";
    std::filesystem::create_directory(folder.path("place"));
    const TemporaryFolder chosen(folder.path(temporary));
    std::vector<std::string> arguments{
        "render", folder.path("room.pbrt"), "-o", place + "out.exr", "--spp", "32", "--lpe", "d=CDL"};
    const auto run = [&](const std::vector<std::string>& more, const std::string& full) {
        std::filesystem::remove_all(folder.path(temporary));
        std::filesystem::create_directory(folder.path(temporary));
        std::vector<std::string> all = arguments;
        all.insert(all.end(), more.begin(), more.end());
        raylex::display::set_file_fault([&](FileCall call, const std::string& path) {
            return call == FileCall::write && path.starts_with(place) && path.ends_with(full) ? ENOSPC : 0;
        });
        const int code = run_here(all);
        raylex::display::set_file_fault(nullptr);
        return code;
    };
    const std::vector<std::string> more{"--atlas", place + "a.atlas.exr", "--deep", place + "d.exr"};
    REQUIRE(run(more, "nothing") == 0);
    const std::string expected = image_bits(place + "out.exr");
    for (const std::string name : {"out.exr", "a.atlas.exr", "d.exr"}) {
        CAPTURE(name);
        for (const char* each : {"out.exr", "a.atlas.exr", "d.exr"}) std::filesystem::remove(place + each);
        CHECK(run(more, name) == 2);
        for (const std::string each : {"out.exr", "a.atlas.exr", "d.exr"}) {
            CHECK(std::filesystem::exists(place + each) == (each != name));
            CHECK(std::filesystem::exists(saved + each) == (each == name));
        }
        if (name == "out.exr") CHECK((image_bits(saved + name) == expected));
        if (name == "a.atlas.exr") CHECK(run_here({"verify", saved + name}) == 0);
    }
    // The saved files of a shard can be merged.
    const std::string record = "out.exr.shard-1-of-2", atlas = "a.atlas.exr.shard-1-of-2";
    std::vector<std::string> first{"--atlas", place + "a.atlas.exr", "--shard", "1/2"}, second = first;
    second.back() = "2/2";
    REQUIRE(run(second, "nothing") == 0);
    for (const std::string& name : {record, atlas}) {
        CAPTURE(name);
        std::filesystem::remove(place + atlas);
        CHECK(run(first, name) == 2);
        CHECK(std::filesystem::exists(saved + atlas) == (name == atlas));
        CHECK_FALSE(std::filesystem::exists(place + record));  // its presence would mean that the shard is complete
        CHECK(run_here({"merge", saved + record, place + "out.exr.shard-2-of-2", "-o", place + "out.exr"}) == 0);
        CHECK((image_bits(place + "out.exr") == expected));
    }
}

TEST_CASE("a rescue prints the file's place and never replaces another file", "[law7]") {
    const Folder folder;
    const TemporaryFolder chosen(folder.path());
    folder.write("out.exr", "of an earlier render");
    const raylex::Error failure = raylex::error_at({"far/out.exr", 0, 0}, "cannot write the file");
    std::string written;
    const raylex::Error saved = raylex::experiments::rescued(failure, "the image", "far/out.exr", [&](auto& path) {
        written = path;
        return raylex::success();
    });
    CHECK(written == folder.path("out.2.exr"));
    CHECK(saved.message == failure.message);
    CHECK(saved.hint == "the image was saved as " + written + " instead");
    const raylex::Error twice =
        raylex::experiments::rescued(saved, "the atlas", "far/a.exr", [&](auto&) { return raylex::Status(failure); });
    CHECK(contains(twice.hint, saved.hint + "\nthe atlas could not be saved"));
}
