// raylex render end to end: its files, its refusals, and that nothing is lost.
#include <catch2/catch.hpp>

#include "display/output/reader/exr_reader.h"
#include "experiments/job/text/json.h"
#include "support.h"

using namespace raylex::test;
using raylex::display::read_exr;

namespace {

/// Checks that the render is refused with exit code 2 and a message with all of `words`, and that only the inputs are
/// left in the folder.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("a render writes a verified file, a preview and statistics") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    Outcome outcome = run_raylex(
        folder,
        "render room.pbrt --lpe direct='CDL' --aov Nn --aov z --preview p.png --stats s.json --seed 3 --threads 1");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(folder.names() == std::vector<std::string>{"p.png", "room.exr", "room.pbrt", "s.json"});
    auto image = read_exr(folder.path("room.exr"));
    REQUIRE(image);
    CHECK(image->width == 16);
    for (const char* layer : {"beauty", "direct", "rest", "Nn", "z"}) {
        CAPTURE(layer);
        CHECK(image->layer(layer) != nullptr);
    }
    CHECK(image->attributes["lpe/direct"] == "CDL");
    CHECK(image->attributes["raylex/seed"] == "3");
    CHECK(image->attributes["raylex/samples_per_pixel"] == "4");
    for (const char* name : {"raylex/version", "raylex/revision", "raylex/command", "raylex/scene", "raylex/threads",
                             "raylex/isa", "raylex/arithmetic", "raylex/integrator", "raylex/sampler", "raylex/filter",
                             "raylex/compiler", "raylex/host", "raylex/time", "raylex/color_config"}) {
        CAPTURE(name);
        CHECK_FALSE(image->attributes[name].empty());
    }
    REQUIRE(image->partitions.size() == 1);
    CHECK(image->partitions[0].name == "auto");
    CHECK(image->partitions[0].layers == std::vector<std::string>{"direct", "rest"});
    CHECK(folder.read("p.png").substr(1, 3) == "PNG");
    CHECK(run_raylex(folder, "verify room.exr").code == 0);

    const auto json = raylex::experiments::parse_json(folder.read("s.json"));
    for (const char* phase : {"load", "plan", "build", "prepare", "render", "write"}) {
        CAPTURE(phase);
        CHECK(json["phases"][phase]["wall_seconds"].get<double>() >= 0);
        CHECK(json["phases"][phase]["cpu_seconds"].get<double>() >= 0);
    }
    CHECK(json["samples"]["camera"] == 16 * 16 * 4);
    CHECK(json["rays"]["camera"] == 16 * 16 * 4);
    CHECK(json["rays"]["total"] == json["rays"]["camera"].get<int>() + json["rays"]["scattering"].get<int>() +
                                       json["rays"]["shadow"].get<int>());
    CHECK(json["rays"]["pilot"] == 0);  // the beauty accepts everything, so there is nothing to learn
    std::uint64_t paths = 0;
    for (const auto& each : json["path_length_histogram"]) paths += each.get<std::uint64_t>();
    CHECK(paths == 16 * 16 * 4);
    CHECK(json["attribution_overflow"] == 0);
    CHECK(json["invalid_samples"]["count"] == 0);
    CHECK(json["peak_memory_bytes"].get<double>() > 1e6);
    CHECK(json["complete"] == true);
    CHECK(json["splits"][0]["holds"] == true);
    CHECK(json["warnings"].is_array());
}

TEST_CASE("requested channels do not change the beauty's bits", "[law2]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    REQUIRE(run_raylex(folder, "render room.pbrt -o a.exr --threads 1").code == 0);
    REQUIRE(
        run_raylex(
            folder,
            "render room.pbrt -o b.exr --threads 2 --partition shipped --light-groups --lpe direct=CDL --aov albedo")
            .code == 0);
    auto a = read_exr(folder.path("a.exr")), b = read_exr(folder.path("b.exr"));
    REQUIRE(a);
    REQUIRE(b);
    for (const char* plane : {"R", "G", "B", "A"})
        CHECK((a->layer("beauty")->plane(plane)->values == b->layer("beauty")->plane(plane)->values));
}

TEST_CASE("an image of one tile adds up, with the same bits, on any number of threads", "[law1][law3][gate]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    // 256 blocks of the same few pixels, so that threads meet there all the time.
    CHECK(run_raylex(folder, "render room.pbrt -o a.exr --spp 4096 --threads 4 --lpe direct=CDL").code == 0);
    CHECK(run_raylex(folder, "render room.pbrt -o b.exr --spp 4096 --threads 1 --lpe direct=CDL").code == 0);
    auto a = read_exr(folder.path("a.exr")), b = read_exr(folder.path("b.exr"));
    REQUIRE(a);
    REQUIRE(b);
    for (const char* layer : {"beauty", "direct", "rest"})
        for (const char* plane : {"R", "G", "B"})
            CHECK((a->layer(layer)->plane(plane)->values == b->layer(layer)->plane(plane)->values));
}

TEST_CASE("a job gives labels, groups and partitions to an unmodified scene") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    folder.write("job.toml", R"([scene]
file = "room.pbrt"
[output]
file = "out.exr"
[render]
spp = 2
[channels]
aovs = ["P"]
shipped_partition = true
light_groups = true
[[label]]
material = "ground"
label = "floor"
[[light_group]]
light = "point"
group = "key"
[[channel]]
name = "floor"
lpe = "C<RD'floor'>.*<L.>"
[[partition]]
name = "mine"
channels = ["floor"]
rest = "others"
)");
    Outcome outcome = run_raylex(folder, "render job.toml --spp 3");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    auto image = read_exr(folder.path("out.exr"));
    REQUIRE(image);
    CHECK(image->attributes["raylex/samples_per_pixel"] == "3");
    CHECK(image->attributes["raylex/job"].find("[[light_group]]") != std::string::npos);
    std::vector<std::string> partitions;
    for (const auto& each : image->partitions) partitions.push_back(each.name);
    std::sort(partitions.begin(), partitions.end());
    CHECK(partitions == std::vector<std::string>{"light_groups", "mine", "shipped"});
    // Both lights contribute to the image, each in its own layer.
    for (const char* name : {"light_key", "light_default", "floor", "directDiffuse"}) {
        CAPTURE(name);
        const auto* layer = image->layer(name);
        REQUIRE(layer != nullptr);
        double sum = 0;
        for (const float value : layer->plane("R")->values) sum += value;
        CHECK(sum > 0);
    }
    CHECK(run_raylex(folder, "verify out.exr").code == 0);

    const std::string job = folder.read("job.toml");
    folder.write("bad.toml", replaced(job, "\"ground\"", "\"gruond\""));
    check_refused(folder, "render bad.toml", {"bad.toml:12", "gruond", "ground"});
    folder.write("bad.toml", replaced(job, "[\"P\"]", "[\"Nnn\"]"));
    check_refused(folder, "render bad.toml", {"bad.toml:8:10", "Nnn"});
    folder.write("bad.toml", replaced(job, "[\"floor\"]", "[\"flor\"]"));
    check_refused(folder, "render bad.toml", {"bad.toml:20", "flor", "floor"});
    folder.write("bad.toml", replaced(job, "C<RD'floor'>.*<L.>", "C<RD'floor'.*<L.>"));
    check_refused(folder, "render bad.toml", {"bad.toml:19:", "^"});
}

TEST_CASE("a declared partition that does not hold is refuted before a ray is traced") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    folder.write("job.toml",
                 "[scene]\nfile = 'room.pbrt'\n[output]\nfile = 'out.exr'\n[[channel]]\nname = 'direct'\nlpe = "
                 "'CDL'\n[[partition]]\nname = 'mine'\nchannels = ['direct']\n");
    Outcome outcome = run_raylex(folder, "render job.toml");
    CHECK(outcome.code == 1);
    CHECK(outcome.err.find("job.toml:8") != std::string::npos);
    CHECK(outcome.err.find("'mine'") != std::string::npos);
    CHECK(outcome.err.find("C,- L,-") != std::string::npos);
    CHECK_FALSE(folder.has("out.exr"));
}

TEST_CASE("channels that share paths get no rest layer, with the reason") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    Outcome outcome = run_raylex(folder, "render room.pbrt --spp 1 --lpe all='C.*<L.>' --lpe direct=CDL");
    REQUIRE(outcome.code == 0);
    CHECK(outcome.err.find("no rest layer") != std::string::npos);
    auto image = read_exr(folder.path("room.exr"));
    REQUIRE(image);
    CHECK(image->partitions.empty());
    CHECK(image->layer("rest") == nullptr);
    CHECK(run_raylex(folder, "verify room.exr").code == 2);
}

TEST_CASE("--dialect applies to the --lpe after it") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    // 'B' and '?' are invalid in osl; only the second expression is read as osl.
    REQUIRE(run_raylex(folder, "render room.pbrt --spp 1 --lpe a='CD?<L.>' --dialect osl --lpe b='CDDL'").code == 0);
    check_refused(folder, "render room.pbrt -o b.exr --spp 1 --dialect osl --lpe a='CD?L'", {"--lpe a", "^"});
    check_refused(folder, "render room.pbrt -o b.exr --dialect french --lpe a=CDL", {"french", "renderman or osl"});
    // A --dialect without a following --lpe is an error anywhere.
    const std::string no_effect = "follows '--dialect osl'";
    check_refused(folder, "render room.pbrt -o b.exr --lpe a=CDL --dialect osl",
                  {no_effect, "expected --dialect before"});
    check_refused(folder, "render room.pbrt -o b.exr --dialect osl --aov z", {no_effect});
    check_refused(folder, "render room.pbrt -o b.exr --dialect osl --dialect renderman --lpe a=CDL", {no_effect});
}

TEST_CASE("the residual map of an earlier failure is removed when the split holds") {
    const SceneFolder folder;
    for (const char* name : {"out.light_groups.residual.png", "out.other.residual.png", "other.residual.png"})
        folder.write(name, "of an earlier image");
    REQUIRE(run_raylex(folder, "render room.pbrt -o out.exr --spp 1 --light-groups").code == 0);
    CHECK_FALSE(folder.has("out.light_groups.residual.png"));
    // The map of a split with another name may belong to another image.
    CHECK(folder.has("out.other.residual.png"));
    CHECK(folder.has("other.residual.png"));
}

TEST_CASE("errors in scenes have file, line and the expected form", "[law7]") {
    const Folder folder;
    check_refused(folder, "render absent.pbrt", {"absent.pbrt"});
    check_refused(folder, "render absent.toml", {"absent.toml"});
    const std::string scene = small_scene();
    folder.write("a.pbrt", replaced(scene, "\"integer indices\" [0 1 2", "\"integer indices\" [0 1 x"));
    check_refused(folder, "render a.pbrt", {"a.pbrt:10:"});
    folder.write("a.pbrt", replaced(scene, "WorldBegin\n", "WorldBegin\nFrobnicate \"x\"\n"));
    check_refused(folder, "render a.pbrt", {"a.pbrt:7:", "Frobnicate"});
    folder.write("a.pbrt", replaced(scene, "-2 0 2 2 0 2", "nan 0 2 2 0 2"));
    check_refused(folder, "render a.pbrt", {"a.pbrt:10"});
    folder.write(
        "m.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\nab");
    folder.write("a.pbrt", scene + "Shape \"plymesh\" \"string filename\" \"m.ply\"\n");
    check_refused(folder, "render a.pbrt", {"m.ply"});
    folder.write("a.pbrt", scene +
                               "MakeNamedMedium \"fog\" \"string type\" \"clouds\"\nMediumInterface \"\" \"fog\"\n"
                               "Shape \"sphere\"\n");
    check_refused(folder, "render a.pbrt", {"a.pbrt:1"});
}

TEST_CASE("errors in flags have the expected form", "[law7]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    check_refused(folder, "render room.pbrt --lpe x='CD(L'", {"--lpe x", "CD(L", "^"});
    check_refused(folder, "render room.pbrt --lpe x=CDL --lpe x=CSL", {"'x'", "twice"});
    check_refused(folder, "render room.pbrt --lpe Nn=CDL --aov Nn", {"'Nn'", "twice"});
    CHECK(run_raylex(folder, "render room.pbrt -o twice.exr --aov z --aov z").code == 0);  // duplicates count once
    fs::remove(folder.path("twice.exr"));
    check_refused(folder, "render room.pbrt --lpe z=CL --aov z", {"'z'", "twice"});
    check_refused(folder, "render room.pbrt --aov Nnn", {"Nnn"});
    check_refused(folder, "render room.pbrt --lpe CDL", {"NAME=EXPR"});
    check_refused(folder, "render room.pbrt --lpe 'a b=CDL'", {"a b"});
    check_refused(folder, "render room.pbrt --resolution 16", {"WIDTHxHEIGHT"});
    check_refused(folder, "render room.pbrt --spp 0", {"--spp"});
    check_refused(folder, "render room.pbrt --spp -3", {"--spp"});
    check_refused(folder, "render room.pbrt --integrator pathh", {"pathh", "path"});
    check_refused(folder, "render room.pbrt --sampler nosuch", {"nosuch"});
    check_refused(folder, "render room.pbrt --filter gausian", {"gausian", "gaussian"});
    check_refused(folder, "render room.pbrt --isa z80", {"z80"});
    check_refused(folder, "render room.pbrt --no-beauty", {"--no-beauty"});
    check_refused(folder, "render room.pbrt --ocio absent.ocio", {"absent.ocio"});
    check_refused(folder, "render room.pbrt --rendering-space NoSuchSpace", {"NoSuchSpace"});
}

TEST_CASE("outputs that cannot be written are refused before rendering, and earlier results stay", "[law7]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    check_refused(folder, "render room.pbrt -o absent/out.exr", {"absent"});
    check_refused(folder, "render room.pbrt --preview absent/p.png", {"absent"});
    check_refused(folder, "render room.pbrt --stats absent/s.json", {"absent"});
    check_refused(folder, "render room.pbrt -o out.jpg", {".exr"});
    check_refused(folder, "render room.pbrt -o /dev/full", {"/dev/full"});
    check_refused(folder, "render room.pbrt --stats room.pbrt", {"room.pbrt"});
    REQUIRE(run_raylex(folder, "render room.pbrt -o out.exr").code == 0);
    const std::string earlier = folder.read("out.exr");
    check_refused(folder, "render room.pbrt -o out.exr --lpe x='C('", {"--lpe x"});
    CHECK(folder.read("out.exr") == earlier);
}

TEST_CASE("a full disk loses neither the program nor the earlier result", "[law7]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    REQUIRE(run_raylex(folder, "render room.pbrt -o out.exr").code == 0);
    const std::string earlier = folder.read("out.exr");
    // 8 kB is less than an image of this size needs; the limit also applies to the rescue in the folder for temporary
    // files.
    Outcome outcome =
        run_shell(folder, "ulimit -f 8; exec \"$RAYLEX\" render room.pbrt -o out.exr --seed 5 --resolution 64x64");
    CAPTURE(outcome.err);
    CHECK(outcome.code == 2);
    CHECK(outcome.err.find("out.exr") != std::string::npos);
    CHECK(folder.read("out.exr") == earlier);
    CHECK(folder.names() == std::vector<std::string>{"out.exr", "room.pbrt"});
}

TEST_CASE("Ctrl-C writes the partial image, marked incomplete, and ends with 130", "[law7][gate]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    for (const char* signal : {"INT", "TERM"}) {
        CAPTURE(signal);
        Outcome outcome =
            run_shell(folder,
                      "\"$RAYLEX\" render room.pbrt -o out.exr --spp 2000000000 --lpe direct=CDL --stats s.json &\n"
                      "child=$!\nsleep 2\nkill -" +
                          std::string(signal) + " $child\nwait $child");
        CAPTURE(outcome.err);
        CHECK(outcome.code == 130);
        auto image = read_exr(folder.path("out.exr"));
        REQUIRE(image);
        CHECK(image->attributes.contains("raylex/incomplete"));
        CHECK(run_raylex(folder, "verify out.exr").code == 0);
        CHECK(raylex::experiments::parse_json(folder.read("s.json"))["complete"] == false);
    }
}

TEST_CASE("rendering in another space changes only the primaries") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    REQUIRE(run_raylex(folder, "render room.pbrt -o a.exr").code == 0);
    Outcome outcome = run_raylex(folder, "render room.pbrt -o b.exr --rendering-space ACEScg");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    auto image = read_exr(folder.path("b.exr"));
    REQUIRE(image);
    REQUIRE(image->chromaticities);
    CHECK(image->chromaticities->red[0] == Approx(0.713).epsilon(1e-3));  // S-2014-004: AP1 red
    // compare converts to the reference's primaries. The scene's albedo is nearly grey, so the light differs by less
    // than one per cent: products of colours depend on the primaries.
    Outcome ratio = run_raylex(folder, "compare b.exr a.exr --metric mean-ratio --channel Y");
    REQUIRE(ratio.code == 0);
    CHECK(std::stod(ratio.out) == Approx(1.0).epsilon(0.01));
}

TEST_CASE("a seed that is not a 64-bit integer is refused instead of being converted") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    for (const char* seed : {"-1", "18446744073709551616", "1e3", "x"})
        check_refused(folder, std::string("render room.pbrt --seed ") + seed, {"--seed", seed, "expected"});
    CHECK(run_raylex(folder, "render room.pbrt --spp 1 --seed 18446744073709551615").code == 0);
}

TEST_CASE("an unknown parameter in a job is refused before rendering, with its place", "[law7]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const std::string scene = "[scene]\nfile = 'room.pbrt'\n";
    folder.write("i.toml", scene + "[integrator]\ntype = 'path'\nroulett = true\n");
    check_refused(folder, "render i.toml", {"i.toml:5:", "'roulett'", "did you mean 'roulette'"});
    folder.write("s.toml", scene + "[sampler]\ntype = 'sobol'\nsamples = 3\n");
    check_refused(folder, "render s.toml", {"s.toml:5:", "'samples'", "pixelsamples"});
    folder.write("f.toml", scene + "[filter]\ntype = 'gaussian'\nradius = 3.0\n");
    check_refused(folder, "render f.toml", {"f.toml:5:", "'radius'", "xradius"});
}
