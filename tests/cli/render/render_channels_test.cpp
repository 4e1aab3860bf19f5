// render --channels: renders channel files of other tools.
#include <catch2/catch.hpp>

#include "display/output/reader/exr_reader.h"
#include "support.h"

using namespace raylex::test;
using raylex::display::read_exr;

TEST_CASE("channels of RIB, rendermn.ini, USD and TOML files are rendered as if --lpe gave them") {
    const SceneFolder folder;
    folder.write("show.rib",
                 "DisplayChannel \"color beauty\" \"string source\" \"lpe:C[DS]*[<L.>O]\"\n"
                 "DisplayChannel \"color direct\" \"string source\" \"lpe:C<RD>[<L.>O]\" \"string filter\" \"box\"\n"
                 "DisplayChannel \"color indirect\" \"string source\" \"lpe:C<RD>[DS]+[<L.>O]\"\n"
                 "DisplayChannel \"color direct_mse\" \"string source\" \"lpe:C<RD>[<L.>O]\" \"string statistics\" "
                 "\"mse\"\n"
                 "DisplayChannel \"color spread\" \"string source\" \"lpe:C<RS>[<L.>O]\" \"string statistics\" "
                 "\"variance\"\n"
                 "DisplayChannel \"float z\" \"string source\" \"float z\"\n");
    folder.write("show.ini", "/prman/lpe/macro/direct C<RD>[<L.>O]\n/prman/lpe/macro/indirect C<RD>[DS]+[<L.>O]\n");
    folder.write("show.usda",
                 "#usda 1.0\ndef RenderVar \"direct\"\n{\n    uniform string sourceName = \"C<RD>[<L.>O]\"\n"
                 "    uniform token sourceType = \"lpe\"\n}\n"
                 "def RenderVar \"indirect\"\n{\n    uniform string sourceName = \"C<RD>[DS]+[<L.>O]\"\n"
                 "    uniform token sourceType = \"lpe\"\n}\n");
    folder.write("show.toml",
                 "[[channel]]\nname = \"direct\"\nlpe = \"C<RD>[<L.>O]\"\n[[channel]]\nname = \"indirect\"\n"
                 "lpe = \"C<RD>[DS]+[<L.>O]\"\n[[partition]]\nname = \"mine\"\nchannels = [\"direct\", "
                 "\"indirect\"]\nrest = \"other\"\n");
    REQUIRE(run_raylex(folder,
                       "render room.pbrt -o flags.exr --lpe 'direct=C<RD>[<L.>O]' --lpe 'indirect=C<RD>[DS]+[<L.>O]'")
                .code == 0);
    auto flags = read_exr(folder.path("flags.exr"));
    REQUIRE(flags);
    for (const char* file : {"show.rib", "show.ini", "show.usda", "show.toml"}) {
        CAPTURE(file);
        const Outcome outcome = run_raylex(folder, std::string("render room.pbrt -o out.exr --channels ") + file);
        CAPTURE(outcome.out, outcome.err);
        REQUIRE(outcome.code == 0);
        auto image = read_exr(folder.path("out.exr"));
        REQUIRE(image);
        for (const char* layer : {"", "direct", "indirect"})
            CHECK(plane(*image, layer, "G") == plane(*flags, layer, "G"));
        CHECK(image->attributes["lpe/direct"] == "C<RD>[<L.>O]");
        const bool toml = std::string(file) == "show.toml";
        CHECK(image->attributes[toml ? "partition/mine" : "partition/auto"] ==
              (toml ? "beauty = direct + indirect + other" : "beauty = direct + indirect + rest"));
        if (std::string(file) != "show.rib") continue;
        CHECK(outcome.err.find("channel 'beauty' of show.rib is the image itself") != std::string::npos);
        CHECK(outcome.err.find("that a job cannot store are left out: filter ('direct')") != std::string::npos);
        // A channel with statistics of another channel is a statistics layer, not light.
        CHECK(outcome.err.find(
                  "channel 'spread' of show.rib contains statistics (variance) of an expression that no other "
                  "channel has; it is left out") != std::string::npos);
        CHECK(plane(*image, "direct_mse", "G") != plane(*image, "direct", "G"));
        CHECK(image->layer("z") != nullptr);
    }
    // In the order of the command line, together with flags and other files.
    const Outcome both =
        run_raylex(folder, "render room.pbrt -o both.exr --lpe seen=C.*B --channels show.ini --lpe 'glow=CO'");
    CAPTURE(both.err);
    REQUIRE(both.code == 0);
    auto image = read_exr(folder.path("both.exr"));
    REQUIRE(image);
    CHECK(image->layer_names() == std::vector<std::string>{"", "seen", "direct", "indirect", "glow", "rest"});
}

TEST_CASE("channels of a file without expressions are AOVs, and duplicate names can be renamed") {
    const SceneFolder folder;
    const std::string albedo =
        "DisplayChannel \"color albedo\" \"string source\" "
        "\"lpe:nothruput;overwrite;C<.S'passthru'>*((U2L)|O)\"\n";
    folder.write("show.rib",
                 "DisplayChannel \"color Ci\"\nDisplayChannel \"float a\"\nDisplayChannel \"normal Nn\"\n"
                 "DisplayChannel \"float depth\" \"string source\" [\"float z\"]\n"
                 "DisplayChannel \"color mse\" \"string source\" [\"color Ci\"] \"string statistics\" [\"mse\"]\n" +
                     albedo);
    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[channels]\naovs = [\"albedo\", \"z\"]\n");
    const Outcome plain = run_raylex(folder, "render room.pbrt -o a.exr --channels show.rib --aov Nn --spp 1");
    INFO(plain.out << plain.err);
    REQUIRE(plain.code == 0);
    auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image);
    for (const char* layer : {"a", "Nn", "z", "albedo", "beauty_mse"}) CHECK(image->layer(layer) != nullptr);
    CHECK(contains(plain.err, "channel 'depth' of show.rib is the layer 'z'"));
    check_refused(folder, "render job.toml -o b.exr --channels show.rib",
                  {"'albedo' is used twice with two meanings", "--rename albedo=NAME"});
    const Outcome renamed =
        run_raylex(folder, "render job.toml -o b.exr --channels show.rib --rename albedo=rib_albedo --spp 1");
    INFO(renamed.err);
    REQUIRE(renamed.code == 0);
    image = read_exr(folder.path("b.exr"));
    REQUIRE(image);
    for (const char* layer : {"albedo", "rib_albedo", "z"}) CHECK(image->layer(layer) != nullptr);
    check_refused(folder, "render room.pbrt -o c.exr --channels show.rib --rename albdo=x", {"--rename", "'albdo=x'"});
    // An atlas has no AOVs; it gives the other layers of such a file.
    folder.write("light.rib",
                 "DisplayChannel \"float z\"\nDisplayChannel \"color d\" \"string source\" \"lpe:C<RD>L\" "
                 "\"string filter\" [\"max\"]\n");
    REQUIRE(run_raylex(folder, "render room.pbrt -o g.exr --atlas g.atlas.exr --spp 1").code == 0);
    const Outcome requested = run_raylex(folder, "ask g.atlas.exr --channels light.rib -o h.exr");
    CHECK(requested.code == 0);
    CHECK(contains(requested.err, "'z' is left out"));
    CHECK(contains(requested.err, "the rule of 'd' is left out"));
    // Channels of equal name and meaning are one layer, however they are written.
    const Outcome same = run_raylex(folder, "render room.pbrt -o d.exr --lpe 'd=C<RD>[<L.>O]' --lpe 'd=C<RD>[LO]'");
    INFO(same.err);
    CHECK(same.code == 0);
    check_refused(folder, "render room.pbrt -o e.exr --lpe 'd=C<RD>L' --lpe 'd=C<RS>L'", {"used twice"});
    // Statistics and AOVs of a TOML file also count.
    folder.write("set.toml",
                 "[channels]\naovs = [\"z\"]\n[[channel]]\nname = \"d\"\nlpe = \"C<RD>L\"\nstatistics = [\"mse\"]\n");
    REQUIRE(run_raylex(folder, "render room.pbrt -o f.exr --channels set.toml --spp 2").code == 0);
    image = read_exr(folder.path("f.exr"));
    REQUIRE(image);
    for (const char* layer : {"d", "d_mse", "z"}) CHECK(image->layer(layer) != nullptr);
}

TEST_CASE("filters of channels that are rules become rules, and other filters are named") {
    const SceneFolder folder;
    folder.write("filt.rib",
                 "DisplayChannel \"float z\" \"string source\" [\"z\"] \"string filter\" [\"zmax\"] "
                 "\"float[2] filterwidth\" [1 1]\nDisplayChannel \"normal Nn\" \"string filter\" [\"gaussian\"]\n"
                 "DisplayChannel \"float near\" \"string source\" [\"z\"] \"string filter\" [\"zmin\"]\n"
                 "DisplayChannel \"color most\" \"string source\" [\"lpe:C<RD>L\"] \"string filter\" [\"max\"]\n");
    const Outcome outcome = run_raylex(folder, "render room.pbrt -o a.exr --channels filt.rib --spp 1");
    INFO(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(contains(outcome.err, "left out: filter ('Nn'), filterwidth ('z')"));
    auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image);
    CHECK(image->attributes["rule/z"] == "zmax");
    CHECK(image->attributes["rule/near"] == "zmin");
    CHECK(image->attributes["rule/most"] == "max");
    const Outcome toml = run_raylex(folder, "lpe check filt.rib -o filt.toml");
    INFO(toml.err << folder.read("filt.toml"));
    CHECK(contains(toml.err, "left out: filter ('Nn'), filterwidth ('z')"));
    CHECK(contains(folder.read("filt.toml"), "rules = { z = \"zmax\" }"));
    CHECK(run_raylex(folder, "render room.pbrt -o b.exr --channels filt.toml --spp 1").code == 0);
    auto again = read_exr(folder.path("b.exr"));
    REQUIRE(again);
    for (const char* rule : {"rule/z", "rule/near", "rule/most"})
        CHECK(again->attributes[rule] == image->attributes[rule]);
}

TEST_CASE("a generated layer that equals a channel is that channel") {
    const SceneFolder folder;
    const std::string direct = " --lpe 'directDiffuse=C<RD>[<L.>O]'";
    REQUIRE(run_raylex(folder, "render room.pbrt -o groups.exr --spp 1 --light-groups").code == 0);
    auto groups = read_exr(folder.path("groups.exr"));
    REQUIRE(groups);
    const std::string of_default = "\"light_default=" + groups->attributes["lpe/light_default"] + "\"";
    const Outcome plain =
        run_raylex(folder, "render room.pbrt -o a.exr --atlas a.atlas.exr --spp 1 --partition shipped --light-groups " +
                               std::string("--lpe ") + of_default + direct);
    INFO(plain.err);
    REQUIRE(plain.code == 0);
    auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image);
    CHECK(contains(image->attributes["partition/shipped"], "directDiffuse"));
    CHECK(contains(image->attributes["partition/light_groups"], "light_default"));
    const Outcome requested = run_raylex(folder, "ask a.atlas.exr --partition shipped -o b.exr" + direct);
    INFO(requested.err);
    CHECK(requested.code == 0);
    check_refused(folder, "render room.pbrt -o c.exr --partition shipped --lpe 'directDiffuse=C<RS>L'",
                  {"'directDiffuse' is used twice with two meanings"});
}

TEST_CASE("errors in a channel file have their place, and nothing is rendered", "[law7]") {
    const SceneFolder folder;
    const auto refused = [&](const std::string& name, const std::string& text, const std::vector<std::string>& words) {
        folder.write(name, text);
        const Outcome outcome = run_raylex(folder, "render room.pbrt -o x.exr --channels " + name);
        CAPTURE(name, outcome.err);
        CHECK(outcome.code == 2);
        for (const std::string& word : words) {
            CAPTURE(word);
            CHECK(outcome.err.find(word) != std::string::npos);
        }
        CHECK_FALSE(folder.has("x.exr"));
    };
    refused("a.rib",
            "DisplayChannel \"color good\" \"string source\" \"lpe:C<RD>L\"\n"
            "DisplayChannel \"color bad\" \"string source\" \"lpe:C<RD]L\"\n",
            {"a.rib:2:53"});
    refused("b.rib", "DisplayChannel \"color rgba\" \"string source\" \"lpe:C<RD>L\"\n", {"b.rib:1", "rgba"});
    refused("c.rib", "DisplayChannel \"float mine\"\n", {"c.rib", "no channel with an expression"});
    refused("d.toml", "[[channel]]\nname = \"a\"\nlpe = \"C(L\"\n", {"d.toml:3"});
    refused("e.usda",
            "#usda 1.0\ndef RenderVar \"a\"\n{\n    uniform string sourceName = \"C<\"\n    uniform token sourceType = "
            "\"lpe\"\n}\n",
            {"e.usda:4"});
    refused("f.txt", "neither of them\n", {"f.txt"});
    refused("g.rib",
            "DisplayChannel \"color a\" \"string source\" \"lpe:C<RD>L\"\nDisplayChannel \"color a\" \"string source\" "
            "\"lpe:C<RS>L\"\n",
            {"g.rib:2", "'a' is used twice"});
    const Outcome absent = run_raylex(folder, "render room.pbrt -o x.exr --channels absent.rib");
    CHECK(absent.code == 2);
    CHECK(absent.err.find("absent.rib") != std::string::npos);
    // A partition that does not hold ends the render, as in a job.
    folder.write("split.toml",
                 "[[channel]]\nname = \"a\"\nlpe = \"C<RD>L\"\n[[partition]]\nname = \"mine\"\nchannels = [\"a\"]\n");
    CHECK(run_raylex(folder, "render room.pbrt -o x.exr --channels split.toml").code == 1);
}

TEST_CASE("layers by technique are proved to sum, of beauty and of channels, from flags and job files", "[gate]") {
    const SceneFolder folder;
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[output]\nfile = \"job.exr\"\n[integrator]\ntype = \"bdpt\"\n"
                 "maxdepth = 9\n[channels]\ntechniques = \"pyramid:beauty,direct\"\n[[channel]]\nname = \"direct\"\n"
                 "lpe = \"C<RD>[<L.>O]\"\n");
    Outcome outcome = run_raylex(folder, "render job.toml");
    CAPTURE(outcome.out, outcome.err);
    REQUIRE(outcome.code == 0);
    auto image = read_exr(folder.path("job.exr"));
    REQUIRE(image);
    CHECK(image->attributes["partition/techniques"].find("beauty_s3t1 + ") != std::string::npos);
    CHECK(image->attributes["partition/techniques"].ends_with(" + beauty_beyond8"));
    CHECK(image->attributes["partition/techniques_direct"].starts_with("direct = direct_s0t2 + direct_s0t3"));
    CHECK(image->attributes["lpe/direct_s1t2_unweighted"] == "s1t2;unweighted;C<RD>[<L.>O]");
    const auto total = [&](const std::string& layer) {
        double sum = 0;
        for (const float value : plane(*image, layer, "G")) sum += static_cast<double>(value);
        return sum;
    };
    CHECK(total("beauty_s2t1") > 0);
    CHECK(total("direct_s1t2_unweighted") > total("direct_s1t2"));
    outcome = run_raylex(folder, "verify job.exr");
    CHECK(outcome.code == 0);
    CHECK(outcome.out.find("'techniques_direct'") != std::string::npos);

    // A method without light subpaths has fewer techniques; a small depth leaves no longer paths.
    outcome = run_raylex(folder, "render room.pbrt -o path.exr --max-depth 1 --techniques pyramid");
    REQUIRE(outcome.code == 0);
    image = read_exr(folder.path("path.exr"));
    REQUIRE(image);
    CHECK(image->attributes["partition/techniques"] ==
          "beauty = beauty_s0t2 + beauty_s0t3 + beauty_s1t2 + beauty_s2t1");
    CHECK(total("beauty_s2t1") == 0);

    // Paths inside a body can scatter any number of times, so there is always a layer of longer paths.
    folder.write("wax.pbrt",
                 "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\n"
                 "LookAt 0 1 4 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n"
                 "LightSource \"infinite\"\nMaterial \"subsurface\" \"rgb sigma_a\" [.01 .01 .01] "
                 "\"rgb sigma_s\" [2 2 2] \"float eta\" 1.4\nShape \"sphere\" \"float radius\" 1\n");
    outcome = run_raylex(folder, "render wax.pbrt -o wax.exr --spp 4 --max-depth 3 --techniques pyramid");
    CAPTURE(outcome.out, outcome.err);
    CHECK(outcome.code == 0);
    image = read_exr(folder.path("wax.exr"));
    REQUIRE(image);
    CHECK(image->attributes["partition/techniques"].ends_with(" + beauty_beyond8"));
    CHECK(total("beauty_beyond8") > 0);

    for (const auto& [flags, expected] :
         {std::pair{"--techniques tower", "expected pyramid"}, std::pair{"--techniques pyramid:,x", "expected names"},
          std::pair{"--techniques pyramid:x", "layers of 'x' by technique"},
          std::pair{"--techniques pyramid:x --dialect osl --lpe x=C.*L", "in the renderman dialect"},
          std::pair{"--techniques pyramid:x --lpe 'x=unoccluded;C.*'", "without prefixes"}}) {
        CAPTURE(flags);
        outcome = run_raylex(folder, std::string("render room.pbrt -o no.exr ") + flags);
        CAPTURE(outcome.err);
        CHECK(outcome.code == 2);
        CHECK(outcome.err.find(expected) != std::string::npos);
    }
}
