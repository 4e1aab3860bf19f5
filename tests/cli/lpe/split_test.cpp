// raylex lpe split and channels from files; macros and lobe slots in a job.
#include <catch2/catch.hpp>

#include <numeric>

#include "display/output/reader/exr_reader.h"
#include "tests/experiments/support.h"

using namespace raylex;
using namespace raylex::test;

TEST_CASE("lpe split writes every format, and lpe check reads each back as a partition") {
    const Folder folder;
    for (const char* format : {"toml", "rib", "usda", "ini"}) {
        const std::string file = std::string("split.") + format;
        INFO(file);
        const Outcome split = run_raylex(
            folder, "lpe split --by light-group,lobe,bounce --groups key,fill --bounces 2 --for raylex -o " + file);
        CHECK(split.code == 0);
        CHECK(split.out.empty());
        CHECK(split.err.find("33 channels are a partition of the beauty") != std::string::npos);
        const Outcome check = run_raylex(folder, "lpe check --for raylex --channels " + file);
        INFO(check.out << check.err);
        CHECK(check.code == 0);
        CHECK(check.out.find("33 channels are a partition of the beauty") != std::string::npos);
    }
    // Without media in the split, no channel has a path through a medium.
    CHECK(run_raylex(folder, "lpe split --by lobe --no-volume -o dry.toml").code == 0);
    const Outcome dry = run_raylex(folder, "lpe check --channels dry.toml");
    CHECK(dry.code == 1);
    CHECK(dry.out.find("C,- V,- L,-") != std::string::npos);
    const Outcome printed = run_raylex(folder, "lpe split --by lobe --no-volume --write-as rib");
    CHECK(printed.code == 0);
    CHECK(printed.out.find("DisplayChannel \"color diffuse\" \"string source\" [\"color lpe:C<RD>.*[<L.>O]\"]") !=
          std::string::npos);
    // A split for RenderMan itself has no media.
    check_refused(folder, "lpe split --by lobe -o r.rib", {"'V', which RenderMan does not support", "--no-volume"});
    CHECK(run_raylex(folder, "lpe split --by light-group,lobe --groups key --no-volume -o r.usda").code == 0);
    CHECK(run_raylex(folder, "lpe check r.usda --no-volume").code == 0);
    CHECK(run_raylex(folder, "lpe split --by lobes").code == 2);
    CHECK(run_raylex(folder, "lpe split --by light-group").code == 2);
    CHECK(run_raylex(folder, "lpe split --by lobe -o split.txt").code == 2);
    CHECK_FALSE(folder.has("split.txt"));
}

TEST_CASE("the preset compositing splits a scene by light group, bounce and lobe, and names what is empty", "[law1]") {
    const SceneFolder folder;
    std::string scene = small_scene();
    const std::string emission = "\"rgb L\" [4 4 4]";
    scene.replace(scene.find(emission), emission.size(), emission + " \"bool twosided\" true");  // the camera sees it
    folder.write("room.pbrt", scene);
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[[light_group]]\nlight = \"point\"\ngroup = \"key\"\n");
    const Outcome split = run_raylex(folder, "lpe split --preset compositing --scene job.toml -o layers.toml");
    CAPTURE(split.err);
    REQUIRE(split.code == 0);
    CHECK(contains(split.err, "6 channels are a partition of the beauty"));
    CHECK(contains(split.err,
                   "no path reaches 16 bins, left out: key_direct_specular, key_indirect_specular, "
                   "key_direct_transmission, key_indirect_transmission, key_direct_subsurface, "));
    CHECK(contains(split.err, "default_indirect_volume"));
    REQUIRE(run_raylex(folder, "render job.toml --channels layers.toml -o a.exr").code == 0);
    const Outcome verify = run_raylex(folder, "verify a.exr");
    CAPTURE(verify.out);
    CHECK(verify.code == 0);
    CHECK(contains(verify.out, "partition 'split': 6 layers against beauty: holds to rounding"));
    auto image = display::read_exr(folder.path("a.exr"));
    REQUIRE(image);
    const auto light = [&](const char* name) {
        const std::vector<float> red = plane(*image, name, "R");
        return std::accumulate(red.begin(), red.end(), 0.0);
    };
    for (const char* lit : {"key_direct_diffuse", "default_direct_diffuse", "default_emission"}) CHECK(light(lit) > 0);
    CHECK(light("key_emission") == 0);  // a point light is not seen
    // Without groups all lights are in default; without a scene all bins are kept, in osl too.
    CHECK(
        contains(run_raylex(folder, "lpe split --preset compositing --scene room.pbrt").out, "default_direct_diffuse"));
    for (const char* rest :
         {"", " --groups key,fill", " --dialect osl", " --dialect osl --all-labelled --groups key"}) {
        CAPTURE(rest);
        const Outcome all = run_raylex(folder, std::string("lpe split --preset compositing") + rest);
        CHECK(all.code == 0);
        CHECK(contains(all.err, "channels are a partition of the beauty"));
        CHECK(contains(all.out, "name = \"default_indirect_subsurface\""));
        CHECK_FALSE(contains(all.err, "left out"));
    }
    CHECK(run_raylex(folder, "lpe split --preset compositing --no-volume --write-as rib").code == 0);
    CHECK(run_raylex(folder, "lpe split --preset compositing --by lobe").code == 2);
    CHECK(run_raylex(folder, "lpe split --preset compositor").code == 2);
    check_refused(folder, "lpe split -o x.toml", {"no axis", "--preset compositing"});
}

TEST_CASE("unknown groups and objects are named, with the known ones", "[law7]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    check_refused(folder, "lpe split --by light-group --groups left,right --scene scene.pbrt -o x.toml",
                  {"--groups", "scene.pbrt has no light group 'left', 'right'", "expected some of: none"});
    check_refused(folder, "lpe split --by object --objects flor --scene scene.pbrt -o x.toml",
                  {"--objects", "has no object label 'flor'"});
}

TEST_CASE("lpe check suggests the rest, adds it, and converts files") {
    const Folder folder;
    folder.write("a.rib",
                 "DisplayChannel \"color diff\" \"string source\" [\"color lpe:myD\"] \"string filter\" \"box\"\n"
                 "DisplayChannel \"color spec\" \"string source\" [\"color lpe:C<RS>.*\"]\n");
    folder.write("rendermn.ini", "/prman/lpe/macro/myD C<RD>.*\n");
    const Outcome check = run_raylex(folder, "lpe check --channels a.rib --channels rendermn.ini");
    CHECK(check.code == 1);
    CHECK(check.out.find("rest=\"(C|(CT.*))[LO]\"") != std::string::npos);
    const Outcome whole =
        run_raylex(folder, "lpe check --channels a.rib --channels rendermn.ini --rest others -o whole.toml");
    CHECK(whole.code == 0);
    CHECK(folder.read("whole.toml").find("name = \"others\"\nlpe = \"(C|(CT.*))[LO]\"") != std::string::npos);
    CHECK(run_raylex(folder, "lpe check --channels whole.toml --no-volume").code == 0);
    const Outcome macro = run_raylex(folder, "lpe check --channels a.rib");
    CHECK(macro.code == 2);
    CHECK(macro.err.find("a.rib:1:57: unknown name 'myD'") != std::string::npos);
    folder.write("wrong.ini", "/prman/lpe/macro/myD C<RX>.*\n");
    const Outcome wrong = run_raylex(folder, "lpe check --channels a.rib --channels wrong.ini");
    CHECK(wrong.code == 2);
    CHECK(wrong.err.find("wrong.ini:1:25: found 'X'") != std::string::npos);
    CHECK(wrong.err.find("in the macro 'myD'") != std::string::npos);
    CHECK(run_raylex(folder, "lpe check --channels a.rib --channels a.rib --channels rendermn.ini").code == 1);
    CHECK(run_raylex(folder, "lpe explain spec --channels a.rib --channels rendermn.ini").out.find("C<RS>.*") !=
          std::string::npos);
}

TEST_CASE("errors have the right column in TOML strings with escapes") {
    const Folder folder;
    folder.write("m.toml",
                 "[macros]\nbad = \"C<R\\u0044>\\tD*LX\"\n[[channel]]\nname = \"a\"\nlpe = \"\"\"\nC<RD>\\\n   "
                 ".*($bad)\"\"\"\n");
    const Outcome outcome = run_raylex(folder, "lpe check --channels m.toml");
    CHECK(outcome.code == 2);
    CHECK(outcome.err.find("m.toml:2:23: found 'X'") != std::string::npos);
    folder.write("n.toml", "[[channel]]\nname = \"a\"\nlpe = '''\nC<RD>\n.*X'''\n");
    CHECK(run_raylex(folder, "lpe check --channels n.toml").err.find("n.toml:5:3: found 'X'") != std::string::npos);
    folder.write("c.toml", "[macros]\none = \"C$two\"\ntwo = \"D$one\"\n[[channel]]\nname = \"a\"\nlpe = \"one\"\n");
    CHECK(run_raylex(folder, "lpe check --channels c.toml").err.find("one -> two -> one") != std::string::npos);
    folder.write("k.toml", "[[channel]]\nname = \"a\"\nlpe = \"C.*\"\n[lobeslots]\n");
    CHECK(run_raylex(folder, "lpe check --channels k.toml").err.find("did you mean 'lobe_slots'?") !=
          std::string::npos);
}

TEST_CASE("partitions that a TOML file declares are checked one by one") {
    const Folder folder;
    folder.write(
        "p.toml",
        "[[channel]]\nname = \"a\"\nlpe = \"C<RD>.*\"\n[[channel]]\nname = \"b\"\nlpe = \"C.*-C<RD>.*\"\n"
        "[[channel]]\nname = \"c\"\nlpe = \"C.*\"\n[[partition]]\nname = \"good\"\nchannels = [\"a\", \"b\"]\n");
    const Outcome good = run_raylex(folder, "lpe check --channels p.toml");
    CHECK(good.code == 0);
    CHECK(good.out.find("partition 'good': 2 channels are a partition") != std::string::npos);
    folder.write("q.toml",
                 folder.read("p.toml") + "[[partition]]\nname = \"bad\"\nchannels = [\"a\", \"c\"]\nrest = \"r\"\n");
    const Outcome bad = run_raylex(folder, "lpe check --channels q.toml");
    CHECK(bad.code == 1);
    CHECK(bad.out.find("partition 'bad': 'a' and 'c' both count") != std::string::npos);
}

TEST_CASE("macros and lobe slots of a job determine its layers", "[law1]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    const auto job = [](const std::string& slots, const std::string& lobe) {
        return "[scene]\nfile = \"scene.pbrt\"\n[macros]\nfirst = \"C<RD>\"\n" + slots +
               "[[channel]]\nname = \"numbered\"\nlpe = \"C" + lobe + ".*\"\n" +
               "[[channel]]\nname = \"named\"\nlpe = \"noclamp;$first.*\"\n" +
               "[[channel]]\nname = \"ready\"\nlpe = \"noclamp;diffuse\"\n";
    };
    folder.write("usual.toml", job("", "D2"));
    folder.write("moved.toml", job("[lobe_slots]\ndiffuse3 = [\"Subsurface\", \"diffuse\"]\n", "D3"));
    folder.write("gone.toml", job("[lobe_slots]\ndiffuse3 = \"diffuse\"\n", "D2"));
    for (const char* name : {"usual", "moved", "gone"}) {
        const Outcome render =
            run_raylex(folder, std::string("render ") + name + ".toml -o " + name + ".exr --spp 1 --resolution 8x8");
        INFO(render.err);
        CHECK(render.code == 0);
    }
    // The light of D2 is now in D3, bit for bit, and D2 is empty.
    CHECK(run_raylex(folder, "compare moved.exr usual.exr --layer numbered --metric mae").out == "0\n");
    CHECK(run_raylex(folder, "compare usual.exr usual.exr --layer numbered --metric mean-ratio").out == "1\n");
    CHECK(run_raylex(folder, "compare gone.exr usual.exr --layer numbered --metric mean-ratio").out == "0\n");
    // A macro in a job equals its expression.
    CHECK(run_raylex(folder, "compare usual.exr usual.exr --layer named --metric mean-ratio").out == "1\n");
    folder.write("wrong.toml", "[scene]\nfile = \"scene.pbrt\"\n[lobe_slots]\ndiffuse7 = \"diffuse\"\n");
    const Outcome wrong = run_raylex(folder, "render wrong.toml -o wrong.exr");
    CHECK(wrong.code == 2);
    CHECK(wrong.err.find("no lobe slot 'diffuse7'") != std::string::npos);
}
