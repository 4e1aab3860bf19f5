// Ranked coverage: it sums to alpha, the record does not depend on the order, and the memory of a pixel is limited.
#include "display/buffer/sinks/ranked_coverage.h"

#include <algorithm>
#include <map>
#include <numeric>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/services/samples/display_services.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

using test::pixel_rows;
using test::Random;
using Rank = RankedCoverage::Rank;

/// The weight of every row and every sample has an error of at most half of 2^-32: far below this for the tests' sizes.
constexpr double rounding = 1e-8;

double sum_of(const std::vector<Rank>& ranks) {
    return std::accumulate(ranks.begin(), ranks.end(), 0.0, [](double sum, const Rank& r) { return sum + r.coverage; });
}

TEST_CASE("surfaces are ranked by their coverage of the pixel, and misses count for none", "[coverage]") {
    RankedCoverage coverage(2, 1, {0, 77, 88});
    SampleTable table({}, 16);
    table.begin(pixel_rows(1, 0, 0, 16));
    DisplayServices services(table);
    for (int row = 0; row < 12; ++row) {
        services.write_surface(row, row < 4 ? 1 : 2);
        services.write_opacity(row, Rgb(1));
    }
    coverage.accumulate(table);
    std::vector<Rank> ranks(3);
    CHECK(coverage.resolve(1, ranks) == 0);
    CHECK(ranks[0].id == 88);
    CHECK(ranks[0].coverage == 0.5);
    CHECK(ranks[1].id == 77);
    CHECK(ranks[1].coverage == 0.25);
    CHECK(ranks[2].id == 0);
    CHECK(ranks[2].coverage == 0);
    CHECK(coverage.resolve(0, ranks) == 0);  // this pixel was not rendered
    CHECK(ranks[0].id == 0);
    ranks.resize(1);
    CHECK(coverage.resolve(1, ranks) == 0.25);  // the coverage beyond one rank
}

TEST_CASE("coverages and remainder add up to alpha for half-transparent, coloured and nameless rows", "[coverage]") {
    Random random(7);
    FrameBuffer buffer({4, 4}, std::vector<ChannelDefinition>{});
    std::vector<std::uint32_t> ids{0};
    for (std::uint32_t i = 1; i < 12; ++i) ids.push_back(i == 5 ? 0 : 1000 + i);
    RankedCoverage coverage(4, 4, ids);
    SampleTable table({}, 16);
    for (int pixel = 0; pixel < 16; ++pixel)
        for (std::uint64_t first : {0, 16}) {
            std::vector<CameraRow> rows = pixel_rows(pixel % 4, pixel / 4, first, 16);
            for (CameraRow& row : rows) row.filter_weight = 0.5f + random.uniform_float();
            table.begin(rows);
            DisplayServices services(table);
            for (int row = 0; row < 16; ++row) {
                const auto color = [&] { return RgbD(random.uniform(), random.uniform(), random.uniform()); };
                for (int k = random.below(4); k > 0; --k)
                    services.add_sample(row, {random.uniform_float(), color(), false, 1 + random.below(11)});
                services.write_distance(row, random.uniform_float());
                services.write_opacity(row, Rgb(color()));
                services.write_surface(row, 1 + random.below(11));
            }
            buffer.accumulate(table);
            coverage.accumulate(table);
        }
    const std::vector<double> alpha = buffer.resolve_alpha();
    std::vector<Rank> ranks(4);
    double largest_remainder = 0;
    for (std::size_t pixel = 0; pixel < 16; ++pixel) {
        const double remainder = coverage.resolve(pixel, ranks);
        CHECK(sum_of(ranks) + remainder == Approx(alpha[pixel]).margin(rounding));
        CHECK(std::is_sorted(ranks.begin(), ranks.end(),
                             [](const Rank& a, const Rank& b) { return a.coverage > b.coverage; }));
        largest_remainder = std::max(largest_remainder, remainder);
    }
    CHECK(largest_remainder > 0.05);  // ten ids in four ranks, and one surface in eleven without a name
}

TEST_CASE("the record does not depend on the order of samples and merges, even beyond the limit", "[coverage][law3]") {
    Random random(11);
    std::vector<std::pair<std::uint32_t, double>> samples;
    for (int i = 0; i < 1000; ++i)
        samples.emplace_back(1 + static_cast<std::uint32_t>(random.below(200)), random.uniform());
    RankedCoverage first(1, 1, {}), second(1, 1, {}), half(1, 1, {});
    for (const auto& [id, weight] : samples) {
        first.add(0, id, 1, weight);
        first.add_weight(0, 1);
    }
    for (std::size_t i = samples.size(); i > 1; --i)
        std::swap(samples[i - 1], samples[static_cast<std::size_t>(random.below(static_cast<int>(i)))]);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        RankedCoverage& to = i % 3 == 0 ? half : second;
        to.add(0, samples[i].first, 1, samples[i].second);
        to.add_weight(0, 1);
    }
    REQUIRE(second.merge(half));
    const auto check_same = [&](const RankedCoverage& other) {
        const RankedCoverage::Record a = first.record(0), b = other.record(0);
        CHECK(a.weight == b.weight);
        CHECK(a.remainder == b.remainder);
        REQUIRE(a.entries.size() == b.entries.size());
        for (std::size_t i = 0; i < a.entries.size(); ++i) {
            CHECK(a.entries[i].id == b.entries[i].id);
            CHECK(a.entries[i].weight == b.entries[i].weight);
        }
    };
    check_same(second);
    RankedCoverage restored(1, 1, {});
    restored.restore(0, first.record(0));
    check_same(restored);

    CHECK(first.record(0).entries.size() == RankedCoverage::ids_per_pixel);  // of 200
    std::map<std::uint32_t, double> sums;
    for (const auto& [id, weight] : samples) sums[id] += weight;
    double kept = 0, all = 0;
    for (const auto& [id, weight] : sums) all += weight;
    for (const auto& entry : first.record(0).entries) {
        CHECK(static_cast<double>(entry.weight) * 0x1p-32 == Approx(sums[entry.id]).margin(1000 * rounding));
        kept += sums[entry.id];
    }
    std::vector<Rank> ranks(6);
    const double remainder = first.resolve(0, ranks);
    CHECK(remainder + sum_of(ranks) == Approx(all / 1000).margin(rounding));
    CHECK(remainder >= (all - kept) / 1000);
    CHECK_FALSE(first.merge(RankedCoverage(2, 1, {})));
}

TEST_CASE("the memory of a pixel is limited, and pixels without samples need little", "[coverage]") {
    RankedCoverage coverage(100, 1, {});
    const std::size_t empty = coverage.memory_bytes();
    CHECK(empty <= 100 * 32);
    for (std::uint32_t id = 1; id < 100'000; ++id) coverage.add(3, id, 1, 1);
    CHECK(coverage.memory_bytes() <= empty + RankedCoverage::ids_per_pixel * sizeof(RankedCoverage::Entry));
}

TEST_CASE("equal coverages are ranked by id, and weights of NaN count as 0", "[coverage]") {
    RankedCoverage coverage(1, 1, {});
    for (const std::uint32_t id : {9u, 3u, 5u}) coverage.add(0, id, 1, 1);
    for (const double bad : {std::nan(""), -1.0, 0.0}) coverage.add(0, 4, 1, bad);
    for (int i = 0; i < 3; ++i) coverage.add_weight(0, 1);
    std::vector<Rank> ranks(4);
    CHECK(coverage.resolve(0, ranks) == 0);
    CHECK(ranks[0].id == 3);
    CHECK(ranks[1].id == 5);
    CHECK(ranks[2].id == 9);
    CHECK(ranks[3].id == 0);
    CHECK(sum_of(ranks) == 1);
}

TEST_CASE("a surface is refused for an invalid row, and when it is negative", "[services]") {
    SampleTable table({}, 2);
    table.begin(pixel_rows(0, 0, 0, 2));
    DisplayServices services(table);
    CHECK(services.write_surface(1, 5));
    CHECK_FALSE(services.write_surface(2, 5));
    CHECK_FALSE(services.write_surface(0, -1));
    CHECK(services.add_sample(0, {1, RgbD(1.0), false, -1}) == -1);
    CHECK(services.add_sample(0, {1, RgbD(1.0), false, 6}) == 2);
    CHECK(std::vector(table.surface.begin(), table.surface.begin() + 3) == std::vector<std::int32_t>{0, 5, 6});
    table.begin(pixel_rows(0, 0, 0, 2));
    CHECK(table.surface[1] == 0);
}

}  // namespace
}  // namespace raylex::display
