// `raylex scene`: invariants hold on scenes that once violated one; the commands write and check scenes.
#include <catch2/catch.hpp>

#include <filesystem>

#include "experiments/support.h"
#include "tests/support/paths.h"

using namespace raylex;
namespace fs = std::filesystem;

TEST_CASE("invariants hold on scenes that once violated one", "[invariants][regression][gate]") {
    const test::Folder folder;
    std::size_t scenes = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(test::source_dir()) / "tests/experiments/regressions")) {
        if (entry.path().extension() != ".pbrt") continue;
        ++scenes;
        // A hang ends after five minutes. A scene takes 16 s with sanitizers, and many times that on a busy machine.
        const auto outcome = test::run_raylex(
            folder, "scene check --invariants --timeout 300 --mean-samples 16 '" + entry.path().string() + "'");
        INFO(entry.path() << "\n" << outcome.out << outcome.err);
        CHECK(outcome.code == 0);
    }
    CHECK(scenes >= 3);
}

TEST_CASE("raylex scene: write and check", "[invariants][cli]") {
    const test::SceneFolder folder;
    CHECK(test::run_raylex(folder, "scene write room.pbrt -o out.pbrt").code == 0);
    CHECK(test::run_shell(folder,
                          "\"$RAYLEX\" render room.pbrt -o a.exr && \"$RAYLEX\" render out.pbrt -o b.exr && "
                          "\"$RAYLEX\" compare a.exr b.exr")
              .code == 0);
    const auto checked = test::run_raylex(folder, "scene check --invariants --only split-sum --only threads out.pbrt");
    CHECK(checked.code == 0);
    CHECK(
        test::matches(checked.out, "invariant[^\n]*verdict *\nsplit-sum[^\n]*holds[^\n]*\nthreads[^\n]*holds[^\n]*\n"));
    CHECK(test::contains(test::run_raylex(folder, "scene check room.pbrt").out, "room.pbrt: "));
    const auto refused = test::run_raylex(folder, "scene check --invariants --only splitsum room.pbrt");
    CHECK(refused.code == 2);
    CHECK(test::contains(refused.err, "did you mean 'split-sum'?"));
    CHECK(test::run_raylex(folder, "scene write nothing.pbrt -o x.pbrt").code == 2);
}

TEST_CASE("scene check: a plugin's integrator with a mistake is found", "[invariants][plugin][gate]") {
    // Paths with three or more scattering events are too dark by a quarter: the last third of "C<RD>{1,3}[LO]".
    const test::Folder folder;
    const auto check = [&](const std::string& parameters) {
        folder.write("box.pbrt",
                     "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4\n"
                     "Integrator \"plantederror\"" +
                         parameters +
                         "\nCamera \"perspective\"\nWorldBegin\n"
                         "AreaLightSource \"diffuse\" \"bool twosided\" true\n"
                         "Material \"diffuse\" \"rgb reflectance\" [0.7 0.7 0.7]\nShape \"sphere\"\n");
        return test::run_raylex(folder, "scene check --invariants --only integrator --plugin planted_error box.pbrt");
    };
    const auto wrong = check(""), right = check(" \"bool mistake\" false");
    INFO(wrong.out << wrong.err << right.out << right.err);
    CHECK(wrong.code == 1);
    CHECK(test::contains(wrong.out, "VIOLATED"));
    CHECK(right.code == 0);
    CHECK(test::contains(right.out, "holds"));
}

TEST_CASE("scene check: grids, bodies, heights and glass that disperses follow units of length and light",
          "[invariants][media][materials]") {
    const test::Folder folder;
    const std::string view =
        "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4\nLookAt 0 0 -4 0 0 0 0 1 0\n"
        "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n";
    const auto grid = [&](const std::string& emission) {
        return view +
               "MakeNamedMedium \"smoke\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 1 "
               "\"integer nz\" 1 \"float density\" [.5 1] \"point3 p0\" [-1 -1 -1] \"point3 p1\" [1 1 1] " +
               emission +
               "\nMediumInterface \"smoke\" \"\"\nMaterial \"interface\"\nShape \"sphere\" \"float radius\" 1.8\n";
    };
    struct Case {
        const char* name;
        std::string scene;
    };
    const std::string ball = "Shape \"sphere\"\n";
    for (const Case& each :
         {Case{"plain grid", grid("")}, Case{"Le", grid("\"rgb Le\" [1 2 3]")},
          Case{"Le and Lescale", grid("\"rgb Le\" [1 2 3] \"float Lescale\" [1 2]")},
          Case{"temperature", grid("\"float temperature\" [1500 2500]")},
          Case{"subsurface", view + "Material \"subsurface\"\n" + ball},
          Case{"subsurface of coefficients",
               view + "Material \"subsurface\" \"rgb sigma_a\" [.1 .2 .3] \"rgb sigma_s\" [2 2 2]\n" + ball},
          Case{"subsurface of mean free paths",
               view + "Material \"subsurface\" \"rgb reflectance\" [.5 .6 .7] \"rgb mfp\" [.2 .3 .4]\n" + ball},
          Case{
              "heights",
              view +
                  "Texture \"waves\" \"float\" \"checkerboard\" \"float uscale\" 8 \"float tex1\" .1 \"float tex2\" 0\n"
                  "Material \"diffuse\" \"texture displacement\" \"waves\"\n" +
                  ball},
          Case{"dispersion", view + "Material \"dielectric\" \"spectrum eta\" \"glass-F11\"\n" + ball}}) {
        folder.write("scene.pbrt", each.scene);
        const auto outcome = test::run_raylex(
            folder,
            "scene check --invariants --only unit-of-length --only unit-of-light --only non-negative scene.pbrt");
        INFO(each.name << "\n" << outcome.out << outcome.err);
        CHECK(outcome.code == 0);
        CHECK(test::contains(outcome.out, "unit-of-length"));
        CHECK(test::all_matches(outcome.out, "unit-of-length[^\n]*holds").size() == 1);
        CHECK_FALSE(test::contains(outcome.out, "refused"));
    }
}
