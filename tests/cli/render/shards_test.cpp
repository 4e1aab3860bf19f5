// raylex render --shard and raylex merge: the same image as a single render, however and whenever a shard ends.
#include <catch2/catch.hpp>

#include "display/checkpoint/record_file.h"
#include "support.h"

using namespace raylex::test;

namespace {

Outcome run_well(const Folder& folder, const std::string& arguments) {
    Outcome outcome = run_raylex(folder, arguments);
    INFO(arguments << "\n" << outcome.out << outcome.err);
    REQUIRE(outcome.code == 0);
    return outcome;
}

std::string part_of(int part, int parts) {
    return " --shard " + std::to_string(part) + "/" + std::to_string(parts);
}

/// The records of all shards, the last one first.
std::string records(int parts, const std::string& image = "out.exr") {
    std::string list;
    for (int part = parts; part >= 1; --part)
        list += " " + image + ".shard-" + std::to_string(part) + "-of-" + std::to_string(parts);
    return list;
}

}  // namespace

TEST_CASE("shards merge to the image of one render, with layers of every kind", "[law3][gate]") {
    const SceneFolder folder;
    folder.write("job.toml", R"(
[scene]
file = "room.pbrt"
[render]
spp = 56
crop = [2, 1, 15, 13]
[exr]
value = "float none"
color = "half piz"
[[display_filter]]
type = "background"
color = [0.1, 0.2, 0.3]
[channels]
aovs = ["Nn", "z", "id", "albedo", "sampleCount", "invalidSamples"]
cryptomatte = ["object", "material"]
light_groups = true
statistics = { beauty = ["mse", "even"] }
rules = { Nn = "zmin" }
[[channel]]
name = "direct"
lpe = "CDL"
[[light_group]]
light = "area:0"
group = "key"
)");
    for (const std::string& render :
         {std::string("job.toml"), std::string("room.pbrt --spp 56 --lpe direct=CDL --integrator bdpt"),
          std::string("room.pbrt --spp 40 --lpe direct=CDL --partition shipped --integrator lighttracer"),
          std::string("room.pbrt --spp 48 --filter-mode splat --filter gaussian --exr single --aov P")}) {
        CAPTURE(render);
        const Folder place;
        const std::string command = "render '" + folder.path() + "/'" + render;
        const Outcome whole = run_well(place, command + " -o whole.exr");
        for (const int part : {3, 1, 2}) run_well(place, command + " -o out.exr --threads 2" + part_of(part, 3));
        const Outcome merged = run_well(place, "merge" + records(3) + " -o out.exr");
        CHECK(image_bits(place.path("whole.exr")) == image_bits(place.path("out.exr")));
        // The results of checks are the same.
        for (const auto& line : all_matches(whole.out, "partition '[^\n]*")) CHECK(contains(merged.out, line.front()));
        auto one = raylex::display::read_exr(place.path("whole.exr")),
             sum = raylex::display::read_exr(place.path("out.exr"));
        CHECK(sum->attributes["raylex/shards"] == "3");
        for (auto* each : {&*one, &*sum})  // attributes of the run, not of the image
            for (const char* name :
                 {"raylex/shards", "raylex/merge_command", "raylex/command", "raylex/time", "raylex/threads"})
                each->attributes.erase(name);
        CHECK(one->attributes == sum->attributes);
    }
}

TEST_CASE("a finished shard is not rendered again, and a shard of another render is not mistaken for it", "[law7]") {
    const SceneFolder folder;
    const std::string shard = "render room.pbrt -o out.exr --spp 32 --lpe direct=CDL", record = "out.exr.shard-1-of-2";
    CHECK(contains(run_well(folder, shard + part_of(1, 2)).out, record + ": shard 1/2, samples 0 to 15 of 32"));
    const std::string bits = folder.read(record);
    CHECK(contains(run_well(folder, shard + part_of(1, 2)).out, "samples 0 to 15 of 32 is done already"));
    CHECK((folder.read(record) == bits));
    check_refused(folder, shard + part_of(1, 2) + " --seed 1",
                  {record, "belongs to another render", "seed: 0 there, 1 here", "remove this record"});
    check_refused(folder, "render room.pbrt -o out.exr --spp 64 --lpe direct=CDL" + part_of(1, 2),
                  {"samples per pixel: 32 there, 64 here"});
    check_refused(folder, shard + part_of(1, 2) + " --lpe more=CSL", {"channel more"});
    // Damage is found and repaired.
    std::string damaged = bits;
    damaged[damaged.size() / 2] ^= 1;
    folder.write(record, damaged);
    check_refused(folder, "merge " + record + " -o out.exr", {record, "damaged"});
    CHECK(contains(run_well(folder, shard + part_of(1, 2)).err, "this shard is rendered again"));
    run_well(folder, shard + part_of(2, 2));
    run_well(folder, "merge" + records(2) + " -o out.exr");
}

TEST_CASE("an incomplete render is not merged, and renders that cannot be sharded are refused by name",
          "[law7][gate]") {
    const SceneFolder folder;
    const std::string shard = "render room.pbrt -o out.exr --spp 48";
    for (const int part : {1, 2, 3}) run_well(folder, shard + part_of(part, 3));
    run_well(folder, shard + part_of(2, 2));
    run_well(folder, "render room.pbrt -o other.exr --spp 48 --seed 7" + part_of(3, 3));
    const std::string first = "out.exr.shard-1-of-3", second = "out.exr.shard-2-of-3", third = "out.exr.shard-3-of-3";
    const std::string to = " -o sum.exr";
    check_refused(folder, "merge " + first + " " + third + to,
                  {"samples 16 to 31 of 48 are in no record", "run the shard with these samples"});
    check_refused(folder, "merge " + second + " " + first + to, {"samples 32 to 47 of 48"});
    check_refused(folder, "merge" + records(3) + " " + second + to, {second, "they overlap", "leave out one"});
    check_refused(folder, "merge" + records(3) + " out.exr.shard-2-of-2" + to, {"out.exr.shard-2-of-2", "overlap"});
    check_refused(folder, "merge " + first + " " + second + " other.exr.shard-3-of-3" + to,
                  {"other.exr.shard-3-of-3", "belong to different renders", "seed: 7 there, 0 here"});
    check_refused(folder, "merge room.pbrt" + to, {"room.pbrt", "record"});
    check_refused(folder, "merge gone" + to, {"gone"});
    check_refused(folder, "merge" + records(3) + " -o sum.png", {"sum.png", ".exr"});
    // Halves and thirds of one render can be combined if they fit.
    run_well(folder, shard + part_of(1, 2));
    check_refused(folder, "merge out.exr.shard-1-of-2 " + third + to, {"samples 16 to 31"});
    run_well(folder, "merge out.exr.shard-2-of-2 " + first + to);

    check_refused(folder, shard + part_of(1, 4), {"4 shards of 48 samples per pixel; expected at most 3"});
    check_refused(folder, shard + " --shard 4/3", {"--shard", "PART from 1 to PARTS"});
    check_refused(folder, shard + part_of(1, 3) + " --until-error 1%", {"adaptive sampling in shards"});
    check_refused(folder, shard + part_of(1, 3) + " --time 1s", {"--time", "expected --spp"});
    check_refused(folder, shard + part_of(1, 3) + " --deep d.exr", {"a deep image"});
    check_refused(folder, shard + part_of(1, 3) + " --atlas a.atlas.exr --checkpoint 9s",
                  {"a path atlas", "checkpoint"});
    check_refused(folder, shard + part_of(1, 3) + " --replay 1,1,1", {"--replay"});
    check_refused(folder, shard + part_of(1, 3) + " --integrator pssmlt", {"Markov chains of integrator 'pssmlt'"});
}

TEST_CASE("a shard that was killed at any time resumes with the same bits", "[law3][gate]") {
    const SceneFolder folder;
    const std::string shard =
        "render room.pbrt -o out.exr --spp 4096 --lpe direct=CDL --cryptomatte object --threads 2";
    run_well(folder, shard);
    const std::string whole = image_bits(folder.path("out.exr"));
    for (const char* ending : {"-KILL", "-TERM"}) {
        CAPTURE(ending);
        const std::string record = "out.exr.shard-1-of-2";
        const Outcome killed =
            run_shell(folder, "rm -f out.exr*; \"$RAYLEX\" " + shard + part_of(1, 2) +
                                  " --checkpoint 0.02s & pid=$!\nfor i in $(seq 1500); do [ -e " + record +
                                  ".checkpoint ] && break; sleep 0.02; done\nkill " + ending + " $pid; wait $pid");
        CHECK(killed.code == (std::string(ending) == "-KILL" ? 137 : 130));
        CHECK_FALSE(folder.has(record));
        REQUIRE(folder.has(record + ".checkpoint"));
        const Outcome other = run_raylex(folder, shard + part_of(1, 2) + " --seed 3");
        CHECK(other.code == 2);
        CHECK(contains(other.err, "the checkpoint belongs to another render"));
        CHECK(contains(other.err, "seed: 0 there, 3 here"));
        REQUIRE(folder.has(record + ".checkpoint"));
        run_well(folder, shard + part_of(1, 2));
        CHECK_FALSE(folder.has(record + ".checkpoint"));
        run_well(folder, shard + part_of(2, 2));
        run_well(folder, "merge" + records(2) + " -o out.exr");
        CHECK((image_bits(folder.path("out.exr")) == whole));
    }
}

TEST_CASE("shards of another build, scene, seed or config are refused, and the difference is named", "[law7]") {
    const SceneFolder folder;
    for (const int part : {1, 2}) run_well(folder, "render room.pbrt -o out.exr --spp 32" + part_of(part, 2));
    const std::string first = "out.exr.shard-1-of-2", second = "out.exr.shard-2-of-2";
    const auto record = raylex::display::read_record_file(folder.path(second));
    REQUIRE(record.ok());
    for (const auto& [field, kind] : {std::pair<const char*, const char*>{"raylex", "build of raylex"},
                                      {"scene", "scene"},
                                      {"seed", "seed"},
                                      {"instruction set", "instruction set"},
                                      {"sampler", "config"},
                                      {"colour config", "config"}}) {
        CAPTURE(field);
        auto other = *record;
        bool changed = false;
        for (auto& [name, value] : other.identity)
            if (name == field) value = "another", changed = true;
        REQUIRE(changed);
        REQUIRE(raylex::display::write_record_file(folder.path("other"), other).ok());
        check_refused(folder, "merge " + first + " other -o sum.exr",
                      {"other", "'" + first + "' (here)", std::string("different ") + kind + ":",
                       std::string(field) + ": another there, "});
    }
    // Mix-ups as they really happen.
    folder.write("other.pbrt", folder.read("room.pbrt") + "\nLightSource \"point\"\n");
    run_well(folder, "render other.pbrt -o scene.exr --spp 32" + part_of(2, 2));
    check_refused(folder, "merge " + first + " scene.exr.shard-2-of-2 -o sum.exr", {"different scene:", "scene: "});
    run_well(folder, "render room.pbrt -o config.exr --spp 32 --max-depth 2" + part_of(2, 2));
    check_refused(folder, "merge " + first + " config.exr.shard-2-of-2 -o sum.exr",
                  {"different config:", "max depth: 2"});
    // A truncated record.
    const std::string bytes = folder.read(second);
    for (const std::size_t size : {std::size_t{10}, bytes.size() / 2, bytes.size() - 1}) {
        folder.write("cut", bytes.substr(0, size));
        check_refused(folder, "merge " + first + " cut -o sum.exr",
                      {"cut", "truncated: it ends after " + std::to_string(size) + " bytes"});
    }
    check_refused(folder, "merge " + first + " " + second + " " + second + " -o sum.exr", {second, "they overlap"});
    check_refused(folder, "merge " + first + " -o sum.exr", {"samples 16 to 31 of 32 are in no record"});
}

TEST_CASE("shards in buckets of any size merge to the image of one render", "[buckets][law3]") {
    const SceneFolder folder;
    const std::string what =
        "render room.pbrt --spp 56 --resolution 40x37 --lpe direct=CDL --aov z --statistics beauty=mse";
    run_well(folder, what + " -o whole.exr");
    for (const int part : {1, 2, 3})
        run_well(folder, what + " -o out.exr --bucket-rows " + std::to_string(5 * part) + part_of(part, 3));
    for (const int part : {1, 2, 3})
        CHECK_FALSE(folder.has("out.exr.shard-" + std::to_string(part) + "-of-3.checkpoint"));
    run_well(folder, "merge" + records(3) + " -o out.exr");
    CHECK((image_bits(folder.path("whole.exr")) == image_bits(folder.path("out.exr"))));
}
