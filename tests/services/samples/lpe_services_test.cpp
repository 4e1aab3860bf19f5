#include "display/services/samples/lpe_services.h"

#include <array>
#include <bit>
#include <limits>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "lpe/shipped.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::build_setup;
using test::Classes;
using test::expression_channel;
using test::plain_channel;
using test::Random;

std::vector<ChannelDefinition> with_beauty(std::span<const lpe::NamedExpression> expressions) {
    std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb)};
    for (const lpe::NamedExpression& e : expressions)
        channels.push_back(expression_channel(std::string(e.name), std::string(e.expression)));
    return channels;
}

Rgb random_color(Random& random) {
    // Colours with components of 0, or black ones, are critical for normalisation.
    const auto component = [&] { return random.below(6) == 0 ? 0.0f : random.uniform_float(); };
    return random.below(10) == 0 ? Rgb(0) : Rgb(component(), component(), component());
}

/// Follows one random path: lobes at every vertex, light sampled from a copy of the tracker, a terminal at the end.
void follow_random_path(LpeServices& services, const Classes& classes, int row, std::uint64_t seed, int length) {
    Random random(seed);
    Tracker tracker = services.begin(row);
    const auto any = [&](const std::vector<lpe::EventClass>& from) {
        return from[static_cast<std::size_t>(random.below(static_cast<int>(from.size())))];
    };
    for (int vertex = 0; vertex < length; ++vertex) {
        std::array<LobePart, 4> parts;
        const int count = 1 + random.below(4);
        for (int i = 0; i < count; ++i)
            parts[static_cast<std::size_t>(i)] = {any(classes.scattering), random_color(random)};
        services.move(tracker, std::span(parts).first(static_cast<std::size_t>(count)));
        Tracker lit = tracker;
        services.move(lit, any(classes.terminals));
        services.contribute(random_color(random), Technique{1, 2}, lit);
    }
    services.move(tracker, any(classes.terminals));
    services.contribute(random_color(random) + Rgb(0.1f), Technique{}, tracker);
}

struct Rendered {
    std::vector<double> beauty;
    double worst = 0;  // largest |sum - beauty| / beauty over rows and colours
    std::uint64_t overflow = 0;
};

Rendered render_random_paths(const std::vector<ChannelDefinition>& channels, const lpe::CompileOptions& options = {}) {
    constexpr int rows = 256;
    const LpeSetup setup = build_setup(channels, 0, options);
    const Classes classes(setup);
    SampleTable table(channels, rows);
    table.begin(test::pixel_rows(3, 4, 0, rows));
    LpeServices services(setup, table, 17);
    for (int row = 0; row < rows; ++row)
        follow_random_path(services, classes, row, static_cast<std::uint64_t>(row), row % 64);
    Rendered result;
    result.beauty.assign(table.raw_values(0), table.raw_values(0) + 3 * rows);
    result.overflow = services.overflow_count();
    for (int i = 0; i < 3 * rows; ++i) {
        double sum = 0;
        for (ChannelId id = 1; id < table.channel_count(); ++id) sum += table.raw_values(id)[i];
        result.worst = std::max(result.worst, std::abs(sum - table.raw_values(0)[i]) / table.raw_values(0)[i]);
    }
    return result;
}

TEST_CASE("a partition sums to beauty over long random paths with random lobes", "[lpe_services][law1]") {
    // 64 bounces with 4 parts round 256 times at 2^-53 each; in the worst case all in one direction: 3e-14.
    CHECK(render_random_paths(with_beauty(lpe::shipped_partition())).worst < 1e-12);
    CHECK(render_random_paths(test::count_diffuse(8)).worst < 1e-12);
    const Rendered overflown = render_random_paths(test::count_diffuse(60));
    CHECK(overflown.overflow > 0);  // collapsing preserves the sum
    CHECK(overflown.worst < 1e-12);
}

TEST_CASE("a partition that the compiler distributes over groups sums to beauty", "[lpe_services][law1]") {
    const std::vector<ChannelDefinition> channels = test::count_diffuse(8);
    lpe::CompileOptions options;
    options.state_cap = 14;
    const LpeSetup setup = build_setup(channels, 0, options);
    CAPTURE(setup.program().group_count());
    CHECK(setup.program().group_count() > 1);
    CHECK(render_random_paths(channels, options).worst < 1e-12);
}

TEST_CASE("beauty is bit-identical whatever else is requested", "[lpe_services][law2]") {
    const std::vector<double> alone = render_random_paths({plain_channel("beauty", ChannelType::rgb)}).beauty;
    CHECK(render_random_paths(with_beauty(lpe::shipped_partition())).beauty == alone);
    CHECK(render_random_paths(test::count_diffuse(60)).beauty == alone);
}

/// Splits at `vertices` vertices into the diffuse fraction `diffuse_part` and a singular rest, and contributes 1.
void follow_two_lobes(LpeServices& services, const Classes& classes, int row, int vertices, const Rgb& diffuse_part) {
    Tracker tracker = services.begin(row);
    const std::array<LobePart, 2> parts{
        {{classes.diffuse, diffuse_part * 0.5f}, {classes.singular, (Rgb(1) - diffuse_part) * 0.5f}}};
    for (int i = 0; i < vertices; ++i) services.move(tracker, parts);
    services.move(tracker, classes.light);
    services.contribute(Rgb(1), Technique{}, tracker);
}

std::vector<double> binomial(int n, double p) {
    std::vector<double> result{1};
    for (int i = 0; i < n; ++i) {
        result.push_back(0);
        for (std::size_t k = result.size() - 1; k > 0; --k) result[k] = result[k] * (1 - p) + result[k - 1] * p;
        result[0] *= 1 - p;
    }
    return result;
}

TEST_CASE("each colour is attributed in proportion to the lobes' values", "[lpe_services][law5]") {
    const std::vector<ChannelDefinition> channels = test::count_diffuse(12);
    const LpeSetup setup = build_setup(channels, 0);
    SampleTable table(channels, 1);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    LpeServices services(setup, table, 1);
    const Rgb part(0.25f, 0.5f, 0.75f);
    follow_two_lobes(services, Classes(setup), 0, 10, part);
    CHECK(services.overflow_count() == 0);
    for (int c = 0; c < 3; ++c) {
        const std::vector<double> expected = binomial(10, static_cast<double>(part[c]));
        for (int k = 0; k <= 10; ++k) {
            CAPTURE(c, k);
            CHECK(table.values(1 + k)[c] == Approx(expected[static_cast<std::size_t>(k)]).epsilon(1e-14));
        }
    }
}

TEST_CASE("a channel that does not distinguish lobes equals beauty exactly", "[lpe_services][law5]") {
    const std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb),
                                                  expression_channel("all", "C.*"),
                                                  expression_channel("lit", "C[RT]+L")};
    const LpeSetup setup = build_setup(channels, 0);
    SampleTable table(channels, 1);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    LpeServices services(setup, table, 1);
    for (int i = 0; i < 100; ++i) follow_two_lobes(services, Classes(setup), 0, i + 1, Rgb(0.3f, 0.1f, 0.7f));
    for (int c = 0; c < 3; ++c) {
        CHECK(table.values(0)[c] == 100);
        CHECK(table.values(1)[c] == 100);  // not 99.999..., because nothing was split
    }
}

TEST_CASE("a colour without a value in any lobe belongs to the first lobe", "[lpe_services][law5]") {
    const std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb),
                                                  expression_channel("d", "C<RD>L"), expression_channel("s", "C<RS>L")};
    const LpeSetup setup = build_setup(channels, 0);
    const Classes classes(setup);
    SampleTable table(channels, 1);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    LpeServices services(setup, table, 1);
    Tracker tracker = services.begin(0);
    const std::array<LobePart, 2> parts{{{classes.singular, Rgb(0, 0, 1)}, {classes.diffuse, Rgb(1, 0, 3)}}};
    services.move(tracker, parts);
    services.move(tracker, classes.light);
    services.contribute(Rgb(8), Technique{}, tracker);
    CHECK(table.values(1)[0] == 8);
    CHECK(table.values(2)[1] == 8);
    CHECK(table.values(1)[2] == 6);
    CHECK(table.values(2)[2] == 2);
}

TEST_CASE("contributions that are not finite reach nothing and are logged with pixel and sample",
          "[lpe_services][law6]") {
    const std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb),
                                                  expression_channel("l", "CL")};
    const LpeSetup setup = build_setup(channels, 0);
    const Classes classes(setup);
    SampleTable table(channels, 2);
    table.begin(test::pixel_rows(11, 12, 100, 2));
    LpeServices services(setup, table, 1);
    Tracker tracker = services.begin(table.add_row(1));
    services.move(tracker, classes.light);
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    services.contribute(Rgb(1, nan, 1), Technique{}, tracker);
    services.contribute(Rgb(-inf, 0, 0), Technique{1, 2}, tracker);
    CHECK(services.invalid_count() == 2);
    REQUIRE(table.invalid_log().size() == 2);
    CHECK(table.invalid_log()[1].pixel_x == 11);
    CHECK(table.invalid_log()[1].pixel_y == 12);
    CHECK(table.invalid_log()[1].sample == 101);
    CHECK(table.invalid_log()[1].value.r == -inf);
    for (ChannelId id = 0; id < 2; ++id) {
        CHECK_FALSE(table.touched(id));
        for (int i = 0; i < 9; ++i) CHECK(table.values(id)[i] == 0);
    }
    for (int i = 0; i < 100; ++i) services.contribute(Rgb(nan), Technique{}, tracker);
    CHECK(services.invalid_count() == 102);
    CHECK(table.invalid_log().size() == SampleTable::invalid_samples_kept);
    services.contribute(Rgb(1), Technique{}, tracker);
    CHECK(table.values(0)[6] == 1);  // the third row
    CHECK(table.values(1)[6] == 1);
}

TEST_CASE("a contribution beyond the frame buffer's range affects no other one, and splits still sum",
          "[lpe_services][law1][law6]") {
    const std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb),
                                                  expression_channel("lights", "CL-CB"),
                                                  expression_channel("sky", "CB")};
    const LpeSetup setup = build_setup(channels, 0);
    const Classes classes(setup);
    SampleTable table(channels, 1);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    LpeServices services(setup, table, 1);
    const auto add = [&](float value, lpe::EventClass terminal) {
        Tracker tracker = services.begin(0);
        services.move(tracker, terminal);
        services.contribute(Rgb(value), Technique{}, tracker);
    };
    add(1e15f, classes.background);  // finite, but too large for a block of samples
    add(2.0f, classes.light);
    add(3e9f, classes.background);  // the sun in photometric units
    CHECK(services.invalid_count() == 1);
    Result<FrameBuffer> buffer = FrameBuffer::create({1, 1}, channels);
    REQUIRE(buffer);
    buffer->accumulate(table);
    CHECK(buffer->rejected_count() == 0);
    CHECK(buffer->resolve(1)[0] == 2.0);
    CHECK(buffer->resolve(2)[0] == 3e9);
    CHECK(buffer->resolve(0)[0] == 3e9 + 2.0);
}

TEST_CASE("a path is live while something can still accept it", "[lpe_services][law4]") {
    std::vector<ChannelDefinition> channels{expression_channel("direct", "C<RD>L"),
                                            expression_channel("caustic", "C<RD><RS>+L")};
    const LpeSetup setup = build_setup(channels, invalid_channel);
    const Classes classes(setup);
    SampleTable table(channels, 1);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    LpeServices services(setup, table, 1);
    Tracker tracker = services.begin(0);
    CHECK(services.live(tracker));
    CHECK(services.live_after(tracker, classes.diffuse));
    CHECK_FALSE(services.live_after(tracker, classes.singular));
    CHECK_FALSE(services.live_after(tracker, classes.light));
    services.move(tracker, classes.diffuse);
    CHECK(services.live_after(tracker, classes.light));
    Tracker other = tracker;
    services.move(other, classes.diffuse);
    CHECK_FALSE(services.live(other));
    services.contribute(Rgb(1), Technique{}, other);
    CHECK_FALSE(table.touched(0));
    CHECK(services.live(tracker));  // the copy changed nothing
    // With beauty everything counts.
    channels.push_back(plain_channel("beauty", ChannelType::rgb));
    const LpeSetup with_beauty = build_setup(channels, 2);
    SampleTable second(channels, 1);
    second.begin(test::pixel_rows(0, 0, 0, 1));
    LpeServices all(with_beauty, second, 1);
    Tracker dead = all.begin(0);
    all.move(dead, classes.singular);
    CHECK(all.live(dead));
    CHECK(all.live_after(dead, classes.singular));
}

TEST_CASE("without expression channels only beauty gets values", "[lpe_services]") {
    const std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb)};
    const LpeSetup setup = build_setup(channels, 0);
    CHECK(setup.classify({lpe::EventType::light, lpe::Scatter::none, 0, {""}}) == 0);
    SampleTable table(channels, 1);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    LpeServices services(setup, table, 1);
    Tracker tracker = services.begin(0);
    const std::array<LobePart, 2> parts{{{0, Rgb(1)}, {0, Rgb(1)}}};
    services.move(tracker, parts);
    services.move(tracker, lpe::EventClass{0});
    services.contribute(Rgb(1, 2, 3), Technique{}, tracker);
    CHECK(services.live(tracker));
    CHECK(table.values(0)[2] == 3);
    const LpeSetup nothing = build_setup({plain_channel("N", ChannelType::normal)}, invalid_channel);
    LpeServices idle(nothing, table, 1);
    CHECK_FALSE(idle.live(idle.begin(0)));
}

TEST_CASE("packed channels get exactly the values that each gets alone", "[lpe_services][law5]") {
    std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb)};
    for (int i = 0; i < 40; ++i)
        channels.push_back(expression_channel(test::join({"x", std::to_string(i)}),
                                              test::join({"C.*<RD'", std::to_string(i), "'>.*[<L.>O]"})));
    channels.push_back(expression_channel("direct", "C<RD>[<L.>O]"));
    const auto render = [](const std::vector<ChannelDefinition>& list, int& branches_dropped) {
        const LpeSetup setup = build_setup(list, 0);
        SampleTable table(list, 64);
        table.begin(test::pixel_rows(0, 0, 0, 64));
        LpeServices services(setup, table, 3);
        for (int row = 0; row < 64; ++row) {
            Random random(static_cast<std::uint64_t>(row));
            Tracker tracker = services.begin(row);
            for (int vertex = 0; vertex < 3; ++vertex) {
                const std::string object = std::to_string(random.below(6));
                const std::array<LobePart, 2> parts{
                    {{setup.classify({lpe::EventType::reflection, lpe::Scatter::diffuse, 0, {object, ""}}),
                      random_color(random)},
                     {setup.classify({lpe::EventType::reflection, lpe::Scatter::glossy, 0, {object, ""}}),
                      random_color(random)}}};
                services.move(tracker, parts);
            }
            services.move(tracker, setup.classify({lpe::EventType::light, lpe::Scatter::none, 0, {""}}));
            services.contribute(Rgb(0.25f, 0.5f, 1), Technique{}, tracker);
        }
        branches_dropped += static_cast<int>(services.overflow_count());
        std::vector<std::vector<double>> values;
        for (ChannelId id = 0; id < table.channel_count(); ++id)
            values.emplace_back(table.raw_values(id), table.raw_values(id) + 3 * 64);
        return values;
    };
    int overflow = 0;
    REQUIRE(build_setup(channels, 0).program().view().has_parallel());
    const auto together = render(channels, overflow);
    double total = 0;
    for (std::size_t k = 1; k < channels.size(); ++k) {
        const auto alone = render({channels[0], channels[k]}, overflow);
        REQUIRE(alone[0] == together[0]);  // Law 2
        for (std::size_t i = 0; i < alone[1].size(); ++i) {
            // At most 8 shares of a path, each rounded three times at 2^-53, are summed in a different order.
            REQUIRE(together[k][i] == Approx(alone[1][i]).margin(1e-14).epsilon(0));
            total += alone[1][i];
        }
    }
    CHECK(overflow == 0);
    CHECK(total > 10);
}

TEST_CASE("channels that a tracker cannot follow are errors", "[lpe_services][law7]") {
    std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb), expression_channel("a", "CL")};
    channels[1].type = ChannelType::real;
    CHECK_FALSE(LpeSetup::build(channels, 0));
    channels[1].type = ChannelType::rgb;
    channels[1].rest_of = {0};  // beauty has no expression
    CHECK_FALSE(LpeSetup::build(channels, 0));
    // Each `C.*<RD'x'>.*` needs a bit: 1100 need 35 words, more than fit in a tracker.
    std::vector<ChannelDefinition> many;
    for (int i = 0; i < 1100; ++i) {
        const std::string number = std::to_string(i);
        many.push_back(expression_channel(test::join({"x", number}), test::join({"C.*<RD'", number, "'>.*"})));
    }
    lpe::CompileOptions options;
    options.word_cap = 64;
    const auto setup = LpeSetup::build(many, invalid_channel, options);
    REQUIRE_FALSE(setup);
    CHECK(setup.error().message.find("words of state") != std::string::npos);
}

}  // namespace
}  // namespace raylex::display
