// Compares renders by different integrators through replicates: independent seeds give the standard errors, so that no
// independence of the samples of one render is assumed (light paths reach many pixels, chains are correlated).
#pragma once

#include <algorithm>
#include <array>

#include "transport/render_support.h"

namespace render_test {

/// Means of every expression channel over blocks of pixels, for each seed.
struct Replicates {
    std::vector<std::vector<double>> of_seed;  // [seed][channel * blocks + block]

    [[nodiscard]] double mean(std::size_t i) const {
        double sum = 0;
        for (const auto& each : of_seed) sum += each[i];
        return sum / static_cast<double>(of_seed.size());
    }
    /// The variance of the mean with index `i`.
    [[nodiscard]] double variance(std::size_t i) const {
        const double m = mean(i);
        double squares = 0;
        for (const auto& each : of_seed) squares += (each[i] - m) * (each[i] - m);
        const double n = static_cast<double>(of_seed.size());
        return squares / (n * (n - 1));
    }
    /// The sum of the variances over all blocks of all channels.
    [[nodiscard]] double sum_of_variances() const {
        double sum = 0;
        for (std::size_t i = 0; i < of_seed[0].size(); ++i) sum += variance(i);
        return sum;
    }
    /// A channel's mean over the image, with blocks of equal size, and its standard error: blocks of one seed are
    /// correlated.
    [[nodiscard]] Estimate channel(std::size_t index) const;
};

inline constexpr int blocks_across = 3;

inline Estimate Replicates::channel(std::size_t index) const {
    constexpr std::size_t blocks = blocks_across * blocks_across;
    Replicates whole;
    for (const std::vector<double>& each : of_seed) {
        double sum = 0;
        for (std::size_t b = 0; b < blocks; ++b) sum += each[index * blocks + b];
        whole.of_seed.push_back({sum / blocks});
    }
    return {whole.mean(0), std::sqrt(whole.variance(0))};
}

/// Appends the means of a channel's color over each block of pixels to `means`.
inline void append_block_means(const transport::RenderOutput& output, int channel, int color,
                               std::vector<double>& means) {
    const std::vector<double> image = output.frame_buffer.resolve(channel);
    std::vector<double> sum(blocks_across * blocks_across), count(blocks_across * blocks_across);
    for (int y = 0; y < output.view.height; ++y)
        for (int x = 0; x < output.view.width; ++x) {
            const auto block = static_cast<std::size_t>(y * blocks_across / output.view.height * blocks_across +
                                                        x * blocks_across / output.view.width);
            sum[block] +=
                image[3 * static_cast<std::size_t>(y * output.view.width + x) + static_cast<std::size_t>(color)];
            ++count[block];
        }
    for (std::size_t b = 0; b < sum.size(); ++b) means.push_back(sum[b] / count[b]);
}

/// Replicates of `channels` expression channels from id 0, in one colour (green), or in red, green and blue one after
/// another (-1). The seeds are first_seed, first_seed + 1, ...
inline Replicates replicates(const transport::BuiltScene& scene, transport::RenderSettings settings, int channels,
                             int seeds, std::uint64_t first_seed, int color = 1) {
    Replicates result;
    for (int i = 0; i < seeds; ++i) {
        settings.samples.seed = first_seed + static_cast<std::uint64_t>(i);
        auto output = transport::render(scene, settings);
        INFO((output ? std::string() : output.error().to_string()));
        REQUIRE(output.ok());
        CHECK(output->statistics.invalid_samples == 0);
        std::vector<double>& means = result.of_seed.emplace_back();
        for (int channel = 0; channel < channels; ++channel)
            for (int c = 0; c < 3; ++c)
                if (color == c || color == -1) append_block_means(*output, channel, c, means);
    }
    return result;
}

/// Merges blocks in which some seed found nothing, which are too rare for error estimates from a dozen seeds, with the
/// brightest block of their channel.
inline void pool_rare_blocks(Replicates& a, Replicates& b) {
    constexpr std::size_t blocks = blocks_across * blocks_across;
    for (std::size_t first = 0; first < a.of_seed[0].size(); first += blocks) {
        std::size_t brightest = first;
        for (std::size_t i = first; i < first + blocks; ++i)
            if (a.mean(i) > a.mean(brightest)) brightest = i;
        for (std::size_t i = first; i < first + blocks; ++i) {
            const auto nothing = [i](const std::vector<double>& each) { return each[i] == 0; };
            if (i == brightest || (std::none_of(a.of_seed.begin(), a.of_seed.end(), nothing) &&
                                   std::none_of(b.of_seed.begin(), b.of_seed.end(), nothing)))
                continue;
            for (Replicates* side : {&a, &b})
                for (std::vector<double>& each : side->of_seed) {
                    each[brightest] += each[i];
                    each[i] = 0;
                }
        }
    }
}

/// Welch's t for each channel and block of two equally long sets of replicates. With n = 12 seeds it has 11 to 22
/// degrees of freedom: |t| exceeds 7 at most once in 44,000 comparisons, and t^2 has a mean of at most 11 / 9.
inline void check_agreement(Replicates a, Replicates b, const std::vector<std::string>& names) {
    pool_rare_blocks(a, b);
    constexpr std::size_t blocks = blocks_across * blocks_across;
    double squares = 0;
    int compared = 0;
    for (std::size_t i = 0; i < a.of_seed[0].size(); ++i) {
        const double variance = a.variance(i) + b.variance(i), difference = a.mean(i) - b.mean(i);
        INFO(names[i / blocks] << " block " << i % blocks << ": " << a.mean(i) << " +- " << std::sqrt(a.variance(i))
                               << " and " << b.mean(i) << " +- " << std::sqrt(b.variance(i)));
        if (variance == 0) {
            CHECK(difference == 0);
            continue;
        }
        const double t = difference / std::sqrt(variance);
        CHECK(std::abs(t) < 7);
        squares += t * t;
        ++compared;
    }
    REQUIRE(compared > 0);
    CAPTURE(compared);
    // Blocks and channels share paths, so the mean square of t varies more than for independent ones. The limit uses
    // twice its variance of 2 and a half at the 11 degrees of freedom of one side alone.
    CHECK(squares / compared < 11.0 / 9 + 4.5 * std::sqrt(2 * 2.5 / compared));
}

/// The |t| that Student's t with `dof` degrees of freedom exceeds in any of `tests` tests once in a thousand (Sidak).
/// Its tail beyond sqrt(dof) tan(x) is an integral of cos^(dof - 1) from x to pi / 2.
inline double student_threshold(int dof, std::size_t tests) {
    const double each = -std::expm1(std::log1p(-0.001) / static_cast<double>(tests));
    const double right = std::acos(0.0);
    const double scale = std::sqrt(2 / right) * std::exp(std::lgamma((dof + 1) / 2.0) - std::lgamma(dof / 2.0));
    const auto tail = [&](double from) {
        constexpr int steps = 2000;
        double sum = 0;
        for (int i = 0; i < steps; ++i) sum += std::pow(std::cos(from + (i + 0.5) * (right - from) / steps), dof - 1);
        return scale * sum * (right - from) / steps;
    };
    double low = 0, high = right;
    for (int i = 0; i < 50; ++i) {
        const double middle = (low + high) / 2;
        (tail(middle) > each ? low : high) = middle;
    }
    return std::sqrt(static_cast<double>(dof)) * std::tan(low);
}

/// A channel and its expected mean.
struct ClosedForm {
    std::string expression;
    double value;
};

/// Compares channels from id 0 with their closed forms, with errors from the seeds, as some of `tests` tests in all.
/// `largest_error` is relative and keeps the check strict. An expected 0 must be exact.
inline void check_closed_forms(const Replicates& found, const std::vector<ClosedForm>& expected, std::size_t tests,
                               double largest_error) {
    const double threshold = student_threshold(static_cast<int>(found.of_seed.size()) - 1, tests);
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const Estimate e = found.channel(i);
        const double value = expected[i].value;
        INFO(expected[i].expression << ": " << e.mean << " +- " << e.error << ", expected " << value << "; at most "
                                    << threshold << " errors");
        if (value == 0) {
            CHECK(e.mean == 0);
            continue;
        }
        // Products of up to a dozen floats, and directions with relative errors of up to 2^-20.
        CHECK(std::abs(e.mean - value) <= threshold * e.error + 1e-5 * value);
        CHECK(e.error <= largest_error * value);
    }
}

inline transport::SceneEntity integrator_named(const std::string& type) {
    transport::SceneEntity entity;
    entity.type = type;
    return entity;
}

inline transport::SceneEntity metropolis(int chains, int bootstrap_samples) {
    transport::SceneEntity entity = integrator_named("pssmlt");
    entity.parameters.parameters = {number_parameter("chains", chains),
                                    number_parameter("bootstrapsamples", bootstrap_samples)};
    return entity;
}

/// An expression channel without statistics, which integrators that splat anywhere do not support.
inline display::ChannelDefinition osl(const std::string& name, const std::string& expression) {
    display::ChannelDefinition channel = lpe_channel(name, expression);
    channel.dialect = raylex::lpe::Dialect::osl;
    channel.statistics = false;
    return channel;
}

/// Compares each channel of settings.channels.list with the path tracer, which takes settings.samples.per_pixel. Every
/// channel must find light.
inline void compare_with_path(const transport::SceneDescription& scene, transport::RenderSettings settings,
                              const transport::SceneEntity& other, int seeds, std::uint64_t other_samples,
                              int color = 1) {
    std::vector<std::string> expressions;
    for (const display::ChannelDefinition& channel : settings.channels.list) expressions.push_back(channel.expression);
    auto built = transport::BuiltScene::build(scene);
    REQUIRE(built.ok());
    const int channels = static_cast<int>(expressions.size());
    settings.machine.threads = 2;
    settings.channels.beauty = false;
    settings.paths.integrator = integrator_named("path");
    const Replicates path = replicates(**built, settings, channels, seeds, 100, color);
    settings.paths.integrator = other;
    settings.samples.per_pixel = other_samples;
    const Replicates tested = replicates(**built, settings, channels, seeds, 500, color);
    check_agreement(path, tested, expressions);
    for (std::size_t c = 0; c < expressions.size(); ++c) {  // a black channel would agree with anything
        const Estimate e = tested.channel(c);
        CAPTURE(expressions[c], e.mean, e.error);
        CHECK(std::abs(e.mean) > 10 * e.error);
    }
}

/// Compares expressions in the osl dialect with the path tracer.
inline void compare_with_path(const std::string& text, transport::RenderSettings settings,
                              const transport::SceneEntity& other, int seeds, std::uint64_t other_samples,
                              const std::vector<std::string>& expressions, int color = 1) {
    settings.channels.list.clear();
    for (const std::string& each : expressions)
        settings.channels.list.push_back(osl("c" + std::to_string(settings.channels.list.size()), each));
    compare_with_path(scene_of(text), std::move(settings), other, seeds, other_samples, color);
}

inline const std::string plain_film = R"(
Film "rgb" "integer xresolution" 18 "integer yresolution" 18
Sampler "independent" "integer pixelsamples" 64
)";

/// Shading normals, a lens, a cutout and every kind of light. It contains a mirror ball's caustic of the sky; coarse
/// meshes shaded smoothly, whose shading and geometric normals differ by up to 55 degrees; rough glass, whose
/// scattering is not symmetric; a cutout between camera and floor; a wide lens focused on the floor; and a filter with
/// negative lobes that reaches across the image's border.
inline std::string many_lights() {
    const std::string octahedron = R"(
Shape "trianglemesh" "integer indices" [4 0 2 4 2 1 4 1 3 4 3 0 5 2 0 5 1 2 5 3 1 5 0 3]
    "point3 P" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1] "normal N" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1]
)";
    return plain_film + R"(
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
)";
}

}  // namespace render_test
