// Studies that run other renderers by their command lines.
#include <catch2/catch.hpp>

#include <algorithm>
#include <sstream>
#include <string>

#include "experiment_support.h"
#include "experiments/job/text/json.h"

using namespace raylex::experiments;
using raylex::test::Folder;
using raylex::test::Outcome;
using raylex::test::prepare;
using raylex::test::results_of;
using raylex::test::run_shell;
using raylex::test::succeed;

TEST_CASE("a renderer that writes only the beauty gets one warning and needs no {scene}; a partial image is refused",
          "[gate]") {
    const Folder folder;
    const std::string study = R"(replicates = 2
[[scene]]
name = "room"
file = "room.pbrt"
[[method]]
name = "path"
[[method]]
name = "theirs"
command = "\"$RAYLEX\" render room.pbrt --seed {seed} --spp {spp} --threads 1 -o {out}"
[[method]]
name = "part"
command = "\"$RAYLEX\" render room.pbrt --seed {seed} --spp {spp} --crop 0,0,8,8 -o {out}"
[[channel]]
name = "direct"
lpe = "CDL"
[budget]
samples = [2, 8]
[reference]
method = "path"
spp = 32
)";
    prepare(folder, study);
    const Outcome run = run_shell(folder, "export RAYLEX\nexec \"$RAYLEX\" experiment run c.toml -o out");
    INFO(run.out << run.err);
    REQUIRE(run.code == 2);
    const std::string absent =
        "the images of method 'theirs' have no layers named direct, rest; these channels are not measured";
    CHECK(raylex::test::count_matches(run.out, absent) == 1);
    for (const StudyRun& cell : results_of(folder, "out").runs) {
        CAPTURE(cell.id, cell.failure);
        REQUIRE(cell.failed == (cell.method == "part"));
        if (cell.failed)
            CHECK(cell.failure.find("the image has pixels in 8x8 of its 16x16 only (its data window)") !=
                  std::string::npos);
    }
    succeed(folder, "experiment report c.toml -o out");
    int told = 0;
    std::istringstream lines(folder.read("out/results.jsonl"));
    for (std::string line; std::getline(lines, line);)
        if (const auto json = parse_json(line); json.at("kind") == "omission")
            told += json.at("what").get<std::string>().find("theirs") != std::string::npos ? 1 : 0;
    CHECK(told == 1);

    // With several scenes a command must name the scene.
    folder.write("c.toml", study + "[[scene]]\nname = \"again\"\nfile = \"room.pbrt\"\n");
    CHECK(succeed(folder, "experiment plan c.toml", 2).err.find("would render the same image for 2 scenes") !=
          std::string::npos);
    std::string named = folder.read("c.toml");
    for (std::size_t at; (at = named.find("render room.pbrt")) != std::string::npos;)
        named.replace(at, 16, "render {scene_name}.pbrt");
    folder.write("c.toml", named);
    succeed(folder, "experiment plan c.toml --no-calibration");
}

TEST_CASE("external renderers are run, timed and judged; failures are listed with their output", "[gate]") {
    const Folder folder;
    prepare(folder, R"(replicates = 2
[[scene]]
name = "room"
file = "room.pbrt"
reference = "truth.exr"
[[method]]
name = "self"
command = "\"$RAYLEX\" render {scene} --seed {seed} --spp {spp} --lpe direct=CDL --threads 1 -o {out}"
[[method]]
name = "broken"
command = """[ -e licence ] || { echo 'no licence' >&2; exit 3; }; \
  "$RAYLEX" render {scene} --seed {seed} --spp {spp} -o {out}"""
[[method]]
name = "silent"
command = ": {scene} {seed} {out} {spp}"
[[method]]
name = "endless"
command = "sleep 60; : {scene} {seed} {out} {spp}"
timeout = "0.2s"
[[exclude]]
method = "endless"
samples = 8
[[channel]]
name = "direct"
lpe = "CDL"
[budget]
samples = [2, 8]
)");
    succeed(folder, "render room.pbrt --spp 64 -o truth.exr");
    const Outcome run = run_shell(folder, "export RAYLEX\nexec \"$RAYLEX\" experiment run c.toml -o out");
    CAPTURE(run.out, run.err);
    REQUIRE(run.code == 2);
    CHECK(run.out.find("4 of 14 cells done, 10 FAILED") != std::string::npos);
    const Experiment results = results_of(folder, "out");
    for (const StudyRun& cell : results.runs) {
        CAPTURE(cell.id, cell.failure);
        CHECK(cell.failed == (cell.method != "self"));
        if (cell.method == "broken")
            CHECK(cell.failure.find("ended with exit code 3; its last output: no licence") != std::string::npos);
        if (cell.method == "broken") CHECK(cell.failure.find("c.toml:9:") != std::string::npos);
        if (cell.method == "silent") CHECK(cell.failure.find("wrote no image to {out}") != std::string::npos);
        if (cell.method == "endless") CHECK(cell.failure.find("after its timeout of 0.2") != std::string::npos);
        if (cell.failed) continue;
        CHECK(cell.cpu_seconds > 0);
        CHECK(cell.wall_seconds > 0);
        REQUIRE(read_mean(cell.directory, "direct"));
        CHECK_FALSE(read_m2(cell.directory, "direct"));
    }
    CHECK(results.scenes.front().reference_relative_error < 0);
    REQUIRE(read_mean(results.scenes.front().reference, "beauty"));
    // The renders equal those of a method of raylex; an image stores its means as floats.
    auto first = read_mean(folder.path("out/cells/room.self.2spp.r0"), "beauty"),
         second = read_mean(folder.path("out/cells/room.self.2spp.r1"), "beauty");
    REQUIRE(first);
    REQUIRE(second);
    CHECK(first->values != second->values);
    // Failed cells stay failed unless --retry is given.
    CHECK(run_shell(folder, "export RAYLEX\nexec \"$RAYLEX\" experiment resume c.toml -o out").code == 2);
    CHECK(results_of(folder, "out").runs.size() == 14);
    folder.write("licence", "");
    CHECK(run_shell(folder, "export RAYLEX\nexec \"$RAYLEX\" experiment resume c.toml -o out --retry").code == 2);
    const Experiment retried = results_of(folder, "out");
    CHECK(std::count_if(retried.runs.begin(), retried.runs.end(), [](const StudyRun& cell) { return cell.failed; }) ==
          6);
    for (const StudyRun& cell : retried.runs)
        if (cell.method == "broken") CHECK_FALSE(cell.failed);
    CHECK_FALSE(folder.has("out/failed/room.broken.2spp.r0.json"));
}
