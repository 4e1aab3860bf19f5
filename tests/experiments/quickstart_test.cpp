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
