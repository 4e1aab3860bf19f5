// A cell gets its name only when it is safely on disk, which happens during the next cell's render.
#include <catch2/catch.hpp>

#include <atomic>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <set>

#include "display/output/atomic_file.h"
#include "experiments/study/plan/config.h"
#include "experiments/study/results.h"
#include "experiments/study/run/runner.h"
#include "tests/experiments/support.h"

using namespace raylex::experiments;
using raylex::display::FileCall;
using raylex::test::Folder;

namespace fs = std::filesystem;

namespace {

/// Files by the cell's name and their own name, whatever the current name of the directory.
std::string within_run(const fs::path& path) {
    std::string cell = path.parent_path().filename().string();
    if (cell.ends_with(".partial")) cell.resize(cell.size() - 8);
    return cell + "/" + path.filename().string();
}

struct Faults {
    explicit Faults(raylex::display::FileFault fault) { raylex::display::set_file_fault(std::move(fault)); }
    ~Faults() { raylex::display::set_file_fault(nullptr); }
};

raylex::Result<RunOutcome> run(const Folder& folder, bool resume) {
    auto config = read_experiment_config(folder.path("c.toml"), {});
    REQUIRE(config);
    RunRequest request;
    request.directory = folder.path("out");
    request.resume = resume;
    request.isolated = false;  // the faults are injected into this process
    return run_experiment(*config, request, nullptr);
}

}  // namespace

TEST_CASE("a cell gets its name when all its files are on disk; one that cannot be synced is rendered again",
          "[law7]") {
    const Folder folder;
    folder.write("room.pbrt", raylex::test::small_scene());
    folder.write("c.toml",
                 "replicates = 3\nthreads = 1\n[[scene]]\nname = \"room\"\nfile = \"room.pbrt\"\n[[method]]\n"
                 "name = \"path\"\n[budget]\nsamples = 4\n[[channel]]\nname = \"direct\"\nlpe = \"CDL\"\n");
    const std::string second = "room.path.4spp.r1";
    std::mutex mutex;
    std::set<std::string> synced;
    bool too_early = false;
    {
        // The second cell's record does not reach the disk, which is known only during the third cell's render or after
        // it.
        const Faults faults([&](FileCall call, const std::string& path) {
            if (call != FileCall::sync || path.find("/cells/") == std::string::npos) return 0;
            const std::lock_guard lock(mutex);
            synced.insert(within_run(path));
            const std::string name = within_run(path);
            too_early |= fs::exists(folder.path("out/cells/" + name.substr(0, name.find('/'))));
            return name == second + "/record.bin" ? EIO : 0;
        });
        auto outcome = run(folder, false);
        REQUIRE_FALSE(outcome);
        CHECK(within_run(outcome.error().file) == second + "/record.bin");
    }
    CHECK_FALSE(too_early);
    CHECK(folder.has("out/cells/room.path.4spp.r0/cell.json"));
    CHECK_FALSE(folder.has("out/cells/" + second));
    CHECK_FALSE(folder.has("out/cells/room.path.4spp.r2"));  // nothing follows after a failed disk
    for (const auto& entry : fs::directory_iterator(folder.path("out/cells/room.path.4spp.r0")))
        CHECK(synced.contains(within_run(entry.path())));
    folder.write("out/cells/" + second + ".partial/half.residual.png", "of the run that failed");
    auto resumed = run(folder, true);
    REQUIRE(resumed);
    CHECK(resumed->done == 3);
    CHECK(folder.has("out/cells/" + second + "/record.bin"));
    CHECK_FALSE(folder.has("out/cells/" + second + "/half.residual.png"));
    auto results = read_experiment(folder.path("out"));
    REQUIRE(results);
    CHECK(results->missing.empty());
    CHECK(results->time.render > 0);
    CHECK(results->time.overhead() > 0);
    CHECK(results->time.warm_up > 0);
    CHECK(results->time.total > results->time.render + results->time.warm_up + results->time.references);
}

TEST_CASE("an array of zeros is a hole in its file and reads back as zeros, one with a negative zero does not") {
    const Folder folder;
    PixelArray zeros{64, 64, 3, std::vector<double>(std::size_t{64} * 64 * 3)};
    REQUIRE(write_npy(folder.path("zeros.npy"), zeros, raylex::display::FileSync::later));
    CHECK(fs::file_size(folder.path("zeros.npy")) == 128 + 8 * zeros.values.size());
    auto read = read_npy(folder.path("zeros.npy"));
    REQUIRE(read);
    CHECK((read->values == zeros.values));
    zeros.values.back() = -0.0;
    REQUIRE(write_npy(folder.path("zeros.npy"), zeros));
    read = read_npy(folder.path("zeros.npy"));
    REQUIRE(read);
    CHECK(std::signbit(read->values.back()));
}
