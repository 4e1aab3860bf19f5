// raylex render --memory and --bucket-rows: an image in buckets of rows, each saved when finished, has the bits of the
// whole image, however the program ends.
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>

#include "experiments/job/text/json.h"
#include "support.h"

using namespace raylex::test;

namespace {

namespace files = std::filesystem;

/// Layers of every kind, rule and statistic.
const std::string bucket_layers =
    " --resolution 40x37 --lpe direct=CDL --aov z --aov Nn,id --layer nearest=z:zmin --layer mean=Nn:average"
    " --statistics beauty=variance,mse,even,odd";

std::vector<std::string> buckets_in(const Folder& folder) {
    std::vector<std::string> names;
    std::error_code failed;
    for (const auto& each : files::directory_iterator(folder.path("out.exr.checkpoint"), failed))
        names.push_back(each.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace

TEST_CASE("an image in buckets has the bits of the whole, for any size of buckets and threads",
          "[buckets][law3][gate]") {
    const SceneFolder folder;
    REQUIRE(run_raylex(folder, "render room.pbrt -o whole.exr --preview whole.png" + bucket_layers).code == 0);
    const std::string expected = image_bits(folder.path("whole.exr"));
    for (const auto& [rows, threads] : {std::pair{1, 2}, {5, 1}, {16, 3}, {36, 2}, {64, 1}}) {
        CAPTURE(rows, threads);
        const Outcome outcome =
            run_raylex(folder, "render room.pbrt -o out.exr --preview out.png --stats s.json" + bucket_layers +
                                   " --bucket-rows " + std::to_string(rows) + " --threads " + std::to_string(threads));
        CAPTURE(outcome.err, outcome.out);
        REQUIRE(outcome.code == 0);
        CHECK(contains(outcome.out, "partition 'auto': 2 layers sum to beauty"));
        CHECK((image_bits(folder.path("out.exr")) == expected));
        CHECK((folder.read("out.png") == folder.read("whole.png")));
        CHECK_FALSE(folder.has("out.exr.checkpoint"));
        const auto json = raylex::experiments::parse_json(folder.read("s.json"));
        CHECK(json["samples"]["camera"] == 40 * 37 * 4);
        CHECK(raylex::display::read_exr(folder.path("out.exr"))->attributes.at("raylex/buckets") ==
              std::to_string((37 + rows - 1) / rows));
    }
    CHECK(run_raylex(folder, "verify out.exr").code == 0);
}

TEST_CASE("crops, display filters and single parts work with buckets", "[buckets][law3]") {
    const SceneFolder folder;
    const std::string what = "render room.pbrt" + bucket_layers +
                             " --crop 3,5,30,33 --display-filter grade:exposure=1 --exr single --sample-filter "
                             "clamp:luminance=0.2 -o ";
    REQUIRE(run_raylex(folder, what + "whole.exr").code == 0);
    const Outcome outcome = run_raylex(folder, what + "out.exr --bucket-rows 9");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
}

// Only in Release, because sanitizers need memory themselves.
TEST_CASE("--memory renders large images in buckets and stays within the limit", "[buckets][release-only][gate]") {
    const SceneFolder folder;
    const std::string what =
        "render room.pbrt -o out.exr --spp 1 --resolution 800x700 --threads 2 --lpe 'a=CDL' "
        "--lpe 'b=C<RD>[DS]+L' --statistics beauty=mse --stats s.json";
    REQUIRE(run_raylex(folder, what + " --memory 64G").code == 0);
    const std::string expected = image_bits(folder.path("out.exr"));
    CHECK_FALSE(raylex::display::read_exr(folder.path("out.exr"))->attributes.contains("raylex/buckets"));
    CHECK_FALSE(folder.has("out.exr.checkpoint"));
    const Outcome too_little = run_raylex(folder, what + " --memory 1MiB");
    CHECK(too_little.code == 2);
    CHECK(contains(too_little.err, "not even a row of it fits: expected --memory of at least "));
    // The number in the message, and room for some rows; the image alone takes 170 MiB.
    const auto least = all_matches(too_little.err, "at least ([0-9.]+) MiB");
    REQUIRE(least.size() == 1);
    const int memory = static_cast<int>(std::stod(least[0][1])) + 60;
    CAPTURE(memory);
    const Outcome outcome = run_raylex(folder, what + " --memory " + std::to_string(memory) + "MiB");
    CAPTURE(outcome.err, outcome.out);
    REQUIRE(outcome.code == 0);
    CHECK((image_bits(folder.path("out.exr")) == expected));
    CHECK(raylex::display::read_exr(folder.path("out.exr"))->attributes.contains("raylex/buckets"));
    const auto json = raylex::experiments::parse_json(folder.read("s.json"));
    CHECK(json["peak_memory_bytes"].get<double>() <= memory * 1048576.0);
}

TEST_CASE("a job can request buckets", "[buckets]") {
    const SceneFolder folder;
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\nbucket_rows = 3\nmemory = \"64G\"\n");
    REQUIRE(run_raylex(folder, "render job.toml -o out.exr").code == 0);
    CHECK(raylex::display::read_exr(folder.path("out.exr"))->attributes.at("raylex/buckets") == "6");
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\nbucket_rows = 0\n");
    check_refused(folder, "render bad.toml", {"bad.toml:4", "bucket_rows"});
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\nmemory = \"much\"\n");
    check_refused(folder, "render bad.toml", {"bad.toml:4", "not an amount of memory"});
}

TEST_CASE("finished buckets are not rendered again after a kill, whatever the size of the others",
          "[buckets][law3][release-only][gate]") {
    const SceneFolder folder;
    const std::string what = "render room.pbrt --spp 1024" + bucket_layers;
    REQUIRE(run_raylex(folder, what + " -o whole.exr").code == 0);
    const Outcome killed = run_shell(folder, "\"$RAYLEX\" " + what +
                                                 " -o out.exr --bucket-rows 4 & pid=$!\n"
                                                 "for i in $(seq 1500); do [ -e out.exr.checkpoint/rows-00004-00008."
                                                 "bucket ] && break; sleep 0.02; done\n"
                                                 "kill -9 $pid || exit 7\nwait $pid\n[ $? = 137 ]");
    CAPTURE(killed.err);
    REQUIRE(killed.code == 0);
    const std::size_t saved = buckets_in(folder).size();
    REQUIRE(saved >= 2);
    // The lock of a killed process blocks nobody, and the next process removes it.
    CHECK(folder.has("out.exr.checkpoint.lock"));
    run_raylex(folder, what + " -o out.exr --bucket-rows 4");
    CHECK_FALSE(folder.has("out.exr.checkpoint.lock"));
    // Files left by a kill during writing: of a process that no longer exists, and of rows that no further bucket has.
    folder.write("out.exr.checkpoint/rows-00012-00016.bucket.2147483647-3.partial", "half a bucket");
    check_refused(folder, what + " -o out.exr --bucket-rows 4", {"--resume continues it"});
    check_refused(folder, what + " -o out.exr --resume", {"these are the buckets of a render with --memory"});
    check_refused(folder, what + " -o out.exr --bucket-rows 4 --resume --seed 9", {"seed: 0 there, 9 here"});
    check_refused(folder, what + " -o out.exr --bucket-rows 4 --resume --crop 0,1,9,9",
                  {"contains rows that this render does not have"});
    const std::string bucket = "out.exr.checkpoint/rows-00000-00004.bucket", bytes = folder.read(bucket);
    std::string damaged = bytes;
    damaged[bytes.size() / 2] = static_cast<char>(damaged[bytes.size() / 2] ^ 1);
    folder.write(bucket, damaged);
    check_refused(folder, what + " -o out.exr --bucket-rows 4 --resume", {bucket, "damaged"});
    folder.write(bucket, bytes);
    const Outcome outcome = run_raylex(folder, what + " -o out.exr --bucket-rows 7 --resume --stats s.json");
    CAPTURE(outcome.err, outcome.out);
    REQUIRE(outcome.code == 0);
    const auto resumed = all_matches(outcome.out, "resumed from a checkpoint with ([0-9]+) of 1515520 samples");
    REQUIRE(resumed.size() == 1);
    CHECK(std::stoul(resumed[0][1]) >= 2 * 4 * 40 * 1024);
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
    CHECK_FALSE(folder.has("out.exr.checkpoint"));
}

TEST_CASE("a full disk during a render in buckets loses no finished bucket", "[buckets][law7]") {
    const SceneFolder folder;
    // 40 x 37 pixels: a bucket of 4 rows takes 10 to 25 kB, one of all rows 100 to 200, as the image does.
    const std::string what = "render room.pbrt" + bucket_layers;
    REQUIRE(run_raylex(folder, what + " -o whole.exr").code == 0);
    const auto within = [&](int kilobytes, const std::string& more) {
        return run_shell(folder, "ulimit -f " + std::to_string(kilobytes) + "; exec \"$RAYLEX\" " + what +
                                     " -o out.exr --bucket-rows " + more);
    };
    const Outcome no_bucket = within(4, "4");
    CAPTURE(no_bucket.err);
    CHECK(no_bucket.code == 2);
    CHECK(contains(no_bucket.err, "rows-00000-00004.bucket: a finished bucket could not be saved"));
    CHECK(buckets_in(folder).empty());
    const Outcome no_image = within(40, "4");
    CAPTURE(no_image.err);
    CHECK(no_image.code == 2);
    CHECK(contains(no_image.err, "out.exr"));
    CHECK(buckets_in(folder).size() == 10);
    CHECK_FALSE(folder.has("out.exr"));
    const Outcome outcome = run_raylex(folder, what + " -o out.exr --bucket-rows 4 --resume");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.out, "resumed from a checkpoint with 5920 of 5920 samples"));
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
}

TEST_CASE("a render stopped inside a bucket is written, and resumes inside it", "[buckets][law3][release-only][gate]") {
    const SceneFolder folder;
    const std::string what = "render room.pbrt --spp 2048" + bucket_layers;
    REQUIRE(run_raylex(folder, what + " -o whole.exr").code == 0);
    const Outcome stopped = run_shell(folder, "\"$RAYLEX\" " + what +
                                                  " -o out.exr --bucket-rows 20 --checkpoint 0.02s & pid=$!\n"
                                                  "for i in $(seq 1500); do [ -e out.exr.checkpoint/rows-00000-00020."
                                                  "bucket ] && break; sleep 0.02; done\n"
                                                  "kill -INT $pid; wait $pid");
    CAPTURE(stopped.out, stopped.err);
    REQUIRE(stopped.code == 130);
    CHECK(contains(stopped.out, "INCOMPLETE: interrupted"));
    CHECK(contains(stopped.out, "out.exr.checkpoint: --resume continues from here"));
    CHECK(raylex::display::read_exr(folder.path("out.exr"))->attributes.contains("raylex/incomplete"));
    const Outcome outcome = run_raylex(folder, what + " -o out.exr --bucket-rows 20 --resume");
    CAPTURE(outcome.err, outcome.out);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.out, "resumed from a checkpoint with "));
    CHECK((image_bits(folder.path("out.exr")) == image_bits(folder.path("whole.exr"))));
}

TEST_CASE("requests that buckets do not support are refused by name", "[buckets][law7]") {
    const SceneFolder folder;
    const std::string buckets = "render room.pbrt -o out.exr --bucket-rows 4 ";
    check_refused(folder, buckets + "--integrator lighttracer", {"buckets", "lighttracer", "land anywhere"});
    check_refused(folder, buckets + "--integrator bdpt", {"buckets", "bdpt", "land anywhere"});
    check_refused(folder, buckets + "--integrator pssmlt", {"buckets", "pssmlt"});
    check_refused(folder, buckets + "--filter-mode splat", {"buckets", "filter mode splat"});
    check_refused(folder, buckets + "--until-error 5%", {"buckets", "with an error limit"});
    check_refused(folder, buckets + "--time 1s", {"buckets", "with a time limit"});
    check_refused(folder, buckets + "--cryptomatte object", {"buckets", "cryptomattes"});
    check_refused(folder, buckets + "--deep d.exr", {"deep image", "buckets"});
    check_refused(folder, buckets + "--atlas a.atlas.exr", {"path atlas", "buckets"});
    check_refused(folder, buckets + "--tev localhost:1", {"live viewer", "buckets"});
    const std::string little = "render room.pbrt -o out.exr --memory 1MiB ";
    check_refused(folder, little + "--integrator bdpt", {"the image needs", "--memory", "bdpt", "is not possible"});
    check_refused(folder, "render room.pbrt -o out.exr --memory-limit 1k",
                  {"more than the limit of", "--memory SIZE renders it in buckets"});
}
