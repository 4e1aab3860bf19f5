// raylex lpe split and channels from files; macros and lobe slots in a job.
#include <catch2/catch.hpp>

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
