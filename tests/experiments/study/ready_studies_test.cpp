// The experiments that come with raylex: each can be planned, and the planted mistake is found.
#include <catch2/catch.hpp>

#include <filesystem>

#include "tests/experiments/support.h"
#include "tests/support/paths.h"

using namespace raylex::test;

namespace {

const std::string studies = source_dir() + "/experiments/studies";

}  // namespace

TEST_CASE("every ready experiment can be planned", "[gate][gate]") {
    const Folder folder;
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(studies)) {
        if (entry.path().extension() != ".toml") continue;  // pictures and their page
        CAPTURE(entry.path().string());
        const Outcome plan = run_raylex(folder, "experiment plan '" + entry.path().string() + "' --no-calibration");
        INFO(plan.err);
        CHECK(plan.code == 0);
        ++count;
    }
    CHECK(count == 12);
}

TEST_CASE("a planted mistake is found, and the first wrong path named", "[study][release-only][gate][gate]") {
    const Folder folder;
    const std::string common = " '" + studies +
                               "/planted-error.toml' -o out --set replicates=4 --set budget.samples=64 "
                               "--set scene.*.resolution=32x32 --set reference.spp=1024";
    const Outcome run = run_raylex(folder, "experiment run" + common);
    INFO(run.err);
    REQUIRE(run.code == 0);
    REQUIRE(run_raylex(folder, "experiment report" + common).code == 0);
    const std::string page = folder.read("out/report.html");
    // Seeds are fixed, so chance plays no role. Without weights, a roulette of 0.75 loses a quarter of the paths with
    // three scattering events and none of those with fewer.
    CHECK(page.find(
              "Declared unbiased but differs from the reference:</span> planted-error on cornell-grey (beauty: -") !=
          std::string::npos);
    CHECK(page.find("is first wrong at the path <code>C,- R,D R,D R,D L,-</code>") != std::string::npos);
}

TEST_CASE("a channel without beauty is compared with the same channel of a full render, by the configured clock",
          "[study][release-only][gate][gate]") {
    const Folder folder;
    const std::string common = " '" + studies +
                               "/one-light-group.toml' -o out --set replicates=3 --set budget.samples=16 "
                               "--set scene.*.resolution=24x24 --set reference.spp=256";
    const Outcome run = run_raylex(folder, "experiment run" + common + " --report");
    INFO(run.out + run.err);
    REQUIRE(run.code == 0);
    // The full render has two channels besides the beauty; the other method does not have `rest`.
    CHECK(run.out.find("key on cornell-lamps16, method full to alone: ") != std::string::npos);
    CHECK(run.out.find("rest on cornell-lamps16, method") == std::string::npos);
    CHECK(run.err.find("omission") == std::string::npos);
    CHECK(folder.has("out/cells/cornell-lamps16.full.16spp.r0/beauty.mean.npy"));
    CHECK(!folder.has("out/cells/cornell-lamps16.alone.16spp.r0/beauty.mean.npy"));
    CHECK(folder.has("out/cells/cornell-lamps16.alone.16spp.r0/key.mean.npy"));
    CHECK(folder.read("out/experiment.json").find("\"clock\": \"cpu\"") != std::string::npos);
    CHECK(folder.read("out/report.html").find("times below are CPU seconds of all threads") != std::string::npos);

    const auto refused = [&](const std::string& setting, const std::string& message) {
        const Outcome outcome = run_raylex(folder, "experiment plan '" + studies + "/one-light-group.toml' " + setting);
        CAPTURE(setting, outcome.err);
        CHECK(outcome.code == 2);
        CHECK(outcome.err.find(message) != std::string::npos);
    };
    refused("--set clock=sun", "'clock' is 'sun'; expected \"wall\" or \"cpu\"");
    refused("--set reference.method=alone", "references contain everything");
    refused("--set budget.error=0.1", "a budget of error applies to the beauty");
}

TEST_CASE("methods that start at the lights agree with the path tracer in every channel of a partition, also in fog",
          "[study][release-only][gate][gate]") {
    const Folder folder;
    const Outcome run =
        run_raylex(folder, "experiment run '" + studies +
                               "/agreement.toml' -o out --report "
                               "--set replicates=6 --set budget.samples=32 --set scene.*.resolution=24x24 "
                               "--set reference.spp=512");
    INFO(run.out + run.err);
    REQUIRE(run.code == 0);
    for (const char* scene : {"cornell-color", "cornell-fog"})
        for (const char* method : {"bdpt", "lighttracer", "metropolis"}) {
            const std::string who = std::string(method) + " on " + scene + ": ";
            const std::size_t at = run.out.find(who);
            CAPTURE(who);
            REQUIRE(at != std::string::npos);
            const std::string result = run.out.substr(at + who.size(), 13);
            CAPTURE(result);
            // In fog, images of this size would miss a bias of a tenth, so a bias is neither claimed nor excluded.
            const bool cannot_tell = result.starts_with("cannot tell");
            CHECK((result == "no bias found" || (cannot_tell && std::string(scene) == "cornell-fog")));
        }
}

TEST_CASE("one command passes the README's integrator, and finds its bias when it misses some light",
          "[study][release-only][gate][gate]") {
    const Folder folder;
    folder.write("own.toml", "plugins = [\"" + binary_dir() + R"(/tests/libambient_occlusion.so"]
replicates = 4
[[scene]]
name = "white-sky"
file = ")" + source_dir() + R"(/experiments/scenes/white-sky/scene.pbrt"
resolution = [48, 32]
[[method]]
name = "path"
integrator = "path"
max_depth = 1
[[method]]
name = "mine"
integrator = "ambientocclusion"
[[method]]
name = "short-sighted"
integrator = { type = "ambientocclusion", maxdistance = 1 }
[budget]
samples = [64]
[reference]
method = "path"
spp = 1024
)");
    const Outcome run = run_raylex(folder, "experiment run own.toml -o out --report");
    INFO(run.out << run.err);
    REQUIRE(run.code == 0);
    CHECK(run.out.find("\nmine on white-sky: no bias found; a bias of ") != std::string::npos);
    CHECK(run.out.find("\nshort-sighted on white-sky: BIASED: it differs from the reference") != std::string::npos);
    CHECK(folder.has("out/report.html"));
}
