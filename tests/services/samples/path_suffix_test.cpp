// Words of light subpaths with shares, against the same words followed forward.
#include "display/services/liveness/path_suffix.h"

#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "lpe/shipped.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::build_setup;
using test::Classes;
using test::expression_channel;
using test::plain_channel;
using test::Random;

/// A path of several lobes a vertex, from the camera to a terminal.
struct RandomPath {
    std::vector<std::vector<LobePart>> vertices;
    lpe::EventClass terminal = 0;
};

struct Events {
    std::vector<lpe::EventClass> scattering, terminals;
};

RandomPath random_path(Random& random, const Events& events, int length) {
    const auto any = [&](const std::vector<lpe::EventClass>& from) {
        return from[static_cast<std::size_t>(random.below(static_cast<int>(from.size())))];
    };
    RandomPath path;
    for (int vertex = 0; vertex < length; ++vertex) {
        std::vector<LobePart> parts(static_cast<std::size_t>(1 + random.below(3)));
        for (LobePart& part : parts) {
            const auto component = [&] { return random.below(6) == 0 ? 0.0f : random.uniform_float(); };
            part = {any(events.scattering), Rgb(component(), component(), component())};
        }
        path.vertices.push_back(std::move(parts));
    }
    path.terminal = any(events.terminals);
    return path;
}

/// The first `of_camera` vertices forward, the others from the light.
Tracker follow(LpeServices& services, PathSuffixes& words, int row, const RandomPath& path, std::size_t of_camera) {
    Tracker tracker = services.begin(row);
    for (std::size_t k = 0; k < of_camera; ++k) services.move(tracker, path.vertices[k]);
    PathSuffix word = services.begin(words, path.terminal);
    for (std::size_t k = path.vertices.size(); k-- > of_camera;)
        word = services.prepend(words, word, path.vertices[k], 1000 * k + static_cast<std::size_t>(row));
    services.connect(tracker, words, word);
    return tracker;
}

/// Every cut of random paths: the channels get what they get forward.
void check_against_forward(const std::vector<ChannelDefinition>& channels, const LpeSetup& setup, const Events& events,
                           int longest, const lpe::ReversedProgram* language) {
    PathSuffixes words(language);
    constexpr int paths = 60;
    SampleTable table(channels, paths * (longest + 2));
    table.begin(test::pixel_rows(3, 4, 0, paths * (longest + 2)));
    LpeServices services(setup, table, 5);
    int row = 0, accepted = 0;
    double largest = 0;
    for (int i = 0; i < paths; ++i) {
        Random random(static_cast<std::uint64_t>(i));
        const RandomPath path = random_path(random, events, i % (longest + 1));
        const int forward = row++;
        Tracker tracker = services.begin(forward);
        for (const std::vector<LobePart>& parts : path.vertices) services.move(tracker, parts);
        services.move(tracker, path.terminal);
        services.contribute(Rgb(0.25f, 0.5f, 1), Technique{}, tracker);
        words.clear();
        for (std::size_t of_camera = 0; of_camera <= path.vertices.size(); ++of_camera, ++row) {
            const Tracker joined = follow(services, words, row, path, of_camera);
            CHECK(services.channels_follow(joined) == services.channels_follow(tracker));
            services.contribute(Rgb(0.25f, 0.5f, 1), Technique{}, joined);
            for (ChannelId id = 0; id < table.channel_count(); ++id)
                for (int c = 0; c < 3; ++c) {
                    const double expected = table.raw_values(id)[3 * forward + c];
                    accepted += expected > 0;
                    largest = std::max(largest, std::abs(table.raw_values(id)[3 * row + c] - expected));
                }
        }
    }
    REQUIRE(services.overflow_count() == 0);
    // Shares are products of up to `longest` fractions, summed over at most 24 branches in another order: each rounds
    // at 2^-53 of a share of at most 1.
    CHECK(largest <= (longest + 24) * 0x1p-53);
    CHECK(accepted > 300);
}

/// By reversed automata, and as where a program is too large for these.
void check_both_ways(const std::vector<ChannelDefinition>& channels, const LpeSetup& setup, const Events& events,
                     int longest) {
    const auto reversed = lpe::ReversedProgram::build(setup.program());
    REQUIRE(reversed);
    check_against_forward(channels, setup, events, longest, &*reversed);
    check_against_forward(channels, setup, events, longest, nullptr);
}

Events without_labels(const LpeSetup& setup) {
    const Classes classes(setup);
    return {classes.scattering, classes.terminals};
}

TEST_CASE("a joined path reaches what the whole path reaches, with the same shares", "[path_suffix][law1][law5]") {
    std::vector<ChannelDefinition> shipped{plain_channel("beauty", ChannelType::rgb)};
    for (const lpe::NamedExpression& e : lpe::shipped_partition())
        shipped.push_back(expression_channel(std::string(e.name), std::string(e.expression)));
    const LpeSetup one_table = build_setup(shipped, 0);
    REQUIRE(one_table.program().word_count() == 1);
    check_both_ways(shipped, one_table, without_labels(one_table), 8);

    const std::vector<ChannelDefinition> counting = test::count_diffuse(8);
    lpe::CompileOptions options;
    options.state_cap = 14;
    const LpeSetup groups = build_setup(counting, 0, options);
    REQUIRE(groups.program().word_count() > 1);
    check_both_ways(counting, groups, without_labels(groups), 8);

    std::vector<ChannelDefinition> labels{plain_channel("beauty", ChannelType::rgb)};
    for (int i = 0; i < 40; ++i)
        labels.push_back(expression_channel(test::join({"x", std::to_string(i)}),
                                            test::join({"C.*<RD'", std::to_string(i), "'>.*[<L.>O]"})));
    const LpeSetup packed = build_setup(labels, 0);
    REQUIRE(packed.program().view().has_parallel());
    Events events;
    for (int i = 0; i < 3; ++i)
        for (const lpe::Scatter scatter : {lpe::Scatter::diffuse, lpe::Scatter::glossy})
            events.scattering.push_back(
                packed.classify({lpe::EventType::reflection, scatter, 0, {std::to_string(i), ""}}));
    events.terminals = {packed.classify({lpe::EventType::light, lpe::Scatter::none, 0, {""}})};
    check_both_ways(labels, packed, events, 4);
}

TEST_CASE("a light subpath that no channel makes anything of is dead", "[path_suffix][law4]") {
    const std::vector<ChannelDefinition> channels{expression_channel("direct", "C<RD>L")};
    const LpeSetup setup = build_setup(channels, invalid_channel);
    const Classes classes(setup);
    const auto reversed = lpe::ReversedProgram::build(setup.program());
    REQUIRE(reversed);
    PathSuffixes words(&*reversed);
    SampleTable table(channels, 1);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    LpeServices services(setup, table, 1);
    CHECK_FALSE(services.begin(words, classes.emission).live());
    PathSuffix word = services.begin(words, classes.light);
    REQUIRE(word.live());
    const std::array<LobePart, 2> parts{{{classes.diffuse, Rgb(1)}, {classes.glossy, Rgb(3)}}};
    word = services.prepend(words, word, parts, 0);
    CHECK(word.live());
    CHECK(word.branches() == 1);  // of the diffuse lobe alone
    Tracker tracker = services.begin(0);
    services.connect(tracker, words, word);
    services.contribute(Rgb(8), Technique{}, tracker);
    CHECK(table.values(0)[0] == 2);  // a quarter of what the vertex scatters
    word = services.prepend(words, word, classes.diffuse);
    CHECK_FALSE(word.live());
    Tracker dead = services.begin(0);
    services.connect(dead, words, word);
    CHECK_FALSE(services.channels_follow(dead));
    CHECK_FALSE(services.prepend(words, services.begin(words, classes.light), {}, 0).live());  // scatters nothing
}

/// Means of the channels of count_diffuse(60) for one path of 40 vertices that are diffuse with 0.3, 0.5, 0.9 of each
/// colour, cut in the middle: more branches than a word keeps on either side.
struct Counted {
    std::vector<double> mean, error, largest;  // [channel][colour]
    double worst_sum = 0;
    std::uint64_t overflow = 0;
};

Counted count_by_connections(LpeServices::Attribution attribution, int samples, int length, int of_camera) {
    const std::vector<ChannelDefinition> channels = test::count_diffuse(60);
    const LpeSetup setup = build_setup(channels, 0);
    const Classes classes(setup);
    const auto reversed = lpe::ReversedProgram::build(setup.program());
    REQUIRE(reversed);
    PathSuffixes words(&*reversed);
    Counted result;
    std::vector<double> squares(3 * channels.size(), 0);
    result.mean.assign(3 * channels.size(), 0);
    result.largest = result.mean;
    const std::array<LobePart, 2> parts{
        {{classes.diffuse, Rgb(0.3f, 0.5f, 0.9f)}, {classes.glossy, Rgb(0.7f, 0.5f, 0.1f)}}};
    for (int sample = 0; sample < samples; ++sample) {
        SampleTable table(channels, 1);
        table.begin(test::pixel_rows(1, 2, static_cast<std::uint64_t>(sample), 1));
        LpeServices services(setup, table, 9, attribution);
        words.clear();
        Tracker tracker = services.begin(0);
        for (int k = 0; k < of_camera; ++k) services.move(tracker, parts);
        PathSuffix word = services.begin(words, classes.light);
        for (int k = of_camera; k < length; ++k)
            word = services.prepend(words, word, parts,
                                    static_cast<std::uint64_t>(sample) << 32 | static_cast<unsigned>(k));
        services.connect(tracker, words, word);
        services.contribute(Rgb(1), Technique{}, tracker);
        result.overflow += services.overflow_count();
        for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (ChannelId id = 1; id < table.channel_count(); ++id) {
                const double value = table.raw_values(id)[c];
                sum += value;
                result.mean[static_cast<std::size_t>(3 * id + c)] += value / samples;
                squares[static_cast<std::size_t>(3 * id + c)] += value * value / samples;
                double& largest = result.largest[static_cast<std::size_t>(3 * id + c)];
                largest = std::max(largest, value);
            }
            result.worst_sum = std::max(result.worst_sum, std::abs(sum - 1));
        }
    }
    for (std::size_t i = 0; i < squares.size(); ++i)
        result.error.push_back(std::sqrt(std::max(0.0, squares[i] - result.mean[i] * result.mean[i]) / samples));
    return result;
}

void check_binomial(const Counted& counted, int length, int samples) {
    constexpr std::array<double, 3> diffuse{0.3, 0.5, 0.9};
    const std::array<float, 3> as_float{0.3f, 0.5f, 0.9f};
    for (std::size_t c = 0; c < 3; ++c) {
        const double p = static_cast<double>(as_float[c]) /
                         (static_cast<double>(as_float[c]) + static_cast<double>(std::array{0.7f, 0.5f, 0.1f}[c]));
        REQUIRE(p == Approx(diffuse[c]).epsilon(1e-6));  // 0.3f, 0.5f, 0.9f are rounded
        for (int k = 0; k <= length; ++k) {
            const double truth = std::exp(std::lgamma(length + 1) - std::lgamma(k + 1) - std::lgamma(length - k + 1) +
                                          k * std::log(p) + (length - k) * std::log(1 - p));
            const std::size_t at = 3 * (1 + static_cast<std::size_t>(k)) + c;
            CAPTURE(c, k, truth, counted.mean[at], counted.error[at]);
            // 4 x 123 tests: Sidak at 0.001 asks for 4.9 standard errors. Shares below 1e-4 are drawn too rarely for a
            // normal law: of at most 0.4 draws expected, 7 or more come with a probability of 3e-7. A share that is
            // drawn a few times seems to vary less than it does: draws of one size are Poisson's, of variance truth x
            // size.
            const double size = counted.largest[at] > 0 ? counted.largest[at] : 1;
            const double drawn = counted.error[at] > 1e-12 ? std::sqrt(truth * size / samples) : 0;
            if (truth > 1e-4)
                CHECK(std::abs(counted.mean[at] - truth) <= 4.9 * std::max(counted.error[at], drawn) + 1e-12);
            else CHECK(counted.mean[at] < 7.0 / 4000);
        }
    }
}

TEST_CASE("light words that overflow keep every sum and are unbiased in every share",
          "[path_suffix][law1][law5][statistical][gate]") {
    constexpr int samples = 4000, length = 40;
    for (const int of_camera : {0, 8, 20, 38}) {
        CAPTURE(of_camera);
        const Counted counted = count_by_connections(LpeServices::Attribution::exact, samples, length, of_camera);
        CHECK(counted.overflow >= samples);  // in the join if not before
        CHECK(counted.worst_sum < 1e-12);    // some thousand additions of shares at 2^-53
        check_binomial(counted, length, samples);
    }
}

TEST_CASE("the connections of one camera vertex choose by numbers of their own", "[path_suffix][law5][statistical]") {
    // The same camera subpath, connected with two neighbouring vertices of one light subpath. Neither end overflows,
    // and both connections do.
    constexpr int samples = 2000;
    const std::vector<ChannelDefinition> channels = test::count_diffuse(60);
    const LpeSetup setup = build_setup(channels, 0);
    const Classes classes(setup);
    const auto reversed = lpe::ReversedProgram::build(setup.program());
    REQUIRE(reversed);
    PathSuffixes words(&*reversed);
    const std::array<LobePart, 2> parts{{{classes.diffuse, Rgb(0.5f)}, {classes.glossy, Rgb(0.5f)}}};
    std::array<std::vector<double>, 2> found;
    for (int sample = 0; sample < samples; ++sample) {
        SampleTable table(channels, 2);
        table.begin(test::pixel_rows(1, 2, static_cast<std::uint64_t>(sample), 1));
        LpeServices services(setup, table, 9);
        words.clear();
        Tracker tracker = services.begin(0);
        for (int k = 0; k < 14; ++k) services.move(tracker, parts);
        PathSuffix word = services.begin(words, classes.light);
        for (int k = 0; k < 14; ++k) word = services.prepend(words, word, parts, static_cast<unsigned>(k));
        REQUIRE(services.overflow_count() == 0);
        double before = 0;
        for (std::size_t i = 0; i < 2; ++i) {
            word = services.prepend(words, word, parts, 14 + i);
            Tracker joined = tracker;
            services.connect(joined, words, word);
            services.contribute(Rgb(1), Technique{}, joined);
            const double value = table.raw_values(1 + 2)[0];
            found[i].push_back(value - before);
            before = value;
        }
        REQUIRE(services.overflow_count() == 2);
    }
    const auto moment = [&](std::size_t i, std::size_t k) {
        double means[2] = {0, 0}, product = 0;
        for (int s = 0; s < samples; ++s) means[0] += found[i][s] / samples, means[1] += found[k][s] / samples;
        for (int s = 0; s < samples; ++s) product += (found[i][s] - means[0]) * (found[k][s] - means[1]) / samples;
        return product;
    };
    const double correlation = moment(0, 1) / std::sqrt(moment(0, 0) * moment(1, 1));
    REQUIRE(moment(0, 0) > 1e-20);  // more than the rounding of a share of about 1e-7
    // The standard error of a correlation of nothing is 1 / sqrt(samples); 4.9 of them are seen once in a million runs.
    CHECK(std::abs(correlation) < 4.9 / std::sqrt(static_cast<double>(samples)));
}

TEST_CASE("a light word labelled by drawn lobes has the exact shares' mean", "[path_suffix][law5][statistical]") {
    const Counted counted = count_by_connections(LpeServices::Attribution::picked, 4000, 20, 8);
    CHECK(counted.overflow == 0);
    check_binomial(counted, 20, 4000);
    const Counted exact = count_by_connections(LpeServices::Attribution::exact, 10, 20, 8);
    CHECK(exact.overflow == 0);
    for (const double error : exact.error) CHECK(error < 1e-8);  // attribution adds no noise: the same each time
}

}  // namespace
}  // namespace raylex::display
