#include "experiments/invariants/scene_under_test.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/invariants/random_expression.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/film.h"

namespace raylex::experiments {
namespace {

display::ChannelDefinition layer(const std::string& name, const std::string& expression) {
    display::ChannelDefinition channel;
    channel.name = name;
    channel.style = display::ChannelStyle::expression;
    channel.expression = expression;
    channel.statistics = false;
    return channel;
}

/// Returns expressions that match every path of light exactly once: fixed ones, or a random one and its complement.
std::vector<std::string> partition(std::uint64_t seed) {
    static const std::array<std::vector<std::string>, 3> ready{{
        {"C[LO]", "C.[LO]", "C..+[LO]"},
        {"C<RD>.*", "C<TD>.*", "C<R[GS]>.*", "C<T[GS]>.*", "CV.*", "C[LO]"},
        {"C.*B", "C.*O", "C.*<L.>-C.*B"},
    }};
    if (seed % 2 == 0) return ready[seed / 2 % ready.size()];
    const std::string taken = random_expression(seed);
    return {taken, "C.*[LO]-(" + taken + ")"};
}

/// Returns a smaller resolution if the film has too many pixels.
std::optional<std::array<int, 2>> small_enough(const transport::BuiltScene& built, int most_pixels) {
    std::vector<Error> warnings;
    const auto film = transport::read_film(built.film, std::nullopt, warnings);
    if (!film) return std::nullopt;
    const double pixels = double(film->width) * film->height;
    if (pixels <= most_pixels) return std::nullopt;
    const double ratio = std::sqrt(most_pixels / pixels);
    const auto less = [ratio](int size) { return std::max(1, static_cast<int>(size * ratio)); };
    return std::array<int, 2>{less(film->width), less(film->height)};
}

}  // namespace

Result<SceneUnderTest> SceneUnderTest::make(const std::string& text, const std::string& path,
                                            const InvariantOptions& options) {
    SceneUnderTest test(options);
    test.path = path;
    auto scene = transport::import_pbrt_text(text, path);
    if (!scene) return scene.error();
    test.scene = std::move(*scene);
    auto built = transport::BuiltScene::build(test.scene, {.threads = 1});
    if (!built) return built.error();
    test.built = std::move(*built);
    const auto samples = test.scene.sampler.parameters.integer_or("pixelsamples", 16);
    test.settings.samples.per_pixel =
        samples ? static_cast<std::uint64_t>(std::clamp<std::int64_t>(*samples, 1, options.most_samples)) : 1;
    test.settings.film.resolution = small_enough(*test.built, options.most_pixels);
    test.settings.machine.threads = 1;
    test.settings.samples.seed = options.seed;
    for (const std::string& expression : partition(options.seed))
        test.settings.channels.list.push_back(
            layer("layer" + std::to_string(test.settings.channels.list.size()), expression));
    test.layers = test.settings.channels.list.size();
    // Some seeds also use other features of a render.
    test.settings.film.splat = options.seed % 7 == 3;
    test.settings.labels.picked_lobes = options.seed % 11 == 5;
    static constexpr std::array<const char*, 6> aovs{"Nn", "z", "Pw", "curvature", "albedo", "sampleCount"};
    if (options.seed % 5 == 2) {
        display::ChannelDefinition channel;
        channel.name = aovs[options.seed / 5 % aovs.size()];
        channel.style = display::ChannelStyle::name;
        test.settings.channels.list.push_back(channel);
    }
    auto output = transport::render(*test.built, test.settings);
    if (!output) return output.error();
    test.output = std::make_shared<const transport::RenderOutput>(std::move(*output));
    return test;
}

double difference(const transport::RenderOutput& a, const transport::RenderOutput& b) {
    const double none = std::numeric_limits<double>::infinity();
    if (a.frame_buffer.channels().size() != b.frame_buffer.channels().size()) return none;
    double worst = 0;
    for (std::size_t id = 0; id < a.frame_buffer.channels().size(); ++id) {
        const auto x = a.frame_buffer.resolve(static_cast<display::ChannelId>(id));
        const auto y = b.frame_buffer.resolve(static_cast<display::ChannelId>(id));
        if (x.size() != y.size()) return none;
        double largest = 0, apart = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (std::isfinite(x[i]) != std::isfinite(y[i])) return none;
            if (!std::isfinite(x[i])) continue;
            largest = std::max({largest, std::abs(x[i]), std::abs(y[i])});
            apart = std::max(apart, std::abs(x[i] - y[i]));
        }
        if (apart > 0) worst = std::max(worst, apart / largest);
    }
    return worst;
}

}  // namespace raylex::experiments
