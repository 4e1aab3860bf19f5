// raylex render --guide-file: one command trains, and shards, replays and later renders read its guide.
#include <catch2/catch.hpp>

#include <filesystem>
#include <sstream>

#include "display/checkpoint/record_file.h"
#include "experiments/job/text/json.h"
#include "support.h"

using namespace raylex::test;
using raylex::experiments::Json;
using raylex::experiments::parse_json;

namespace {

/// A folder with a guided job: guided.toml.
struct GuidedFolder : SceneFolder {
    GuidedFolder() {
        write("guided.toml", R"([scene]
file = "room.pbrt"
[render]
spp = 64
[integrator]
type = "path"
guide = "on"
)");
    }
    /// Runs the program, which must succeed.
    [[nodiscard]] Outcome good(const std::string& arguments) const {
        Outcome outcome = run_raylex(*this, arguments);
        INFO(arguments << "\n" << outcome.out << outcome.err);
        REQUIRE(outcome.code == 0);
        return outcome;
    }
};

}  // namespace

TEST_CASE("one command trains for all shards, and they merge to the bits of one render", "[guide][law3]") {
    const GuidedFolder folder;
    const std::string render = "render guided.toml -o out.exr --guide-file ours.guide";
    CHECK_FALSE(contains(folder.good("render guided.toml -o whole.exr").out, "read from a file"));
    CHECK(contains(folder.good(render + " --guide-only").out, "ours.guide: what the training found for this render"));
    CHECK_FALSE(folder.has("out.exr"));
    const std::string bytes = folder.read("ours.guide");
    for (const char* part : {" --shard 1/2 --stats 1.json", " --shard 2/2 --threads 2 --stats 2.json"})
        (void)folder.good(render + part);
    for (const char* file : {"1.json", "2.json"}) {
        const Json statistics = parse_json(folder.read(file));
        CHECK(statistics["guide"]["read"] == true);
        CHECK(statistics["guide"]["samples_per_pixel"] == 16);
        CHECK(statistics["guide"]["paths"] == 0);
        CHECK(statistics["guide"]["cpu_seconds"] == 0);
        CHECK(statistics["rays"]["pilot"] == 0);
    }
    // No shard trained, so the training is in no sum of theirs.
    CHECK(contains(folder.good("merge --shards 2 -o out.exr").out,
                   "CPU in total; the guide learned from 16 other samples of each pixel\n"));
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
    // Its first shard trains.
    const std::string first = "render guided.toml -o b.exr --guide-file b.guide";
    (void)folder.good(first + " --shard 1/2 --stats 1.json");
    CHECK_FALSE(parse_json(folder.read("1.json"))["guide"].contains("read"));
    CHECK(parse_json(folder.read("1.json"))["rays"]["pilot"] > 0);
    (void)folder.good(first + " --shard 2/2");
    CHECK(matches(folder.good("merge --shards 2 -o b.exr").out,
                  "[^]*the guide learned from 16 other samples[^\\n]* CPU\\)\n"));
    CHECK((image_bits(folder.path("b.exr")) == image_bits(folder.path("whole.exr"))));
    CHECK((folder.read("b.guide") == bytes));
    // A finished shard does not train again.
    std::filesystem::remove(folder.path("b.guide"));
    CHECK(contains(folder.good(first + " --shard 1/2").out, "is done already"));
    CHECK_FALSE(folder.has("b.guide"));
    // A render that reads, and a second training that finds the file.
    CHECK(contains(folder.good("render guided.toml -o again.exr --guide-file ours.guide").out, "read from a file"));
    CHECK((image_bits(folder.path("again.exr")) == image_bits(folder.path("whole.exr"))));
    (void)folder.good(render + " --guide-only");
    CHECK((folder.read("ours.guide") == bytes));
    // A replayed sample has the same guide.
    const std::string replay = "render guided.toml --replay 5,9,3";
    const std::string value = folder.good(replay).out;
    CHECK(folder.good(replay + " --guide-file ours.guide").out == value);
    CHECK(folder.good(replay + " --guide-file none.guide").out == value);
    CHECK_FALSE(folder.has("none.guide"));
}

TEST_CASE("the commands of a render with a guide file begin with its training", "[guide]") {
    const GuidedFolder folder;
    folder.write("there.toml", folder.read("guided.toml") + "[output]\nfile = 'out.exr'\nstats = 'out.json'\n");
    const std::string flags = " --guide-file sub/../g --shards 2 --no-calibration --commands";
    const Outcome printed = folder.good("render there.toml" + flags + "=json");
    std::istringstream lines(printed.out);
    std::vector<Json> commands;
    for (std::string line; std::getline(lines, line);) commands.push_back(parse_json(line));
    REQUIRE(commands.size() == 4);
    CHECK(commands[0]["name"] == "guide");
    CHECK(commands[0]["target"] == folder.path("g"));
    CHECK(commands[0]["arguments"].back() == "--guide-only");
    for (const int shard : {1, 2}) {
        CHECK(commands[static_cast<std::size_t>(shard)]["needs"] == Json::array({"guide"}));
        const std::string words = commands[static_cast<std::size_t>(shard)]["arguments"].dump();
        CHECK(contains(words, "\"--guide-file\",\"" + folder.path("g") + "\""));
        CHECK_FALSE(contains(words, "--guide-only"));
    }
    // A guide of the same render that is there already does not disturb the test render of --commands.
    (void)folder.good("render there.toml --guide-file g --guide-only");
    CHECK_FALSE(folder.has("out.json"));
    CHECK(contains(folder.good("render there.toml --guide-file g --shards 2 --commands").out, "--guide-only"));
    folder.write("commands", folder.good("render there.toml --guide-file h --shards 2 --commands").out);
    CHECK(run_shell(folder, "cd / && sh '" + folder.path("commands") + "'").code == 0);
    (void)folder.good("render guided.toml -o whole.exr");
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
    CHECK((folder.read("g") == folder.read("h")));
}

TEST_CASE("a guide file in a job is relative to the job", "[guide]") {
    const GuidedFolder folder;
    folder.write("sub/job.toml", R"([scene]
file = "../room.pbrt"
[render]
guide_file = "its.guide"
[integrator]
type = "bdpt"
guide = "on"
guidesamples = 2
)");
    (void)folder.good("render sub/job.toml -o out.exr");
    CHECK(folder.has("sub/its.guide"));
}

TEST_CASE("guide files that cannot be used are refused by name", "[guide][law7]") {
    const GuidedFolder folder;
    const std::string render = "render guided.toml -o out.exr --guide-file ";
    (void)folder.good(render + "ours.guide --guide-only");
    check_refused(
        folder, render + "ours.guide --seed 1",
        {"ours.guide", "it belongs to another render", "seed: 0 there, 1 here", "a name that does not exist yet"});
    check_refused(folder, render + "ours.guide --spp 256 --shard 1/2", {"training: 16 samples", "64 samples of each"});
    folder.write("other.pbrt", folder.read("room.pbrt") + "\nLightSource \"point\"\n");
    folder.write("other.toml",
                 "[scene]\nfile = 'other.pbrt'\n[render]\nspp = 64\n[integrator]\ntype = 'path'\n"
                 "guide = 'on'\n");
    check_refused(folder, "render other.toml -o out.exr --guide-file ours.guide", {"ours.guide", "scene: "});
    folder.write("cut.guide", folder.read("ours.guide").substr(0, 300));
    check_refused(folder, render + "cut.guide", {"cut.guide", "truncated: it ends after 300 bytes"});
    check_refused(folder, render + ".", {"cannot use this guide file"});
    check_refused(folder, render + "missing/g", {"missing/g"});
    check_refused(folder, render + "room.pbrt", {"room.pbrt", "cannot use this guide file"});
    check_refused(folder, render + "out.exr", {"'out.exr' is already an input or another output"});
    for (const char* commands : {"", " --shards 2 --commands", " --shards 2 --commands --no-calibration"})
        check_refused(folder, std::string("render room.pbrt -o out.exr --guide-file g") + commands,
                      {"'path' learns no guide", "\"auto\""});
    check_refused(folder, "render guided.toml -o out.exr --guide-only", {"--guide-only", "expected --guide-file FILE"});
    check_refused(folder, render + "g --guide-only --shard 1/2", {"--guide-only", "no --shard, --resume and --replay"});
    check_refused(folder, "render room.pbrt -o out.exr --guide-file g --pass 'path:C<RD>.*:guide=on' --pass path:rest",
                  {"passes do not support a guide file"});
}
