// Effects in the output and the options of the program.
#include <catch2/catch.hpp>

#include "support.h"

using namespace raylex::test;

TEST_CASE("raylex render lists simulated and omitted effects, and flags and jobs can force them") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    Outcome outcome = run_raylex(folder, "render room.pbrt");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("effects: ") != std::string::npos);
    CHECK(outcome.out.find("left out, the scene has none: media, ") != std::string::npos);
    const std::string plain = folder.read("room.exr");

    outcome = run_raylex(folder, "render room.pbrt --effects --effect media=on --effect alpha=off --stats s.json");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("media                on, forced") != std::string::npos);
    CHECK(outcome.out.find("polarisation         never") != std::string::npos);
    const std::string statistics = folder.read("s.json");
    CHECK(statistics.find("\"effects\"") != std::string::npos);
    CHECK(statistics.find("\"depth-of-field\"") != std::string::npos);

    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\neffects = { media = true, alpha = false }\n");
    outcome = run_raylex(folder, "render job.toml --effect alpha=on");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("forced: media on") != std::string::npos);
    CHECK(outcome.out.find("alpha on") != std::string::npos);
}

TEST_CASE("raylex render lists the needed kinds of AOVs and the channels that need them") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    Outcome outcome = run_raylex(folder, "render room.pbrt");
    CHECK(outcome.out.find("AOVs need") == std::string::npos);
    outcome = run_raylex(folder, "render room.pbrt --aov P --aov Pw --aov z --stats s.json");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("AOVs need: positions (P, Pw), depths of rays (z)\n") != std::string::npos);
    const std::string statistics = folder.read("s.json");
    CHECK(statistics.find("\"positions\"") != std::string::npos);
    CHECK(statistics.find("\"albedo\"") == std::string::npos);
    outcome = run_raylex(folder, "render room.pbrt --aov Nn --effects");
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("shading normals           on           for Nn\n") != std::string::npos);
    CHECK(outcome.out.find("curvature                 off          not requested\n") != std::string::npos);
}

TEST_CASE("invalid choices of effects are errors with their place and the expected form") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const auto refused = [&](const std::string& arguments, const std::string& part) {
        const Outcome outcome = run_raylex(folder, arguments);
        CAPTURE(arguments, outcome.err);
        CHECK(outcome.code == 2);
        CHECK(outcome.err.find(part) != std::string::npos);
    };
    refused("render room.pbrt --effect fog=off", "there is no effect 'fog'; expected one of: media, depth-of-field");
    refused("render room.pbrt --effect media", "expected NAME=on or NAME=off");
    refused("render room.pbrt --effect polarisation=off", "does not simulate 'polarisation'");
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\neffects = { meda = false }\n");
    refused("render job.toml", "job.toml:4:");
    refused("render job.toml", "did you mean 'media'?");
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\neffects = { media = \"off\" }\n");
    refused("render job.toml", "job.toml:4:");
}
