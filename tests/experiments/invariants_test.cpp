// The search for scenes that violate an invariant: it finds planted mistakes, and nothing in the code as it is.
#include <catch2/catch.hpp>

#include <algorithm>
#include <csignal>
#include <filesystem>

#include "experiments/invariants/search.h"
#include "experiments/support.h"
#include "tests/support/paths.h"
#include "transport/lights/light_table.h"

using namespace raylex;
using namespace raylex::experiments;
namespace fs = std::filesystem;

namespace {

/// Replaces the point light by a different one while it exists.
class PlantedLight {
  public:
    explicit PlantedLight(const std::function<void(transport::SceneLight&)>& mistake)
        : entry_(*transport::light_registry().find("point")) {
        auto planted = entry_;
        planted.factory = [mistake, right = entry_.factory](const transport::SceneLight& light,
                                                            transport::LightContext& context) {
            transport::SceneLight wrong = light;
            mistake(wrong);
            return right(wrong, context);
        };
        transport::light_registry().add(planted);
    }
    ~PlantedLight() { transport::light_registry().add(entry_); }
    PlantedLight(const PlantedLight&) = delete;
    PlantedLight& operator=(const PlantedLight&) = delete;

  private:
    Registry<transport::LightFactory>::Entry entry_;
};

SearchReport search(SearchOptions options, const test::Folder& folder) {
    options.folder = folder.path("found");
    auto report = search_scenes(options);
    if (!report) FAIL(report.error().to_string());
    return std::move(*report);
}

}  // namespace

TEST_CASE("scene search: every invariant holds for random scenes, or they are rejected",
          "[invariants][law1][law6][law7]") {
    const test::Folder folder;
    SearchOptions options;
    options.scenes = 250;
    options.means_every = 40;
    const SearchReport report = search(options, folder);
    for (const Finding& finding : report.findings)
        FAIL_CHECK("scene " << finding.scene << ", " << finding.invariant << ": " << finding.verdict.note << "\n"
                            << finding.text);
    // Most scenes must be valid, and every invariant must have been checked.
    CHECK(report.scenes == options.scenes);
    CHECK(report.refused < report.scenes / 3);
    for (const InvariantInfo& info : invariants()) {
        CAPTURE(std::string(info.name));
        if (info.name != "energy" && info.name != "integrator")
            CHECK(report.checked.count(std::string(info.name)) == 1);
    }
}

TEST_CASE("scene search: a planted mistake is found and shrunk", "[invariants]") {
    // The planted light ignores its factor: eight times the light does not give eight times the image.
    const PlantedLight planted([](transport::SceneLight& light) {
        std::erase_if(light.parameters.parameters, [](const Parameter& p) { return p.name == "scale"; });
    });
    const test::Folder folder;
    SearchOptions options;
    options.scenes = 200;
    options.most_findings = 1;
    options.check.only = {"unit-of-light"};
    const SearchReport report = search(options, folder);
    REQUIRE(report.findings.size() == 1);
    const Finding& finding = report.findings[0];
    CHECK(finding.invariant == "unit-of-light");
    INFO(finding.text);
    CHECK(finding.text.find("LightSource \"point\"") != std::string::npos);
    CHECK(finding.lines <= 8);  // a camera, a light, a shape and their transforms
    CHECK(finding.lines < finding.lines_before / 2);
    CHECK(fs::exists(finding.file));
    CHECK(command_of(finding).find("--only unit-of-light") != std::string::npos);
}

TEST_CASE("scene search: a crash is a finding", "[invariants]") {
    const PlantedLight planted([](transport::SceneLight&) { std::raise(SIGKILL); });
    const test::Folder folder;
    SearchOptions options;
    options.scenes = 100;
    options.most_findings = 1;
    options.check.only = {"finite"};
    const SearchReport report = search(options, folder);
    REQUIRE(report.findings.size() == 1);
    CHECK(report.findings[0].invariant == "death");
    CHECK(report.findings[0].verdict.note.find("SIGKILL") != std::string::npos);
    INFO(report.findings[0].text);
    CHECK(report.findings[0].lines <= 3);
}

TEST_CASE("scene search: earlier findings stay fixed", "[invariants][regression]") {
    const test::Folder folder;
    std::size_t scenes = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(test::source_dir()) / "tests/experiments/regressions")) {
        if (entry.path().extension() != ".pbrt") continue;
        ++scenes;
        const auto outcome = test::run_raylex(
            folder, "scene check --invariants --timeout 60 --mean-samples 16 '" + entry.path().string() + "'");
        INFO(entry.path() << "\n" << outcome.out << outcome.err);
        CHECK(outcome.code == 0);
    }
    CHECK(scenes >= 3);
}

TEST_CASE("raylex scene: write, check and search", "[invariants][cli]") {
    const test::SceneFolder folder;
    CHECK(test::run_raylex(folder, "scene write room.pbrt -o out.pbrt").code == 0);
    CHECK(test::run_shell(folder,
                          "$RAYLEX render room.pbrt -o a.exr && $RAYLEX render out.pbrt -o b.exr && "
                          "$RAYLEX compare a.exr b.exr")
              .code == 0);
    const auto checked = test::run_raylex(folder, "scene check --invariants --only split-sum --only threads out.pbrt");
    CHECK(checked.code == 0);
    CHECK(
        test::matches(checked.out, "invariant[^\n]*verdict *\nsplit-sum[^\n]*holds[^\n]*\nthreads[^\n]*holds[^\n]*\n"));
    CHECK(test::contains(test::run_raylex(folder, "scene check room.pbrt").out, "room.pbrt: "));
    const auto found = test::run_raylex(folder, "scene search --scenes 3 --seconds 0 --means-every 0 -o found");
    CHECK(found.code == 0);
    CHECK(test::contains(found.out, "3 scenes in "));
    const auto refused = test::run_raylex(folder, "scene check --invariants --only splitsum room.pbrt");
    CHECK(refused.code == 2);
    CHECK(test::contains(refused.err, "did you mean 'split-sum'?"));
    CHECK(test::run_raylex(folder, "scene write nothing.pbrt -o x.pbrt").code == 2);
}

TEST_CASE("scene check: a plugin's integrator with a mistake is found", "[invariants][plugin]") {
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
