// Where pruning by what a pilot meets, by tables that are too wide or by rates that show would go wrong (Law 4).
#include "transport/render_support.h"

using namespace render_test;

namespace {

const std::string view = R"(
LookAt 0 4 -6  0 0 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
)";
const std::string lamp_ball = R"(
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 8 8]
  Translate 0 3 1
  Shape "sphere" "float radius" 0.3
AttributeEnd
)";
const std::string floor_of_grey = R"(
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 -3  -3 0 3  3 0 3  3 0 -3]
)";

transport::RenderOutput render_alone(const transport::SceneDescription& scene, const std::string& expression,
                                     bool prune, const std::string& integrator = "path") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.channels.beauty = false;
    settings.paths.prune = prune;
    settings.channels.list = {lpe_channel("asked", expression)};
    settings.paths.integrator.emplace().type = integrator;
    return render_of(scene, settings);
}

}  // namespace

TEST_CASE("a spot that a pilot's rays do not meet keeps its light samples", "[render][pruning][law4]") {
    // Its cone lights a 27,000th of what the camera sees: in the pilot's 8,192 paths most likely nothing, in 442,368
    // samples about 16.
    const std::string spot =
        "LightSource \"spot\" \"point3 from\" [1 3 1] \"point3 to\" [1 0 1] \"float coneangle\" 0.5 "
        "\"rgb I\" [400000 400000 400000]\n";
    const auto mean_with = [&](const std::string& light, bool prune) {
        transport::RenderSettings settings;
        settings.samples.per_pixel = 64;
        settings.film.resolution = {96, 72};
        settings.channels.beauty = false;
        settings.paths.prune = prune;
        settings.channels.list = {lpe_channel("asked", "C<RD>[LB]")};
        const auto output =
            render_of(scene_of(film + view + "LightSource \"infinite\"\n" + light + floor_of_grey), settings);
        if (prune && !light.empty()) CHECK(output.statistics.shadow_rays > 0);
        return estimate(output, 0).mean;
    };
    const double sky = mean_with("", false), whole = mean_with(spot, false), pruned = mean_with(spot, true);
    CAPTURE(sky, whole, pruned);
    REQUIRE(whole > 1.2 * sky);  // or there is nothing to lose
    // 16 hits are known to 25 %, and so is their half of the light: below a third of it would be four standard errors.
    CHECK(pruned - sky > (whole - sky) / 3);
}

TEST_CASE("channels that take light without throughput are not pruned", "[render][pruning][law4]") {
    const std::string lamps = R"(
LightSource "point" "point3 from" [1 3 0] "rgb I" [4 4 4]
LightSource "point" "point3 from" [-1 3 0] "rgb I" [4 4 4]
)" + lamp_ball + R"(
AttributeBegin
  Material "coateddiffuse"
  Translate 0 0.6 0
  Shape "sphere" "float radius" 0.6
AttributeEnd
)";
    auto scene = scene_of(film + view + lamps + floor_of_grey);
    scene.area_lights.at(0).group = "key";
    for (const char* expression : {"nothruput;C<RD>L", "nothruput;C<RD><L.'key'>", "nothruput;C<RD><RD>L"}) {
        CAPTURE(expression);
        // How often a path is sampled is what such a channel shows: the same bits.
        for (const char* integrator : {"path", "bdpt"})
            CHECK(render_alone(scene, expression, true, integrator).frame_buffer.resolve(0) ==
                  render_alone(scene, expression, false, integrator).frame_buffer.resolve(0));
    }
}

TEST_CASE("what no object, no medium and no light of the scene gives is not looked for", "[render][pruning][law4]") {
    // A leaf and a cloud that nothing is made of, and a mirror that has no diffuse lobe.
    const std::string rest = R"(
LightSource "point" "point3 from" [0 3 0] "rgb I" [4 4 4]
MakeNamedMedium "cloud" "string type" "homogeneous"
MakeNamedMaterial "leaf" "string type" "diffusetransmission"
MakeNamedMaterial "mirror" "string type" "conductor" "float roughness" 0
AttributeBegin
  NamedMaterial "mirror"
  Translate 0 0.6 0
  Shape "sphere" "float radius" 0.6
AttributeEnd
)";
    const auto scene = scene_of(film + view + rest + floor_of_grey);
    CHECK(render_alone(scene, "C<RD>.*L", true).statistics.scattering_rays > 0);
    for (const char* nothing : {"C.*<TD>L", "C.*V.*L", "C.*O", "C.*<RD'mirror'>L", "C.*<TD>.*L"})
        for (const char* integrator : {"path", "bdpt", "lighttracer"}) {
            CAPTURE(nothing, integrator);
            const auto statistics = render_alone(scene, nothing, true, integrator).statistics;
            CHECK(statistics.scattering_rays == 0);
            CHECK(statistics.shadow_rays == 0);
            if (std::string(integrator) != "path")
                CHECK(statistics.pruned[static_cast<std::size_t>(transport::Pruned::light_paths)] > 0);
        }
    // Beside a channel that finds something such a channel costs nothing.
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    settings.channels.beauty = false;
    settings.channels.list = {lpe_channel("asked", "C<RD>L")};
    const auto alone = render_of(scene, settings).statistics;
    settings.channels.list.push_back(lpe_channel("nothing", "C.*O"));
    const auto both = render_of(scene, settings).statistics;
    CHECK(both.scattering_rays == alone.scattering_rays);
    CHECK(both.shadow_rays == alone.shadow_rays);
}

TEST_CASE("an effect that is forced on changes no choice of a pilot", "[render][pruning][effects]") {
    const std::string glass = lamp_ball + R"(
AttributeBegin
  Material "dielectric"
  Translate 0 0.7 0
  Shape "sphere" "float radius" 0.6
AttributeEnd
)";
    auto scene = scene_of(film + view + glass + floor_of_grey);
    for (const char* expression : {"C.*L", "C<TS>+.*L", "C<RD>S+L"}) {
        CAPTURE(expression);
        auto forced = scene;
        for (const auto effect : {transport::Effect::alpha, transport::Effect::media, transport::Effect::motion})
            forced.general_code.insert(effect);
        const auto a = render_alone(scene, expression, true), b = render_alone(forced, expression, true);
        CHECK(a.frame_buffer.resolve(0) == b.frame_buffer.resolve(0));
        CHECK(a.statistics.branches == b.statistics.branches);
    }
}

TEST_CASE("last vertices use the better technique beside cutouts and in fog, too", "[render][pruning][law4]") {
    const std::string cutout = R"(
AttributeBegin
  Translate 1.5 0.5 0
  Shape "sphere" "float radius" 0.4 "float alpha" 0.5
AttributeEnd
)";
    const std::string fog = R"(
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [0.2 0.2 0.2] "rgb sigma_a" [0.1 0.1 0.1]
AttributeBegin
  MediumInterface "fog" ""
  Material "interface"
  Translate 0 1 0
  Shape "sphere" "float radius" 0.9
AttributeEnd
)";
    for (const std::string& more : {std::string(), cutout, fog, cutout + fog}) {
        CAPTURE(more);
        const auto scene = scene_of(film + view + lamp_ball + floor_of_grey + more);
        const auto pruned = render_alone(scene, "C<RD>L", true);
        // Rays find the lamp, which fills a hundredth of the sky, as an exception.
        CHECK(pruned.statistics.pruned[static_cast<std::size_t>(transport::Pruned::rays_left_to_light_samples)] >
              pruned.statistics.camera_rays / 3);
        const Estimate a = estimate(pruned, 0), b = estimate(render_alone(scene, "C<RD>L", false), 0);
        CAPTURE(a.mean, a.error, b.mean, b.error);
        CHECK(b.mean > 0);
        CHECK(deviation(a, b) < 5);  // once in 1.7 million; a sequence errs less than its samples would
    }
    // Beside a channel of what fog scatters its vertices are last ones too, which the pilot does not look at.
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    settings.channels.beauty = false;
    settings.channels.list = {lpe_channel("asked", "C<RD>L"), lpe_channel("fog", "CVL")};
    const auto both = render_of(scene_of(film + view + lamp_ball + floor_of_grey + fog), settings).statistics;
    CHECK(both.pruned[static_cast<std::size_t>(transport::Pruned::rays_left_to_light_samples)] == 0);
}
