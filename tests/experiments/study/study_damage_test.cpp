// Damaged result files: replay, resume, merge and report name them.
#include <catch2/catch.hpp>

#include <filesystem>
#include <functional>

#include "experiments/study/file_records.h"
#include "experiments/study/results.h"
#include "tests/experiments/support.h"

using namespace raylex::experiments;
using raylex::test::Folder;
using raylex::test::Outcome;
using raylex::test::run_raylex;
using raylex::test::small_scene;

namespace fs = std::filesystem;

TEST_CASE("damage in every file of a cell is named, and the cell is rendered again, refused or left out",
          "[law7][gate]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    folder.write("c.toml", R"(threads = 1
[[scene]]
name = "room"
file = "room.pbrt"
resolution = [4, 4]
[[method]]
name = "path"
[budget]
samples = [2, 4]
[reference]
method = "path"
spp = 16
[[channel]]
name = "direct"
lpe = "CDL"
)");
    REQUIRE(run_raylex(folder, "experiment run c.toml -o out").code == 0);
    const std::string id = "room.path.2spp.r0", run = "out/cells/" + id + "/";
    auto results = read_experiment(folder.path("out"));
    REQUIRE(results);
    REQUIRE(results->runs.front().id == id);
    std::vector<std::string> names;
    for (const FileRecord& each : results->runs.front().files) names.push_back(each.name);
    CHECK(names == std::vector<std::string>{"beauty.m2.npy", "beauty.mean.npy", "direct.m2.npy", "direct.mean.npy",
                                            "image.exr", "record.bin", "rest.m2.npy", "rest.mean.npy", "samples.npy"});
    const Outcome same = run_raylex(folder, "experiment replay c.toml " + id + " -o out");
    CHECK(same.code == 0);
    CHECK(same.out.find("the same bits, in record.bin, beauty.m2.npy, beauty.mean.npy") != std::string::npos);
    fs::copy(folder.path("out"), folder.path("whole"), fs::copy_options::recursive);
    const auto begin_anew = [&] {
        fs::remove_all(folder.path("out"));
        fs::copy(folder.path("whole"), folder.path("out"), fs::copy_options::recursive);
    };
    const std::vector<std::function<void(const std::string&)>> damages{
        [&](const std::string& file) { fs::remove(folder.path(file)); },
        [&](const std::string& file) { fs::resize_file(folder.path(file), 5); },
        [&](const std::string& file) {
            std::string bytes = folder.read(file);
            bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
            folder.write(file, bytes);
        }};
    std::size_t turn = 0;
    for (const std::string& name : names) {
        CAPTURE(name);
        damages[turn++ % damages.size()](run + name);
        const Outcome replay = run_raylex(folder, "experiment replay c.toml " + id + " -o out");
        CHECK(replay.code == 1);
        CHECK(replay.out.find("DIFFERS in ") != std::string::npos);
        CHECK(replay.out.find(name + ": this file") != std::string::npos);
        if (turn > 3) {
            begin_anew();
            continue;
        }
        const Outcome merge = run_raylex(folder, "experiment merge out -o merged");
        CHECK(merge.code == 2);
        CHECK(merge.err.find(name + ": this file") != std::string::npos);
        CHECK_FALSE(folder.has("merged"));
        const Outcome report = run_raylex(folder, "experiment report c.toml -o out");
        CHECK(report.code == 2);
        CHECK(report.err.find("is damaged and is left out: ") != std::string::npos);
        CHECK(folder.read("out/report.html").find(name + ": this file") != std::string::npos);
        const Outcome resume = run_raylex(folder, "experiment resume c.toml -o out");
        CHECK(resume.code == 0);
        CHECK(resume.err.find("cell '" + id + "' is damaged and is rendered again: ") != std::string::npos);
        CHECK(folder.has("out/damaged/" + id + "/cell.json"));
        CHECK(run_raylex(folder, "experiment replay c.toml " + id + " -o out").code == 0);
        CHECK(run_raylex(folder, "experiment merge out -o merged").code == 0);
        fs::remove_all(folder.path("merged"));
        begin_anew();
    }
    // A checksum changed together with its file: the new render shows the difference.
    std::string bytes = folder.read(run + "direct.mean.npy");
    bytes[bytes.size() - 2] = static_cast<char>(bytes[bytes.size() - 2] ^ 1);
    folder.write(run + "direct.mean.npy", bytes);
    auto records = file_records(folder.path(run));
    REQUIRE(records);
    std::string json = folder.read(run + "cell.json");
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == "direct.mean.npy") {
            const std::string before = results->runs.front().files[i].hash;
            json.replace(json.find(before, json.find("\"direct.mean.npy\"")), before.size(), (*records)[i].hash);
        }
    folder.write(run + "cell.json", json);
    const Outcome forged = run_raylex(folder, "experiment replay c.toml " + id + " -o out");
    CHECK(forged.code == 1);
    CHECK(forged.out.find("DIFFERS in direct.mean.npy") != std::string::npos);
    begin_anew();
    // The files of a reference are checked too.
    const std::string reference = results->scenes.front().reference.substr(folder.path("").size());
    fs::resize_file(folder.path(reference + "/beauty.mean.npy"), 100);
    for (const char* step : {"resume c.toml -o out", "merge out -o merged", "report c.toml -o out"}) {
        CAPTURE(step);
        const Outcome outcome = run_raylex(folder, std::string("experiment ") + step);
        CHECK(outcome.code == 2);
        CHECK(outcome.err.find("beauty.mean.npy: this file has 100 bytes") != std::string::npos);
    }
}
