#include "display/services/samples/sample_filter.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <iterator>
#include <limits>

#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

std::vector<ChannelDefinition> split_channels() {
    return {test::plain_channel("beauty", ChannelType::rgb), test::expression_channel("direct", "C<RD>L"),
            test::expression_channel("raw", "noclamp;C<RD>L"), test::plain_channel("N", ChannelType::normal)};
}

ParameterSet limit(double value, const std::string& measure = "luminance") {
    ParameterSet set;
    Parameter parameter;
    parameter.name = measure;
    parameter.numbers = {value};
    set.parameters.push_back(parameter);
    return set;
}

TEST_CASE("clamp scales beauty and splits by one factor and does not change other channels", "[sample_filter][law1]") {
    const std::vector<ChannelDefinition> channels = split_channels();
    const auto filter = make_sample_filter("clamp", limit(2), {channels, 0, {}});
    REQUIRE(filter);
    SampleTable table(channels, 4);
    table.begin(test::pixel_rows(0, 0, 0, 2));
    const int extra = table.add_row(0);
    const auto set = [&](ChannelId id, int row, double v) {
        table.touch(id);
        for (int c = 0; c < 3; ++c) table.raw_values(id)[3 * row + c] = v;
    };
    for (ChannelId id = 0; id < 4; ++id) {
        set(id, 0, 3);  // sample 0 is 3 + 5 = 8 over its two rows: factor 1 / 4
        set(id, extra, 5);
        set(id, 1, 1.5);  // sample 1 is unchanged
    }
    (*filter)->apply(table);
    for (const ChannelId id : {0, 1}) {
        CHECK(table.values(id)[0] == Approx(0.75));
        CHECK(table.values(id)[3 * extra] == Approx(1.25));
        CHECK(table.values(id)[3] == 1.5);
    }
    for (const ChannelId id : {2, 3}) {
        CHECK(table.values(id)[0] == 3);
        CHECK(table.values(id)[3 * extra] == 5);
    }
}

TEST_CASE("clamp by the largest component, like pbrt's films", "[sample_filter]") {
    const std::vector<ChannelDefinition> channels = split_channels();
    const auto filter = make_sample_filter("clamp", limit(2, "component"), {channels, 0, {}});
    REQUIRE(filter);
    SampleTable table(channels, 4);
    table.begin(test::pixel_rows(0, 0, 0, 2));
    table.touch(0);
    const double values[] = {1, 8, 4, 2, 1, 0.5};  // the second sample's largest component equals the limit
    std::copy(std::begin(values), std::end(values), table.raw_values(0));
    (*filter)->apply(table);
    CHECK(table.values(0)[0] == 0.25);
    CHECK(table.values(0)[1] == 2);
    CHECK(table.values(0)[2] == 1);
    for (int c = 3; c < 6; ++c) CHECK(table.values(0)[c] == values[c]);
    ParameterSet both = limit(2, "component");
    both.parameters.push_back(limit(2).parameters.front());
    CHECK_FALSE(make_sample_filter("clamp", both, {channels, 0, {}}));
}

TEST_CASE("clamp uses the component after a matrix if there is one", "[sample_filter]") {
    const std::vector<ChannelDefinition> channels = split_channels();
    ParameterSet by_matrix = limit(2, "component");
    Parameter measure;
    measure.name = "measure";
    measure.type = ParameterType::real;
    measure.numbers = {0, 0, 1, 0.25, 0.25, 0.25, 0, 0, 0.5};
    by_matrix.parameters.push_back(measure);
    const auto filter = make_sample_filter("clamp", by_matrix, {channels, 0, {}});
    REQUIRE(filter);
    SampleTable table(channels, 4);
    table.begin(test::pixel_rows(0, 0, 0, 2));
    table.touch(0);
    const double values[] = {1, 8, 4, 6, 1, 1};  // after the matrix: 4, 3.25, 2 and 1, 2, 0.5
    std::copy(std::begin(values), std::end(values), table.raw_values(0));
    (*filter)->apply(table);
    for (int c = 0; c < 3; ++c) CHECK(table.values(0)[c] == values[c] / 2);
    for (int c = 3; c < 6; ++c) CHECK(table.values(0)[c] == values[c]);
    const auto refusal = [&](const ParameterSet& parameters) {
        const auto refused = make_sample_filter("clamp", parameters, {channels, 0, {}});
        REQUIRE_FALSE(refused);
        return refused.error().message;
    };
    by_matrix.parameters.back().numbers[0] = std::numeric_limits<double>::quiet_NaN();
    CHECK(refusal(by_matrix).find("expected nine finite numbers") != std::string::npos);
    by_matrix.parameters.back().numbers = std::vector<double>(8, 1);
    CHECK(refusal(by_matrix).find("expected nine finite numbers") != std::string::npos);
    ParameterSet alone = limit(2);
    alone.parameters.push_back(measure);
    CHECK(refusal(alone).find("expected both") != std::string::npos);
}

TEST_CASE("splits sum to beauty with the clamp on", "[sample_filter][law1]") {
    const std::vector<ChannelDefinition> channels{
        test::plain_channel("beauty", ChannelType::rgb), test::expression_channel("a", "CDL"),
        test::expression_channel("b", "CDDL"), test::expression_channel("c", "CSL")};
    const auto filter = make_sample_filter("clamp", limit(0.5), {channels, 0, {}});
    REQUIRE(filter);
    SampleTable table(channels, 64);
    table.begin(test::pixel_rows(0, 0, 0, 64));
    test::Random random(1);
    int clamped = 0;
    for (int i = 0; i < 3 * 64; ++i)
        for (ChannelId id = 1; id < 4; ++id) {
            const double v = random.uniform();
            table.raw_values(id)[i] = v;
            table.raw_values(0)[i] += v;
        }
    for (ChannelId id = 0; id < 4; ++id) table.touch(id);
    const std::vector<double> before(table.raw_values(0), table.raw_values(0) + 3 * 64);
    (*filter)->apply(table);
    for (int i = 0; i < 3 * 64; ++i) {
        const double sum = table.raw_values(1)[i] + table.raw_values(2)[i] + table.raw_values(3)[i];
        CHECK(sum == Approx(table.values(0)[i]).epsilon(1e-12));
        clamped += table.raw_values(0)[i] < before[static_cast<std::size_t>(i)];
    }
    CHECK(clamped > 100);
}

TEST_CASE("the filter none changes nothing; bad settings are errors", "[sample_filter][law7]") {
    const std::vector<ChannelDefinition> channels = split_channels();
    const auto none = make_sample_filter("none", {}, {channels, 0, {}});
    REQUIRE(none);
    SampleTable table(channels, 4);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    table.raw_values(0)[0] = 1e6;
    table.touch(0);
    (*none)->apply(table);
    CHECK(table.values(0)[0] == 1e6);
    CHECK_FALSE(make_sample_filter("clamp", limit(0), {channels, 0, {}}));
    CHECK_FALSE(make_sample_filter("clamp", limit(1), {channels, invalid_channel, {}}));
    CHECK_FALSE(make_sample_filter("clmp", {}, {channels, 0, {}}));
}

}  // namespace
}  // namespace raylex::display
