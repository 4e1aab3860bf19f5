// A black image has a warning with the reason if light was requested.
#include "transport/image_file.h"
#include "transport/render_support.h"

using namespace render_test;

namespace {

std::vector<raylex::Error> warnings_of(const std::string& world, const transport::RenderSettings& settings = {}) {
    return render_of(scene_of("Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4\n"
                              "Sampler \"independent\" \"integer pixelsamples\" 1\nWorldBegin\n" +
                              world),
                     settings)
        .warnings;
}

}  // namespace

TEST_CASE("a scene without light, and lights that emit none, give warnings", "[render][lights]") {
    const std::string ball = "\nTranslate 0 0 4 Shape \"sphere\"\n";
    const auto none = warnings_of(ball);
    REQUIRE(none.size() == 1);
    CHECK(none[0].message == "the scene has no light: its image is black");
    for (const char* light :
         {"LightSource \"point\" \"blackbody I\" 3", "LightSource \"infinite\" \"rgb L\" [1e-40 1e-40 1e-40]",
          "LightSource \"distant\" \"spectrum L\" [400 0 700 0]", "LightSource \"infinite\" \"rgb L\" [0 0 0]",
          "AreaLightSource \"diffuse\" \"rgb L\" [0 0 0]"}) {
        CAPTURE(light);
        const auto warnings = warnings_of(light + ball);
        REQUIRE(warnings.size() == 1);
        CHECK(warnings[0].line == 4);
        CHECK(warnings[0].message.ends_with(" light emits no light"));
    }
    const auto several = warnings_of(
        "LightSource \"point\" \"rgb I\" [0 0 0]\nLightSource \"infinite\"\n"
        "LightSource \"point\" \"rgb I\" [0 0 0]\n" +
        ball);
    REQUIRE(several.size() == 1);
    CHECK(several[0].message == "this point light emits no light, and neither does one other light of the scene");
    CHECK(warnings_of("LightSource \"infinite\"" + ball).empty());
    CHECK(warnings_of("MakeNamedMedium \"fire\" \"string type\" \"homogeneous\" \"rgb Le\" [1 1 1]\n"
                      "MediumInterface \"fire\" \"\"\n" +
                      ball)
              .empty());
}

TEST_CASE("a render of AOVs only has no warnings about lights", "[render][geoaovs]") {
    const std::string ball = "Translate 0 0 4 Shape \"sphere\"\n";
    transport::RenderSettings settings;
    settings.channels.beauty = false;
    settings.channels.list = {aov("z")};
    CHECK(warnings_of(ball, settings).empty());
    CHECK(warnings_of("LightSource \"infinite\" \"rgb L\" [0 0 0]" + ball, settings).empty());
    settings.channels.list.push_back(lpe_channel("direct", "CDL"));
    CHECK(warnings_of(ball, settings).size() == 1);
}

TEST_CASE("lights with a black image and media that cannot emit are dark", "[render][lights][media]") {
    const std::string ball = "\nTranslate 0 0 4 Shape \"sphere\"\n";
    const ImageFile black(4, 4, std::vector<transport::Rgb>(16));
    const std::string file = black.parameter();
    for (const std::string& light : {"LightSource \"infinite\"" + file, "LightSource \"goniometric\"" + file,
                                     "LightSource \"projection\"" + file, "AreaLightSource \"diffuse\"" + file}) {
        CAPTURE(light);
        const auto warnings = warnings_of(light + ball);
        REQUIRE(warnings.size() == 1);
        CHECK(warnings[0].message.ends_with(" light emits no light"));
    }
    for (const char* medium :
         {"\"float density\" 1 \"float temperature\" 50",
          "\"float density\" 1 \"float temperature\" 2000 \"float temperaturescale\" .01",
          "\"float density\" 1 \"rgb Le\" [1 1 1] \"float Lescale\" 0", "\"float density\" 0 \"rgb Le\" [1 1 1]"}) {
        CAPTURE(medium);
        const auto warnings = warnings_of("MakeNamedMedium \"fire\" \"string type\" \"uniformgrid\" " +
                                          std::string(medium) + "\nMediumInterface \"fire\" \"\"" + ball);
        REQUIRE(warnings.size() == 1);
        CHECK(warnings[0].message == "the scene has no light: its image is black");
    }
}
