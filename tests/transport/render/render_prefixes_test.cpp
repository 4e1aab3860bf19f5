// Channels with prefixes on rendered paths: unbiasedness, sums, equal bits.
#include "transport/guide/guide_support.h"
#include "transport/render_support.h"

using namespace render_test;

namespace {

/// A floor in the shadow of a hovering plate, under a spherical lamp, a spot and the lights in `sky`.
std::string plate_scene(const std::string& sky, const std::string& plate_material = "\"diffuse\"") {
    return film + R"(
Integrator "path" "integer maxdepth" 4
LookAt 0 3 4  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
AttributeBegin
  Translate 0 3 0.5
  AreaLightSource "diffuse" "rgb L" [20 18 15]
  Shape "sphere" "float radius" 0.4
AttributeEnd
LightSource "spot" "rgb I" [6 7 8] "point3 from" [-2 2.5 1] "point3 to" [0 0 0] "float coneangle" 60
)" + sky + R"(
MakeNamedMaterial "floor" "string type" "coateddiffuse" "rgb reflectance" [0.5 0.4 0.3] "float roughness" 0.3
MakeNamedMaterial "plate" "string type" )" +
           plate_material + R"(
NamedMaterial "floor"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 3 3 0 3 3 0 -3 -3 0 -3]
NamedMaterial "plate"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.8 1 0.8 0.8 1 0.8 0.8 1 -0.8 -0.8 1 -0.8]
)";
}

const std::string constant_sky = "LightSource \"infinite\" \"rgb L\" [0.3 0.4 0.5]\n";

transport::SceneDescription with_holdout(const std::string& text, const std::string& material) {
    transport::SceneDescription scene = scene_of(text);
    transport::LabelRule rule{transport::LabelRule::Selector::material, material, "", {"job.toml", 1, 1}};
    rule.holdout = true;
    rule.keeps_label = true;
    REQUIRE(transport::apply_label_rules(scene, {rule}).ok());
    return scene;
}

/// The difference of two channels of one render, pixel by pixel, with its standard error. The channels share their
/// samples, so the error of the difference is estimated from blocks of pixels.
struct Difference {
    double mean = 0, error = 0;
};
Difference difference(const std::vector<double>& a, const std::vector<double>& b) {
    Difference d;
    const std::size_t pixels = a.size() / 3;
    double squares = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        const double x = a[3 * i + 1] - b[3 * i + 1];
        d.mean += x;
        squares += x * x;
    }
    const auto n = static_cast<double>(pixels);
    d.mean /= n;
    d.error = std::sqrt(std::max(0.0, squares / n - d.mean * d.mean) / n);
    return d;
}

std::vector<double> sum_of(const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> sum = a;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += b[i];
    return sum;
}

/// The largest relative difference of two images.
double furthest(const std::vector<double>& a, const std::vector<double>& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i] != b[i]) worst = std::max(worst, std::abs(a[i] - b[i]) / std::max(std::abs(a[i]), std::abs(b[i])));
    return worst;
}

double total(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v;
    return sum;
}

}  // namespace

TEST_CASE("unshadowed direct light is the direct light of the scene without occluders", "[render][prefixes]") {
    for (const std::string& sky : {std::string(), constant_sky}) {
        transport::RenderSettings settings;
        settings.samples.per_pixel = 256;
        settings.channels.list = {lpe_channel("unoccluded", "unoccluded;C<RD'floor'>L"),
                                  lpe_channel("plain", "C<RD'floor'>L")};
        const auto shadowed = render_of(scene_of(plate_scene(sky)), settings);
        // Without the plate the floor has no shadow. Where the camera sees the plate, neither render has floor. So the
        // comparison is with a plate that is visible to the camera and not to light; light of the floor is black on
        // plate pixels.
        settings.samples.seed = 77;
        std::string empty = plate_scene(sky);
        const std::size_t plate = empty.find("NamedMaterial \"plate\"\nShape");
        REQUIRE(plate != std::string::npos);
        empty.resize(plate);
        const auto bare = render_of(scene_of(empty), settings);
        const std::vector<double> unoccluded = shadowed.frame_buffer.resolve(1), plain = bare.frame_buffer.resolve(2);
        const std::vector<double> variance_a = shadowed.frame_buffer.resolve_variance_of_mean(1),
                                  variance_b = bare.frame_buffer.resolve_variance_of_mean(2);
        double sum = 0, variance = 0;
        int pixels = 0;
        for (std::size_t i = 1; i < plain.size(); i += 3) {
            const std::size_t y = i / 3 / 24;
            if (y < 16) continue;  // rows below the plate: floor alone in both
            sum += unoccluded[i] - plain[i];
            variance += variance_a[i] + variance_b[i];
            ++pixels;
        }
        INFO("sky " << sky << ", mean difference " << sum / pixels);
        CHECK(pixels == 8 * 24);
        // exceeded by chance once in 150,000
        CHECK(std::abs(sum) < 4.5 * std::sqrt(variance));
        CHECK(total(shadowed.frame_buffer.resolve(2)) < 0.98 * total(unoccluded));  // there is a shadow
    }
}

TEST_CASE("shadows equal unshadowed light minus light", "[render][prefixes]") {
    for (const std::string& strategy : {std::string("mis"), std::string("light")}) {
        transport::RenderSettings settings;
        settings.samples.per_pixel = 256;
        settings.paths.integrator = path_with(text_parameter("strategy", strategy));
        settings.paths.max_depth = 4;
        settings.channels.list = {lpe_channel("plain", "C[DS]+L"), lpe_channel("unoccluded", "unoccluded;C[DS]+L"),
                                  lpe_channel("shadows", "shadows;C[DS]+L")};
        const auto output = render_of(scene_of(plate_scene(constant_sky)), settings);
        const std::vector<double> plain = output.frame_buffer.resolve(1), shadows = output.frame_buffer.resolve(3);
        const Difference d = difference(sum_of(plain, shadows), output.frame_buffer.resolve(2));
        INFO("strategy " << strategy << ", difference " << d.mean << " +- " << d.error);
        CHECK(std::abs(d.mean) <= 4.5 * d.error);
        // otherwise the check above would be weak
        CHECK(d.error < 0.02 * total(plain) / static_cast<double>(plain.size()));
        CHECK(total(shadows) > 0.05 * total(plain));
        for (const double v : shadows) CHECK(v >= 0);
    }
}

TEST_CASE("light through a half-transparent cutout casts half a shadow", "[render][prefixes]") {
    std::string text = plate_scene("");
    const std::string shape = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-0.8";
    const std::size_t at = text.find(shape);
    REQUIRE(at != std::string::npos);
    text.insert(at + std::string("Shape \"trianglemesh\"").size(), " \"float alpha\" 0.5");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 256;
    settings.paths.max_depth = 1;
    settings.channels.list = {lpe_channel("plain", "C<RD'floor'>L"),
                              lpe_channel("unoccluded", "unoccluded;C<RD'floor'>L"),
                              lpe_channel("shadows", "shadows;C<RD'floor'>L")};
    const auto output = render_of(scene_of(text), settings);
    const std::vector<double> shadows = output.frame_buffer.resolve(3);
    const Difference d = difference(sum_of(output.frame_buffer.resolve(1), shadows), output.frame_buffer.resolve(2));
    INFO("difference " << d.mean << " +- " << d.error);
    CHECK(std::abs(d.mean) <= 4.5 * d.error);
    CHECK(total(shadows) > 0);
}

TEST_CASE("beauty and plain channels have the same bits with and without channels with prefixes and user events",
          "[render][prefixes][law2]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.channels.list = {lpe_channel("direct", "C<RD>[<L.>O]"), lpe_channel("osl", "C<RD>.*")};
    const auto alone = render_of(scene, settings);
    for (const char* expression :
         {"unoccluded;C.*", "shadows;C.*", "nothruput;C.*", "holdouts;C.*", "overwrite;C.*", "noinfinitecheck;C.*",
          "unoccluded;holdouts;C[DS]+<L.>",
          "nothruput;noinfinitecheck;noclamp;unoccluded;overwrite;C<.S'passthru'>*((U2L)|O)", "CU6L"})
        settings.channels.list.push_back(
            lpe_channel(std::string("p").append(std::to_string(settings.channels.list.size())), expression));
    const auto beside = render_of(scene, settings);
    for (display::ChannelId id = 0; id < 3; ++id)
        CHECK((beside.frame_buffer.resolve(id) == alone.frame_buffer.resolve(id)));
    CHECK(beside.statistics.shadow_rays == alone.statistics.shadow_rays);
    CHECK(beside.statistics.scattering_rays == alone.statistics.scattering_rays);
}

TEST_CASE("paths whose first hit is a holdout leave beauty, alpha and plain channels", "[render][prefixes][law1]") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.channels.list = {lpe_channel("floor", "C<.D'floor'>.*"), lpe_channel("all", "C.*"),
                              lpe_channel("catcher", "holdouts;C.*"), lpe_channel("occluded", "holdouts;C[DS]+<L.>"),
                              lpe_channel("clear", "holdouts;unoccluded;C[DS]+<L.>")};
    display::ChannelDefinition depth;
    depth.name = "z";
    settings.channels.list.push_back(depth);
    const std::string text = plate_scene(constant_sky);
    const auto ordinary = render_of(scene_of(text), settings);
    const auto output = render_of(with_holdout(text, "floor"), settings);
    const std::vector<double> beauty = output.frame_buffer.resolve(output.beauty);
    // For each path nothing else changed: the beauty plus the holdout's channel is the ordinary beauty.
    const double rounding = 1e-12;  // Law 1's bound for double sums
    CHECK(furthest(sum_of(beauty, output.frame_buffer.resolve(3)), ordinary.frame_buffer.resolve(ordinary.beauty)) <
          rounding);
    CHECK(total(output.frame_buffer.resolve(1)) == 0);
    CHECK(furthest(output.frame_buffer.resolve(2), beauty) < rounding);
    CHECK(total(beauty) > 0);
    CHECK(total(output.frame_buffer.resolve(5)) > 1.02 * total(output.frame_buffer.resolve(4)));
    CHECK(total(ordinary.frame_buffer.resolve(3)) == 0);
    CHECK(output.frame_buffer.resolve(6) == ordinary.frame_buffer.resolve(6));  // depth includes the holdout
    const std::vector<double> alpha = output.frame_buffer.resolve_alpha(), full = ordinary.frame_buffer.resolve_alpha();
    double held = 0, kept = 0;
    for (std::size_t i = 0; i < alpha.size(); ++i) (alpha[i] < full[i] ? held : kept) += 1;
    CHECK(full[7 * 24 + 12] == 1);
    CHECK(alpha[7 * 24 + 12] == 1);  // the plate, in front of the holdout floor
    CHECK(full[22 * 24 + 12] == 1);
    CHECK(alpha[22 * 24 + 12] == 0);  // the floor
    CHECK(held > 100);
    CHECK(kept > 30);
}

TEST_CASE("a holdout without a channel costs no rays", "[render][prefixes][law4]") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    const std::string text = plate_scene(constant_sky);
    const auto ordinary = render_of(scene_of(text), settings),
               output = render_of(with_holdout(text, "floor"), settings);
    CHECK(output.statistics.shadow_rays * 2 < ordinary.statistics.shadow_rays);
    // If only unshadowed light is requested, no shadow ray is traced.
    settings.channels.beauty = false;
    settings.channels.list = {lpe_channel("clear", "unoccluded;C<RD>L")};
    const auto unshadowed = render_of(scene_of(text), settings);
    CHECK(unshadowed.statistics.shadow_rays == 0);
    CHECK(total(unshadowed.frame_buffer.resolve(0)) > 0);
    settings.channels.beauty = true;
    const auto beside = render_of(scene_of(text), settings);
    CHECK(beside.frame_buffer.resolve(1) == unshadowed.frame_buffer.resolve(0));
}

TEST_CASE("an instance can override the holdout flag of its shapes", "[render][prefixes]") {
    const std::string text = film + R"(
LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
MakeNamedMaterial "m" "string type" "diffuse"
NamedMaterial "m"
ObjectBegin "ball"
Shape "sphere" "float radius" 0.5
ObjectEnd
AttributeBegin Translate -1 0 0 ObjectInstance "ball" AttributeEnd
AttributeBegin Translate 1 0 0 ObjectInstance "ball" AttributeEnd
)";
    transport::SceneDescription scene = scene_of(text);
    using Selector = transport::LabelRule::Selector;
    transport::LabelRule all{Selector::material, "m", "balls", {}, true},
        one{Selector::instance, "ball:1", "right", {}, false};
    REQUIRE(transport::apply_label_rules(scene, {all, one}).ok());
    CHECK(scene.objects[0].shapes[0].label == "balls");
    CHECK(scene.instances[1].label == "right");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    settings.channels.list = {lpe_channel("held", "holdouts;C.+L"), lpe_channel("plain", "C.+L")};
    const auto output = render_of(scene, settings);
    const std::vector<double> held = output.frame_buffer.resolve(1), plain = output.frame_buffer.resolve(2);
    // Camera space is left-handed: looking along -z, the object at x = -1 is on the right.
    double held_left = 0, held_right = 0, plain_left = 0, plain_right = 0;
    for (std::size_t i = 0; i < held.size(); ++i) {
        const bool left = i / 3 % 24 < 12;
        (left ? held_left : held_right) += held[i];
        (left ? plain_left : plain_right) += plain[i];
    }
    CHECK(held_right > 0);
    CHECK(plain_left > 0);
    CHECK(held_left == 0);
    CHECK(plain_right == 0);
}

TEST_CASE("without throughput a channel receives the light's emission", "[render][prefixes]") {
    const std::string text = film + R"(
LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" 20
WorldBegin
)";
    const std::string wall = R"(
Material "diffuse" "rgb reflectance" [0.2 0.2 0.2]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 -2 0 2 -2 0 2 2 0 -2 2 0]
)";
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.paths.max_depth = 1;
    settings.channels.list = {lpe_channel("sent", "nothruput;CDL"), lpe_channel("last", "nothruput;overwrite;CDL")};
    const auto mean = [](const transport::RenderOutput& output, display::ChannelId id) {
        const std::vector<double> values = output.frame_buffer.resolve(id);
        return total(values) / static_cast<double>(values.size());
    };
    // One light sample per camera sample, and no other way to find these lights.
    for (const char* light :
         {"LightSource \"point\" \"rgb I\" [3 3 3] \"point3 from\" [0 0 3]\n",
          "LightSource \"distant\" \"rgb L\" [3 3 3] \"point3 from\" [0 0 3] \"point3 to\" [0 0 0]\n"}) {
        const auto output = render_of(scene_of(text + light + wall), settings);
        // Intensity times the squared distance by which the sample was divided: two roundings of a float.
        CHECK(mean(output, 1) == Approx(3).epsilon(1e-6));
        CHECK(mean(output, 2) == Approx(3).epsilon(1e-6));
    }
    // A directly visible emitter contributes its radiance.
    settings.channels.list = {lpe_channel("sent", "nothruput;CL")};
    const auto seen = render_of(scene_of(text + "AreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\n" + wall), settings);
    CHECK(mean(seen, 1) == 5);
}

TEST_CASE("RenderMan's albedo and normal recipes match the geometric AOVs", "[render][prefixes]") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 8;
    const std::string prefixes = "nothruput;noinfinitecheck;noclamp;unoccluded;overwrite;";
    settings.channels.list = {lpe_channel("a", prefixes + "C<.S'passthru'>*((U2L)|O)"),
                              lpe_channel("n", prefixes + "CU6L"),
                              lpe_channel("second", prefixes + "C<RS><.U2'plate'>L"), lpe_channel("through", "CDU2L")};
    for (const char* name : {"albedo", "Nn"}) {
        display::ChannelDefinition aov;
        aov.name = name;
        settings.channels.list.push_back(aov);
    }
    for (const std::int64_t depth : {5, 0}) {
        settings.paths.max_depth = depth;
        const auto output = render_of(scene_of(plate_scene(constant_sky, "\"conductor\"")), settings);
        for (const auto& [mine, aov] : {std::pair{1, 5}, std::pair{2, 6}}) {
            const std::vector<double> a = output.frame_buffer.resolve(mine), b = output.frame_buffer.resolve(aov);
            REQUIRE(a.size() == b.size());
            double worst = 0, largest = 0;
            for (std::size_t i = 0; i < a.size(); ++i) {
                worst = std::max(worst, std::abs(a[i] - b[i]));
                largest = std::max(largest, std::abs(a[i]));
            }
            CHECK(largest > 0.2);
            CHECK(worst < 1e-6);  // the AOV's normal is normalised once more, in float
        }
        // The plate's albedo in the floor's glossy coat, and an albedo that throughput attenuates.
        CHECK((total(output.frame_buffer.resolve(3)) > 0) == (depth > 0));
        CHECK((total(output.frame_buffer.resolve(4)) > 0) == (depth > 0));
    }
}

TEST_CASE("channels that the integrator cannot fill are refused before the render", "[render][prefixes][law7]") {
    const auto scene = scene_of(plate_scene(""));
    transport::RenderSettings settings;
    settings.samples.per_pixel = 1;
    settings.paths.integrator = path_with(text_parameter("strategy", "scattering"));
    for (const char* expression : {"unoccluded;C.*", "holdouts;shadows;C.*"}) {
        settings.channels.list = {lpe_channel("mine", expression)};
        const auto output = transport::render(scene, settings);
        REQUIRE_FALSE(output.ok());
        CHECK(output.error().message.find("'mine'") != std::string::npos);
        CHECK(output.error().message.find("samples no lights") != std::string::npos);
    }
    settings.channels.list = {lpe_channel("mine", "nothruput;overwrite;C.*")};
    CHECK(transport::render(scene, settings).ok());
}

TEST_CASE("a guide learns the same beside a channel of holdouts", "[render][prefixes][guide][law2]") {
    const auto scene = with_holdout(plate_scene(constant_sky), "plate");
    const std::string mode = GENERATE("on", "auto"), takes = GENERATE("", "C<R.>.*");
    CAPTURE(mode, takes);
    transport::RenderSettings settings = guided_settings(64, 16);
    settings.paths.integrator = with_guide(integrator_named("path"), mode, 64);
    settings.channels.takes = takes;  // of a pass
    const auto alone = render_of(scene, settings);
    CHECK(alone.statistics.guide.paths > 0);
    settings.channels.list = {lpe_channel("catcher", "holdouts;" + (takes.empty() ? "C.*" : takes))};
    if (takes.empty()) settings.channels.list.push_back(lpe_channel("drawn", "nothruput;C.*"));
    const auto beside = render_of(scene, settings);
    CHECK((beside.frame_buffer.resolve(beside.beauty) == alone.frame_buffer.resolve(alone.beauty)));
    CHECK(beside.statistics.pilot_rays == alone.statistics.pilot_rays);
    CHECK(beside.statistics.guide.gain == alone.statistics.guide.gain);
    CHECK(total(beside.frame_buffer.resolve(1)) > 0);
}
