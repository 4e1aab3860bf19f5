// raylex experiment as a user runs it: small scenes, every step from plan to merge, and errors.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <thread>

#include "display/output/reader/exr_reader.h"
#include "experiment_support.h"
#include "experiments/job/text/json.h"
#include "experiments/study/results.h"
#include "support.h"
#include "support/skip.h"

using namespace raylex::experiments;
using raylex::test::contains;
using raylex::test::experiment_config;
using raylex::test::Folder;
using raylex::test::Outcome;
using raylex::test::prepare;
using raylex::test::results_of;
using raylex::test::run_raylex;
using raylex::test::run_shell;
using raylex::test::small_scene;
using raylex::test::succeed;

namespace fs = std::filesystem;

namespace {

/// Returns the properties of a cell that must not depend on where and when it runs.
std::string bits_of(const Folder& folder, const std::string& results, const std::string& id) {
    std::string bits;
    for (const char* file :
         {"record.bin", "beauty.mean.npy", "beauty.m2.npy", "direct.mean.npy", "direct.m2.npy", "samples.npy"})
        bits += folder.read(results + "/cells/" + id + "/" + file) + "\n";
    return bits;
}

}  // namespace

TEST_CASE("a plan has times even if the calibration ends before its first pass", "[gate]") {
    // A white box that no path leaves: 64 x 64 paths with 3,000 scattering events take one thread seconds, like a small
    // image on a busy machine.
    const Folder folder;
    prepare(folder, R"(replicates = 2
threads = 1
[[scene]]
name = "box"
file = "box.pbrt"
[[method]]
name = "deep"
integrator = { type = "path", roulette = false }
max_depth = 3000
[[method]]
name = "other"
command = ": {out} {seed} {spp}"
[budget]
samples = [4, 64]
)");
    folder.write("box.pbrt", R"(Film "rgb" "integer xresolution" 64 "integer yresolution" 64
LookAt 0 0 0  0 0 1  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
LightSource "point" "rgb I" [1 1 1]
Material "diffuse" "rgb reflectance" [1 1 1]
ReverseOrientation
Shape "sphere" "float radius" 2
)");
    const Outcome plan = succeed(folder, "experiment plan c.toml");
    INFO(plan.out << plan.err);
    CHECK(raylex::test::count_matches(plan.out, "box\\.deep\\.[0-9]+spp\\.r[01]  seed [0-9]+  about ") == 4);
    // A plan does not run the command of another renderer.
    CHECK(raylex::test::count_matches(plan.out, "box\\.other\\.[0-9]+spp\\.r[01]  seed [0-9]+  time unknown") == 4);
    CHECK(plan.out.find("(the time of 4 cells is unknown)") != std::string::npos);
}

TEST_CASE("an experiment stores every cell's image and sums, and refuses to start twice", "[gate]") {
    const Folder folder;
    prepare(folder);
    const Outcome plan = succeed(folder, "experiment plan c.toml");
    CHECK(plan.out.find("room.shallow.24spp.r1  seed ") != std::string::npos);
    CHECK(plan.out.find("8 cells: 1 scene, 2 pairs of scene and settings, 2 budgets, 2 replicates") !=
          std::string::npos);
    CHECK(plan.out.find("a short render of every scene") != std::string::npos);
    CHECK(plan.out.find("memory: ") != std::string::npos);
    CHECK(folder.names() == std::vector<std::string>{"c.toml", "room.pbrt"});

    // A run that failed before its start does not block another one, and a folder with other files is not touched.
    CHECK(succeed(folder, "experiment run c.toml -o out --set method.deep.integrator=nothing-like-it", 2).out.empty());
    fs::create_directory(folder.path("mine"));
    folder.write("mine/thesis.tex", "");
    CHECK(succeed(folder, "experiment run c.toml -o mine", 2).err.find("neither empty nor a results directory") !=
          std::string::npos);

    const Outcome run = succeed(folder, "experiment run c.toml -o out");
    CHECK(run.out.find("out: 8 of 8 cells done") != std::string::npos);
    CHECK(run.out.find("% of render time") != std::string::npos);
    const Experiment results = results_of(folder, "out");
    REQUIRE(results.runs.size() == 8);
    CHECK(results.missing.empty());
    REQUIRE(results.scenes.size() == 1);
    const SceneInfo& scene = results.scenes.front();
    CHECK(scene.width == 16);
    REQUIRE(scene.channels.size() == 3);  // beauty, direct, rest
    CHECK(scene.channels[1].expression == "CDL");
    CHECK(scene.reference_samples == 64);
    CHECK(scene.reference_relative_error > 0);
    REQUIRE(read_mean(scene.reference, "beauty"));
    REQUIRE(read_m2(scene.reference, "direct"));
    for (const StudyRun& cell : results.runs) {
        CAPTURE(cell.id);
        CHECK(cell.samples_per_pixel == static_cast<std::uint64_t>(cell.budget));
        CHECK(cell.wall_seconds > 0);
        CHECK(cell.cpu_seconds > 0);
        CHECK(cell.rays > 0);
        REQUIRE(cell.phases.size() == 6);
        REQUIRE(cell.splits.size() == 1);
        CHECK(cell.splits.front().holds);
        // The arrays equal the image up to rounding to float, 2^-24.
        auto image = raylex::display::read_exr(cell.directory + "/image.exr");
        auto mean = read_mean(cell.directory, "direct");
        auto m2 = read_m2(cell.directory, "direct");
        auto samples = read_samples(cell.directory);
        REQUIRE(image);
        REQUIRE(mean);
        REQUIRE(m2);
        REQUIRE(samples);
        REQUIRE(mean->values.size() == 16 * 16 * 3);
        const auto* layer = image->layer("direct");
        REQUIRE(layer != nullptr);
        double sum = 0, squares = 0;
        for (std::size_t i = 0; i < mean->values.size(); ++i) {
            const double value = mean->values[i];
            const auto stored = static_cast<double>(layer->triple()[i % 3]->values[i / 3]);
            CHECK(std::abs(stored - value) <= std::ldexp(std::abs(value), -24));
            CHECK(samples->values[i / 3] == cell.budget);
            sum += value;
            squares += m2->values[i];
        }
        CHECK(sum > 0);
        CHECK(squares > 0);
    }
    // No checkpoint, partial directory or other temporary file is left.
    for (const auto& entry : fs::directory_iterator(folder.path("out/cells")))
        CHECK(fs::exists(entry.path() / "cell.json"));

    const Outcome again = succeed(folder, "experiment run c.toml -o out", 2);
    CHECK(again.err.find("out: there are 8 finished cells of this config already") != std::string::npos);
    CHECK(again.err.find("experiment resume") != std::string::npos);
    // Without Debian's d3 there is no page, and a message explains that.
    const Outcome report = run_raylex(folder, "experiment report c.toml -o out");
    CAPTURE(report.out, report.err);
    const bool has_d3 = report.err.find("libjs-d3") == std::string::npos;
    CHECK(report.code == (has_d3 ? 0 : 2));
    for (const char* file : {"out/report.html", "out/results.csv", "out/results.jsonl"})
        CHECK(folder.has(file) == has_d3);
    CHECK(succeed(folder, "experiment report c.toml -o out --set replicates=3", 2).err.find("another config") !=
          std::string::npos);
    const Outcome other = succeed(folder, "experiment resume c.toml -o out --set replicates=3", 2);
    CHECK(other.err.find("another config") != std::string::npos);
    CHECK(succeed(folder, "experiment replay c.toml room.deep.24spp.r1 -o out").out.find("the same bits") !=
          std::string::npos);
    CHECK(succeed(folder, "experiment replay c.toml room.deep.24spp.r2 -o out", 2)
              .err.find("did you mean 'room.deep.24spp.r") != std::string::npos);
    // A modified cell is not equal.
    fs::copy_file(folder.path("out/cells/room.deep.24spp.r0/record.bin"),
                  folder.path("out/cells/room.deep.24spp.r1/record.bin"), fs::copy_options::overwrite_existing);
    CHECK(succeed(folder, "experiment replay c.toml room.deep.24spp.r1 -o out", 1).out.find("DIFFERS") !=
          std::string::npos);
    // An incomplete cell is named and refused.
    fs::remove(folder.path("out/cells/room.deep.4spp.r1/cell.json"));
    CHECK(
        succeed(folder, "experiment resume c.toml -o out", 2).err.find("room.deep.4spp.r1: this cell is incomplete") !=
        std::string::npos);
    fs::remove_all(folder.path("out/cells/room.deep.4spp.r1"));
    succeed(folder, "experiment resume c.toml -o out");
    CHECK(results_of(folder, "out").runs.size() == 8);
    // Resume also refuses a changed scene.
    fs::remove_all(folder.path("out/cells/room.deep.4spp.r1"));
    std::string changed = small_scene();
    changed.replace(changed.find("I\" [3 3 3]"), 10, "I\" [4 3 3]");
    folder.write("room.pbrt", changed);
    CHECK(succeed(folder, "experiment resume c.toml -o out", 2).err.find("has changed since") != std::string::npos);
}

TEST_CASE("a study measures perceptual errors of the beauty, like raylex compare") {
    const Folder folder;
    prepare(folder, experiment_config.substr(0, experiment_config.find("[[method]]\nname = \"shallow\"")) +
                        "[budget]\nsamples = [4]\n[[channel]]\nname = \"direct\"\nlpe = \"CDL\"\n");
    std::string text = folder.read("c.toml");
    text.insert(text.find("[[method]]"), "reference = \"truth.exr\"\n");
    folder.write("c.toml", text);
    succeed(folder, "render room.pbrt -o truth.exr --lpe direct=CDL --spp 64");
    succeed(folder, "experiment run c.toml -o out");
    if (run_raylex(folder, "experiment report c.toml -o out").code != 0) RAYLEX_SKIP("needs the package libjs-d3");
    std::istringstream lines(folder.read("out/results.jsonl"));
    std::size_t seen = 0;
    for (std::string line; std::getline(lines, line);) {
        if (!contains(line, "\"kind\":\"cell\"")) continue;
        const bool beauty = contains(line, "\"channel\":\"beauty\"");
        CHECK(contains(line, "\"ssim\":") == beauty);
        if (!beauty) continue;
        for (const std::string metric : {"ssim", "flip"}) {
            const std::string cell =
                line.substr(line.find("\"room."), line.find("\",", line.find("\"room.")) - line.find("\"room."));
            const Outcome compared =
                succeed(folder, "compare out/cells/" + cell.substr(1) + "/image.exr truth.exr --metric " + metric);
            const double value = std::stod(line.substr(line.find("\"" + metric + "\":") + metric.size() + 3));
            // The study has doubles, the image the nearest floats; roots in FLIP enlarge the rounding errors.
            CHECK(value == Approx(std::stod(compared.out)).epsilon(1e-5));
            ++seen;
        }
    }
    CHECK(seen == 4);
}

TEST_CASE("shards merge to the unsharded run bit for bit, in any order; overlaps are refused", "[law3][gate]") {
    const Folder folder;
    prepare(folder);
    succeed(folder, "experiment run c.toml -o whole");
    for (const char* part : {"1", "2", "3"})
        succeed(folder, std::string("experiment run c.toml -o part") + part + " --shard " + part + "/3");
    succeed(folder, "experiment merge part1 part2 part3 -o merged");
    succeed(folder, "experiment merge part3 part1 part2 -o again");
    const Experiment whole = results_of(folder, "whole"), merged = results_of(folder, "merged");
    REQUIRE(merged.runs.size() == whole.runs.size());
    for (const StudyRun& cell : whole.runs) {
        CAPTURE(cell.id);
        CHECK((bits_of(folder, "whole", cell.id) == bits_of(folder, "merged", cell.id)));
        CHECK((folder.read("merged/cells/" + cell.id + "/cell.json") ==
               folder.read("again/cells/" + cell.id + "/cell.json")));
    }
    CHECK((folder.read("merged/experiment.json") == folder.read("again/experiment.json")));
    CHECK(fs::exists(merged.scenes.front().reference + "/reference.json"));

    CHECK(succeed(folder, "experiment merge part1 whole -o bad", 2).err.find("is finished here and also in") !=
          std::string::npos);
    CHECK(succeed(folder, "experiment merge part1 part2 -o merged", 2).err.find("expected a new one") !=
          std::string::npos);
    succeed(folder, "experiment run c.toml -o other --set replicates=1");
    CHECK(succeed(folder, "experiment merge part1 other -o bad", 2).err.find("another config") != std::string::npos);
    // Two cells with the same seed would be the same render.
    auto edit = [&](const std::string& file, const std::string& list) {
        auto json = raylex::experiments::parse_json(folder.read(file));
        if (list.empty()) json["seed"] = 7;
        else
            for (auto& each : json[list]) each["seed"] = 7;
        folder.write(file, json.dump());
    };
    for (const StudyRun& each : results_of(folder, "part1").runs) edit("part1/cells/" + each.id + "/cell.json", "");
    edit("part1/experiment.json", "cells");
    CHECK(succeed(folder, "experiment merge part1 part2 -o bad", 2).err.find("have the same seed 7") !=
          std::string::npos);
    CHECK_FALSE(folder.has("bad"));
}

TEST_CASE("a killed experiment resumes inside the cell, with the same bits", "[release-only][law3][gate]") {
    const Folder folder;
    prepare(folder, "checkpoint = '0.02s'\n" + experiment_config);
    const std::string budget = " --set budget.samples=20000 --set replicates=1 --set reference.spp=16";
    succeed(folder, "experiment run c.toml -o whole" + budget);
    const Outcome killed = run_shell(
        folder,
        "\"$RAYLEX\" experiment run c.toml -o out" + budget +
            " & pid=$!\nfor i in $(seq 1500); do [ -e out/cells/room.deep.20000spp.r0.partial/render.checkpoint ] && "
            "break; sleep 0.02; done\nkill -9 $pid || exit 7\nwait $pid\n[ $? = 137 ]");
    CAPTURE(killed.out, killed.err);
    REQUIRE(killed.code == 0);
    REQUIRE(folder.has("out/cells/room.deep.20000spp.r0.partial/render.checkpoint"));
    // Ctrl-C in the second session; the third one finishes.
    const Outcome stopped = run_shell(folder, "\"$RAYLEX\" experiment resume c.toml -o out" + budget +
                                                  " & pid=$!\nsleep 0.4\nkill -INT $pid\nwait $pid");
    CAPTURE(stopped.out, stopped.err);
    CHECK((stopped.code == 130 || stopped.code == 0));
    succeed(folder, "experiment resume c.toml -o out" + budget);
    const Experiment results = results_of(folder, "out");
    REQUIRE(results.runs.size() == 2);
    for (const StudyRun& cell : results.runs)
        CHECK((bits_of(folder, "out", cell.id) == bits_of(folder, "whole", cell.id)));
    CHECK(results.time.total > 0);
    for (const auto& entry : fs::recursive_directory_iterator(folder.path("out")))
        CHECK(entry.path().extension() != ".checkpoint");
}

TEST_CASE("a split that does not hold is rendered and measured, with a counterexample") {
    const Folder folder;
    prepare(folder, experiment_config + R"([[channel]]
name = "lit"
lpe = "C.+L"
[[channel]]
name = "seen"
lpe = "CL"
[[partition]]
name = "double"
channels = ["lit", "seen", "direct"]
)");
    const Outcome run = succeed(folder, "experiment run c.toml -o out --set replicates=1 --set budget.samples=4", 1);
    CHECK(run.out.find("split 'double' DOES NOT HOLD") != std::string::npos);
    const Experiment results = results_of(folder, "out");
    REQUIRE(results.runs.size() == 2);
    for (const StudyRun& cell : results.runs) {
        REQUIRE(cell.splits.size() == 1);
        CHECK_FALSE(cell.splits.front().holds);
        // Direct light is counted twice: |2 b - b| relative to 2 b + b. With indirect light the fraction is smaller.
        CHECK(cell.splits.front().worst_relative_error == Approx(1.0 / 3).epsilon(1e-6));
        CHECK(std::filesystem::exists(cell.directory + "/double.residual.png"));
        REQUIRE_FALSE(cell.warnings.empty());
        CHECK(std::any_of(cell.warnings.begin(), cell.warnings.end(), [](const std::string& each) {
            return each.find("partition 'double' does not hold: 'direct' and 'lit' both count") != std::string::npos ||
                   each.find("partition 'double' does not hold: 'lit' and 'direct' both count") != std::string::npos;
        }));
    }
    succeed(folder, "experiment report c.toml -o out --set replicates=1 --set budget.samples=4");
    CHECK(folder.read("out/report.html").find("alt=\"where double fails\"") != std::string::npos);
}

TEST_CASE("no two processes run cells into one directory") {
    const Folder folder;
    prepare(folder);
    const std::string endless = " c.toml -o out --set replicates=1 --set budget.seconds=60 --set reference.spp=1";
    const Outcome outcome =
        run_shell(folder, "\"$RAYLEX\" experiment run" + endless +
                              " >first.txt 2>&1 & pid=$!\n"
                              "for i in $(seq 1500); do [ -e out/experiment.json ] && break; sleep 0.02; done\n"
                              "\"$RAYLEX\" experiment resume" +
                              endless + "; code=$?\nkill -INT $pid\nwait $pid\nexit $code");
    CAPTURE(outcome.out);
    CHECK(outcome.code == 2);
    CHECK(outcome.err.find("another process is running cells into this directory") != std::string::npos);
    CHECK(folder.read("first.txt")
              .find("'raylex experiment resume' with the same config and directory continues from here") !=
          std::string::npos);
}

TEST_CASE("a study by the CPU clock records the load of other processes, and warns of a busy machine", "[gate]") {
    if (!fs::exists("/proc/stat")) RAYLEX_SKIP("needs Linux's /proc/stat");
    const Folder folder;
    prepare(folder);
    const Outcome run = run_shell(folder,
                                  "export RAYLEX; (while :; do :; done) & burner=$!; \"$RAYLEX\" experiment run c.toml "
                                  "-o out --report --set threads=1 --set budget.samples=4096 --set replicates=1; "
                                  "code=$?; kill $burner; exit $code");
    INFO(run.out << run.err);
    REQUIRE(run.code == 0);
    const Experiment results = results_of(folder, "out");
    CHECK(results.cpu_clock);  // by default, because other processes increase wall times
    for (const StudyRun& each : results.runs) {
        CAPTURE(each.id, each.other_load);
        CHECK((each.other_load >= 0 && each.other_load <= 1));
        CHECK(each.machine.find("hardware threads") != std::string::npos);
    }
    const double processors = std::max(1U, std::thread::hardware_concurrency());
    // One process takes one processor's time, or half of it if it shares the processor with the render; the warning
    // begins at 5 %.
    if (0.5 / processors > 0.05) {
        CHECK(run.out.find("warning: the machine was not idle: other processes used ") != std::string::npos);
        CHECK(folder.read("out/report.html").find("Times:</span> the machine was not idle") != std::string::npos);
    }
    const std::string page = folder.read("out/report.html");
    CHECK(page.find("<th>CPU seconds</th><th>Wall seconds</th>") != std::string::npos);
    CHECK(folder.read("out/experiment.json").find("\"load average at the start\"") != std::string::npos);

    Experiment idle = results;
    for (StudyRun& each : idle.runs) each.other_load = 0.01;
    CHECK(idle.load_warning().empty());
    for (StudyRun& each : idle.runs) each.other_load = -1;  // unknown
    CHECK(idle.load_warning().empty());
    idle.runs.front().other_load = 0.5;
    CHECK(idle.load_warning().find("used 50 % of its processors") != std::string::npos);
    idle.cpu_clock = false;
    CHECK(idle.load_warning().find("clock = \"cpu\" compares by CPU time") != std::string::npos);
}

TEST_CASE("budgets of time and error store the samples they reached, and replay", "[gate]") {
    const Folder folder;
    prepare(folder);
    succeed(folder,
            "experiment run c.toml -o out --set replicates=1 --set budget.samples=1 --set budget.seconds=0.1 --set "
            "'budget.error=[\"20%\"]'");
    const Experiment results = results_of(folder, "out");
    REQUIRE(results.runs.size() == 6);
    for (const StudyRun& cell : results.runs) {
        CAPTURE(cell.id);
        if (cell.budget_kind == BudgetKind::seconds) CHECK(cell.samples_per_pixel > 1);
        if (cell.budget_kind == BudgetKind::error) CHECK(cell.samples_per_pixel >= 64);
        if (cell.budget_kind != BudgetKind::samples && cell.method == "deep")
            succeed(folder, "experiment replay c.toml " + cell.id +
                                " -o out --set replicates=1 --set budget.samples=1 --set budget.seconds=0.1 --set "
                                "'budget.error=[\"20%\"]'");
    }
}
