// Channels that share sums get the same values as separate channels.
#include <cmath>
#include <numeric>
#include <optional>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/services/samples/display_services.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::build_setup;
using test::Classes;

constexpr int width = 6, height = 2, samples = 16;

/// Channels that overlap in many ways. One keeps statistics, one has a rule, one has a second output: these are
/// separate.
std::vector<ChannelDefinition> overlapping() {
    std::vector<ChannelDefinition> channels{test::plain_channel("beauty", ChannelType::rgb)};
    for (const char* expression : {"C.*", "C.*", "CD.*", "CS.*", "C.*D.*", "C[^D]*", "C.*SL", "CD[DS]*L", "C.D.*",
                                   "C..S.*", "C.*[LO]", "C.*D[LO]", "CDDL", "C.?.?L", "C[DS]+L", "CDS.*"})
        channels.push_back(test::expression_channel(test::join({"c", std::to_string(channels.size())}), expression));
    channels[3].statistics = true;
    channels[4].rule = FilterRule::max;
    ChannelDefinition output = channels[5];
    output.name = "again";
    output.style = ChannelStyle::name;
    output.expression.clear();
    output.source = 5;
    output.rule = FilterRule::average;
    channels.push_back(output);
    return channels;
}

/// Follows the path of one sample, which is the same whatever else is followed: up to four vertices, some with two
/// lobes, and light at each.
void follow(LpeServices& lpe, const Classes& classes, int row, int pixel, std::uint64_t sample) {
    test::Random random(static_cast<std::uint64_t>(pixel) * 1000 + sample);
    Tracker tracker = lpe.begin(row);
    const int vertices = random.below(5);
    const auto value = [&] { return Rgb(random.uniform_float(), random.uniform_float(), random.uniform_float()); };
    for (int vertex = 0; vertex <= vertices; ++vertex) {
        Tracker ahead = tracker;
        lpe.move(ahead, random.below(3) == 0 ? classes.emission : classes.light);
        lpe.contribute(value(), Technique{1, 2}, ahead);
        const LobePart parts[2] = {{classes.diffuse, value()}, {classes.singular, value()}};
        lpe.move(tracker, {parts, random.below(2) == 0 ? std::size_t{2} : std::size_t{1}});
    }
}

struct Render {
    FrameBuffer frame_buffer;
    std::size_t sets = 0, most_in_use = 0;
};

/// Renders all pixels in batches of `batch` pixels, from the first or from the last.
Render render(std::span<const ChannelDefinition> channels, const LpeSetup& setup, bool share, int batch,
              bool backwards) {
    Render result{FrameBuffer({width, height, samples}, channels)};
    std::optional<SplatSets> sets;
    if (share) {
        sets = setup.splat_sets(result.frame_buffer.sums_only(), samples);
        result.sets = sets->size();
        result.frame_buffer.expect(*sets);
    }
    SampleTable table(channels, batch * samples, sets ? &*sets : nullptr);
    LpeServices lpe(setup, table, 1);
    DisplayServices services(table);
    const Classes classes(setup);
    for (int first = 0; first < width * height; first += batch) {
        std::vector<CameraRow> rows;
        std::vector<int> pixels;
        for (int i = first; i < std::min(first + batch, width * height); ++i) {
            pixels.push_back(backwards ? width * height - 1 - i : i);
            for (const CameraRow& row : test::pixel_rows(pixels.back() % width, pixels.back() / width, 0, samples)) {
                rows.push_back(row);
                rows.back().filter_weight = row.sample % 3 == 0 ? -0.5f : 1.25f;
            }
        }
        table.begin(rows);
        for (std::size_t row = 0; row < rows.size(); ++row) {
            follow(lpe, classes, static_cast<int>(row), pixels[row / samples], rows[row].sample);
            if (rows[row].sample % 5 != 0) continue;
            ExtraSample veil;  // a half transparent surface in front, with light of its own
            veil.opacity = RgbD(0.5);
            follow(lpe, classes, services.add_sample(static_cast<int>(row), veil), pixels[row / samples],
                   rows[row].sample + samples);
        }
        result.most_in_use = std::max(result.most_in_use, table.sets_in_use().size());
        result.frame_buffer.accumulate(table);
    }
    return result;
}

}  // namespace

TEST_CASE("channels that share sums have the same pixels as separate channels", "[sets][law1][law2]") {
    const auto channels = overlapping();
    const LpeSetup setup = build_setup(channels, 0);
    const Render alone = render(channels, setup, false, 3, false), shared = render(channels, setup, true, 3, false);
    const auto sums_only = shared.frame_buffer.sums_only();
    CHECK(std::accumulate(sums_only.begin(), sums_only.end(), 0) == 13);  // 16 less statistics, rule and second output
    CHECK(shared.sets > 3);
    CHECK(shared.most_in_use > 3);
    CHECK(shared.frame_buffer.resolve(0) == alone.frame_buffer.resolve(0));
    for (std::size_t i = 1; i < channels.size(); ++i) {
        CAPTURE(channels[i].name, channels[i].expression);
        const auto expected = alone.frame_buffer.resolve(static_cast<ChannelId>(i)),
                   found = shared.frame_buffer.resolve(static_cast<ChannelId>(i));
        double light = 0;
        for (std::size_t k = 0; k < expected.size(); ++k) {
            light += std::abs(expected[k]);
            // A pixel is the mean of 16 samples with two rows of at most 5 contributions below 1, in at most 8 parts,
            // with weights up to 1.25 over a mean weight of 0.6: 1280 terms, each sum rounded by at most 2^-53 of its
            // maximum.
            CHECK(std::abs(found[k] - expected[k]) <= 1280 * 0x1p-53 * 10 * 1.25 / 0.6);
            if (sums_only[i] == 0) CHECK(found[k] == expected[k]);
        }
        CHECK(light > 0);
    }
}

TEST_CASE("sums that channels share do not depend on how pixels are grouped into batches", "[sets][law3]") {
    const auto channels = overlapping();
    const LpeSetup setup = build_setup(channels, 0);
    const Render one = render(channels, setup, true, 1, false);
    for (const int batch : {2, 5, width * height})
        for (const bool backwards : {false, true}) {
            const Render other = render(channels, setup, true, batch, backwards);
            for (std::size_t i = 0; i < channels.size(); ++i)
                CHECK(one.frame_buffer.resolve(static_cast<ChannelId>(i)) ==
                      other.frame_buffer.resolve(static_cast<ChannelId>(i)));
        }
}

TEST_CASE("many more sets than one chunk of a table lose no light", "[sets]") {
    // One channel for each of 2^10 paths, and one for all of them.
    constexpr int bits = 10, paths = 1 << bits;
    std::vector<ChannelDefinition> channels{test::plain_channel("beauty", ChannelType::rgb)};
    for (int path = 0; path < paths; ++path) {
        std::string expression = "C";
        for (int i = 0; i < bits; ++i) expression += (path >> i) & 1 ? 'D' : 'S';
        channels.push_back(test::expression_channel(test::join({"path", std::to_string(path)}), expression + "L"));
    }
    channels.push_back(test::expression_channel("all", "C.*"));
    const LpeSetup setup = build_setup(channels, 0);
    const Classes classes(setup);
    FrameBuffer frame_buffer({1, 1, paths}, channels);
    const SplatSets sets = setup.splat_sets(frame_buffer.sums_only(), paths);
    SampleTable table(channels, paths, &sets);
    LpeServices lpe(setup, table, 1);
    for (int batch = 0; batch < 2; ++batch) {
        table.begin(test::pixel_rows(0, 0, static_cast<std::uint64_t>(batch) * paths, paths));
        for (int path = 0; path < paths; ++path) {
            Tracker tracker = lpe.begin(path);
            for (int i = 0; i < bits; ++i) lpe.move(tracker, (path >> i) & 1 ? classes.diffuse : classes.singular);
            lpe.move(tracker, classes.light);
            lpe.contribute(Rgb(1, 2, 4), Technique{}, tracker);
        }
        CHECK(table.sets_in_use().size() == paths);
        CHECK(paths >= 4 * SampleTable::set_chunk);
        CHECK_FALSE(table.sent_separately());
        frame_buffer.accumulate(table);
    }
    // Powers of two and their sums are exact.
    for (int i = 1; i <= paths; ++i)
        CHECK(frame_buffer.resolve(i) == std::vector<double>{1.0 / paths, 2.0 / paths, 4.0 / paths});
    CHECK(frame_buffer.resolve(paths + 1) == std::vector<double>{1, 2, 4});
}

TEST_CASE("sets with a different block size than the frame buffer are rejected, not summed wrongly", "[sets][law7]") {
    const auto channels = overlapping();
    const LpeSetup setup = build_setup(channels, 0);
    FrameBuffer frame_buffer({width, height, samples}, channels);
    const SplatSets sets = setup.splat_sets(frame_buffer.sums_only(), 2 * samples);
    SampleTable table(channels, samples, &sets);
    LpeServices lpe(setup, table, 1);
    table.begin(test::pixel_rows(0, 0, 0, samples));
    follow(lpe, Classes(setup), 0, 0, 0);
    frame_buffer.accumulate(table);
    CHECK(frame_buffer.rejected_count() == 1);
    CHECK(frame_buffer.sample_count(0, 0) == 0);
}

TEST_CASE("values sent to a sharing channel itself add to its shared sums, and a discarded batch leaves neither",
          "[sets]") {
    const std::vector<ChannelDefinition> channels{test::plain_channel("beauty", ChannelType::rgb),
                                                  test::expression_channel("all", "C.*"),
                                                  test::expression_channel("too", "C.*")};
    const LpeSetup setup = build_setup(channels, 0);
    const Classes classes(setup);
    FrameBuffer frame_buffer({1, 1, 1}, channels);
    const SplatSets sets = setup.splat_sets(frame_buffer.sums_only(), 1);
    frame_buffer.expect(sets);
    SampleTable table(channels, 1, &sets);
    LpeServices lpe(setup, table, 1);
    DisplayServices services(table);
    for (std::uint64_t sample = 0; sample < 4; ++sample) {
        table.begin(test::pixel_rows(0, 0, sample, 1));
        Tracker tracker = lpe.begin(0);
        lpe.move(tracker, classes.light);
        lpe.contribute(Rgb(1), Technique{}, tracker);
        if (sample == 1) {
            services.discard_iteration();
            lpe.contribute(Rgb(16), Technique{}, tracker);  // into a batch that is discarded
            continue;
        }
        if (sample == 2) CHECK(services.splat(2, 0, Rgb(8)));
        CHECK(table.sent_separately() == (sample == 2));
        frame_buffer.accumulate(table);
    }
    CHECK(frame_buffer.resolve(0) == std::vector<double>(3, 1));
    CHECK(frame_buffer.resolve(1) == std::vector<double>(3, 1));
    CHECK(frame_buffer.resolve(2) == std::vector<double>(3, 1 + 8.0 / 3));
}

}  // namespace raylex::display
