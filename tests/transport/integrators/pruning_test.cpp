// Nothing requested, nothing simulated (Law 4): what rays are saved, and that every channel keeps its mean.
#include "transport/replicates.h"

using namespace render_test;

namespace {

/// A floor in a corner, a ball of glass, a ball with a coat, lamps in two groups and a sky.
std::string corner(const std::string& more = {}) {
    return film + R"(
Integrator "path" "integer maxdepth" 6
LookAt 0 2 -6  0 0.7 0  0 1 0
Camera "perspective" "float fov" 45
WorldBegin
LightSource "infinite" "rgb L" [0.2 0.2 0.2]
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 -3  -3 0 3  3 0 3  3 0 -3]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 3  -3 4 3  3 4 3  3 0 3]
AttributeBegin
  Material "dielectric"
  Translate -1 0.7 0
  Shape "sphere" "float radius" 0.7
AttributeEnd
AttributeBegin
  Material "coateddiffuse" "float roughness" 0.2 "bool raylex:unbiased" true
  Translate 1 0.6 0
  Shape "sphere" "float radius" 0.6
AttributeEnd
Material "diffuse" "rgb reflectance" [0 0 0]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 8 8]
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 3.5 -1  -1 3.5 -1  -1 3.5 0  -2 3.5 0]
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [20 20 20]
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [1 3.5 -1  1.5 3.5 -1  1.5 3.5 -0.5  1 3.5 -0.5]
AttributeEnd
)" + more;
}

transport::SceneDescription grouped(transport::SceneDescription scene) {
    scene.area_lights.at(0).group = "key";
    scene.area_lights.at(1).group = "rim";
    return scene;
}

transport::SceneEntity named(const std::string& integrator) {
    transport::SceneEntity entity;
    entity.type = integrator;
    return entity;
}

transport::RenderSettings asking_for(const std::string& expression) {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.channels.beauty = false;
    settings.channels.list = {lpe_channel("asked", expression)};
    return settings;
}

/// Those methods whose paths begin at lights, too.
constexpr std::array from_lights{"bdpt", "lighttracer"};

/// Means of blocks of the image with and without pruning, by independent seeds.
void check_means(const std::string& scene, const std::string& expression,
                 const transport::SceneEntity& integrator = named("path")) {
    auto built = transport::BuiltScene::build(grouped(scene_of(scene)));
    REQUIRE(built.ok());
    transport::RenderSettings settings = asking_for(expression);
    settings.paths.integrator = integrator;
    constexpr int seeds = 12;
    const Replicates pruned = replicates(**built, settings, 1, seeds, 0);
    settings.paths.prune = false;
    const Replicates whole = replicates(**built, settings, 1, seeds, 1000);
    const Estimate a = pruned.channel(0), b = whole.channel(0);
    CAPTURE(integrator.type, expression, a.mean, a.error, b.mean, b.error);
    CHECK(b.mean > 0);
    // Of Student's t with at least 11 degrees of freedom, 6 is exceeded once in 10,000.
    CHECK(deviation(a, b) < 6);
}

}  // namespace

TEST_CASE("pruned channels keep their means", "[render][pruning][law4][statistical][gate]") {
    for (const char* expression :
         {"C<RD>L", "C<RD>[LB]", "C<RD>B", "C<RD>{2}L", "C<RD><.S>+L", "C<.S>+<RD>L", "C.*<L.'rim'>",
          "C<RD>.*<L.'key'>", "C<RS>.*", "C(<RD>|<RS>)<L.'rim'>", "C<TS>+[LB]", "C<RD><RD>B"})
        check_means(corner(), expression);
    check_means(corner("LightSource \"point\" \"point3 from\" [0 3 -2] \"rgb I\" [4 4 4]\n"), "C<RD>L");
    check_means(corner("Shape \"sphere\" \"float alpha\" 0.5 \"float radius\" 0.3\n"), "C<RD>L");
}

TEST_CASE("what no channel takes is not traced", "[render][pruning][law4]") {
    const auto statistics = [](const std::string& expression, bool prune = true) {
        transport::RenderSettings settings = asking_for(expression);
        settings.paths.integrator = path_with(flag_parameter("splits", false));  // as many paths as samples, to compare
        settings.paths.prune = prune;
        return render_of(grouped(scene_of(corner())), settings).statistics;
    };
    const auto whole = statistics("C<RD>L", false);
    CHECK(whole.scattering_rays > whole.camera_rays);
    // Nothing in the scene transmits diffusely: paths end where the camera's rays do.
    const auto nothing = statistics("C<TD>L");
    CHECK(nothing.scattering_rays == 0);
    CHECK(nothing.shadow_rays == 0);
    // One scattering, then a light: small lamps are left to light samples, most rays to find them are not traced.
    const auto direct = statistics("C<RD><L.'rim'>");
    CHECK(direct.scattering_rays * 4 < direct.shadow_rays);
    CHECK(direct.shadow_rays < whole.shadow_rays);
    // A light sample cannot pass glass: of this only words that end at the coat do with one.
    const auto caustic = statistics("C<RD><.S>+L");
    CHECK(caustic.shadow_rays * 20 < whole.shadow_rays);
    CHECK(statistics("C<RD><TS>+L").shadow_rays == 0);
    CHECK(caustic.scattering_rays < whole.scattering_rays);
    // The sky has nothing to aim at: only rays find it.
    CHECK(statistics("C<RD>B").shadow_rays == 0);
}

TEST_CASE("in a furnace rays find direct light without noise, and light samples are left out",
          "[render][pruning][law4]") {
    const auto scene = scene_of(film + R"(
Integrator "path" "integer maxdepth" 4
Camera "perspective" "float fov" 60
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 3 0 3 2 4 5 7 4 7 6 0 1 5 0 5 4 2 3 7 2 7 6 0 2 6 0 6 4 1 3 7 1 7 5]
  "point3 P" [-1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1  -1 -1 1  1 -1 1  -1 1 1  1 1 1]
)");
    const auto output = render_of(scene, asking_for("C<RD>L"));
    CHECK(output.statistics.shadow_rays == 0);
    for (const double value : output.frame_buffer.resolve(0)) REQUIRE(value == Approx(0.5).epsilon(1e-6));
}

TEST_CASE("a light group alone is sampled alone: less noise from as many samples", "[render][pruning][law4]") {
    auto built = transport::BuiltScene::build(grouped(scene_of(corner())));
    REQUIRE(built.ok());
    transport::RenderSettings settings = asking_for("C<RD><L.'key'>");
    const Replicates pruned = replicates(**built, settings, 1, 12, 0);
    settings.paths.prune = false;
    const Replicates whole = replicates(**built, settings, 1, 12, 0);
    // The lamp is chosen always instead of about half of the time; a ratio of variances of 9 x 11 degrees of freedom
    // is off by more than a factor of 1.6 once in 1,000.
    CHECK(pruned.sum_of_variances() * 1.6 < whole.sum_of_variances());
}

TEST_CASE("channels keep their means where paths begin at lights", "[render][pruning][law4][statistical][gate]") {
    for (const char* integrator : from_lights)
        for (const char* expression : {"C<RD>L", "C<RD><RD>B", "C<RD><.S>+L", "C.*<L.'rim'>", "C<RD>.*<L.'key'>"})
            check_means(corner(), expression, named(integrator));
    for (const char* expression : {"C<RD>{2}L", "C<TS>+[LB]", "C<RS>.*<L.'rim'>", "C<.S>+<RD>L"})
        check_means(corner(), expression, named("bdpt"));
    transport::SceneEntity chains = named("pssmlt");
    chains.parameters.parameters = {text_parameter("integrator", "bdpt"), number_parameter("chains", 20),
                                    number_parameter("bootstrapsamples", 2000)};
    check_means(corner(), "C<RD>{2}<L.'rim'>", chains);
    const std::string fog = R"(
AttributeBegin
  MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [0.4 0.4 0.4] "rgb sigma_a" [0.2 0.2 0.2]
  MediumInterface "fog" ""
  Material "interface"
  Translate 0 1.2 -2
  Shape "sphere" "float radius" 0.9
AttributeEnd
)";
    for (const char* integrator : from_lights) {
        check_means(corner("Shape \"sphere\" \"float alpha\" 0.5 \"float radius\" 0.3\n"), "C<RD>L", named(integrator));
        // Where no channel takes what a medium scatters, flights through it only lose light, at both ends.
        check_means(corner(fog), "C<RD>L", named(integrator));
        check_means(corner(fog), "CV+<RD>L", named(integrator));
    }
}

TEST_CASE("light paths that are left out change no bit of the others", "[render][pruning][law4]") {
    // Every light is live and there are no media, so that only rays and joins are left out.
    for (const char* integrator : from_lights)
        for (const char* expression : {"C<RD>L", "C<RD>{2}L", "C<RD><.S>+L", "C<TS>+L", "C<RD>(<RS>|<RD><TS>)L"}) {
            transport::RenderSettings settings = asking_for(expression);
            settings.paths.integrator = named(integrator);
            const auto scene = grouped(scene_of(corner()));
            const auto pruned = render_of(scene, settings);
            settings.paths.prune = false;
            const auto whole = render_of(scene, settings);
            CAPTURE(integrator, expression);
            CHECK(pruned.frame_buffer.resolve(0) == whole.frame_buffer.resolve(0));
            CHECK(pruned.statistics.scattering_rays < whole.statistics.scattering_rays);
        }
}

TEST_CASE("what no word joins is not traced from the lights", "[render][pruning][law4]") {
    const auto statistics = [](const char* integrator, const std::string& expression, bool prune = true) {
        transport::RenderSettings settings = asking_for(expression);
        settings.paths.integrator = named(integrator);
        settings.paths.prune = prune;
        return render_of(grouped(scene_of(corner())), settings).statistics;
    };
    const auto count = [](const auto& statistics, transport::Pruned cause) {
        return statistics.pruned[static_cast<std::size_t>(cause)];
    };
    for (const char* integrator : from_lights) {
        CAPTURE(integrator);
        // Nothing in the scene transmits diffusely, and no light is in this group.
        for (const char* dead : {"C<TD>L", "C.*<L.'nobody'>"}) {
            const auto nothing = statistics(integrator, dead);
            CHECK(nothing.scattering_rays == 0);
            CHECK(nothing.shadow_rays == 0);
        }
        const auto whole = statistics(integrator, "C<RD>L", false);
        for (const std::uint64_t each : whole.pruned) CHECK(each == 0);
        const auto caustic = statistics(integrator, "C<RD><TS>+L");
        CHECK(count(caustic, transport::Pruned::light_paths) > 0);
        CHECK(caustic.shadow_rays * 10 < whole.shadow_rays);
        // What the camera sees through glass alone, or behind glass by a light sample, no light subpath brings.
        for (const char* unmet : {"C<TS>+L", "C<TS>+<RD>L"}) {
            const auto of_camera = statistics(integrator, unmet);
            CAPTURE(unmet);
            CHECK(count(of_camera, transport::Pruned::light_paths) == of_camera.camera_samples);
        }
    }
    CHECK(statistics("bdpt", "C<TS>+L").shadow_rays == 0);
    CHECK(statistics("bdpt", "C<TS>+<RD>L").shadow_rays > 0);
    // A light path of one ray, and its vertex seen by the camera.
    const auto direct = statistics("lighttracer", "C<RD>L");
    CHECK(direct.scattering_rays <= direct.camera_samples);
    CHECK(direct.shadow_rays <= direct.camera_samples);
    // Of two scatterings one is the light path's, and only the camera's first vertex is joined with it.
    const auto second = statistics("bdpt", "C<RD>{2}L");
    CHECK(count(second, transport::Pruned::connections) > 0);
    CHECK(count(second, transport::Pruned::light_samples) > 0);  // none from the camera's first vertex
    CHECK(count(statistics("bdpt", "C<RD><.S>+L"), transport::Pruned::connections) > 0);
}

TEST_CASE("light paths begin at live lights alone: less noise from as many", "[render][pruning][law4]") {
    auto built = transport::BuiltScene::build(grouped(scene_of(corner())));
    REQUIRE(built.ok());
    for (const char* integrator : from_lights) {
        transport::RenderSettings settings = asking_for("C<RD>.*<L.'key'>");
        settings.paths.integrator = named(integrator);
        const Replicates pruned = replicates(**built, settings, 1, 12, 0);
        settings.paths.prune = false;
        const Replicates whole = replicates(**built, settings, 1, 12, 0);
        // As above.
        CAPTURE(integrator);
        CHECK(pruned.sum_of_variances() * 1.6 < whole.sum_of_variances());
    }
}
