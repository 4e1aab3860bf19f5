// One cell's samples over several runs: parts merge to the bits of the whole, and incomplete sets are refused.
#include <catch2/catch.hpp>

#include <filesystem>

#include "experiments/job/text/json.h"
#include "experiments/study/results.h"
#include "experiments/study/results_file.h"
#include "tests/experiments/support.h"

using namespace raylex::experiments;
using raylex::test::Folder;
using raylex::test::Outcome;

namespace fs = std::filesystem;
using raylex::experiments::Json;
using raylex::experiments::parse_json;

namespace {

const std::string scene = R"(replicates = 1
threads = 2
[[scene]]
name = "room"
file = "room.pbrt"
)";
const std::string channels = R"(
[[channel]]
name = "direct"
lpe = "CDL"
)";

Outcome raylex_run(const Folder& folder, const std::string& arguments, int code = 0) {
    Outcome outcome = raylex::test::run_raylex(folder, "experiment " + arguments);
    INFO(arguments << "\n" << outcome.out << outcome.err);
    REQUIRE(outcome.code == code);
    return outcome;
}

std::string bits_of(const Folder& folder, const std::string& run) {
    std::string bits;
    for (const char* file :
         {"record.bin", "samples.npy", "beauty.mean.npy", "beauty.m2.npy", "direct.mean.npy", "direct.m2.npy"})
        if (folder.has(run + "/" + file)) bits += file + folder.read(run + "/" + file);
    return bits;
}

void edit(const Folder& folder, const std::string& file, const std::function<void(Json&)>& change) {
    Json json = parse_json(folder.read(file));
    change(json);
    folder.write(file, json.dump());
}

}  // namespace

TEST_CASE("parts of cells merge to the bits of the whole, for every method that has parts", "[law3][gate]") {
    const Folder folder;
    folder.write("room.pbrt", raylex::test::small_scene());
    folder.write("c.toml", scene + R"(
[[method]]
name = "deep"
[[method]]
name = "splat"
filter_mode = "splat"
[[method]]
name = "light"
integrator = "lighttracer"
[[method]]
name = "chains"
integrator = "pssmlt"
[budget]
samples = [16, 56]
error = ["90%"]
[[exclude]]
method = "splat"
error = true
[[exclude]]
method = "light"
error = true
[[exclude]]
method = "chains"
error = true
)" + channels);
    const std::string plan = raylex_run(folder, "plan c.toml --split-cells 3 --no-calibration").out;
    for (const char* note : {"budget of 16spp stay whole: a part needs at least 16 samples",
                             "budget of e0.9 stay whole: the number of samples for a budget of error",
                             "'chains' with a budget of 56spp stay whole: the Markov chains of integrator 'pssmlt'"}) {
        CAPTURE(note);
        CHECK(plan.find(note) != std::string::npos);
    }
    raylex_run(folder, "run c.toml -o whole");
    for (const char* part : {"1", "2"})
        raylex_run(folder, std::string("run c.toml -o part") + part + " --split-cells 3 --shard " + part + "/2");
    raylex_run(folder, "merge part1 part2 -o merged");
    raylex_run(folder, "merge part2 part1 -o again");

    const auto whole = read_experiment(folder.path("whole")), merged = read_experiment(folder.path("merged"));
    REQUIRE((whole && merged));
    REQUIRE(merged->runs.size() == whole->runs.size());
    CHECK(merged->missing.empty());
    for (std::size_t i = 0; i < whole->runs.size(); ++i) {
        const StudyRun &one = whole->runs[i], &sum = merged->runs[i];
        CAPTURE(one.id);
        CHECK((bits_of(folder, "whole/cells/" + one.id) == bits_of(folder, "merged/cells/" + one.id)));
        CHECK((folder.read("merged/cells/" + one.id + "/cell.json") ==
               folder.read("again/cells/" + one.id + "/cell.json")));
        CHECK(sum.samples_per_pixel == one.samples_per_pixel);
        const bool in_parts = one.budget == 56 && one.method != "chains";
        CHECK(sum.parts == (in_parts ? 3 : 0));
        if (!in_parts) continue;
        CHECK(sum.rays == one.rays);
        REQUIRE(sum.splits.size() == one.splits.size());
        CHECK(sum.splits.front().holds);
        CHECK(sum.splits.front().worst_relative_error == one.splits.front().worst_relative_error);
        double cpu = 0, wall = 0;
        for (const char* part : {"part1", "part2"})
            for (const char* name : {".p1of3", ".p2of3", ".p3of3"}) {
                const std::string file = std::string(part) + "/cells/" + one.id + name + "/cell.json";
                if (!folder.has(file)) continue;
                const Json json = parse_json(folder.read(file));
                cpu += json.at("cpu_seconds").get<double>();
                wall += json.at("wall_seconds").get<double>();
            }
        // Three sums of one double each.
        CHECK(sum.cpu_seconds == Approx(cpu).epsilon(1e-14));
        CHECK(sum.wall_seconds == Approx(wall).epsilon(1e-14));
    }
    CHECK(raylex_run(folder, "replay c.toml room.deep.56spp.r0 -o merged").out.find("the same bits") !=
          std::string::npos);
}

TEST_CASE("incomplete sets of parts are refused by name, before anything is written", "[law7][gate]") {
    const Folder folder;
    folder.write("room.pbrt", raylex::test::small_scene());
    folder.write("c.toml", scene + "[[method]]\nname = \"deep\"\n[budget]\nsamples = 56\n" + channels);
    const std::string split = "run c.toml --split-cells 3 -o ";
    for (const char* part : {"1", "2", "3"}) raylex_run(folder, split + "part" + part + " --shard " + part + "/3");
    raylex_run(folder, "run c.toml -o whole");
    raylex_run(folder, "run c.toml --split-cells 2 -o halves");
    const std::string run = "room.deep.56spp.r0", all = "merge part1 part2 part3 ";
    const auto refused = [&](const std::string& arguments, const std::string& with) {
        CAPTURE(with);
        CHECK(raylex_run(folder, arguments + " -o bad", 2).err.find(with) != std::string::npos);
        CHECK_FALSE(folder.has("bad"));
    };
    refused("merge part1 part3", "cell '" + run + "' is incomplete: samples 16 to 31 are in no directory");
    refused("merge part1 part2", "samples 32 to 55 are in no directory");
    refused("merge part3 part2", "samples 0 to 15 are in no directory");
    refused(all + "part2", "has samples 16 to 31, and");
    refused(all + "halves", "they overlap");
    refused(all + "whole", "its cell is finished in 'whole/cells/" + run + "'");
    raylex_run(folder, split + "other --set seed=5 --shard 1/3");
    refused("merge part1 other", "another config");
    CHECK(raylex_run(folder, "resume c.toml -o part1 --split-cells 2", 2).err.find("does not belong to this run") !=
          std::string::npos);
    CHECK(raylex_run(folder, split + "part1", 2).err.find("'raylex experiment resume' continues") != std::string::npos);
    // A failed part makes a failed cell; if another directory has it finished, it is finished.
    const std::string second = "part2/cells/" + run + ".p2of3";
    const std::string good = folder.read(second + "/cell.json");
    edit(folder, second + "/cell.json", [](Json& json) { json["isa"] = "sse2"; });
    refused(all, "so they do not belong to one render");
    folder.write(second + "/cell.json", good);
    edit(folder, second + "/cell.json", [](Json& json) { json["seed"] = 7; });
    refused(all, "this part has seed 7");
    folder.write(second + "/cell.json", good);
    const std::string record = folder.read("part2/experiment.json");
    edit(folder, "part2/experiment.json", [](Json& json) { json["provenance"]["revision"] = "elsewhere"; });
    refused(all, "come from another program (revision elsewhere)");
    folder.write("part2/experiment.json", record);
    fs::create_directories(folder.path("part2/failed"));
    Json failed = parse_json(good);
    failed["state"] = "failed";
    const std::string failed_file = "part2/failed/" + run + ".p2of3.json";
    folder.write(failed_file, failed.dump());
    const auto without_reason = read_run_file(folder.path(failed_file));
    REQUIRE_FALSE(without_reason);
    CHECK(without_reason.error().message.find("'reason'") != std::string::npos);
    failed["reason"] = "out of memory";
    folder.write(failed_file, failed.dump());
    raylex_run(folder, all + "-o done");
    CHECK(bits_of(folder, "done/cells/" + run) == bits_of(folder, "whole/cells/" + run));
    fs::remove_all(folder.path(second));
    raylex_run(folder, all + "-o failed");
    const auto results = read_experiment(folder.path("failed"));
    REQUIRE(results);
    REQUIRE(results->runs.size() == 1);
    CHECK(results->runs.front().failure == "part '" + run + ".p2of3' failed: out of memory");
}
