// Renders whose paths a guide draws: the image stays what it is without the guide.
#include "transport/directed_integrator.h"
#include "transport/enclosure.h"
#include "transport/guide/guide_support.h"
#include "transport/image_file.h"
#include "transport/paths/guide/guide_view.h"
#include "transport/render/stages/prepared_job.h"

using namespace render_test;

namespace {

/// A small lamp, whose light is rare.
const std::string lamp_in_glass = lamp_in_globe(0.3, 0.12, 60);

/// A method that draws directions by a guide trained in lamp_in_glass, so that a guide is used where none pays.
transport::SceneEntity misled(const std::string& method) {
    const auto scene = transport::BuiltScene::build(scene_of(lamp_in_glass));
    REQUIRE(scene.ok());
    const transport::RenderSettings settings = guided_settings(64, 1, method);
    auto job = transport::ResolvedJob::resolve(**scene, settings);
    REQUIRE(job.ok());
    auto prepared = transport::PreparedJob::prepare(*std::move(job));
    REQUIRE(prepared.ok());
    CHECK(prepared->guide.summary.guided > 0.9);  // of the regions, which cover all space
    register_directed("misled-" + method, method, std::move(prepared->guide.guide));
    return integrator_named("misled-" + method);
}

/// Whether a render with the guide of these settings, which `guidesamples` alone determines, uses it.
bool guide_is_used(const transport::BuiltScene& scene, transport::RenderSettings settings) {
    settings.samples.per_pixel = 1;
    const auto output = transport::render(scene, settings);
    REQUIRE(output.ok());
    return output->statistics.guide.used;
}

}  // namespace

TEST_CASE("in an enclosure guided paths find the light of every path string", "[guide][render][gate]") {
    const double kd = 0.5, ks = 0.3;
    const auto scene = transport::BuiltScene::build(scene_of(enclosure(kd, ks)));
    REQUIRE(scene.ok());
    const std::vector<EnclosurePathString> words = enclosure_path_strings(kd, ks, 8);
    const std::string method = GENERATE("path", "bdpt");
    CAPTURE(method);
    transport::RenderSettings settings;
    settings.paths.integrator = misled(method);  // radiance is the same from everywhere, so no guide pays
    settings.samples.per_pixel = method == "path" ? 256 : 32;
    settings.machine.threads = 2;
    settings.paths.max_depth = 8;
    // Beauty and the strings up to length 4 one by one, the longer ones by their number of reflections.
    std::vector<double> values{0};
    for (const EnclosurePathString& word : words) {
        values[0] += word.value;
        if (word.reflections.size() > 4) continue;
        settings.channels.list.push_back(lpe_channel("w" + word.reflections, "C" + word.reflections + "L"));
        values.push_back(word.value);
    }
    for (std::size_t length = 5; length <= 8; ++length) {
        std::string expression = "C";
        for (std::size_t i = 0; i < length; ++i) expression += "[DS]";
        settings.channels.list.push_back(lpe_channel("l" + std::to_string(length), expression + "L"));
        values.push_back(std::pow(kd + ks, static_cast<double>(length)));
    }
    const Replicates found = replicates(**scene, settings, static_cast<int>(values.size()), 8, 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const Estimate e = found.channel(i);
        CAPTURE(i, values[i], e.mean, e.error);
        // Student's t with 7 degrees of freedom: beyond 9 by chance once in 20,000 comparisons. 1e-5: products of a
        // few floats.
        CHECK(std::abs(e.mean - values[i]) <= 9 * e.error + 1e-5);
    }
}

TEST_CASE("guided paths estimate the image of paths that closures draw", "[guide][render][gate][statistical]") {
    // Diffuse, glossy, coated and clear glass, lights of all kinds; the same in fog; shading normals, rough glass, a
    // cutout and the sky; a lamp in glass.
    for (const std::string& text : {room, foggy_room(), many_lights(), lamp_in_glass}) {
        const auto scene = transport::BuiltScene::build(scene_of(text));
        REQUIRE(scene.ok());
        transport::RenderSettings settings = guided_settings(32, 64);
        const bool pays = text != many_lights();
        if (!pays) settings.paths.integrator = misled("path");
        settings.channels.list = {lpe_channel("direct", "C.L"), lpe_channel("indirect", "C..+L")};
        CHECK((!pays || guide_is_used(**scene, settings)));
        const Replicates guided = replicates(**scene, settings, 3, 12, 500);
        settings.paths.integrator = pays ? with_guide(integrator_named("bdpt"), "on", 32) : misled("bdpt");
        CHECK((!pays || guide_is_used(**scene, settings)));
        const Replicates bidirectional = replicates(**scene, settings, 3, 12, 900);
        settings.paths.integrator = integrator_named("path");
        const Replicates plain = replicates(**scene, settings, 3, 12, 100);
        check_agreement(plain, guided, {"beauty", "direct", "indirect"});
        check_agreement(plain, bidirectional, {"beauty", "direct", "indirect"});
    }
}

TEST_CASE("a guide does not change how textures are filtered", "[guide][render][texture-filter][gate][statistical]") {
    // Nearly all light comes by a small white patch of the ceiling, so a guide draws its direction much more often than
    // the closure does. With footprints by the guide's density, the patch would not be blurred, and the floor would be
    // about three times as bright.
    std::vector<raylex::transport::Rgb> texels(128 * 128, raylex::transport::Rgb(0));
    for (int y = 80; y < 84; ++y)
        for (int x = 70; x < 74; ++x) texels[static_cast<std::size_t>(y * 128 + x)] = raylex::transport::Rgb(1);
    const ImageFile image(128, 128, texels);
    // The coat has pbrt's bias, whose visible part depends on the densities.
    for (const auto& [filter, floor] : {std::pair<std::string, std::string>{"bilinear", "diffuse"},
                                        {"trilinear", "diffuse"},
                                        {"bilinear", "coateddiffuse"}}) {
        CAPTURE(filter, floor);
        const auto scene = transport::BuiltScene::build(scene_of(R"(
Film "rgb" "integer xresolution" 16 "integer yresolution" 16
Integrator "path" "integer maxdepth" 3
LookAt 0 1 0  0 0 0  0 0 1
Camera "perspective" "float fov" 60
WorldBegin
AttributeBegin Translate 0 0.1 0
  LightSource "spot" "rgb I" [20 20 20] "point3 from" [0 0 0] "point3 to" [0 1 0] "float coneangle" 50
AttributeEnd
Material ")" + floor + R"(" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 -1 -1 0 1 1 0 1 1 0 -1]
Texture "patch" "spectrum" "imagemap" "string encoding" "linear" "string filter" ")" +
                                                                 filter + "\"" + image.parameter() + R"(
Material "diffuse" "texture reflectance" "patch"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 2 -1 1 2 -1 1 2 1 -1 2 1]
    "point2 uv" [0 0 1 0 1 1 0 1]
)"));
        REQUIRE(scene.ok());
        transport::RenderSettings settings = guided_settings(64, 512);
        const Replicates guided = replicates(**scene, settings, 1, 12, 500);
        settings.paths.integrator = integrator_named("path");
        const Replicates plain = replicates(**scene, settings, 1, 12, 500);
        check_agreement(plain, guided, {"beauty"});
        CHECK(plain.mean(0) != guided.mean(0));
    }
}

TEST_CASE("10,000 short guided renders have the mean of plain ones, however rare the light",
          "[guide][render][.full][statistical]") {
    // Each guide learns from 144 paths, few of which meet the lamp: a weight that depended on what it weighs would
    // show.
    std::string small = lamp_in_glass;
    for (std::size_t at = 0; (at = small.find("resolution\" 24", at)) != std::string::npos; ++at)
        small.replace(at, 14, "resolution\" 6 ");
    const auto scene = transport::BuiltScene::build(scene_of(small));
    REQUIRE(scene.ok());
    transport::RenderSettings settings = guided_settings(4, 144);
    settings.machine.threads = 1;
    const Estimate guided = replicates(**scene, settings, 1, 10'000, 100'000).channel(0);
    settings.paths.integrator = integrator_named("path");
    const Estimate plain = replicates(**scene, settings, 1, 10'000, 1).channel(0);
    CAPTURE(guided.mean, guided.error, plain.mean, plain.error);
    CHECK(deviation(guided, plain) < 4.5);
    // A bias of 0.5 % is detected in nine of ten cases: it moves the deviation to 1.2816 beyond the limit.
    CHECK((4.5 + 1.2816) * std::hypot(guided.error, plain.error) < 0.005 * plain.mean);
}

TEST_CASE("a guide makes the light of a lamp in glass less noisy", "[guide][render][gate][statistical]") {
    const auto scene = transport::BuiltScene::build(scene_of(lamp_in_glass));
    REQUIRE(scene.ok());
    transport::RenderSettings settings = guided_settings(256, 64);
    const double guided = replicates(**scene, settings, 1, 12, 500).sum_of_variances();
    settings.paths.integrator = integrator_named("path");
    const double plain = replicates(**scene, settings, 1, 12, 100).sum_of_variances();
    CAPTURE(guided, plain);
    // The ratio of two such sums of nine blocks and twelve seeds has a standard error of about 15 %; 0.5 to 0.6 was
    // found.
    CHECK(guided < 0.8 * plain);
}

TEST_CASE("a guided image has the same bits for every number of threads", "[guide][render][law3]") {
    const auto scene = scene_of(foggy_room());
    transport::RenderSettings settings = guided_settings(8, 16);
    settings.machine.threads = 1;
    const auto one = render_of(scene, settings);
    CHECK(one.statistics.guide.used);
    CHECK(one.statistics.guide.samples == 8);
    CHECK(one.statistics.guide.bytes <= std::size_t{64} << 20);
    for (const int threads : {2, 3, 8}) {
        settings.machine.threads = threads;
        CHECK((frame_bits(render_of(scene, settings)) == frame_bits(one)));
    }
}

TEST_CASE("a guided render in many sessions has the bits of one that was never interrupted",
          "[guide][render][checkpoint][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.paths.integrator = with_guide(counted("path"), "on", 64);
    settings.samples.per_pixel = 200;
    const auto whole = render_of(scene, settings);
    CHECK(whole.statistics.guide.used);
    const ScratchFile file;
    const RenderInSessions found = render_in_sessions(scene, settings, 2'000, file.path());
    CHECK(found.sessions > 20);  // the threads leave their batches at once, so sessions differ a little
    const auto record = raylex::display::RecordFileReader::open(file.path());
    CHECK((record.ok() && record->has("guide")));
    CHECK((frame_bits(found.output) == frame_bits(whole)));
}

TEST_CASE("the training takes a quarter of the samples of the whole render, in each shard", "[guide][render][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = guided_settings(0, 128);
    auto whole = render_of(scene, settings);
    CHECK(whole.statistics.guide.samples == 32);
    CHECK(whole.statistics.guide.used);
    settings.samples.whole = 128;
    settings.samples.per_pixel = 48;
    auto merged = render_of(scene, settings);
    settings.samples.first = 48;
    settings.samples.per_pixel = 128;
    const auto last = render_of(scene, settings);
    REQUIRE(merged.frame_buffer.merge(last.frame_buffer).ok());
    CHECK((frame_bits(merged) == frame_bits(whole)));
}

TEST_CASE("auto does not train for a short render", "[guide][render]") {
    transport::RenderSettings settings = guided_settings(0, 511);
    settings.paths.integrator = with_guide(integrator_named("path"), "auto", 0);
    CHECK(render_of(scene_of(room), settings).statistics.guide.samples == 0);
    settings.samples.per_pixel = 512;
    CHECK(render_of(scene_of(room), settings).statistics.guide.samples > 0);
}

TEST_CASE("the bits of a guided render with a time limit can be repeated", "[guide][render][law3]") {
    const auto scene = scene_of(lamp_in_glass);
    transport::RenderSettings settings = guided_settings(0, 1);
    settings.samples.per_pixel.reset();
    settings.stop.limit = transport::SampleLimit{.seconds = 1.5};
    const auto limited = render_of(scene, settings);
    REQUIRE(limited.samples.complete);
    const transport::GuideSummary& guide = limited.statistics.guide;
    // A busy machine may end the training; the render then has no guide, and repeated() is 0.
    CHECK(guide.samples > 0);
    settings.stop.limit.reset();
    settings.samples.per_pixel = limited.samples.per_pixel;
    settings.paths.guide_samples = guide.repeated();
    CHECK((frame_bits(render_of(scene, settings)) == frame_bits(limited)));
}

TEST_CASE("a record of a guide gives the same guide, and a damaged one none", "[guide][render][checkpoint]") {
    transport::RenderSettings settings = guided_settings(32, 16);
    const auto scene = transport::BuiltScene::build(scene_of(lamp_in_glass));
    REQUIRE(scene.ok());
    auto job = transport::ResolvedJob::resolve(**scene, settings);
    REQUIRE(job.ok());
    const auto prepared = transport::PreparedJob::prepare(*std::move(job));
    REQUIRE(prepared.ok());
    const std::string bytes = prepared->guide.record();
    auto again = transport::TrainedGuide::from_record(bytes);
    REQUIRE(again.has_value());
    CHECK((again->record() == bytes));
    CHECK_FALSE(transport::TrainedGuide::from_record(bytes.substr(0, bytes.size() - 1)).has_value());
    CHECK_FALSE(transport::TrainedGuide::from_record(bytes + "x").has_value());
    // An index of a node that is not in the tree.
    std::string wild = bytes;
    wild[wild.size() - 1] = '\x7f';
    wild[wild.size() - 4] = '\x7f';
    CHECK_FALSE(transport::TrainedGuide::from_record(wild).has_value());
}

TEST_CASE("a view of a guide has the regions that pixels see, and changes no bit", "[guide][render]") {
    transport::RenderSettings settings = guided_settings(32, 4);
    const auto scene = scene_of(lamp_in_glass);
    const auto plain = render_of(scene, settings);
    CHECK(plain.statistics.guide_view == nullptr);
    settings.paths.guide_view = true;
    const auto output = render_of(scene, settings);
    CHECK((frame_bits(output) == frame_bits(plain)));
    REQUIRE(output.statistics.guide_view != nullptr);
    const transport::GuideView& view = *output.statistics.guide_view;
    CHECK(view.step == 1);
    REQUIRE((view.width == 24 && view.height == 24 && view.regions.size() == 24 * 24));
    CHECK(view.tree.regions().size() == output.statistics.guide.regions);
    // The camera looks along -z, and +x is on the left in pbrt's camera space.
    CHECK((view.to_camera == std::array<transport::Real, 9>{-1, 0, 0, 0, 1, 0, 0, 0, -1}));
    const std::vector<std::uint8_t> sides = view.tree.sides();
    const auto side_at = [&](std::size_t x, std::size_t y) { return sides.at(view.regions[24 * y + x]); };
    CHECK(side_at(12, 23) == 2);  // the floor faces +y, the ceiling -y
    CHECK(side_at(12, 0) == 3);
    CHECK(side_at(4, 12) == 1);   // the wall on the left -x
    CHECK(side_at(15, 12) == 4);  // the wall behind +z
    // Paths end within the glass of the globe at most; all else is diffuse.
    const auto seen = std::count_if(view.regions.begin(), view.regions.end(),
                                    [](std::uint32_t each) { return each != transport::GuideView::no_region; });
    CHECK(seen > 500);
    CHECK(view.guided() > 0);
    CHECK(view.guided() <= static_cast<double>(seen) / (24 * 24));

    settings.film.resolution = {130, 127};  // more pixels than a view has points
    settings.samples.per_pixel = 1;
    settings.paths.integrator = with_guide(integrator_named("path"), "on", 16);
    const auto large = render_of(scene, settings);
    REQUIRE(large.statistics.guide_view != nullptr);
    CHECK(large.statistics.guide_view->step == 2);
    CHECK((large.statistics.guide_view->width == 65 && large.statistics.guide_view->height == 64));
}

TEST_CASE("a training that takes half of the time limit is given up, with a warning", "[guide][render]") {
    transport::RenderSettings settings = guided_settings(4096, 16);
    settings.samples.per_pixel.reset();
    settings.stop.limit = transport::SampleLimit{.seconds = 0.4};
    auto output = transport::render(scene_of(room), settings);
    REQUIRE(output.ok());
    CHECK(output->statistics.guide.cut);
    CHECK_FALSE(output->statistics.guide.used);
    REQUIRE_FALSE(output->warnings.empty());
    CHECK(output->warnings.back().message.find("half of the time limit") != std::string::npos);
}

TEST_CASE("a stop ends the training of a guide", "[guide][render]") {
    transport::RenderSettings settings = guided_settings(4096, 16);  // 2.4 million paths
    std::atomic<bool> stop{true};
    auto output = transport::render(scene_of(room), settings, {}, &stop);
    REQUIRE(output.ok());
    CHECK_FALSE(output->samples.complete);
    CHECK_FALSE(output->statistics.guide.used);
}

TEST_CASE("channels change nothing of a guided beauty", "[guide][render][law2]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = guided_settings(8, 16);
    const auto alone = render_of(scene, settings);
    settings.channels.list = {lpe_channel("caustics", "C<RD><TS>+L"), lpe_channel("direct", "CDL"), aov("Nn")};
    const auto beside = render_of(scene, settings);
    CHECK(alone.frame_buffer.resolve(alone.beauty) == beside.frame_buffer.resolve(beside.beauty));
}

TEST_CASE("without beauty a guide learns the light of the requested channels", "[guide][render]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = guided_settings(64, 64);
    settings.channels.beauty = false;
    settings.channels.list = {lpe_channel("caustics", "C<RD><TS>+L")};
    const auto guided = render_of(scene, settings);
    CHECK(guided.statistics.guide.used);
    settings.paths.integrator = integrator_named("path");
    settings.samples.per_pixel = 256;
    const auto plain = render_of(scene, settings);
    CHECK(deviation(estimate(guided, 0), estimate(plain, 0)) < 4.5);
}

TEST_CASE("auto leaves paths to closures where a guide does not pay", "[guide][render]") {
    // Radiance is the same from everywhere: nothing is better than the closure.
    const auto scene = scene_of(enclosure(0.5, 0.3));
    transport::RenderSettings settings = guided_settings(0, 16);
    settings.paths.integrator = with_guide(integrator_named("path"), "auto", 64);
    const auto automatic = render_of(scene, settings);
    CHECK(automatic.statistics.guide.samples > 0);
    CHECK_FALSE(automatic.statistics.guide.used);
    settings.paths.integrator = integrator_named("path");
    CHECK((frame_bits(render_of(scene, settings)) == frame_bits(automatic)));
}

TEST_CASE("an unknown mode of guides is refused by name", "[guide][law7]") {
    transport::RenderSettings settings;
    settings.paths.integrator = path_with(text_parameter("guide", "maybe"));
    const auto refused = transport::render(scene_of(room), settings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().to_string().find("maybe") != std::string::npos);
    CHECK(refused.error().to_string().find("auto") != std::string::npos);
}
