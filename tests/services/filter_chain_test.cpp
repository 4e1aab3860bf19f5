// Chains of sample filters: order, grades and their sums, shadows, and the effects of a broken filter.
#include <limits>

#include <catch2/catch.hpp>

#include "display/services/object_request.h"
#include "display/services/samples/sample_filter.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

const SourceLocation chain_location{"job.toml", 7, 1};

ParameterSet parameters(const std::string& filter, const std::string& text) {
    const auto request =
        parse_object_request(filter + ":" + text, sample_filter_registry(), "sample filter", chain_location);
    if (!request) FAIL(request.error().to_string());
    return request->parameters;
}

/// The channels beauty = a + b, a normal, and a channel that is not light.
struct Chain {
    std::vector<ChannelDefinition> channels{test::expression_channel("beauty", "C.*"),
                                            test::expression_channel("a", "CDL"), test::expression_channel("b", "CSL"),
                                            test::plain_channel("N", ChannelType::normal),
                                            test::expression_channel("albedo", "nothruput;CU2L")};
    SampleFilterChain chain;

    std::string add(const std::string& name, const std::string& text) {
        std::vector<ChannelDefinition> added;
        auto filter = make_sample_filter(
            name, parameters(name, text),
            {channels, 0, [&](ChannelDefinition channel) {
                 added.push_back(std::move(channel));
                 return Result<ChannelId>(static_cast<ChannelId>(channels.size() + added.size() - 1));
             }});
        if (!filter) return filter.error().to_string();
        chain.add(*std::move(filter));
        channels.insert(channels.end(), added.begin(), added.end());
        return {};
    }
    [[nodiscard]] SampleTable table(int rows) const {
        SampleTable result(channels, rows);
        result.begin(test::pixel_rows(0, 0, 0, rows));
        return result;
    }
};

void set(SampleTable& table, ChannelId id, int row, const RgbD& v) {
    for (int c = 0; c < 3; ++c) table.raw_values(id)[3 * row + c] = v[c];
    table.touch(id);
    if (table.channel(id).style == ChannelStyle::name) table.set_row_state(id, row, SampleTable::RowState::written);
}

RgbD get(const SampleTable& table, ChannelId id, int row) {
    const double* v = table.values(id) + 3 * row;
    return {v[0], v[1], v[2]};
}

TEST_CASE("filters work in the order of their declaration", "[sample_filter]") {
    for (const bool clamp_first : {true, false}) {
        Chain c;
        if (clamp_first) REQUIRE(c.add("clamp", "luminance=2").empty());
        REQUIRE(c.add("grade", "gain=4").empty());
        if (!clamp_first) REQUIRE(c.add("clamp", "luminance=2").empty());
        SampleTable table = c.table(1);
        set(table, 0, 0, RgbD(8.0));
        c.chain.apply(table);
        CHECK(get(table, 0, 0).r == Approx(clamp_first ? 8 : 2));  // min(8, 2) x 4, or min(8 x 4, 2)
    }
}

TEST_CASE("a grade of all light keeps sums, whatever its exposure, gain and saturation", "[sample_filter][law1]") {
    Chain c;
    REQUIRE(c.add("clamp", "luminance=0.8").empty());
    REQUIRE(c.add("grade", "exposure=1.5,gain=0.5 1 2,saturation=0.3").empty());
    REQUIRE(c.add("grade", "saturation=1.7").empty());
    CHECK(c.chain.alters().empty());
    SampleTable table = c.table(64);
    test::Random random(3);
    const auto color = [&] { return RgbD(random.uniform(), random.uniform(), random.uniform()); };
    for (int i = 0; i < 8; ++i) table.add_row(i);
    for (int row = 0; row < table.row_count(); ++row) {
        set(table, 1, row, color());
        set(table, 2, row, color());
        set(table, 0, row, get(table, 1, row) + get(table, 2, row));
        set(table, 3, row, RgbD(0.6));
        set(table, 4, row, RgbD(0.7));
    }
    const RgbD before = get(table, 0, 5);
    c.chain.apply(table);
    CHECK(get(table, 0, 5) != before);
    for (int row = 0; row < table.row_count(); ++row)
        for (int i = 0; i < 3; ++i) {
            const double sum = get(table, 1, row)[i] + get(table, 2, row)[i], whole = get(table, 0, row)[i];
            // Law 1's bound for double accumulators; with saturation the terms are up to 6 times the result here.
            CHECK(std::abs(sum - whole) <= 1e-12 * 6);
        }
    CHECK(get(table, 3, 9) == RgbD(0.6));
    CHECK(get(table, 4, 9) == RgbD(0.7));  // not light
}

TEST_CASE("the grade equals its formula, per component", "[sample_filter]") {
    Chain c;
    REQUIRE(c.add("grade", "channels='a b',exposure=1,gain=0.5 1 2,offset=0.25,gamma=2 1 0.5,saturation=0.5").empty());
    CHECK(c.chain.alters() == std::vector<ChannelId>{1, 2});
    SampleTable table = c.table(2);
    const int extra = table.add_row(0);
    set(table, 1, 0, RgbD(2.25, 1.0, 0.5));
    set(table, 0, 0, RgbD(3.0));
    set(table, 2, 0, RgbD(1.25, 0.75, 0.25));  // together with the extra row the same sample as that of channel a
    set(table, 2, extra, RgbD(1.0, 0.25, 0.25));
    c.chain.apply(table);
    // (2.25 + 0.25)^(1/2), 1 x 2 + 0.25, (0.5 x 4 + 0.25)^2
    const RgbD powered(std::sqrt(2.5), 2.25, 2.25 * 2.25);
    const RgbD grey(0.2126 * powered.r + 0.7152 * powered.g + 0.0722 * powered.b);
    const RgbD expected = grey + (powered - grey) * 0.5;
    for (int i = 0; i < 3; ++i) {
        CHECK(get(table, 1, 0)[i] == Approx(expected[i]).epsilon(1e-12));
        CHECK(get(table, 2, 0)[i] + get(table, 2, extra)[i] == Approx(expected[i]).epsilon(1e-12));
    }
    CHECK(get(table, 0, 0) == RgbD(3.0));
}

TEST_CASE("shadow puts the blocked fraction of the light into alpha and a layer", "[sample_filter]") {
    for (const bool held_back : {true, false}) {
        Chain c;
        c.channels = {test::expression_channel("beauty", "C.*"), test::expression_channel("u", "unoccluded;C[DS]+<L.>"),
                      test::expression_channel("other", held_back ? "shadows;C[DS]+<L.>" : "C[DS]+<L.>")};
        REQUIRE(c.add("shadow", std::string("unoccluded=u,") + (held_back ? "shadows" : "occluded") +
                                    "=other,channel=shadow,threshold=0.1")
                    .empty());
        REQUIRE(c.channels.size() == 4);
        CHECK(c.channels[3].type == ChannelType::real);
        SampleTable table = c.table(5);
        const std::array<double, 5> light{4, 4, 4, 0.05, 2}, arrives{4, 3, 0, 0, 5}, expected{0, 0.25, 1, 0, 0};
        for (int row = 0; row < 5; ++row) {
            const auto i = static_cast<std::size_t>(row);
            set(table, 1, row, RgbD(light[i]));
            set(table, 2, row, RgbD(held_back ? light[i] - arrives[i] : arrives[i]));
        }
        table.opacity[1] = RgbD(0.5);
        c.chain.apply(table);
        for (int row = 0; row < 5; ++row) {
            const double shadow = expected[static_cast<std::size_t>(row)];
            CHECK(table.values(3)[row] == Approx(shadow).margin(1e-15));
            CHECK(table.opacity[static_cast<std::size_t>(row)].r ==
                  Approx(row == 1 ? 1 - 0.5 * 0.75 : shadow).margin(1e-15));
        }
    }
}

/// A plugin with a bug.
class Broken final : public SampleFilter {
  public:
    void apply(SampleTable& table) const override {
        table.raw_values(1)[3] = std::numeric_limits<double>::quiet_NaN();  // channel a, row 1
        table.raw_values(3)[6] = std::numeric_limits<double>::infinity();   // N, row 2
        table.opacity[0] = RgbD(std::numeric_limits<double>::infinity());
    }
};

TEST_CASE("values that a filter makes and that are not finite are removed from beauty and layers and counted",
          "[sample_filter][law1][law6]") {
    Chain c;
    c.chain.add(std::make_unique<Broken>());
    SampleTable table = c.table(3);
    for (int row = 0; row < 3; ++row) {
        set(table, 0, row, RgbD(3.0));
        set(table, 1, row, RgbD(1.0));
        set(table, 2, row, RgbD(2.0));
        set(table, 3, row, RgbD(1.0));
    }
    c.chain.apply(table);
    for (const ChannelId id : {0, 1, 2}) {
        CHECK(get(table, id, 0).g == (id == 0 ? 3 : id));
        CHECK(get(table, id, 1) == RgbD(0.0));
    }
    CHECK(get(table, 3, 2) == RgbD(0.0));
    CHECK_FALSE(table.written(3, 2));
    CHECK(table.opacity[0] == RgbD(0.0));
    for (int row = 0; row < 3; ++row) CHECK(table.invalid_count(row) == 1);
    CHECK(table.invalid_by_channel()[1] == 1);
    CHECK(table.invalid_by_channel()[3] == 1);
}

TEST_CASE("filters that cannot be made give errors with the expected values", "[sample_filter][law7]") {
    Chain c;
    const auto holds = [](const std::string& error, const char* words) {
        CAPTURE(error, words);
        return error.find("job.toml:7:1") != std::string::npos && error.find(words) != std::string::npos;
    };
    CHECK(holds(c.add("grade", "offset=0.1"), "no longer sum to the beauty"));
    CHECK(holds(c.add("grade", "gamma=2.2"), "no longer sum to the beauty"));
    CHECK(holds(c.add("grade", "channels=aa"), "did you mean 'a'"));
    CHECK(holds(c.add("grade", "gain=-1"), "negative gain"));
    CHECK(holds(c.add("grade", "gain=1 2"), "nor three numbers"));
    CHECK(holds(c.add("grade", "gamma=0,channels=a"), "above 0"));
    CHECK(holds(c.add("grade", "saturation=-1"), "negative saturation"));
    CHECK(holds(c.add("grade", "gian=2"), "did you mean 'gain'"));
    CHECK(holds(c.add("clamp", "limit=2"), "no parameter 'limit'"));
    CHECK(holds(c.add("shadow", "unoccluded=a"), "expected unoccluded=NAME with"));
    CHECK(holds(c.add("shadow", "unoccluded=a,occluded=b,shadows=b"), "expected unoccluded=NAME with"));
    CHECK(holds(c.add("shadow", "unoccluded=a,occluded=N"), "not a light path expression"));
    CHECK(holds(c.add("shadow", "unoccluded=a,occluded=b,alpha=false"), "no destination for"));
    CHECK(holds(c.add("shadow", "unoccluded=a,occluded=b,threshold=-1"), "below 0"));
    const auto bad = parse_object_request("grade:gain=big", sample_filter_registry(), "sample filter", chain_location);
    CHECK((!bad && holds(bad.error().to_string(), "three with blanks")));
}

}  // namespace
}  // namespace raylex::display
