// Filter mode splat in whole renders: the laws, and the same mean image as importance mode.
#include "transport/render_support.h"

using namespace render_test;

namespace {

transport::SceneEntity filter_named(const std::string& name) {
    transport::SceneEntity entity;
    entity.type = name;
    return entity;
}

display::ChannelDefinition split(const std::string& name, const std::string& expression) {
    display::ChannelDefinition channel = lpe_channel(name, expression);
    channel.statistics = false;
    return channel;
}

}  // namespace

TEST_CASE("splatted images have the same bits for any number of threads and channels, and their splits sum",
          "[splat][render][law1][law2][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 20;
    settings.film.splat = true;
    settings.film.filter = filter_named("mitchell");
    settings.machine.threads = 3;
    const auto alone = render_of(scene, settings);
    CHECK(alone.used.splat);
    CHECK(alone.statistics.camera_samples == (24 + 4) * (24 + 4) * 20);  // the kernel reaches 2 pixels around the image
    settings.channels.list = {split("direct", "C<RD>[<L.>O]"), split("rest", "")};
    settings.channels.list[1].rest_of = {0};
    const auto three = render_of(scene, settings);
    settings.machine.threads = 1;
    const auto one = render_of(scene, settings);
    for (display::ChannelId id = 0; id < 3; ++id) CHECK(one.frame_buffer.resolve(id) == three.frame_buffer.resolve(id));
    CHECK(one.frame_buffer.resolve(0) == alone.frame_buffer.resolve(0));
    CHECK(one.frame_buffer.resolve_alpha() == alone.frame_buffer.resolve_alpha());
    const std::vector<double> whole = one.frame_buffer.resolve(0), a = one.frame_buffer.resolve(1),
                              b = one.frame_buffer.resolve(2);
    double light = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        light += whole[i];
        CHECK(std::abs(a[i] + b[i] - whole[i]) <= 1e-12 * (std::abs(a[i]) + std::abs(b[i]) + std::abs(whole[i])));
    }
    CHECK(light > 0);
}

// Per pixel over independent seeds: the share of the quad in either mode, and Welch's t of the two means. If the share
// is so close to 0 or 1 that few samples of importance mode differ, their scatter is no estimate, and the share itself
// is compared: it is a count of N = 24 x 64 samples. With 64 samples a pixel, the bias of a ratio of sums, one over the
// number of samples in reach, is a tenth of a standard error.
TEST_CASE("splat and importance mode agree in the mean, at edges and borders too",
          "[splat][render][statistical][gate]") {
    // A bright quad across the image's border, on a dark sky: modes would differ at edges and borders.
    const auto scene = scene_of(R"(
Film "rgb" "integer xresolution" 24 "integer yresolution" 24
Sampler "independent" "integer pixelsamples" 64
Integrator "path" "integer maxdepth" 1
LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" 39
WorldBegin
LightSource "infinite" "rgb L" [0.1 0.2 0.3]
AreaLightSource "diffuse" "rgb L" [2 1 3]
Material "diffuse" "rgb reflectance" [0 0 0]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 -0.71 0 0.37 -0.71 0 0.57 0.57 0 -3 0.67 0]
)");
    constexpr std::uint64_t seeds = 24;
    for (const char* name : {"gaussian", "triangle"}) {
        CAPTURE(name);
        std::array<std::vector<double>, 2> sum, square;
        for (const std::size_t mode : {0u, 1u})
            for (std::uint64_t seed = 0; seed < seeds; ++seed) {
                transport::RenderSettings settings;
                settings.samples.seed = 1 + 2 * seed + mode;
                settings.film.splat = mode == 1;
                settings.film.filter = filter_named(name);
                const auto output = render_of(scene, settings);
                const std::vector<double> image = output.frame_buffer.resolve(output.beauty);
                sum[mode].resize(image.size());
                square[mode].resize(image.size());
                for (std::size_t i = 0; i < image.size(); ++i) {
                    sum[mode][i] += image[i];
                    square[mode][i] += image[i] * image[i];
                }
            }
        double worst = 0, squares = 0;
        int uncertain = 0;
        for (std::size_t i = 1; i < sum[0].size(); i += 3) {  // green; the others use the same hits
            double difference = 0, variance = 0;
            const double share = (sum[1][i] / seeds - 0.2) / (1 - 0.2);
            for (const std::size_t mode : {0u, 1u}) {
                const double mean = sum[mode][i] / seeds;
                difference += mode == 0 ? mean : -mean;
                variance += std::max(0.0, square[mode][i] / seeds - mean * mean) / (seeds - 1);
            }
            constexpr double count = seeds * 64;
            const double rare = std::min(share, 1 - share);
            // Fewer than 31 such samples: 6 standard deviations of a Poisson count, and one sample for counts near 0.
            if (rare < 0.02) {
                CHECK(std::abs(difference) / 0.8 <= 6 * std::sqrt(std::max(rare, 1 / count) / count) + 1 / count);
                continue;
            }
            const double z = difference / std::sqrt(variance);
            worst = std::max(worst, std::abs(z));
            squares += z * z;
            ++uncertain;
        }
        CAPTURE(worst, uncertain);
        CHECK(uncertain > 40);
        // t with 2 x 23 degrees of freedom: 5.2 is as rare as 4.5 for a normal deviate.
        CHECK(worst < 5.2);
        // The mean square of t is 46 / 44. 4 times its standard error over `uncertain` pixels, a few of which share
        // samples.
        CHECK(squares / uncertain < 46.0 / 44 + 4 * std::sqrt(3 * 2.2 / uncertain));
    }
}

TEST_CASE("features that splat mode does not support are refused by name", "[splat][render][law7]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.film.splat = true;
    const auto error = [&] {
        const auto output = transport::render(scene, settings);
        return output.ok() ? std::string() : output.error().to_string();
    };
    settings.channels.statistics = {*display::parse_statistic_request("beauty", "mse", {"job.toml", 3, 1})};
    CHECK(error().find("job.toml:3:1") != std::string::npos);
    CHECK(error().find("filter mode splat") != std::string::npos);
    settings.channels.statistics.clear();
    settings.channels.list = {lpe_channel("a", "CDL")};
    CHECK(error().find("'a' keeps statistics") != std::string::npos);
    settings.channels.list.clear();
    settings.mattes.kinds = {raylex::geoaovs::MatteKind::object};
    CHECK(error().find("cryptomatte") != std::string::npos);
    settings.mattes.kinds.clear();
    settings.film.filter = filter_named("box");
    Parameter radius;
    radius.name = "xradius";
    radius.numbers = {17};
    settings.film.filter->parameters.parameters = {radius};
    CHECK(error().find("reaches farther than 16 pixels") != std::string::npos);
}
