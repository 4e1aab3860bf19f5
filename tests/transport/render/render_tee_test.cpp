// The tee pattern: the value that a material's texture passes through, in a channel of its own.
#include "transport/render_support.h"

using namespace render_test;

namespace {

/// A plane that fills the image, in the given material, after `textures`.
std::string plane(const std::string& textures, const std::string& material) {
    return R"(
Film "rgb" "integer xresolution" 8 "integer yresolution" 8
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "independent" "integer pixelsamples" 16
Integrator "path" "integer maxdepth" 3
LookAt 0 0 3  0 0 0  0 1 0
Camera "perspective" "float fov" 30
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
)" + textures +
           "\n" + material + R"(
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 -4 0 4 -4 0 4 4 0 -4 4 0] "point2 uv" [0 0 1 0 1 1 0 1]
)";
}

const std::string teed = R"(
Texture "board" "spectrum" "checkerboard" "float uscale" 8 "float vscale" 8 "rgb tex1" [.8 .4 .2] "rgb tex2" [.1 .2 .3]
Texture "paint" "spectrum" "tee" "texture input" "board" "string channel" "paint"
)";

}  // namespace

TEST_CASE("a tee writes its input, at first hits, and changes nothing else", "[render][tee]") {
    const std::string direct = plane(teed, "Material \"diffuse\" \"texture reflectance\" \"board\"");
    const std::string through = plane(teed, "Material \"diffuse\" \"texture reflectance\" \"paint\"");
    transport::RenderSettings settings;
    const auto plain = render_of(scene_of(direct), settings), unasked = render_of(scene_of(through), settings);
    settings.channels.list = {aov("paint"), aov("albedo"), lpe_channel("diffuse", "C<RD>.*")};
    settings.machine.threads = 2;
    const auto output = render_of(scene_of(through), settings);
    const std::vector<double> beauty = plain.frame_buffer.resolve(0);
    CHECK(unasked.frame_buffer.resolve(0) == beauty);  // Law 2; the value of a tee is its input
    CHECK(output.frame_buffer.resolve(0) == beauty);
    CHECK(output.frame_buffer.channels()[1].type == display::ChannelType::rgb);
    // A diffuse surface's albedo is its reflectance: the tee's own channel and the geometric AOV agree to the bit.
    CHECK(output.frame_buffer.resolve(1) == output.frame_buffer.resolve(2));
    double sum = 0;
    for (const double value : output.frame_buffer.resolve(1)) sum += value;
    CHECK(sum > 0.2 * 3 * 64);
    CHECK(output.statistics.refused_services_calls == 0);
    settings.channels.list = {aov("paint")};
    settings.channels.beauty = false;
    const auto alone = render_of(scene_of(through), settings);
    CHECK(alone.frame_buffer.resolve(0) == output.frame_buffer.resolve(1));
    CHECK(alone.statistics.shadow_rays + alone.statistics.scattering_rays == 0);  // Law 4
}

TEST_CASE("tees write wherever they are evaluated: branches, floats, mixes, several in a row", "[render][tee]") {
    transport::RenderSettings settings;
    settings.channels.list = {aov("left"), aov("right"), aov("whole"), aov("rough"), aov("never")};
    const auto output =
        render_of(scene_of(plane(R"(
Texture "l" "spectrum" "tee" "rgb input" [.25 .25 .25] "string channel" "left"
Texture "r" "spectrum" "tee" "rgb input" [.75 .75 .75] "string channel" "right"
Texture "n" "spectrum" "tee" "rgb input" [.5 .5 .5] "string channel" "never"
Texture "halves" "spectrum" "checkerboard" "float uscale" 2 "float vscale" 1 "texture tex1" "l" "texture tex2" "r"
Texture "mixed" "spectrum" "mix" "texture tex1" "halves" "texture tex2" "n" "float amount" 0
Texture "all" "spectrum" "tee" "texture input" "mixed" "string channel" "whole"
Texture "rough" "float" "tee" "float input" 0.375 "string channel" "rough"
MakeNamedMaterial "paint" "string type" "diffuse" "texture reflectance" "all"
MakeNamedMaterial "other" "string type" "conductor" "texture roughness" "rough"
)",
                                 "Material \"mix\" \"string materials\" [\"paint\" \"other\"] \"float amount\" 0.5")),
                  settings);
    CHECK(output.frame_buffer.channels()[4].type == display::ChannelType::real);
    const std::vector<double> left = output.frame_buffer.resolve(1), right = output.frame_buffer.resolve(2),
                              whole = output.frame_buffer.resolve(3), rough = output.frame_buffer.resolve(4);
    double painted = 0;
    for (std::size_t p = 0; p < 64; ++p) {
        const bool first = p % 8 < 4;
        CHECK((first ? left : right)[3 * p] == 0);  // the border between the tiles is the border between pixels
        const double value = first ? right[3 * p] / 0.75 : left[3 * p] / 0.25;
        CHECK(value >= 0);
        CHECK(whole[3 * p] == Approx(left[3 * p] + right[3 * p]));
        CHECK(rough[p] / 0.375 == Approx(1 - value));  // the mix chooses one of the two materials
        painted += value / 64;
    }
    CHECK(std::abs(painted - 0.5) <= 4.5 * std::sqrt(0.25 / (64 * 16)));  // binomial
    for (const double value : output.frame_buffer.resolve(5)) CHECK(value == 0);
}

TEST_CASE("invalid tees are errors at their position", "[render][tee][law7]") {
    struct Slip {
        const char *text, *message;
        int line;
    };
    const Slip slips[] = {
        {"Texture \"t\" \"spectrum\" \"tee\"", "names no channel", 10},
        {"Texture \"t\" \"spectrum\" \"tee\" \"string channel\" \"Nn\"", "one of raylex's own", 10},
        {"Texture \"t\" \"spectrum\" \"tee\" \"string channel\" \"beauty\"", "one of raylex's own", 10},
        {"Texture \"t\" \"spectrum\" \"tee\" \"string channel\" \"mine\"\nTexture \"u\" \"float\" \"tee\" \"string "
         "channel\" \"mine\"",
         "is a spectrum channel already", 11},
        {"Texture \"t\" \"spectrum\" \"teee\" \"string channel\" \"a\"", "unknown texture 'teee'", 10},
    };
    for (const Slip& slip : slips) {
        CAPTURE(slip.text);
        auto output = transport::render(scene_of(plane(slip.text, "Material \"diffuse\"")), {});
        REQUIRE_FALSE(output.ok());
        CAPTURE(output.error().message);
        CHECK(output.error().message.find(slip.message) != std::string::npos);
        CHECK(output.error().line == slip.line);
    }
    transport::RenderSettings settings;
    settings.channels.list = {aov("pant")};
    auto output = transport::render(scene_of(plane(teed, "Material \"diffuse\"")), settings);
    REQUIRE_FALSE(output.ok());
    CHECK(output.error().hint.find("'paint'") != std::string::npos);
    auto alphabet = transport::scene_alphabet(scene_of(plane(teed, "Material \"diffuse\"")));
    REQUIRE(alphabet.ok());
    REQUIRE(alphabet->pattern_channels.size() == 1);
    CHECK(alphabet->pattern_channels[0].name == "paint");
}
