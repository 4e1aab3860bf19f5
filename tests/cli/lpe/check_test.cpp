// raylex lpe check and explain on channel files as RenderMan users write them.
#include <catch2/catch.hpp>

#include "experiments/job/text/json.h"
#include "tests/experiments/support.h"

using namespace raylex::test;

namespace {

/// Returns a display channel of a RIB file, with the parameters that scene exporters add.
std::string channel(const std::string& name, const std::string& expression, const std::string& more = "") {
    return "DisplayChannel \"color " + name + "\" \"string source\" [\"color lpe:" + expression +
           "\"] \"string filter\" [\"gaussian\"] \"float[2] filterwidth\" [2 2]" + more + "\n";
}

/// Returns RenderMan's documented basic set, with beauty and depth.
std::string basic_set() {
    return "##RenderMan RIB-Structure 1.1\nversion 3.04\n# beauty\nDisplayChannel \"color Ci\"\nDisplayChannel \"float "
           "a\"\n"
           "DisplayChannel \"float z\" \"string source\" [\"z\"]\n" +
           channel("emissive", "C[<L.>O]") + channel("directDiffuse", "C<RD>[<L.>O]") +
           channel("indirectDiffuse", "C<RD>[DS]+[<L.>O]") + channel("subsurface", "C<TD>[DS]*[<L.>O]") +
           channel("directSpecular", "C<RS>[<L.>O]") + channel("indirectSpecular", "C<RS>[DS]+[<L.>O]") +
           channel("transmissive", "C<TS>[DS]*[<L.>O]");
}

/// Returns the further channels of a denoiser: statistics of the same expressions, albedo and normal by prefixed
/// recipes.
std::string denoiser_set() {
    const std::string mse = " \"string statistics\" [\"mse\"]";
    return "DisplayChannel \"color mse\" \"string source\" [\"color Ci\"]" + mse + "\n" +
           channel("diffuse_mse", "C(D[DS]*[LO])|[LO]", mse) + channel("specular_mse", "CS[DS]*[LO]", mse) +
           channel("albedo", "nothruput;noinfinitecheck;noclamp;unoccluded;overwrite;C<.S'passthru'>*((U2L)|O)") +
           channel("normal", "nothruput;noinfinitecheck;noclamp;unoccluded;overwrite;CU6L");
}

}  // namespace

TEST_CASE("one command gives the correct result for a production's RIB file") {
    const Folder folder;
    folder.write("show.rib", basic_set() + denoiser_set());
    const Outcome holds = run_raylex(folder, "lpe check show.rib");
    INFO(holds.out << holds.err);
    CHECK(holds.code == 0);
    CHECK(contains(holds.out, "show.rib: 11 channels with expressions, 7 of them layers"));
    CHECK(contains(holds.out, "not layers (prefix nothruput): 'albedo', 'normal'"));
    CHECK(contains(holds.out, "not layers (statistics mse): 'diffuse_mse', 'specular_mse'"));
    CHECK(contains(holds.out, "--volume includes them"));
    CHECK(contains(holds.out, "7 channels are a partition of the beauty"));
    const Outcome volume = run_raylex(folder, "lpe check show.rib --volume");
    CHECK(volume.code == 1);
    CHECK(contains(volume.out, "C,- V,- L,-"));
    // A V in the file includes media, --no-volume excludes them; RenderMan itself does not read V.
    folder.write("fog.rib", basic_set() + channel("fog", "CV.*"));
    CHECK(run_raylex(folder, "lpe check fog.rib --for raylex").code == 1);
    CHECK(run_raylex(folder, "lpe check fog.rib --for raylex --no-volume").code == 0);
    CHECK(run_raylex(folder, "lpe check fog.rib --for raylex --no-volume --volume").code == 2);
    // A raylex job includes media.
    CHECK(run_raylex(folder, "lpe check show.rib -o show.toml").code == 0);
    CHECK(contains(folder.read("show.toml"), "subsurface"));
    folder.write("job.toml", "[[channel]]\nname = \"a\"\nlpe = \"C[DS]*[<L.>O]\"\n");
    const Outcome job = run_raylex(folder, "lpe check job.toml");
    CHECK(job.code == 1);
    CHECK(contains(job.out, "--no-volume excludes"));
    CHECK(run_raylex(folder, "lpe check job.toml --no-volume").code == 0);
}

TEST_CASE("lpe check prints every overlap and every gap before the result") {
    const Folder folder;
    folder.write("show.rib", channel("diffuse", "CD[DS]*[<L.>O]") + channel("direct", "C<RD>[<L.>O]") +
                                 channel("key", "C[DS]+<L.'key'>"));
    const Outcome outcome = run_raylex(folder, "lpe check show.rib");
    INFO(outcome.out << outcome.err);
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.out,
                   "3 pairs count the same light; the shortest path of each:\n"
                   "             1 2 3\n"
                   "  1 diffuse  \\ a b\n"
                   "  2 direct   a \\ b\n"
                   "  3 key      b b \\\n"));
    CHECK(contains(outcome.out, "a  camera, diffuse reflection, light (C,- R,D L,-)"));
    CHECK(contains(outcome.out, "b  camera, diffuse reflection, light 'key' (C,- R,D L,-,key)"));
    CHECK(contains(outcome.out, "seen directly"));
    CHECK(contains(outcome.out, "first a specular reflection"));
    CHECK(outcome.out.substr(outcome.out.rfind('\n', outcome.out.size() - 2) + 1) == "C,- L,-\n");
    const auto json = raylex::experiments::parse_json(run_raylex(folder, "lpe check show.rib --json").out);
    CHECK(json[0]["verdict"] == "missed");
    CHECK(json[0]["overlaps"].size() == 3);
    CHECK(json[0]["volume"] == false);
}

TEST_CASE("several splits of one beauty in a file are recognised") {
    const Folder folder;
    const std::string lights = channel("key", "C[DS]*<L.'key'>") + channel("rest", "C[DS]*[<L.[^'key']>O]");
    folder.write("show.rib",
                 basic_set() + lights + channel("diffuse", "C(D[DS]*[LO])|[LO]") + channel("specular", "CS[DS]*[LO]"));
    const Outcome holds = run_raylex(folder, "lpe check show.rib");
    INFO(holds.out << holds.err);
    CHECK(holds.code == 0);
    CHECK(contains(holds.out, "a partition by themselves: 'key', 'rest'"));
    CHECK(contains(holds.out, "a partition by themselves: 'diffuse', 'specular'"));
    CHECK(contains(holds.out, "the layers are 3 partitions of the beauty"));
    // A layer in none of the splits is counted twice.
    folder.write("more.rib", folder.read("show.rib") + channel("caustics", "CDS+L"));
    const Outcome more = run_raylex(folder, "lpe check more.rib");
    INFO(more.out);
    CHECK(more.code == 1);
    CHECK(contains(more.out, "in none: 'caustics'"));
    // Two equal channels are not two splits.
    folder.write("twice.rib", channel("a", "CD.*") + channel("b", "CD.*") + channel("rest", "C((S.*[LO])|[LO])"));
    CHECK(run_raylex(folder, "lpe check twice.rib").code == 1);
}

TEST_CASE("lpe check names every invalid expression") {
    const Folder folder;
    folder.write("show.rib",
                 channel("a", "C<RX>.*") + channel("good", "CL") + channel("b", "C[DS") + channel("c", "noSuchName"));
    const Outcome outcome = run_raylex(folder, "lpe check show.rib");
    INFO(outcome.err);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, "show.rib:1:57: found 'X'"));
    CHECK(contains(outcome.err, "show.rib:3:"));
    CHECK(contains(outcome.err, "show.rib:4:"));
    CHECK(contains(outcome.err, "3 errors in the channels"));
    folder.write("m.ini", "/prman/lpe/macro/bad C<RX>\n");
    folder.write("two.rib", channel("a", "bad") + channel("b", "unoccluded;bad"));
    const Outcome macro = run_raylex(folder, "lpe check two.rib m.ini");
    CHECK(contains(macro.err, "m.ini:1:25: found 'X'"));
}

TEST_CASE("expressions that RenderMan cannot read are errors in its files", "[law7]") {
    const Folder folder;
    folder.write("show.rib", channel("seen", "C[<L.>O]") + channel("glossy", "C<RG>.*") +
                                 channel("mirror", "C(<RS>-<RG>).*") + channel("fog", "CV.*") +
                                 channel("beauty_Village", "beauty_Village") + channel("sampled", "s1t3;C.*"));
    check_refused(folder, "lpe check show.rib",
                  {"show.rib:2:", "'glossy' has 'G', which RenderMan does not support", "S is every specular",
                   "show.rib:3:", "'mirror' has '-', 'G'", "show.rib:4:", "'fog' has 'V'", "show.rib:6:", "s1t3;",
                   "4 errors in the channels", "--for raylex"});
    CHECK_FALSE(contains(run_raylex(folder, "lpe check show.rib").err, "Village"));
    CHECK(run_raylex(folder, "lpe check show.rib --for raylex").code == 1);
    folder.write("rendermn.ini", "/prman/lpe/macro/glossy C<RG>.*\n");
    folder.write("uses.rib", channel("a", "glossy"));
    check_refused(folder, "lpe check uses.rib rendermn.ini", {"rendermn.ini:1:", "'G'"});
    folder.write("a.usda",
                 "#usda 1.0\ndef RenderVar \"a\"\n{\n    uniform string sourceName = \"C<RG>.*\"\n"
                 "    uniform token sourceType = \"lpe\"\n}\n");
    check_refused(folder, "lpe check a.usda", {"a.usda:4:", "'G'"});
    CHECK(run_raylex(folder, "lpe check a.usda --dialect osl").code == 1);
    // Text written for RenderMan must follow its rules; it has neither blanks nor comments.
    folder.write("mine.toml",
                 "[[channel]]\nname = \"glossy\"\nlpe = \"C<RG>.*\"\n[[channel]]\nname = \"others\"\n"
                 "lpe = \"C.*-C<RG>.*\"\n");
    CHECK(run_raylex(folder, "lpe check mine.toml").code == 0);
    for (const char* format : {"rib", "ini", "usda"}) {
        CAPTURE(format);
        check_refused(folder, std::string("lpe check mine.toml -o x.") + format, {"mine.toml:3:", "'G'"});
        CHECK(run_raylex(folder, std::string("lpe check mine.toml --for raylex -o y.") + format).code == 0);
    }
    folder.write("plain.toml", "[[channel]]\nname = \"all\"\nlpe = \"C [DS]*  # bounces\\n [<L.'a b'>O]\"\n");
    CHECK(run_raylex(folder, "lpe check plain.toml --no-volume -o plain.rib").code == 1);
    CHECK(contains(folder.read("plain.rib"), "lpe:C[DS]*[<L.'a b'>O]\""));
}

TEST_CASE("several files are reported one by one, then together") {
    const Folder folder;
    const std::string beauty = channel("Ci", "C.*[<L.>O]");
    folder.write("lobes.rib", beauty + channel("diffuse", "C(D[DS]*[LO])|[LO]") + channel("specular", "CS[DS]*[LO]"));
    folder.write("lights.rib", beauty + channel("key", "C[DS]*<L.'key'>") + channel("glow", "C[DS]*[<L.[^'key']>O]"));
    const Outcome both = run_raylex(folder, "lpe check lobes.rib lights.rib");
    INFO(both.out << both.err);
    CHECK(both.code == 0);
    const std::size_t first = both.out.find("lobes.rib: 3 channels with expressions, 2 of them layers"),
                      second = both.out.find("lights.rib: 3 channels with expressions, 2 of them layers"),
                      all = both.out.find("lobes.rib, lights.rib: 5 channels with expressions, 4 of them layers");
    CHECK(first < second);
    CHECK(second < all);
    CHECK(all != std::string::npos);
    CHECK(contains(both.out, "each of the 2 files splits the beauty by itself"));
    CHECK(raylex::experiments::parse_json(run_raylex(folder, "lpe check lobes.rib lights.rib --json").out).size() == 3);
    // A layer that both have is not an overlap; a file that does not hold alone is named.
    const std::string emission = channel("seen", "C[<L.>O]");
    folder.write("a.rib", emission + channel("d", "CD[DS]*[LO]") + channel("s", "CS[DS]*[LO]"));
    folder.write("b.rib", emission + channel("k", "C[DS]+<L.'key'>") + channel("g", "C[DS]+[<L.[^'key']>O]"));
    CHECK(run_raylex(folder, "lpe check a.rib b.rib").code == 0);
    folder.write("b.rib", emission + channel("k", "C[DS]+<L.'key'>"));
    const Outcome less = run_raylex(folder, "lpe check a.rib b.rib");
    INFO(less.out);
    CHECK(less.code == 1);
    CHECK(contains(less.out, "3 channels are a partition of the beauty"));
    // Files that form one split together hold together.
    folder.write("c.rib", channel("d", "CD[DS]*[LO]"));
    folder.write("e.rib", channel("s", "CS[DS]*[LO]") + emission);
    CHECK(run_raylex(folder, "lpe check c.rib e.rib").code == 0);
    folder.write("f.rib", channel("d", "CS[DS]*[LO]"));
    check_refused(folder, "lpe check c.rib f.rib", {"f.rib:1", "'d' is used twice with two meanings", "c.rib:1"});
}

TEST_CASE("conversions keep statistics and AOVs, and name everything that the format cannot store") {
    const Folder folder;
    const std::string mse = " \"string statistics\" [\"mse\"]";
    folder.write("show.rib",
                 "DisplayChannel \"normal Nn\"\nDisplayChannel \"float depth\" \"string source\" [\"z\"]\n"
                 "DisplayChannel \"color odd\" \"string source\" [\"mine\"]\n" +
                     channel("diffuse", "C(D[DS]*[LO])|[LO]") + channel("diffuse_mse", "C(D[DS]*[LO])|[LO]", mse) +
                     channel("spec", "CS[DS]*[LO]") + channel("caustics_mse", "CDS+L", mse));
    const Outcome toml = run_raylex(folder, "lpe check show.rib -o show.toml");
    INFO(toml.out << toml.err << folder.read("show.toml"));
    CHECK(toml.code == 0);
    CHECK(
        contains(folder.read("show.toml"), "name = \"diffuse\"\nlpe = \"C(D[DS]*[LO])|[LO]\"\nstatistics = [\"mse\"]"));
    CHECK(contains(folder.read("show.toml"), "[channels]\naovs = [\"Nn\", \"z\"]"));
    CHECK(contains(toml.err, "filter ('diffuse', 'diffuse_mse', 'spec', 'caustics_mse'), filterwidth ("));
    CHECK(contains(toml.err,
                   "channel 'caustics_mse' of show.rib contains statistics (mse) of an expression that no other"));
    CHECK(contains(toml.err, "left out: 'odd'"));
    CHECK(run_raylex(folder, "lpe check show.toml --no-volume").code == 0);
    // The conversion back, and to the other formats.
    CHECK(run_raylex(folder, "lpe check show.toml --no-volume -o again.rib").code == 0);
    CHECK(contains(folder.read("again.rib"), "DisplayChannel \"color diffuse_mse\""));
    CHECK(contains(folder.read("again.rib"), "DisplayChannel \"float z\""));
    CHECK(contains(run_raylex(folder, "lpe check again.rib").out, "not layers (statistics mse): 'diffuse_mse'"));
    const Outcome usd = run_raylex(folder, "lpe check show.rib -o show.usda");
    CHECK(contains(usd.err, "USD has no place for parameters of channels, which are left out: filter ("));
    CHECK(contains(usd.err, "channels without one are left out: 'Nn', 'depth', 'odd'"));
    CHECK(contains(run_raylex(folder, "lpe check show.usda --no-volume").out,
                   "(statistics mse): 'diffuse_mse', 'caustics_mse'"));
    const Outcome ini = run_raylex(folder, "lpe check show.rib -o show.ini");
    CHECK(contains(ini.err,
                   "rendermn.ini has no statistics; channels of them are left out: 'diffuse_mse', 'caustics_mse'"));
    CHECK(run_raylex(folder, "lpe check show.ini").code == 0);
    CHECK(run_raylex(folder, "lpe check show.rib -o same.rib").code == 0);
    CHECK(contains(folder.read("same.rib"), "DisplayChannel \"float depth\" \"string source\" [\"z\"]"));
}

TEST_CASE("conversions of a TOML file never lose a definition silently") {
    const Folder folder;
    const std::string all =
        "[macros]\ncaustics = \"C<RD>S+[<L.>O]\"\n[lobe_slots]\nspecular5 = \"coat\"\n[channels]\n"
        "aovs = [\"z\", \"Nn\"]\ncryptomatte = [\"object\"]\ncryptomatte_ranks = 4\n"
        "rules = { z = \"zmax\", heat = \"max\" }\nshipped_partition = true\nlight_groups = true\n"
        "techniques = \"pyramid:caus\"\n[channels.statistics]\nbeauty = [\"mse\"]\n"
        "[[channel]]\nname = \"caus\"\nlpe = \"lpe:caustics\"\nstatistics = [\"variance\"]\nrule = \"max\"\n"
        "[[channel]]\nname = \"other\"\nlpe = \"!($caustics)\"\n[[channel]]\nname = \"heat\"\ntype = \"float\"\n"
        "[[layer]]\nname = \"z_far\"\nchannel = \"z\"\nrule = \"zmin\"\n"
        "[[partition]]\nname = \"mine\"\nchannels = [\"caus\", \"other\"]\n";
    folder.write("all.toml", all);
    const Outcome toml = run_raylex(folder, "lpe check all.toml -o once.toml");
    INFO(toml.err << folder.read("once.toml"));
    CHECK(toml.code == 0);
    CHECK_FALSE(contains(toml.err, "left out"));
    for (const char* kept :
         {"caustics = \"C<RD>S+[<L.>O]\"", "specular5 = \"coat\"", "aovs = [\"z\", \"Nn\"]",
          "cryptomatte = [\"object\"]", "cryptomatte_ranks = 4", "rules = { heat = \"max\", z = \"zmax\" }",
          "shipped_partition = true", "light_groups = true", "techniques = \"pyramid:caus\"", "\"beauty\" = [\"mse\"]",
          "lpe = \"lpe:caustics\"\nstatistics = [\"variance\"]\nrule = \"max\"", "name = \"heat\"\ntype = \"float\"",
          "[[layer]]\nname = \"z_far\"\nchannel = \"z\"\nrule = \"zmin\"", "[[partition]]\nname = \"mine\""}) {
        CAPTURE(kept);
        CHECK(contains(folder.read("once.toml"), kept));
    }
    CHECK(run_raylex(folder, "lpe check once.toml -o twice.toml").code == 0);
    CHECK(folder.read("twice.toml") == folder.read("once.toml"));
    for (const std::string format : {"rib", "usda", "ini"}) {
        CAPTURE(format);
        const Outcome out = run_raylex(folder, "lpe check all.toml --for raylex -o x." + format);
        const std::string text = folder.read("x." + format);
        INFO(out.err << text);
        CHECK(out.code == 0);
        CHECK_FALSE(contains(text, "lpe:lpe:"));
        CHECK(contains(text, "caustics") == (format == "ini"));
        CHECK(contains(out.err, "all.toml:2: the macro 'caustics' is expanded") == (format != "ini"));
        for (const char* lost : {"all.toml:7: ", "'cryptomatte' of", "all.toml:10: ", "'shipped_partition' of",
                                 "all.toml:11: ", "'light_groups' of", "all.toml:12: ", "'techniques' of",
                                 "all.toml:30: ", "the partition 'mine'"})
            CHECK(contains(out.err, lost));
        CHECK(contains(out.err, "all.toml:4: USD has no place for the lobe slot 'specular5'") == (format == "usda"));
        // In rendermn.ini the macro itself is also a channel.
        CHECK(run_raylex(folder, "lpe check x." + format + " --for raylex --volume").code == (format == "ini" ? 1 : 0));
    }
    const std::string rib = folder.read("x.rib");
    CHECK(contains(rib, "\"color caus\" \"string source\" [\"color lpe:C<RD>S+[<L.>O]\"] \"string filter\" [\"max\"]"));
    CHECK(contains(rib, "DisplayChannel \"float z\" \"string filter\" [\"zmax\"]"));
    CHECK(contains(rib, "DisplayChannel \"float z_far\" \"string filter\" [\"zmin\"] \"string source\" [\"z\"]"));
    CHECK(contains(rib, "DisplayChannel \"float heat\""));
    CHECK(contains(rib, "DisplayChannel \"normal Nn\""));
    const Outcome back = run_raylex(folder, "lpe check x.rib --for raylex --volume -o back.toml");
    INFO(back.err << folder.read("back.toml"));
    CHECK(contains(folder.read("back.toml"), "rules = { z = \"zmax\" }"));
    CHECK(contains(folder.read("back.toml"), "[[layer]]\nname = \"z_far\"\nchannel = \"z\"\nrule = \"zmin\""));
    // For RenderMan the expression of the macro is checked.
    folder.write("plain.toml", "[macros]\nmine = \"C[DS]*[<L.>O]\"\n[[channel]]\nname = \"all\"\nlpe = \"$mine\"\n");
    CHECK(run_raylex(folder, "lpe check plain.toml --no-volume -o plain.rib").code == 0);
    check_refused(folder, "lpe check all.toml -o x.rib", {"all.toml:", "'other' has '!'"});
}

TEST_CASE("all errors of a channel file are reported together", "[law7]") {
    const Folder folder;
    folder.write("bad.rib", channel("a", "C<RD>L") + channel("b", "C[DS+L") + "DisplayChanel \"color c\"\n" +
                                channel("d", "") + channel("e", "C<RX>L") + channel("a", "C<RS>L") +
                                channel("f", "CL", " \"string statistics\" [\"msee\"]"));
    const Outcome outcome = run_raylex(folder, "lpe check bad.rib");
    INFO(outcome.err);
    CHECK(outcome.code == 2);
    std::size_t at = 0;
    for (const char* line : {"bad.rib:2:", "bad.rib:3:1: unknown request 'DisplayChanel'", "'DisplayChannel'?",
                             "bad.rib:4:", "bad.rib:5:", "bad.rib:6", "two meanings", "bad.rib:7:", "'mse'?",
                             "6 errors in the channels"}) {
        CAPTURE(line);
        at = outcome.err.find(line, at);
        REQUIRE(at != std::string::npos);
    }
    check_refused(folder, "lpe explain bad.rib", {"bad.rib:3:1"});
}

TEST_CASE("the suggested rest can be read by the application of the file") {
    const Folder folder;
    folder.write("show.rib",
                 channel("Ci", "C.*[<L.>O]") + channel("diffuse", "C<RD>[DS]*[<L.>O]") + channel("seen", "C[<L.>O]"));
    const Outcome outcome = run_raylex(folder, "lpe check show.rib");
    INFO(outcome.out << outcome.err);
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.out, "not layers (the beauty): 'Ci'"));
    const std::size_t begin = outcome.out.find("rest=\"");
    REQUIRE(begin != std::string::npos);
    const std::string rest = outcome.out.substr(begin + 6, outcome.out.find('"', begin + 6) - begin - 6);
    CHECK(rest.find_first_of("?VBG&!{") == std::string::npos);
    CHECK(run_raylex(folder, "lpe check show.rib rest='" + rest + "'").code == 0);
    CHECK(run_raylex(folder, "lpe check show.rib --rest others -o whole.rib").code == 0);
    const Outcome whole = run_raylex(folder, "lpe check whole.rib");
    INFO(whole.out << whole.err);
    CHECK(whole.code == 0);
    // With --of, the beauty of the file is not a layer either.
    const Outcome of = run_raylex(folder, "lpe check show.rib --of 'C[DS]*[<L.>O]' --rest others");
    INFO(of.out << of.err);
    CHECK(of.code == 0);
}

TEST_CASE("lpe check accepts known groups and labels, and finds misspelt ones without a scene") {
    const Folder folder;
    folder.write("lights.rib",
                 channel("key", "C[DS]*<L.'key'>") + channel("fill", "C[DS]*<L.'fill'>") + channel("glow", "C[DS]*O"));
    const Outcome open = run_raylex(folder, "lpe check lights.rib");
    CHECK(open.code == 1);
    CHECK(run_raylex(folder, "lpe check lights.rib --groups key,fill --all-labelled").code == 0);
    const Outcome rim = run_raylex(folder, "lpe check lights.rib --groups kye,fill,rim --all-labelled");
    CHECK(rim.code == 1);
    CHECK(contains(rim.err, "'key' (channel 'key') is not a light group of --groups; did you mean 'kye'?"));
    folder.write("slip.rib", channel("a", "C<RD><L.'key'>") + channel("b", "C<RS><L.'key'>") +
                                 channel("c", "C<TD><L.'kye'>") + channel("d", "C<TS><L.'key2'>"));
    const Outcome slip = run_raylex(folder, "lpe check slip.rib");
    CHECK(contains(slip.err, "'kye' (channel 'c') occurs beside 'key' in 2 channels; did you mean 'key'?"));
    CHECK_FALSE(contains(slip.err, "key2"));
    CHECK_FALSE(contains(run_raylex(folder, "lpe check lights.rib").err, "did you mean"));
    const Outcome label = run_raylex(folder, "lpe check a=\"C<RD'flor'>.*\" --labels floor,wall");
    CHECK(contains(label.err, "'flor' (channel 'a') is not a label of --labels; did you mean 'floor'?"));
    folder.write("scene.pbrt", small_scene());
    CHECK(run_raylex(folder, "lpe check lights.rib --groups key --scene scene.pbrt").code == 2);
}

TEST_CASE("a channel file without an option is recognised") {
    const Folder folder;
    folder.write("show.rib", basic_set());
    folder.write("a=b.rib", basic_set());
    CHECK(run_raylex(folder, "lpe check ./a=b.rib").code == 0);
    const Outcome both = run_raylex(folder, "lpe check a=b.rib");
    CHECK(both.code == 2);
    CHECK(contains(both.err, "also reads as NAME=EXPR"));
    CHECK(run_raylex(folder, "lpe check --channels a=b.rib").code == 0);
    const Outcome missing = run_raylex(folder, "lpe check shwo.rib");
    CHECK(missing.code == 2);
    CHECK(contains(missing.err, "shwo.rib: this channel file does not exist"));
    folder.write("arnold.txt", "RGBA C.*\n");
    check_refused(folder, "lpe check arnold.txt", {"arnold.txt: ", ".toml, .rib, .usda, .usd or .ini", "--format"});
    check_refused(folder, "lpe check arnold",
                  {"'arnold' is not a named expression", ".toml, .rib, .usda, .usd or .ini"});
    const Outcome one = run_raylex(folder, "lpe explain show.rib directDiffuse");
    CHECK(one.code == 0);
    CHECK(contains(one.out, "From the camera, one diffuse reflection"));
    const Outcome all = run_raylex(folder, "lpe explain show.rib");
    CHECK(all.code == 0);
    CHECK(contains(all.out, "emissive    C[<L.>O]\n    "));
    CHECK(contains(all.out, "transmissive    C<TS>"));
    CHECK(run_raylex(folder, "lpe explain show.rib CL CDL").code == 2);
    CHECK(run_raylex(folder, "lpe explain CL --nothing").code == 2);
    // For a misspelt channel name, the suggestion is a name of the file, not a built-in one.
    folder.write("rim.rib", "DisplayChannel \"color rimDiffuse\" \"string source\" \"color lpe:C<RD>[<L.>]\"\n");
    check_refused(folder, "lpe explain rim.rib rimDifuse", {"'rimDifuse'", "did you mean 'rimDiffuse'?"});
    check_refused(folder, "lpe check rim.rib --of rimDifuse", {"'rimDifuse'", "did you mean 'rimDiffuse'?"});
    check_refused(folder, "lpe explain rim.rib keyLight", {"'keyLight'", "known channels: rimDiffuse"});
    CHECK(run_raylex(folder, "lpe graph show.rib").code == 0);
}

TEST_CASE("a file of five hundred channels is checked quickly, and its overlaps are summarised",
          "[release-only][gate]") {
    const Folder folder;
    std::string text;
    for (int group = 0; group < 125; ++group)
        for (const char* lobe : {"RD", "RS", "TD", "TS"})
            text += channel("g" + std::to_string(group) + lobe,
                            "C<" + std::string(lobe) + ">[DS]*<L.'g" + std::to_string(group) + "'>");
    folder.write("big.rib", text + channel("all", "C<RD>[DS]*[<L.>O]"));
    const Outcome outcome = run_raylex(folder, "lpe check big.rib");
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.out, "125 pairs count the same light"));
    CHECK(outcome.out.size() < 4000);
    // Too many labels for a rest as text, and channels too large for one proof, still give a result.
    folder.write("lights.rib", text);
    const Outcome lights = run_raylex(folder, "lpe check lights.rib");
    CHECK(lights.code == 1);
    CHECK(contains(lights.out, "no short expression"));
    std::string large;
    for (int k = 0; k < 500; ++k)
        large += channel("o" + std::to_string(k), "C.*<.D'o" + std::to_string(k) + "'>.*[<L.>O]");
    folder.write("large.rib", large);
    const Outcome pairs = run_raylex(folder, "lpe check large.rib");
    INFO(pairs.out << pairs.err);
    CHECK(pairs.code == 1);
    CHECK(contains(pairs.out, " pairs count the same light"));
    CHECK(contains(pairs.err, "gaps were not searched for"));
    CHECK(contains(pairs.out, "'o0' and 'o1' both count "));
}
