// A channel for each of many objects: bit-parallel automata (lpe/program_view.h), and pruned like any other (Law 4).
#include "display/services/samples/lpe_services.h"
#include "transport/replicates.h"

using namespace render_test;

namespace {

constexpr std::size_t balls = 24;

/// Labelled balls on a floor under five lamps, the first of them the key.
transport::SceneDescription many_objects() {
    std::string text = film + R"(
Integrator "path" "integer maxdepth" 5
LookAt 0 3 -5  0 0.3 0  0 1 0
Camera "perspective" "float fov" 45
WorldBegin
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 -3  -3 0 3  3 0 3  3 0 -3]
)";
    for (std::size_t k = 0; k < balls; ++k)
        text += "AttributeBegin\nTranslate " + std::to_string(double(k % 6) * 0.8 - 2) + " 0.3 " +
                std::to_string(double(k / 6) * 0.8 - 1.2) + "\nShape \"sphere\" \"float radius\" 0.3\nAttributeEnd\n";
    for (int lamp = 0; lamp < 5; ++lamp)
        text += "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [8 8 8]\nTranslate " + std::to_string(lamp - 2) +
                " 3 0\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
                "\"point3 P\" [-.2 0 -.2 .2 0 -.2 .2 0 .2 -.2 0 .2]\nAttributeEnd\n";
    auto scene = scene_of(text);
    for (std::size_t k = 0; k < balls; ++k) scene.shapes.at(k + 1).label = "ball" + std::to_string(k);
    scene.area_lights.at(0).group = "key";
    return scene;
}

transport::RenderSettings asking_for_each(const std::string& integrator) {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 8;
    settings.channels.beauty = false;
    settings.paths.integrator.emplace().type = integrator;
    for (std::size_t k = 0; k < balls; ++k) {
        const std::string number = std::to_string(k);
        settings.channels.list.push_back(lpe_channel("c" + number, "C.*<RD'ball" + number + "'>.*<L.'key'>"));
    }
    return settings;
}

}  // namespace

TEST_CASE("channels of many objects are pruned as those of few", "[render][pruning][bit-parallel][law4]") {
    auto built = transport::BuiltScene::build(many_objects());
    REQUIRE(built.ok());
    for (const char* integrator : {"path", "bdpt", "lighttracer"}) {
        CAPTURE(integrator);
        transport::RenderSettings settings = asking_for_each(integrator);
        const auto setup = display::LpeSetup::build(settings.channels.list, display::invalid_channel);
        REQUIRE(setup.ok());
        REQUIRE(setup->program().view().has_parallel());
        constexpr int seeds = 12;
        const Replicates pruned = replicates(**built, settings, balls, seeds, 0);
        settings.samples.seed = 0;
        auto once = transport::render(**built, settings);
        REQUIRE(once.ok());
        const auto left_out = [&](transport::Pruned cause) {
            return once->statistics.pruned[static_cast<std::size_t>(cause)];
        };
        // From the floor, seen by most, no light sample is a word: first a ball must be met.
        if (std::string(integrator) != "lighttracer") CHECK(left_out(transport::Pruned::light_samples) > 0);
        else CHECK(left_out(transport::Pruned::shadow_rays) > 0);
        settings.paths.prune = false;
        const Replicates whole = replicates(**built, settings, balls, seeds, 1000);
        // One lamp of five has a fifth of the choices where all are chosen from. Ratios of variances of 11 degrees of
        // freedom, of which no block has more than a few per cent of the sum, are off by a factor of 2 less than once
        // in 1,000.
        CHECK(pruned.sum_of_variances() * 2 < whole.sum_of_variances());
        std::size_t apart = 0, seen = 0;
        for (std::size_t k = 0; k < balls; ++k) {
            const Estimate a = pruned.channel(k), b = whole.channel(k);
            CAPTURE(k, a.mean, a.error, b.mean, b.error);
            // Of Student's t with at least 11 degrees of freedom, 6 is exceeded once in 10,000: once in 140 of 72.
            CHECK(deviation(a, b) < 6);
            apart += deviation(a, b) > 2.2;  // once in 20
            seen += b.mean > 0;
        }
        CHECK(seen == balls);
        CHECK(apart < 7);  // of 24, once in 2,000
    }
}

TEST_CASE("nothing is traced where no packed channel can find anything", "[render][pruning][bit-parallel][law4]") {
    const auto scene = many_objects();
    transport::RenderSettings settings = asking_for_each("path");
    const auto statistics = [&] { return render_of(scene, settings).statistics; };
    // Nothing in the scene is a mirror, and no lamp is of that group.
    for (const char* end : {"<RS>.*<L.'key'>", "<L.'rim'>"}) {
        CAPTURE(end);
        for (std::size_t k = 0; k < balls; ++k)
            settings.channels.list[k] =
                lpe_channel("c" + std::to_string(k), "C.*<RD'ball" + std::to_string(k) + "'>.*" + end);
        const auto setup = display::LpeSetup::build(settings.channels.list, display::invalid_channel);
        REQUIRE(setup.ok());
        REQUIRE(setup->program().view().has_parallel());
        const auto nothing = statistics();
        CHECK(nothing.scattering_rays == 0);
        CHECK(nothing.shadow_rays == 0);
    }
}
