// The parts of the quickstart that can be tested without a build.
#include <catch2/catch.hpp>

#include "experiments/job/job_file.h"
#include "support.h"
#include "tests/support/paths.h"

using namespace raylex::test;

namespace {

const std::string script = raylex::test::source_dir() + "/experiments/quickstart.sh";

}  // namespace

TEST_CASE("the quickstart's script is valid, has a help text and refuses unknown arguments") {
    const Folder folder;
    CHECK(run_shell(folder, "bash -n '" + script + "'").code == 0);
    Outcome help = run_shell(folder, "bash '" + script + "' --help");
    CHECK(help.code == 0);
    CHECK(help.out.find("Exit codes") != std::string::npos);
    CHECK(run_shell(folder, "bash '" + script + "' --frobnicate").code == 2);
    CHECK(run_shell(folder, "bash '" + script + "' a b").code == 2);
    CHECK(folder.names().empty());
}

TEST_CASE("the quickstart estimates each step, and does not use a build folder that was configured elsewhere") {
    const Folder folder;
    folder.write("experiments/install_packages.sh", "exit 0\n");
    folder.write("bin/c++", "#!/bin/sh\nsleep 0.2\n");
    folder.write("build/release/CMakeCache.txt", "CMAKE_HOME_DIRECTORY:INTERNAL=/elsewhere\n");
    const Outcome moved =
        run_shell(folder, "mkdir lpe; chmod +x bin/c++; cp '" + script +
                              "' experiments; PATH=$PWD/bin:$PATH bash experiments/quickstart.sh out");
    CHECK(moved.code == 2);
    CHECK(contains(moved.err, "mv build/release build/release-old"));
    CHECK(folder.has("build/release/CMakeCache.txt"));
    CHECK(count_matches(moved.out, "  [a-z][^:]*: about [0-9]+ s\n") == 4);  // 0.2 s: a fast machine
}

TEST_CASE("the quickstart's jobs are valid, and their scenes exist") {
    for (const std::string name : {"window-light", "lantern-fog"}) {
        CAPTURE(name);
        auto job =
            raylex::experiments::read_job(raylex::test::source_dir() + "/experiments/quickstart/" + name + ".toml");
        REQUIRE(job);
        CHECK(job->light_groups);
        CHECK(job->expressions.size() == 4);
        const Folder folder;
        CHECK(run_shell(folder, "test -f '" + job->scene_file + "'").code == 0);
    }
}

TEST_CASE("the quickstart's jobs render, at a thousandth of their budget") {
    const Folder folder;
    for (const std::string name : {"window-light", "lantern-fog"}) {
        CAPTURE(name);
        Outcome outcome =
            run_raylex(folder, "render '" + raylex::test::source_dir() + "/experiments/quickstart/" + name +
                                   ".toml' -o out.exr --preview p.png --stats s.json --resolution 24x16 --spp 4");
        CAPTURE(outcome.err);
        REQUIRE(outcome.code == 0);
        CHECK(run_raylex(folder, "verify out.exr").code == 0);
    }
    CHECK(run_raylex(folder, "report out.exr -o page.html").code == 0);
    CHECK(folder.read("page.html").find("light_near_lantern") != std::string::npos);
}
