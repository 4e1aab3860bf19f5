// The Metropolis integrator against the path tracer, and the laws; the numbers that its chains walk over.
#include <set>
#include <tuple>

#include "transport/integrators/path_contributions.h"
#include "transport/replicates.h"
#include "transport/samplers/primary_samples.h"

using namespace render_test;
using transport::PrimarySamples;

namespace {

const std::string foggy_ball = film + R"(
PixelFilter "gaussian" "float xradius" 2 "float yradius" 2 "float sigma" 0.7
LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" 40 "float lensradius" 0.1 "float focaldistance" 4
WorldBegin
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [0.4 0.5 0.6] "rgb sigma_a" [0.1 0.1 0.1] "float g" 0.3
LightSource "point" "rgb I" [4 4 4] "point3 from" [1.5 2 1]
LightSource "infinite" "rgb L" [0.2 0.2 0.2]
AttributeBegin MediumInterface "fog" "" Material "interface" Shape "sphere" "float radius" 1.2 AttributeEnd
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 -1.3 3 3 -1.3 3 3 -1.3 -3 -3 -1.3 -3]
)";

/// Of images whose words are compared with the path tracer's.
transport::RenderSettings compared(std::int64_t max_depth) {
    transport::RenderSettings settings;
    settings.paths.max_depth = max_depth;
    settings.samples.per_pixel = 256;
    settings.film.resolution = {{18, 18}};
    return settings;
}

transport::SceneEntity metropolis_over(const char* integrator, int chains) {
    transport::SceneEntity entity = metropolis(chains, 20000);
    entity.parameters.parameters.push_back(text_parameter("integrator", integrator));
    return entity;
}

}  // namespace

TEST_CASE("primary samples are a chain whose stationary numbers are uniform", "[pssmlt][samplers]") {
    PrimarySamples chain;
    chain.restart(5);
    chain.propose(true, 0.05f);
    static_cast<void>(chain.get(0, false));
    chain.accept();
    // A rejected step leaves no trace, in numbers first seen in it neither.
    const auto state = [&] {
        chain.propose(false, 1e-6f);
        const std::array<float, 3> now{chain.get(0, false), chain.get(0, true), chain.get(9, false)};
        chain.reject();
        return now;
    };
    const float before = state()[0];
    for (int i = 0; i < 10; ++i) {
        chain.propose(i % 2 == 0, 0.3f);
        CHECK(chain.get(0, false) != before);
        CHECK(chain.get(0, false) == chain.get(0, false));
        chain.reject();
    }
    CHECK(std::abs(state()[0] - before) < 1e-5f);  // six deviations of the step of state() itself

    // All steps accepted: each number walks over [0, 1) evenly, those that are asked for every seventh step only as
    // well, and two numbers of one step are independent. Chi-square over 16 cells; small steps of half the range mix at
    // once, so n / 2 counts.
    constexpr int steps = 40000, cells = 16;
    std::array<std::array<int, cells>, 2> often{}, rare{};
    std::array<int, cells> joint{};
    for (int i = 0; i < steps; ++i) {
        chain.propose(i % 11 == 0, 0.5f);
        const float u = chain.get(3, false), v = chain.get(3, true);
        ++often[0][static_cast<std::size_t>(u * cells)];
        ++often[1][static_cast<std::size_t>(v * cells)];
        ++joint[4 * static_cast<std::size_t>(u * 4) + static_cast<std::size_t>(v * 4)];
        if (i % 7 == 0) {
            ++rare[0][static_cast<std::size_t>(chain.get(1u << 24, false) * cells)];
            ++rare[1][static_cast<std::size_t>(chain.get(1u << 25, true) * cells)];
        }
        chain.accept();
    }
    const auto chi_square = [](const std::array<int, cells>& counts) {
        int total = 0;
        double sum = 0;
        for (const int each : counts) total += each;
        for (const int each : counts) sum += std::pow(each - total / double(cells), 2) / (total / double(cells));
        return sum;
    };
    // 15 degrees of freedom: beyond 2 x 50 once in 10^5, the factor 2 for the steps' correlation.
    for (const auto* counts : {&often[0], &often[1], &rare[0], &rare[1], &joint}) CHECK(chi_square(*counts) < 100);
}

TEST_CASE("primary samples do not depend on the order of questions", "[pssmlt][samplers][law3]") {
    PrimarySamples a, b;
    a.restart(3);
    b.restart(3);
    for (int i = 0; i < 200; ++i) {
        const bool large = i % 10 == 0, accepted = i % 3 != 0;
        a.propose(large, 0.1f);
        b.propose(large, 0.1f);
        for (std::uint32_t d = 0; d < 100; ++d) static_cast<void>(a.get(d, d % 2 == 0));
        for (std::uint32_t d = 100; d-- > 0;) CHECK(b.get(d, d % 2 == 0) == a.get(d, d % 2 == 0));
        accepted ? a.accept() : a.reject();
        accepted ? b.accept() : b.reject();
    }
}

TEST_CASE("primary samples of endless paths take bounded memory, and go by large steps", "[pssmlt][samplers]") {
    PrimarySamples chain;
    chain.restart(7);
    // Of a camera subpath's and a light subpath's scatterings, as they name them.
    const auto far = [](std::uint32_t depth) { return 8 + 6 * depth; };
    const auto far_of_light = [](std::uint32_t depth) { return (1u << 26) + 8 + 5 * depth; };
    chain.propose(true, 0.1f);
    for (std::uint32_t depth = 0; depth < 1'000'000; ++depth) {
        static_cast<void>(chain.get(far(depth), true));
        static_cast<void>(chain.get(far_of_light(depth), false));
    }
    CHECK(chain.size() < 2000);
    const float first = chain.get(far(999'999), true), first_of_light = chain.get(far_of_light(5000), false);
    CHECK(chain.get(far(999'998), true) != first);
    chain.accept();
    chain.switch_stream(8);  // as chains do that begin at one path
    for (int step = 0; step < 20; ++step) {
        const bool large = step % 3 == 0;
        chain.propose(large, 0.1f);
        CHECK((chain.get(far(999'999), true) == first) == !large);
        CHECK((chain.get(far_of_light(5000), false) == first_of_light) == !large);
        large ? chain.reject() : chain.accept();
    }
    chain.propose(true, 0.1f);
    const float second = chain.get(far(999'999), true);
    chain.accept();
    chain.propose(false, 0.1f);
    CHECK(chain.get(far(999'999), true) == second);
    CHECK(second != first);
}

TEST_CASE("sample numbers differ between all mutations of all chains", "[pssmlt]") {
    constexpr std::uint64_t chains_of_tile = 5000, last_mutation = 0xffffffff;
    std::set<std::uint64_t> numbers;
    std::size_t samples = 0;
    // Chain 4,096 of one tile and chain 0 of the next had one number where a tile's chains took twelve bits.
    for (const std::uint64_t tile : {0, 1, 2, 500})
        for (const std::uint64_t chain : {0, 1, 903, 904, 4095, 4096, 4999})
            for (const std::uint64_t mutation : {std::uint64_t{1}, std::uint64_t{2}, last_mutation}) {
                numbers.insert(transport::sample_number(transport::path_number(tile, chains_of_tile, chain), mutation));
                ++samples;
            }
    CHECK(numbers.size() == samples);
}

TEST_CASE("the Metropolis integrator finds the path tracer's image, word by word",
          "[pssmlt][render][statistical][gate]") {
    const transport::RenderSettings settings = compared(5);
    compare_with_path(
        room, settings, metropolis(40, 40000), 12, 128,
        {"C.*", "CL", "C<RD>L", "C<.S>+B", "C<RD><.S>+L", "C<RD><RD>+[LB]", "C<RG>.*L", "C<RD><.G>.*[LB]"});
    // Media, a lens and a filter that reaches over the image's border.
    compare_with_path(foggy_ball, settings, metropolis(8, 20000), 12, 128,
                      {"C.*", "C<Ts>V<Ts>[LB]", "C<Ts>VV+<Ts>[LB]", "C<RD>[LB]", "C<RD><Ts>V.*"});
}

TEST_CASE("Metropolis over bidirectional paths finds the path tracer's image, word by word",
          "[pssmlt][bdpt][render][statistical][gate]") {
    const transport::RenderSettings settings = compared(4);
    compare_with_path(
        room, settings, metropolis_over("bdpt", 40), 12, 96,
        {"C.*", "CL", "C<RD>L", "C<.S>+B", "C<RD><.S>+L", "C<RD><RD>+[LB]", "C<RG>.*L", "C<RD><.G>.*[LB]"});
    compare_with_path(foggy_ball, settings, metropolis_over("bdpt", 8), 12, 96,
                      {"C.*", "C<Ts>V<Ts>[LB]", "C<Ts>VV+<Ts>[LB]", "C<RD>[LB]", "C<RD><Ts>V.*"});
}

TEST_CASE("Metropolis has surfaces say of themselves what the path tracer has them say",
          "[pssmlt][bdpt][render][statistical][gate]") {
    transport::RenderSettings settings = compared(3);
    for (const char* expression : {"C.*", "CU2L", "CDU2L", "C<RS>U2L", "CDU6L"})
        settings.channels.list.push_back(lpe_channel("c" + std::to_string(settings.channels.list.size()), expression));
    for (const char* integrator : {"path", "bdpt"})
        compare_with_path(scene_of(room), settings, metropolis_over(integrator, 40), 12, 96);
}

TEST_CASE("Metropolis with channels for a target keeps every channel's mean, and spends its steps on them",
          "[pssmlt][render][statistical][gate]") {
    const std::string over = GENERATE("path", "bdpt");
    transport::RenderSettings settings;
    settings.paths.max_depth = 4;
    settings.samples.per_pixel = 256;
    settings.film.resolution = {{18, 18}};
    transport::SceneEntity aimed = metropolis(40, 20000);
    aimed.parameters.parameters.push_back(text_parameter("integrator", over));
    transport::SceneEntity plain = aimed;
    aimed.parameters.parameters.push_back(text_parameter("target", "c1"));
    // Large steps alone bring what the target takes nothing of.
    const std::vector<std::string> words{"C.*", "C<RD><.S>+L", "C<RD>L", "C<RD><RD>+[LB]"};
    compare_with_path(room, settings, aimed, 12, 96, words);

    settings.machine.threads = 2;
    settings.channels.beauty = false;
    settings.samples.per_pixel = 64;
    for (const std::string& each : words)
        settings.channels.list.push_back(osl("c" + std::to_string(settings.channels.list.size()), each));
    auto built = transport::BuiltScene::build(scene_of(room));
    REQUIRE(built.ok());
    settings.paths.integrator = aimed;
    const Replicates with = replicates(**built, settings, 4, 12, 900);
    settings.paths.integrator = plain;
    const Replicates without = replicates(**built, settings, 4, 12, 900);
    constexpr std::size_t blocks = blocks_across * blocks_across;
    double of_aimed = 0, of_plain = 0;
    for (std::size_t b = blocks; b < 2 * blocks; ++b) {
        of_aimed += with.variance(b);
        of_plain += without.variance(b);
    }
    CAPTURE(of_aimed, of_plain);
    // The caustic is 2 % of the light, so steps aimed at it leave far less variance; a factor of 2 is F's 0.1 %
    // quantile for nine blocks of eleven degrees of freedom each, were they independent.
    CHECK(2 * of_aimed < of_plain);
}

TEST_CASE("Metropolis keeps the laws: splits sum, asking changes nothing, threads neither",
          "[pssmlt][render][law1][law2][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 20;
    settings.paths.integrator = metropolis(30, 5000);
    settings.machine.threads = 3;
    const auto alone = render_of(scene, settings);
    settings.channels.list = {osl("direct", "C<RD>L"), osl("caustic", "C<RD><.S>+L"), osl("seen", "C[LB]"),
                              osl("rest", "")};
    settings.channels.list[3].rest_of = {0, 1, 2};
    const auto three = render_of(scene, settings);
    settings.machine.threads = 1;
    const auto one = render_of(scene, settings);
    // The start-up's 5000 paths are in none of it.
    CHECK(one.frame_buffer.light_path_count() == 24 * 24 * 20);
    CHECK(one.statistics.camera_samples == 24 * 24 * 20);
    for (display::ChannelId id = 0; id < 5; ++id) CHECK(one.frame_buffer.resolve(id) == three.frame_buffer.resolve(id));
    CHECK(one.frame_buffer.resolve(0) == alone.frame_buffer.resolve(0));
    std::array<std::vector<double>, 5> layers;
    for (std::size_t id = 0; id < 5; ++id) layers[id] = one.frame_buffer.resolve(static_cast<display::ChannelId>(id));
    std::array<double, 5> light{};
    for (std::size_t i = 0; i < layers[0].size(); ++i) {
        double sum = 0, magnitude = layers[0][i];
        for (std::size_t id = 0; id < 5; ++id) light[id] += layers[id][i];
        for (std::size_t id = 1; id < 5; ++id) {
            sum += layers[id][i];
            magnitude += layers[id][i];
        }
        CHECK(std::abs(sum - layers[0][i]) <= 1e-12 * magnitude);
    }
    for (const double each : light) CHECK(each > 0);
}

TEST_CASE("a Metropolis start-up that finds no light, and one of which nothing is left over", "[pssmlt][render]") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    settings.paths.integrator = metropolis(4, 1000);
    const auto dark = render_of(scene_of(film + R"(
WorldBegin
Material "diffuse"
Shape "sphere" "float radius" 1
)"),
                                settings);
    for (const double value : dark.frame_buffer.resolve(0)) CHECK(value == 0);
    // What scatters nowhere is the camera rays' alone: bit for bit the path tracer's image, had the start-up left
    // nothing.
    const auto scene = scene_of(room);
    settings.paths.max_depth = 0;
    const auto metropolis_image = render_of(scene, settings);
    settings.paths.integrator = integrator_named("path");
    CHECK(metropolis_image.frame_buffer.resolve(0) == render_of(scene, settings).frame_buffer.resolve(0));
}

TEST_CASE("Metropolis runs no chains for channels that camera rays serve alone", "[pssmlt][render][pruning][law4]") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 4;
    settings.channels.beauty = false;
    settings.paths.integrator = metropolis(4, 1000);
    settings.channels.list = {lpe_channel("seen", "CL")};
    const auto scene = scene_of(room);
    const auto pruned = render_of(scene, settings);
    CHECK(pruned.statistics.camera_rays == pruned.statistics.camera_samples);
    CHECK(pruned.statistics.pruned[static_cast<std::size_t>(transport::Pruned::paths)] ==
          pruned.statistics.camera_samples);
    settings.paths.prune = false;
    const auto whole = render_of(scene, settings);
    CHECK(whole.statistics.camera_rays >= whole.statistics.camera_samples + 1000);
    CHECK(pruned.frame_buffer.resolve(0) == whole.frame_buffer.resolve(0));
    // Nor where nothing is asked of light, or nothing scatters; what nobody left out is not counted.
    settings.paths.prune = true;
    const auto counts = [&](std::uint64_t pruned_paths) {
        const transport::RenderStatistics statistics = render_of(scene, settings).statistics;
        CHECK(statistics.camera_rays == statistics.camera_samples);
        CHECK(statistics.pilot_rays == 0);
        CHECK(statistics.pruned[static_cast<std::size_t>(transport::Pruned::paths)] == pruned_paths);
    };
    counts(pruned.statistics.camera_samples);
    settings.paths.max_depth = 0;
    counts(0);
    settings.channels.beauty = true;
    counts(0);
    settings.channels.beauty = false;
    settings.paths.max_depth.reset();
    settings.channels.list = {aov("z")};
    counts(0);
    settings.channels.list = {lpe_channel("seen", "CL"), lpe_channel("lit", "C<RD>L")};
    CHECK(render_of(scene, settings).statistics.camera_rays >= whole.statistics.camera_samples + 1000);
}

TEST_CASE("a Metropolis start-up counts as preparation, not as rendering", "[pssmlt][render]") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 1;
    settings.machine.threads = 1;
    settings.paths.integrator = metropolis(4, 100'000);
    const auto statistics = render_of(scene_of(room), settings).statistics;
    // Thirty times as many paths before the image as for it.
    REQUIRE(100'000 >= 30 * statistics.camera_samples);
    CHECK(statistics.prepare_cpu_seconds > statistics.render_cpu_seconds);
    CHECK(statistics.render_cpu_seconds >= 0);
}

TEST_CASE("what Metropolis cannot do is refused by name", "[pssmlt][render][law7]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.paths.integrator = metropolis(4, 1000);
    const auto error = [&] {
        const auto output = transport::render(scene, settings);
        return output.ok() ? std::string() : output.error().to_string();
    };
    settings.samples.only = transport::SampleChoice{.x = 3, .y = 3};
    CHECK(error().find("'pssmlt' cannot render a single sample") != std::string::npos);
    settings.samples.only.reset();
    settings.samples.per_pixel = 32;
    settings.samples.first = 16;
    CHECK(error().find("a shard of a render by Markov chains") != std::string::npos);
    settings.samples.first = 0;
    settings.stop.limit = transport::SampleLimit{.error = 0.1};
    CHECK(error().find("light paths land anywhere") != std::string::npos);
    settings.stop.limit.reset();
    settings.checkpoint = transport::CheckpointSettings{.file = "pssmlt.checkpoint"};
    CHECK(error().find("'pssmlt' cannot save its state") != std::string::npos);
    settings.checkpoint.reset();
    settings.paths.integrator = metropolis(0, 1000);
    CHECK(error().find("'chains' is 0") != std::string::npos);
    settings.paths.integrator = integrator_named("pssmlt");
    settings.paths.integrator->parameters.parameters = {number_parameter("rrthreshold", -1)};
    CHECK(error().find("'rrthreshold' is -1.000000; expected at most 1") != std::string::npos);
    for (const auto& [name, value, expected] :
         {std::tuple{"integrator", "lighttracer", "expected path or bdpt"},
          std::tuple{"target", "a,,b", "expected beauty"}, std::tuple{"target", "glow", "names the channel 'glow'"}}) {
        settings.paths.integrator = metropolis(4, 1000);
        settings.paths.integrator->parameters.parameters.push_back(text_parameter(name, value));
        CHECK(error().find(expected) != std::string::npos);
    }
}
