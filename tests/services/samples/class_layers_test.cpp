// The beauty of a class of paths beside channels: they never change its bits, and a partition of the class sums to it,
// also where a path is in more states than a tracker or a suffix keeps.
#include <bit>
#include <cmath>
#include <optional>

#include <catch2/catch.hpp>

#include "display/services/liveness/path_suffix.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::Classes;
using test::expression_channel;
using test::join;
using test::Random;

constexpr int cuts = 5;

/// A class, and layers that partition it: parts of the class by `layers`, then the rest.
struct ClassRender {
    std::vector<ChannelDefinition> channels;
    LpeSetup setup;
    Classes classes;
    std::optional<lpe::ReversedProgram> of_class, of_all;

    ClassRender(const std::string& paths, const std::vector<std::string>& layers)
        : channels(list(paths, layers)),
          setup(test::build_setup(channels, invalid_channel, {.first_alone = true})),
          classes(setup) {
        of_class.emplace(*lpe::ReversedProgram::build(setup.main()));
        of_all.emplace(*lpe::ReversedProgram::build(setup.program()));
    }
    static std::vector<ChannelDefinition> list(const std::string& paths, const std::vector<std::string>& layers) {
        std::vector<ChannelDefinition> channels{expression_channel("beauty", paths)};
        std::string parts;
        for (const std::string& layer : layers) {
            channels.push_back(expression_channel(join({"p", std::to_string(channels.size())}),
                                                  join({"(", layer, ")&(", paths, ")"})));
            parts += join({parts.empty() ? "(" : "|(", layer, ")"});
        }
        if (!layers.empty()) channels.push_back(expression_channel("rest", join({"(", paths, ")-(", parts, ")"})));
        return channels;
    }

    /// Contributes white light along a path of vertices with two lobes, the first `of_camera` forward and the others
    /// from the light, and returns the values of all channels. `probability`: of the diffuse lobe at each vertex.
    [[nodiscard]] std::vector<double> trace(
        const std::vector<Rgb>& probability, std::size_t of_camera, std::uint64_t sample, bool reverses_layers,
        std::uint64_t& overflow, LpeServices::Attribution attribution = LpeServices::Attribution::exact) const {
        SampleTable table(channels, 1);
        table.begin(test::pixel_rows(1, 2, sample, 1));
        LpeServices services(setup, table, 9, attribution);
        PathSuffixes pool(&*of_class);
        if (setup.has_layers()) pool.add_layers(reverses_layers ? &*of_all : nullptr);
        const auto parts = [&](std::size_t k) {
            return std::array<LobePart, 2>{
                {{classes.diffuse, probability[k]}, {classes.glossy, Rgb(1) - probability[k]}}};
        };
        Tracker tracker = services.begin(0);
        for (std::size_t k = 0; k < of_camera; ++k) services.move(tracker, parts(k));
        if (of_camera == probability.size()) {
            services.move(tracker, classes.light);
        } else {
            PathSuffix suffix = services.begin(pool, classes.light);
            for (std::size_t k = probability.size(); k-- > of_camera;)
                suffix = services.prepend(pool, suffix, parts(k), 1000 * k + sample);
            const Tracker copy = tracker;
            tracker = copy;
            services.connect(tracker, pool, suffix);
        }
        services.contribute(Rgb(1), Technique{}, tracker);
        overflow += services.overflow_count();
        std::vector<double> values;
        for (ChannelId id = 0; id < table.channel_count(); ++id)
            values.insert(values.end(), table.raw_values(id), table.raw_values(id) + 3);
        return values;
    }
};

std::vector<Rgb> random_vertices(Random& random, std::size_t length) {
    std::vector<Rgb> vertices;
    const auto component = [&] { return random.below(8) == 0 ? 0.0f : random.uniform_float(); };
    for (std::size_t k = 0; k < length; ++k) vertices.push_back(Rgb(component(), component(), component()));
    return vertices;
}

/// Paths whose number of diffuse scatterings, divided by `divisor`, leaves `remainder`.
std::string counts_diffuse(int divisor, int remainder) {
    std::string some, loop;
    for (int i = 0; i < remainder; ++i) some += "[^D]*D";
    for (int i = 0; i < divisor; ++i) loop += "[^D]*D";
    return join({"C", some, "(", loop, ")*[^D]*L"});
}

std::vector<std::string> layers_by_count(int most) {
    std::vector<std::string> layers;
    for (int i = 0; i < most; ++i) {
        layers.push_back("C");
        for (int k = 0; k < i; ++k) layers.back() += "[^D]*D";
        layers.back() += "[^D]*L";
    }
    return layers;
}

/// A layer for each way to scatter at the first five vertices: 32 states at once.
std::vector<std::string> layers_by_vertex() {
    std::vector<std::string> layers;
    for (unsigned word = 0; word < 32; ++word) {
        layers.push_back("C");
        for (unsigned k = 0; k < 5; ++k) layers.back() += (word >> k & 1U) != 0 ? "D" : "[^D]";
        layers.back() += ".*L";
    }
    return layers;
}

}  // namespace

TEST_CASE("channels never change the bits of a class, and a partition sums to it", "[class][law1][law2][law5]") {
    // The last is in 11 states at once, more than a tracker keeps for a class.
    const std::vector<std::string> classes{
        "C.*L", "CD.*L", "C.*D[^D].*L", "C[^D]+D.*L", "C(DD|[^D][^D]).(D|[^D]D).*L", counts_diffuse(11, 3)};
    const auto attribution = GENERATE(LpeServices::Attribution::exact, LpeServices::Attribution::picked);
    const bool is_exact = attribution == LpeServices::Attribution::exact;
    std::uint64_t overflow = 0;
    for (const std::string& paths : classes) {
        const ClassRender alone(paths, {});
        CHECK_FALSE(alone.setup.has_layers());
        for (const std::vector<std::string>& layers :
             {std::vector<std::string>{"C.D.*L"}, layers_by_count(24), layers_by_vertex()}) {
            INFO(paths << " with " << layers.size() << " layers, the last " << layers.back());
            const ClassRender split(paths, layers);
            REQUIRE(split.setup.has_layers());
            Random random(7);
            int different = 0, lit = 0;
            double worst = 0;
            for (std::uint64_t sample = 0; sample < 60; ++sample) {
                const std::size_t length = 2 + static_cast<std::size_t>(random.below(24));
                const std::vector<Rgb> vertices = random_vertices(random, length);
                for (std::size_t cut = 0; cut <= cuts; ++cut) {
                    const std::size_t of_camera = length * cut / cuts;
                    std::uint64_t of_class = 0;
                    const std::vector<double> beauty =
                        alone.trace(vertices, of_camera, sample, true, of_class, attribution);
                    const std::vector<double> all =
                        split.trace(vertices, of_camera, sample, !is_exact || sample % 2 == 0, overflow, attribution);
                    for (std::size_t c = 0; c < 3; ++c) {
                        double sum = 0;
                        for (std::size_t at = 3 + c; at < all.size(); at += 3) sum += all[at];
                        lit += beauty[c] > 0;
                        different += std::bit_cast<std::uint64_t>(beauty[c]) != std::bit_cast<std::uint64_t>(all[c]);
                        worst = std::max(worst, std::abs(sum - all[c]));
                    }
                }
            }
            CHECK(lit > (is_exact ? 300 : 50));  // a picked path has all of its light or none
            CHECK(different == 0);
            // Each of up to 26 moves rounds the shares, which sum to at most 1, and each is scaled to those of the
            // class.
            CHECK(worst <= 26 * 4 * 0x1p-52);
        }
    }
    CHECK((overflow > 1000) == is_exact);
}

TEST_CASE("overflow beside a class is unbiased", "[class][law5][statistical]") {
    constexpr std::size_t length = 24;
    constexpr int samples = 4000;
    const Rgb probability(0.3f, 0.5f, 0.9f);
    // The class alone is in 11 states, the layers in 25.
    const ClassRender render(counts_diffuse(11, 3), layers_by_count(length + 1));
    const std::vector<Rgb> vertices(length, probability);
    for (const std::size_t of_camera : {length, length / 2}) {
        std::vector<double> sum, squares;
        std::uint64_t overflow = 0;
        for (std::uint64_t sample = 0; sample < samples; ++sample) {
            const std::vector<double> values = render.trace(vertices, of_camera, sample, sample % 2 == 0, overflow);
            sum.resize(values.size());
            squares.resize(values.size());
            for (std::size_t i = 0; i < values.size(); ++i) sum[i] += values[i], squares[i] += values[i] * values[i];
        }
        CHECK(overflow > samples);
        for (std::size_t c = 0; c < 3; ++c) {
            const double p = static_cast<double>(probability[static_cast<int>(c)]);
            double of_class = 0;
            for (std::size_t count = 0; count <= length; ++count) {
                const double binomial = std::exp(std::lgamma(length + 1.0) - std::lgamma(double(count) + 1) -
                                                 std::lgamma(double(length - count) + 1)) *
                                        std::pow(p, double(count)) * std::pow(1 - p, double(length - count));
                const double expected = count % 11 == 3 ? binomial : 0;
                of_class += expected;
                const std::size_t at = 3 * (1 + count) + c;
                const double mean = sum[at] / samples, error = std::sqrt(squares[at] / samples / samples);
                if (binomial < 1e-4) continue;  // too few samples find it for a standard error
                INFO("colour " << c << ", count " << count << ", " << mean << " of " << expected);
                // 150 comparisons: one of them is outside of 5 standard errors with probability 1e-4. Probabilities
                // in float, to the power of 24, are off by less than 1e-5 of a value.
                CHECK(std::abs(mean - expected) <= 5 * error + 1e-5 * expected);
            }
            const double mean = sum[c] / samples, error = std::sqrt(squares[c] / samples / samples);
            CHECK(std::abs(mean - of_class) <= 5 * error + 1e-5 * of_class);
        }
    }
}

}  // namespace raylex::display
