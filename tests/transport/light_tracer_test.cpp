// The light tracer against the path tracer, word by word, and the laws.
#include "transport/interrupted_render.h"
#include "transport/replicates.h"

using namespace render_test;

namespace {

const std::string plain_film = R"(
Film "rgb" "integer xresolution" 18 "integer yresolution" 18
Sampler "independent" "integer pixelsamples" 64
)";

}  // namespace

TEST_CASE("the light tracer finds the path tracer's image, word by word", "[lighttracer][render][statistical]") {
    // Rough and smooth conductors, glass, a coat, an area light, a sky and a spot light.
    transport::RenderSettings settings;
    settings.max_depth = 4;
    settings.samples_per_pixel = 256;
    settings.resolution = {{18, 18}};
    compare_with_path(room, settings, integrator_named("lighttracer"), 12, 256,
            {"C<.[DG]>L", "C<.[DG]>B", "CL", "C<RD><.S>+L", "C<RD><RD>+[LB]", "C<RG>.*L", "C<RD><.G>.*[LB]"});
}

TEST_CASE("the light tracer through lenses and cutouts, with shading normals and every kind of light",
          "[lighttracer][render][statistical]") {
    // A mirror ball's caustic of the sky (the path tracer finds none of lights that no ray can hit); coarse meshes
    // shaded smoothly, whose shading and geometric normals differ by up to 55 degrees; rough glass, whose scattering is
    // not symmetric; a cutout between camera and floor; a wide lens focused on the floor; a filter with negative lobes
    // that reaches over the image's border.
    transport::RenderSettings settings;
    settings.max_depth = 3;
    settings.samples_per_pixel = 256;
    const std::string octahedron = R"(
Shape "trianglemesh" "integer indices" [4 0 2 4 2 1 4 1 3 4 3 0 5 2 0 5 1 2 5 3 1 5 0 3]
    "point3 P" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1] "normal N" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1]
)";
    compare_with_path(
        plain_film + R"(
PixelFilter "mitchell"
LookAt 0 1.6 4  0 0.4 0  0 1 0
Camera "perspective" "float fov" 45 "float lensradius" 0.15 "float focaldistance" 4.2
WorldBegin
LightSource "point" "rgb I" [3 3 3] "point3 from" [-1.5 2.5 1]
LightSource "distant" "rgb L" [1 1 1] "point3 from" [1 2 1] "point3 to" [0 0 0]
LightSource "infinite" "rgb L" [0.3 0.3 0.3]
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 4 4 0 4 4 0 -4 -4 0 -4]
AttributeBegin Material "raylex:mirror" Translate 0.9 0.4 0.5 Shape "sphere" "float radius" 0.4 AttributeEnd
AttributeBegin Translate -0.8 0.6 -0.3 Scale 0.6 0.6 0.6 )" +
            octahedron + R"( AttributeEnd
AttributeBegin Material "conductor" "float roughness" 0.4 Translate 0.5 0.5 -1 Scale 0.5 0.5 0.5 )" +
            octahedron + R"( AttributeEnd
AttributeBegin Material "dielectric" "float roughness" 0.4 Translate -0.2 0.5 0.6 Shape "sphere" "float radius" 0.3 AttributeEnd
AttributeBegin Translate 0 0.5 1.4 Material "diffuse" "rgb reflectance" [0.2 0.4 0.8]
  Shape "disk" "float radius" 0.5 "float alpha" 0.4 AttributeEnd
AttributeBegin AreaLightSource "diffuse" "rgb L" [6 6 6] "bool twosided" true Translate 0 2 -1 Rotate 60 1 0 0
  Shape "disk" "float radius" 0.4 AttributeEnd
)",
        settings, integrator_named("lighttracer"), 12, 384,
        {"C<RD>[LB]", "C<Ts><RD>[LB]", "C<RD><RS>+B", "C<RG>[LB]", "C<RD><.G>+[LB]", "C<RD><RD>[LB]", "C<Ts>*[LB]"});
}

TEST_CASE("light tracing keeps the laws: splits sum, asking changes nothing, threads and interruptions neither",
          "[lighttracer][render][law1][law2][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples_per_pixel = 20;
    settings.integrator = integrator_named("lighttracer");
    transport::SceneEntity filter;
    filter.type = "mitchell";
    settings.filter = filter;
    for (const bool splat : {false, true}) {
        CAPTURE(splat);
        settings.splat = splat;
        settings.channels.clear();
        settings.threads = 3;
        const auto alone = render_of(scene, settings);
        settings.channels = {osl("direct", "C<RD>L"), osl("caustic", "C<RD><.S>+L"), osl("seen", "C[LB]"),
                             osl("rest", "")};
        settings.channels[3].rest_of = {0, 1, 2};
        const auto three = render_of(scene, settings);
        settings.threads = 1;
        const auto one = render_of(scene, settings);
        const auto side = static_cast<std::uint64_t>(24 + (splat ? 4 : 0));
        CHECK(one.frame_buffer.light_path_count() == side * side * 20);
        for (display::ChannelId id = 0; id < 5; ++id)
            CHECK(one.frame_buffer.resolve(id) == three.frame_buffer.resolve(id));
        CHECK(one.frame_buffer.resolve(0) == alone.frame_buffer.resolve(0));
        CHECK(one.frame_buffer.resolve_alpha() == alone.frame_buffer.resolve_alpha());
        std::array<std::vector<double>, 5> layers;
        for (std::size_t id = 0; id < 5; ++id)
            layers[id] = one.frame_buffer.resolve(static_cast<display::ChannelId>(id));
        std::array<double, 5> light{};
        for (std::size_t i = 0; i < layers[0].size(); ++i) {
            double sum = 0, magnitude = std::abs(layers[0][i]);
            for (std::size_t id = 0; id < 5; ++id) {
                light[id] += std::abs(layers[id][i]);
                if (id == 0) continue;
                sum += layers[id][i];
                magnitude += std::abs(layers[id][i]);
            }
            CHECK(std::abs(sum - layers[0][i]) <= 1e-12 * magnitude);
        }
        for (const double each : light) CHECK(each > 0);

        // Stopped after half the samples, saved, and gone on with.
        const ScratchFile file;
        settings.checkpoint = transport::CheckpointSettings{file.path(), 60, false, {}};
        settings.threads = 2;
        settings.integrator = counted("lighttracer");
        std::atomic<bool> stop{false};
        interruption().begin(side * side * 10, &stop);
        const auto first = transport::render(scene, settings, {}, &stop);
        interruption().begin(0, nullptr);
        REQUIRE(first.ok());
        REQUIRE_FALSE(first->complete);
        settings.checkpoint->resume = true;
        const auto resumed = render_of(scene, settings);
        CHECK(resumed.frame_buffer.light_path_count() == one.frame_buffer.light_path_count());
        for (display::ChannelId id = 0; id < 5; ++id)
            CHECK(one.frame_buffer.resolve(id) == resumed.frame_buffer.resolve(id));
        settings.integrator = integrator_named("lighttracer");
        settings.checkpoint.reset();
    }
}

TEST_CASE("what the light tracer cannot do is refused or said", "[lighttracer][render][law7]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples_per_pixel = 1;
    settings.integrator = integrator_named("lighttracer");
    const auto said = render_of(scene, settings);
    REQUIRE(said.warnings.size() == 1);
    CHECK(said.warnings[0].message.find("first scattering is singular") != std::string::npos);
    const auto error = [&] {
        const auto output = transport::render(scene, settings);
        return output.ok() ? std::string() : output.error().to_string();
    };
    settings.statistics = {*display::parse_statistic_request("beauty", "mse", {"job.toml", 3, 1})};
    CHECK(error().find("job.toml:3:1") != std::string::npos);
    CHECK(error().find("'lighttracer'") != std::string::npos);
    settings.statistics.clear();
    settings.channels = {lpe_channel("a", "CDL")};  // moments that nobody asks a layer of are just not kept
    CHECK(render_of(scene, settings).frame_buffer.resolve_variance_of_mean(1).empty());
    settings.channels[0].rule = display::FilterRule::max;
    CHECK(error().find("no rule but the pixel filter") != std::string::npos);
    settings.channels.clear();
    settings.adaptive.emplace();
    CHECK(error().find("cannot sample adaptively") != std::string::npos);
    settings.adaptive.reset();
    transport::SceneEntity clamp;
    clamp.type = "clamp";
    settings.sample_filters = {clamp};
    CHECK(error().find("sample filters ('clamp')") != std::string::npos);
    settings.sample_filters.clear();
    settings.channels = {osl("u", "unoccluded;C.*L")};
    settings.channels[0].dialect = raylex::lpe::Dialect::renderman;
    CHECK(error().find("samples no lights") != std::string::npos);
}
