// raylex render --checkpoint and --resume: the image has the same bits, however and whenever the program ends.
#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>
#include <set>

#include "display/output/atomic_file.h"
#include "display/output/reader/exr_reader.h"
#include "experiments/cli/command_line.h"
#include "experiments/job/text/json.h"
#include "run_here.h"
#include "support.h"
#include "tests/support/paths.h"

using namespace raylex::test;
using raylex::display::FileCall;

namespace {

/// The arguments of this file's renders except checkpoints: layers of every kind, and an uneven number of samples.
const std::string what = " --lpe direct=CDL --aov Nn --aov id --aov sampleCount --cryptomatte object --threads 2";

/// Shell code that waits for the first checkpoint, so that the program is in the middle of its render.
const std::string until_saved = "for i in $(seq 1500); do [ -e out.exr.checkpoint ] && break; sleep 0.02; done\n";

/// The statistics that are summed over sessions.
std::string sums_of(const Folder& folder, const std::string& name) {
    auto json = raylex::experiments::parse_json(folder.read(name));
    json["samples"].erase("per_cpu_second");
    json["samples"].erase("resumed");
    std::string sums;
    for (const char* key : {"rays", "samples", "path_length_histogram", "attribution_overflow", "invalid_samples",
                            "rejected_block_sums", "refused_services_calls", "complete"})
        sums += json[key].dump() + "\n";
    return sums;
}

std::vector<std::string> short_run(const std::string& folder, bool resume) {
    std::vector<std::string> arguments{"render",       folder + "/room.pbrt",
                                       "-o",           folder + "/out.exr",
                                       "--spp",        "2048",
                                       "--lpe",        "direct=CDL",
                                       "--aov",        "sampleCount",
                                       "--threads",    "2",
                                       "--checkpoint", "0.02s"};
    if (resume) arguments.push_back("--resume");
    return arguments;
}
std::vector<std::string> short_run(const Folder& folder, bool resume) {
    return short_run(folder.path(), resume);
}

}  // namespace

TEST_CASE("a killed render resumes with the same bits", "[release-only][law3][gate]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    // Long enough to be killed: at least half a second.
    const std::string render = "render room.pbrt --spp 8192 --stats s.json" + what;
    REQUIRE(run_raylex(folder, render + " -o whole.exr").code == 0);
    const std::string sums = sums_of(folder, "s.json");
    int kills = 0;
    std::string resume;
    for (; kills < 4; ++kills) {
        // After the first checkpoint, so that it can be resumed.
        const Outcome outcome =
            run_shell(folder, "\"$RAYLEX\" " + render + " -o out.exr --checkpoint 0.02s" + resume + " & pid=$!\n" +
                                  until_saved + "sleep 0.1\nkill -9 $pid || exit 7\nwait $pid\n[ $? = 137 ]");
        CAPTURE(outcome.out, outcome.err);
        if (kills > 0 && outcome.code != 0) break;  // it had finished
        REQUIRE(outcome.code == 0);
        REQUIRE(folder.has("out.exr.checkpoint"));
        CHECK_FALSE(folder.has("out.exr"));
        resume = " --resume";
    }
    CHECK(kills > 0);
    if (folder.has("out.exr.checkpoint")) {
        const Outcome outcome = run_raylex(folder, render + " -o out.exr --resume");
        CAPTURE(outcome.err);
        REQUIRE(outcome.code == 0);
        CHECK(outcome.out.find("resumed from a checkpoint with ") != std::string::npos);
    }
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
    CHECK(sums_of(folder, "s.json") == sums);
    CHECK(folder.names() == std::vector<std::string>{"out.exr", "room.pbrt", "s.json", "whole.exr"});
}

TEST_CASE("Ctrl-C writes a partial image and a checkpoint to resume from", "[gate]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const std::string render = "render room.pbrt --spp 20000" + what;
    const Outcome stopped = run_shell(folder, "\"$RAYLEX\" " + render + " -o out.exr --checkpoint 0.2s & pid=$!\n" +
                                                  until_saved + "kill -INT $pid\nwait $pid");
    CAPTURE(stopped.out, stopped.err);
    REQUIRE(stopped.code == 130);
    CHECK(stopped.out.find("out.exr.checkpoint: --resume continues from here") != std::string::npos);
    CHECK(folder.names() == std::vector<std::string>{"out.exr", "out.exr.checkpoint", "room.pbrt"});
    // Another render would overwrite it.
    const Outcome refused = run_raylex(folder, render + " -o out.exr --checkpoint 60s");
    CHECK(refused.code == 2);
    CHECK(refused.err.find("out.exr.checkpoint: this is the checkpoint of an unfinished render") != std::string::npos);
    REQUIRE(run_raylex(folder, render + " -o out.exr --resume").code == 0);
    REQUIRE(run_raylex(folder, render + " -o whole.exr").code == 0);
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
    CHECK_FALSE(folder.has("out.exr.checkpoint"));
}

TEST_CASE("checkpoints that do not match are refused with exit code 2 and kept", "[law7][gate]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const auto refused = [&](const std::string& arguments, const std::string& word) {
        const std::vector<std::string> before = folder.names();
        const Outcome outcome = run_raylex(folder, "render room.pbrt -o out.exr " + arguments);
        CAPTURE(arguments, outcome.err, word);
        CHECK(outcome.code == 2);
        CHECK(outcome.err.find(word) != std::string::npos);
        CHECK(folder.names() == before);
    };
    refused("--resume", "out.exr.checkpoint: there is no checkpoint to resume from");
    refused("--resume", "omit --resume to start a new render");
    refused("--checkpoint 5x", "'5x' is not a time between checkpoints; expected for example 60s, 5m or 1h");
    refused("--checkpoint 0", "at least 0.01s");
    refused("--checkpoint 60s --deep d.exr", "--deep: a deep image is not saved in checkpoints");
    refused("--until-error 0", "'0' is not a relative error; expected a number above 0 such as 1% or 0.01");
    refused("--until-error 1x", "'1x' is not a relative error");
    refused("--until-error 5", "'5' is not a relative error below 1");
    refused("--until-error 5", "did you mean '5%'?");
    refused("--until-error 5% --spp 1", "at most 1 samples a pixel; expected at least 2");
    const Outcome stopped =
        run_shell(folder, "\"$RAYLEX\" render room.pbrt --spp 20000 -o out.exr --checkpoint 0.2s & pid=$!\n" +
                              until_saved + "kill -INT $pid\nwait $pid");
    REQUIRE(stopped.code == 130);
    const std::string bytes = folder.read("out.exr.checkpoint");
    refused("--spp 20000 --resume --seed 1", "seed: 0 there, 1 here");
    refused("--spp 20000 --resume --lpe direct=CDL", "channel direct: nothing there, CDL");
    refused("--spp 20000 --resume --until-error 1%", "adaptive: nothing there");
    folder.write("out.exr.checkpoint", bytes.substr(0, bytes.size() - 100));
    refused("--spp 20000 --resume", "cannot resume: the file is truncated");
    folder.write("out.exr.checkpoint", "something else");
    refused("--spp 20000 --resume", "cannot resume: ");
    std::string scene = small_scene();
    scene.replace(scene.find(".5 .4 .3"), 8, ".5 .4 .2");
    folder.write("out.exr.checkpoint", bytes);
    folder.write("room.pbrt", scene);
    refused("--spp 20000 --resume", "scene: ");
}

TEST_CASE("a running render locks its checkpoint", "[law7]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    // The second render starts while the first one saves, and does not touch its checkpoint.
    const Outcome both = run_shell(
        folder, "\"$RAYLEX\" render room.pbrt --spp 200000 -o out.exr --checkpoint 0.2s & pid=$!\n" + until_saved +
                    "\"$RAYLEX\" render room.pbrt --spp 200000 -o out.exr --resume 2>second\n"
                    "echo code $?\nkill -INT $pid\nwait $pid");
    CHECK(both.code == 130);
    CHECK(both.out.find("code 2") != std::string::npos);
    CHECK(folder.read("second").find("another process is rendering this image") != std::string::npos);
    CHECK(folder.names().size() == 4);  // room.pbrt, out.exr, its checkpoint, second
    // After the first one has ended, its checkpoint can be used.
    const Outcome third = run_raylex(folder, "render room.pbrt --spp 200000 -o out.exr --resume --seed 1");
    CHECK(third.code == 2);
    CHECK(third.err.find("seed: 0 there, 1 here") != std::string::npos);
}

TEST_CASE("a job can request checkpoints and adaptive sampling") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    folder.write("job.toml", R"([scene]
file = "room.pbrt"
[output]
file = "out.exr"
stats = "s.json"
[render]
checkpoint = "0.02s"
threads = 2
[channels]
aovs = ["sampleCount"]
[[channel]]
name = "direct"
lpe = "CDL"
[adaptive]
error = "20%"
channels = ["beauty", {name = "direct", weight = 0.5}]
min_samples = 32
max_samples = 1000
floor = 0.2
neighbourhood = 2
)");
    const Outcome outcome = run_raylex(folder, "render job.toml");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("adaptive: ") != std::string::npos);
    auto image = raylex::display::read_exr(folder.path("out.exr"));
    REQUIRE(image);
    CHECK(image->attributes["raylex/adaptive"] ==
          "error 0.2 of beauty*1 direct*0.5, 32 to 1000 samples, floor 0.2, "
          "neighbourhood 2");
    const auto json = raylex::experiments::parse_json(folder.read("s.json"));
    CHECK(json["adaptive"]["error"].get<double>() > 0);
    CHECK(json["checkpoints"]["stall_seconds"].get<double>() >= 0);
    double samples = 0;
    for (const float count : image->layer("sampleCount")->planes.front().values) samples += static_cast<double>(count);
    CHECK(samples == json["samples"]["camera"].get<double>());
    CHECK(samples >= 16 * 16 * 32);
    CHECK(samples < 16 * 16 * 1000);
    CHECK_FALSE(folder.has("out.exr.checkpoint"));

    const auto refused = [&](const std::string& from, const std::string& to, const std::string& word) {
        std::string job = folder.read("job.toml");
        job.replace(job.find(from), from.size(), to);
        folder.write("bad.toml", job);
        const Outcome bad = run_raylex(folder, "render bad.toml -o bad.exr");
        CAPTURE(to, bad.err, word);
        CHECK(bad.code == 2);
        CHECK(bad.err.find(word) != std::string::npos);
    };
    refused("\"0.02s\"", "\"often\"", "bad.toml:7:15: 'often' is not a time");
    refused("\"20%\"", "\"x\"", "bad.toml:15:");
    refused("\"20%\"", "-1", "bad.toml:15:9: 'error' in [adaptive] is not a number above 0");
    refused("floor", "flor", "bad.toml:19:1");
    refused("\"direct\", w", "\"dirct\", w", "did you mean 'direct'?");
    refused("\"direct\", w", "\"dirct\", w", "bad.toml:16:");
    refused("max_samples = 1000", "max_samples = 10", "min_samples up to max_samples");
    refused("[\"beauty\", {", "[3, {", "bad.toml:16:13: a channel of [adaptive] is neither");
}

TEST_CASE("--until-error prints the error reached, and --spp is the maximum") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const Outcome outcome = run_raylex(folder, "render room.pbrt --until-error 1% --spp 100");
    CAPTURE(outcome.err, outcome.out);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out.find("error of beauty ") != std::string::npos);
    CHECK(outcome.out.find("pixels are above 1 %") != std::string::npos);
    CHECK(run_raylex(folder, "verify room.exr").code == 2);  // there is no partition
}

TEST_CASE("--time ends a render, and --spp with the number of samples gives the same bits", "[law3]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const Outcome timed = run_raylex(folder, "render room.pbrt -o timed.exr --time 0.2s");
    CAPTURE(timed.err, timed.out);
    REQUIRE(timed.code == 0);
    const std::size_t at = timed.out.find("time: ");
    REQUIRE(at != std::string::npos);
    const std::string spp = std::to_string(std::stoull(timed.out.substr(at + 6)));
    CHECK(timed.out.find(spp + " samples per pixel; --spp " + spp + " renders the same bits") != std::string::npos);
    REQUIRE(run_raylex(folder, "render room.pbrt -o counted.exr --spp " + spp).code == 0);
    CHECK((image_bits(folder.path("timed.exr")) == image_bits(folder.path("counted.exr"))));
    // --spp is the maximum, and the job's key sets the same limit.
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\ntime = \"30s\"\nspp = 3\n");
    CHECK(run_raylex(folder, "render job.toml").out.find("time: 3 samples per pixel") != std::string::npos);
    const auto refused = [&](const std::string& arguments, const std::string& word) {
        const Outcome bad = run_raylex(folder, "render room.pbrt " + arguments);
        CAPTURE(arguments, bad.err);
        CHECK(bad.code == 2);
        CHECK(bad.err.find(word) != std::string::npos);
    };
    refused("--time soon", "--time: 'soon' is not a render time; expected for example 60s, 5m or 1h");
    refused("--time 5s --until-error 1%", "--until-error: adaptive sampling in a render with a time or error limit");
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\ntime = \"0s\"\n");
    const Outcome bad = run_raylex(folder, "render bad.toml");
    CHECK(bad.code == 2);
    CHECK(bad.err.find("bad.toml:4:9: '0s' is not a render time") != std::string::npos);
}

TEST_CASE("a fault in any write, sync or rename of a run costs no bit", "[release-only][law7][gate]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const std::string out = folder.path("out.exr"), checkpoint = out + ".checkpoint";
    setenv("TMPDIR", folder.path().c_str(), 1);  // for images that cannot be written to their place
    REQUIRE(run_here(short_run(folder, false)) == 0);
    const std::string expected = image_bits(out);
    // The image of an earlier run must stay until the new one replaces it.
    const std::string earlier = folder.read("out.exr");
    int failed_runs = 0, faults = 0;
    std::set<FileCall> of_checkpoints;
    // File calls for checkpoints and for the image are counted separately, because the number of checkpoints depends on
    // time.
    for (const bool for_checkpoints : {false, true})
        for (int faulty = 0;; ++faulty) {
            std::remove(checkpoint.c_str());
            folder.write("out.exr", earlier);
            std::atomic<int> calls{0};
            std::atomic<bool> hit{false};
            std::atomic<FileCall> kind{FileCall::open};
            raylex::display::set_file_fault([&](FileCall call, const std::string& path) {
                if ((path == checkpoint) != for_checkpoints || calls++ != faulty) return 0;
                hit = true;
                kind = call;
                return ENOSPC;
            });
            const int code = run_here(short_run(folder, false));
            raylex::display::set_file_fault(nullptr);
            CAPTURE(faulty, code, for_checkpoints);
            if (!hit) {
                CHECK(code == 0);
                break;
            }
            ++faults;
            if (for_checkpoints) of_checkpoints.insert(kind);
            REQUIRE((code == 0 || code == 2));
            if (for_checkpoints) CHECK(code == 0);  // no reason to fail a render
            if (code == 0) {
                CHECK((image_bits(out) == expected));
                continue;
            }
            ++failed_runs;
            CHECK((folder.read("out.exr") == earlier));
            REQUIRE(run_here(short_run(folder, std::filesystem::exists(checkpoint))) == 0);
            CHECK((image_bits(out) == expected));
            CHECK_FALSE(std::filesystem::exists(checkpoint));
        }
    unsetenv("TMPDIR");
    CHECK(faults > 12);
    for (const FileCall call : {FileCall::write, FileCall::sync, FileCall::rename})
        CHECK(of_checkpoints.count(call) == 1);
    CHECK(failed_runs > 3);
}

TEST_CASE("child process that ends at a file call", "[.][recovery-child]") {
    const char* folder = std::getenv("RAYLEX_TEST_FOLDER");
    const char* number = std::getenv("RAYLEX_TEST_CALL");
    if (folder == nullptr || number == nullptr) return;
    const int last = std::atoi(number);
    static std::atomic<int> calls{0};
    raylex::display::set_file_fault([last](FileCall, const std::string&) {
        if (calls++ == last) std::raise(SIGKILL);
        return 0;
    });
    std::vector<std::string> arguments = short_run(std::string(folder), false);  // the run that the parent resumes
    arguments.insert(arguments.begin(), "raylex");
    std::vector<const char*> words;
    for (const std::string& each : arguments) words.push_back(each.c_str());
    std::_Exit(raylex::experiments::run_command_line(static_cast<int>(words.size()), words.data()));
}

TEST_CASE("a crash at any file call of a run costs no bit", "[.full][recovery][law7]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    REQUIRE(run_here(short_run(folder, false)) == 0);
    const std::string out = folder.path("out.exr"), checkpoint = out + ".checkpoint", expected = image_bits(out),
                      earlier = folder.read("out.exr");
    int deaths = 0, resumed = 0;
    for (;; ++deaths) {
        std::remove(checkpoint.c_str());
        folder.write("out.exr", earlier);
        const Outcome outcome = run_shell(folder, "export RAYLEX_TEST_FOLDER='" + folder.path() +
                                                      "' RAYLEX_TEST_CALL=" + std::to_string(deaths) + "\nexec '" +
                                                      binary_dir() + "/test_cli' '[recovery-child]'");
        CAPTURE(deaths, outcome.code, outcome.err);
        CHECK((image_bits(out) == expected));  // the earlier image or the new one, never a mixture
        if (outcome.code == 0) break;
        REQUIRE(outcome.code == 137);
        const bool goes_on = std::filesystem::exists(checkpoint);
        resumed += goes_on ? 1 : 0;
        REQUIRE(run_here(short_run(folder, goes_on)) == 0);
        CHECK((image_bits(out) == expected));
        CHECK_FALSE(std::filesystem::exists(checkpoint));
    }
    std::printf("%d deaths at file calls, %d resumed from a checkpoint, all with the same bits\n", deaths, resumed);
    CHECK(deaths > 12);
    CHECK(resumed > 5);
}

TEST_CASE("a hundred random kills cost no bit", "[.full][recovery][law3]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    std::mt19937 random(20);
    int kills = 0, resumed = 0, images = 0;
    for (const std::string& how : {std::string(" --spp 16384"), std::string(" --until-error 2% --spp 65536")}) {
        const std::string render = "render room.pbrt --stats s.json" + how + what;
        REQUIRE(run_raylex(folder, render + " -o whole.exr").code == 0);
        const std::string expected = image_bits(folder.path("whole.exr")), sums = sums_of(folder, "s.json");
        for (const int most = kills + 50; kills < most;) {
            std::remove(folder.path("out.exr").c_str());
            for (bool ended = false; !ended;) {
                const bool goes_on = folder.has("out.exr.checkpoint");
                const double delay = 0.05 + 0.4 * static_cast<double>(random() % 1000) / 1000;
                const Outcome outcome = run_shell(
                    folder, "\"$RAYLEX\" " + render + " -o out.exr --checkpoint 0.05s" + (goes_on ? " --resume" : "") +
                                " & pid=$!\nsleep " + std::to_string(delay) + "\nkill -9 $pid 2>/dev/null\nwait $pid");
                CAPTURE(kills, goes_on, outcome.err);
                REQUIRE((outcome.code == 0 || outcome.code == 137));
                ended = outcome.code == 0 || kills >= most;
                if (outcome.code == 137) ++kills;
                resumed += goes_on ? 1 : 0;
                if (ended && outcome.code == 137) {  // enough kills: let it finish
                    REQUIRE(run_raylex(folder, render + " -o out.exr --checkpoint 0.05s" +
                                                   (folder.has("out.exr.checkpoint") ? " --resume" : ""))
                                .code == 0);
                }
            }
            ++images;
            CHECK((image_bits(folder.path("out.exr")) == expected));
            CHECK(sums_of(folder, "s.json") == sums);
            CHECK_FALSE(folder.has("out.exr.checkpoint"));
        }
    }
    std::printf("%d random kills over %d images, %d sessions resumed, all with the same bits\n", kills, images,
                resumed);
    CHECK(resumed > 20);
}
