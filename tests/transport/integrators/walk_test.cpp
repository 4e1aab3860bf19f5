// What the walk decides on the way and no image's mean shows: whom roulette ends, which rays are traced, which medium
// a ray flies through behind a border that scatters, what of a camera ray is recorded though no channel asks for it.
#include "transport/replicates.h"

using namespace render_test;

TEST_CASE("roulette ends no path of a throughput above 1, and does not weaken it", "[render][walk]") {
    // Walls that emit 1, scatter red diffusely and green as a mirror, both 0.7. Lobes are drawn by their mean
    // reflectance, half of the time each, so every reflection by the mirror multiplies green by 1.4: after two 1.96,
    // after three 2.74. The word CS^kL carries 0.7^k.
    const auto scene = scene_of(film + R"(
Integrator "path" "integer maxdepth" 4
LookAt 0 0 0.3  0 0 -1  0 1 0
Camera "perspective" "float fov" 60
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1]
Material "raylex:diffuse-mirror" "rgb diffuse" [0.7 0 0] "rgb specular" [0 0.7 0]
ReverseOrientation
Shape "sphere" "float radius" 2
)");
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("2", "CS{2}L"), lpe_channel("3", "CS{3}L"), lpe_channel("4", "CS{4}L")};
    const auto output = render_of(scene, settings);
    for (display::ChannelId id = 1; id <= 3; ++id) {
        const double expected = std::pow(0.7, id + 1), found_by = std::pow(0.5, id + 1);
        const Estimate e = estimate(output, id);
        CAPTURE(id, e.mean, e.error, expected);
        CHECK(std::abs(e.mean - expected) <= 4.5 * e.error + 1e-5 * expected);  // products of a few floats
        // A binomial's relative deviation over 24 x 24 x 64 paths, as found to a tenth: roulette adds nothing to it.
        CHECK(e.error <= 1.1 * expected * std::sqrt((1 / found_by - 1) / (24 * 24 * 64)));
    }
}

TEST_CASE("roulette takes the radiance scaling of glass for no loss: a glass ball in a furnace makes no noise",
          "[render][walk]") {
    // Clear glass under a sky of 1 shows 1 along every path. Inside, radiance is divided by eta^2 = 2.25 until it
    // leaves; roulette that took this for weakness would end paths there.
    const auto scene = scene_of(film + R"(
Integrator "path" "integer maxdepth" 200 "float rrthreshold" 1
LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" 20
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "dielectric" "float eta" 1.5
Shape "sphere" "float radius" 1
)");
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("inner", "C<TS><RS>+<TS>B")};
    const auto output = render_of(scene, settings);
    CHECK(estimate(output, 1).mean > 0.01);  // there are paths long enough for roulette
    // Each interface multiplies by floats whose product is 1 but for some ulp. Roulette may find 1 - 1e-7 too weak and
    // end one path in 10^7, which the 37,000 here would show once in 300 seeds.
    for (const double value : output.frame_buffer.resolve(0)) CHECK(value == Approx(1).epsilon(1e-5));
}

TEST_CASE("roulette is played below rrthreshold, from the second bounce on", "[render][walk]") {
    // Walls of 0.5 leave 0.5^k, and what survives below a threshold goes on with it: half of it at every bounce.
    struct {
        const char* threshold;
        double rays;  // 1 of the first bounce, then the shares that go on
    } const of[] = {{"\"float rrthreshold\" 1", 1 + 0.25 * 2},
                    {"\"float rrthreshold\" 0.5", 1 + 0.5 * 2},
                    {"\"float rrthreshold\" 0.25", 1 + 1 + 0.5 * 2},
                    {"", 1 + 1 + 0.5 * 2}};
    for (const auto& [threshold, rays] : of) {
        CAPTURE(threshold);
        transport::RenderSettings settings;
        settings.samples.per_pixel = 16;
        const auto output = render_of(scene_of(film + R"(
Integrator "path" "integer maxdepth" 60 )" + threshold +
                                               R"(
LookAt 0 0 0.3  0 0 -1  0 1 0
Camera "perspective" "float fov" 60
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
ReverseOrientation
Shape "sphere" "float radius" 2
)"),
                                      settings);
        constexpr double paths = 24 * 24 * 16;
        // Bounces after the first are geometric numbers of 1/2 but for some that never begin: a variance of at most 2
        // + 1, five deviations.
        CHECK(double(output.statistics.scattering_rays) / paths == Approx(rays).margin(5 * std::sqrt(3 / paths)));
        const Estimate e = estimate(output);
        CHECK(std::abs(e.mean - 2) <= 4.5 * e.error + 1e-5);  // 1 / (1 - 0.5); some tens of roundings
    }
}

TEST_CASE("roulette on light paths compares with the strongest colour of the light", "[lighttracer][render][walk]") {
    // Grey walls weaken red light as they weaken white light: the same paths end.
    const auto rays =
        [](const std::string& light) {
            transport::RenderSettings settings;
            settings.samples.per_pixel = 4;
            settings.paths.integrator = integrator_named("lighttracer");
            const auto output = render_of(scene_of(film + R"(
Integrator "path" "integer maxdepth" 20
LookAt 0 0 0.3  0 0 -1  0 1 0
Camera "perspective" "float fov" 60
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [)" + light + R"(]
  Shape "sphere" "float radius" 0.2
AttributeEnd
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "sphere" "float radius" 2
)"),
                                          settings);
            return output.statistics.scattering_rays;
        };
    const std::uint64_t white = rays("1 1 1"), unended = 24 * 24 * 4 * 20;
    CHECK(rays("1 0 0") == white);
    CHECK(rays("0.25 1 0.5") == white);
    CHECK(2 * white < unended);
}

TEST_CASE("behind a border that scatters lies its own medium, for eyes and for light", "[render][media][walk]") {
    // A slab of dye, 1 thick, between index-matched sheets.
    const auto scene = [](const std::string& sigma_a, const std::string& camera, const std::string& world) {
        return scene_of(R"(
Film "rgb" "integer xresolution" 4 "integer yresolution" 4
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "independent" "integer pixelsamples" 256
MakeNamedMedium "dye" "string type" "homogeneous" "rgb sigma_s" [0 0 0] "rgb sigma_a" )" +
                        sigma_a + camera + R"(
WorldBegin
)" + world + R"(
AttributeBegin
  Material "raylex:sheet" "rgb transmittance" [1 1 1]
  MediumInterface "" "dye"
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 -2 0 2 -2 0 2 2 0 -2 2 0]
  MediumInterface "dye" ""
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 -2 1 2 -2 1 2 2 1 -2 2 1]
AttributeEnd
)");
    };
    const double passed[] = {std::exp(-0.5), std::exp(-1.0), std::exp(-2.0)};
    // Seen along its normal from 100 away in a view of 0.1 degrees, so that a ray's crossing is 1 to within
    // 1 - cos = 1e-6; it is a difference of floats of about 100, whose ulp is 8e-6.
    transport::RenderSettings settings;
    settings.paths.integrator = path_with(flag_parameter("roulette", false));
    const auto seen = render_of(scene("[0.5 1 2]", R"(
LookAt 0 0 100  0 0 0  0 1 0
Camera "perspective" "float fov" 0.1)",
                                      R"(LightSource "infinite" "rgb L" [1 1 1])"),
                                settings);
    const std::vector<double> values = seen.frame_buffer.resolve(0);
    for (std::size_t i = 0; i < values.size(); ++i) CHECK(values[i] == Approx(passed[i % 3]).epsilon(4e-5));

    // Parallel light through it onto a board, which the camera sees from in between. Sheets stop shadow rays: light
    // paths alone find it. With and without dye they are the same but for what the dye takes, without roulette.
    settings.paths.integrator->type = "lighttracer";
    const auto lit = [&](const std::string& sigma_a) {
        const auto output =
            render_of(scene(sigma_a, R"(
LookAt 1 0 -0.5  0 0 -2  0 1 0
Camera "perspective" "float fov" 20)",
                            R"(LightSource "distant" "rgb L" [1 1 1] "point3 from" [0 0 1] "point3 to" [0 0 0]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 -2 -2 2 -2 -2 2 2 -2 -2 2 -2])"),
                      settings);
        std::array<double, 3> sum{};
        const std::vector<double> image = output.frame_buffer.resolve(0);
        for (std::size_t i = 0; i < image.size(); ++i) sum[i % 3] += image[i];
        return sum;
    };
    const std::array<double, 3> clear = lit("[0 0 0]"), dyed = lit("[0.5 1 2]");
    for (std::size_t c = 0; c < 3; ++c) {
        REQUIRE(clear[c] > 0);
        CHECK(dyed[c] / clear[c] == Approx(passed[c]).epsilon(2e-6));  // a flight of 1 between floats below 4
    }
}

TEST_CASE("what fog does to camera rays is recorded though no channel asks for its light", "[render][media][law4]") {
    const auto scene = [](bool fog) {
        return scene_of(film + R"(
Integrator "path" "integer maxdepth" 1
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [0.2 0.2 0.2] "rgb sigma_s" [0.3 0.3 0.3]
)" + (fog ? "MediumInterface \"\" \"fog\"" : "") +
                        R"(
LookAt 0 0 2  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "point" "rgb I" [4 4 4] "point3 from" [1 1 1]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 -3 0 3 -3 0 3 3 0 -3 3 0]
)");
    };
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("surface", "C<RD>L"), aov("z")};
    const auto full = render_of(scene(true), settings);
    settings.channels.beauty = false;
    const auto pruned = render_of(scene(true), settings), clear = render_of(scene(false), settings);
    CHECK(pruned.frame_buffer.resolve(0) == full.frame_buffer.resolve(1));
    CHECK(pruned.frame_buffer.resolve(1) == full.frame_buffer.resolve(2));
    CHECK(pruned.frame_buffer.resolve_alpha() == full.frame_buffer.resolve_alpha());
    // The fog is in the way of what is recorded: camera rays of 2 to 2.2 end in it by 1 - exp(-1) at least.
    const std::vector<double> near = pruned.frame_buffer.resolve(1), far = clear.frame_buffer.resolve(1);
    double sum_near = 0, sum_far = 0;
    for (const double each : near) sum_near += each;
    for (const double each : far) sum_far += each;
    CHECK(sum_near < 0.9 * sum_far);
}

TEST_CASE("light that a surface blocks is not followed through media", "[render][media][law4]") {
    // A lamp sealed in a metal ball over a floor in fog that only absorbs: one shadow ray for each camera ray.
    const auto output = render_of(scene_of(film + R"(
Integrator "path" "integer maxdepth" 1
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [0.2 0.2 0.2] "rgb sigma_s" [0 0 0]
MediumInterface "" "fog"
LookAt 0 2 4  0 0 0  0 1 0
Camera "perspective" "float fov" 20
WorldBegin
LightSource "point" "rgb I" [1 1 1] "point3 from" [0 3 0]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 0 9 9 0 9 9 0 -9 -9 0 -9]
AttributeBegin
  Translate 0 3 0
  Material "conductor"
  Shape "sphere" "float radius" 0.5
AttributeEnd
# A border across the way, so that a shadow ray that is followed is traced once more.
AttributeBegin
  MediumInterface "fog" "fog"
  Material "interface"
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 0.01 9 9 0.01 9 9 0.01 -9 -9 0.01 -9]
AttributeEnd
)"));
    for (const double value : output.frame_buffer.resolve(0)) CHECK(value == 0);
    CHECK(output.statistics.camera_samples == 24 * 24 * 64);
    CHECK(output.statistics.shadow_rays == output.statistics.camera_samples);
}
