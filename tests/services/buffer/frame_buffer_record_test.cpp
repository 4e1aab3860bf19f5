// The record of a frame buffer as bytes: written and read back, merged, and never misread.
#include <catch2/catch.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/record_bytes.h"
#include "display/buffer/sinks/ranked_coverage.h"
#include "display/services/samples/display_services.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

using test::plain_channel;
using test::Random;

std::vector<ChannelDefinition> every_recorded_rule() {
    std::vector<ChannelDefinition> channels{
        test::expression_channel("light", "CL"),
        plain_channel("statistics", ChannelType::rgb),
        plain_channel("zmin", ChannelType::point, FilterRule::zmin, std::numeric_limits<float>::infinity()),
        plain_channel("zmax", ChannelType::integer, FilterRule::zmax),
        plain_channel("min", ChannelType::rgb, FilterRule::min),
        plain_channel("max", ChannelType::real, FilterRule::max),
        plain_channel("average", ChannelType::rgb, FilterRule::average),
        plain_channel("sum", ChannelType::real, FilterRule::sum),
    };
    channels[1].statistics = true;
    channels.push_back(plain_channel("even", ChannelType::rgb));
    channels.back().statistic = Statistic::even;
    channels.back().source = 1;
    channels[0].space = "rendering colour space";
    channels[7].rest_of = {0, 3};
    channels[0].scale_exponent = 12;
    channels[1].scale_exponent = channels.back().scale_exponent = -40;
    return channels;
}

/// Blocks first, first + 2, ... of every pixel.
FrameBuffer filled(const std::vector<ChannelDefinition>& channels, int first) {
    FrameBuffer buffer({37, 21}, channels);
    SampleTable table(channels, 16);
    DisplayServices services(table);
    for (int pixel = 0; pixel < 37 * 21; ++pixel)
        for (int block = first; block < 4; block += 2) {
            Random random(static_cast<std::uint64_t>(pixel * 4 + block));
            table.begin(test::pixel_rows(pixel % 37, pixel / 37, static_cast<std::uint64_t>(block * 16), 16));
            for (int row = 0; row < 16; ++row) {
                const auto value = [&] {
                    return static_cast<float>(std::ldexp(random.uniform() - 0.3, random.below(60) - 40));
                };
                services.write_opacity(row, Rgb(random.uniform_float()));
                if (pixel > 500 || random.below(3) == 0) continue;  // whole pages stay empty
                services.write_distance(row, static_cast<float>(random.below(40)));
                services.splat(0, row, Rgb(value(), value(), value()));
                for (const ChannelId id : {1, 2, 4, 6}) services.write(id, row, Rgb(value(), value(), value()));
                services.write(3, row, static_cast<std::int32_t>(random.below(1000)));
                services.write(5, row, value());
                services.write(7, row, pixel == 3 ? 1e30f : value());  // out of range: rejected and counted
            }
            buffer.accumulate(table);
        }
    return buffer;
}

std::string record_of(const FrameBuffer& buffer) {
    std::string bytes;
    buffer.append_record(bytes);
    return bytes;
}

}  // namespace

TEST_CASE("a frame buffer's record restores the frame buffer", "[framebuffer][record][law3]") {
    const auto channels = every_recorded_rule();
    const FrameBuffer buffer = filled(channels, 0);
    REQUIRE(buffer.rejected_count(7) > 0);
    const std::string bytes = record_of(buffer);
    auto back = FrameBuffer::from_record(bytes);
    REQUIRE(back.ok());
    CHECK(back->difference_from(buffer).empty());
    CHECK((record_of(*back) == bytes));
    CHECK(back->rejected_count(7) == buffer.rejected_count(7));
    CHECK(back->channels()[7].rest_of == channels[7].rest_of);
    CHECK(back->sample_count(5, 5) == buffer.sample_count(5, 5));
    for (ChannelId id = 0; id < 9; ++id) {
        CAPTURE(id);
        CHECK((back->resolve(id) == buffer.resolve(id)));
        CHECK((back->resolve_variance_of_mean(id) == buffer.resolve_variance_of_mean(id)));
    }
    CHECK((back->resolve_alpha() == buffer.resolve_alpha()));
}

TEST_CASE("records of shards merge to the whole, in any order", "[framebuffer][record][law3]") {
    const auto channels = every_recorded_rule();
    FrameBuffer whole = filled(channels, 0);
    REQUIRE(whole.merge(filled(channels, 1)).ok());
    auto even = FrameBuffer::from_record(record_of(filled(channels, 0)));
    auto odd = FrameBuffer::from_record(record_of(filled(channels, 1)));
    REQUIRE(even.ok());
    REQUIRE(odd.ok());
    REQUIRE(odd->merge(*even).ok());
    CHECK((record_of(*odd) == record_of(whole)));
}

TEST_CASE("a record does not depend on the number of a pixel's blocks per batch", "[framebuffer][record][law3]") {
    const auto channels = every_recorded_rule();
    constexpr int blocks = 70, rows = 16;  // more than fit in one run
    const auto filled_by = [&](int together) {
        FrameBuffer buffer({2, 1}, channels);
        SampleTable table(channels, rows * together);
        DisplayServices services(table);
        for (int first = 0; first < blocks; first += together) {
            const int count = std::min(together, blocks - first) * rows;
            const auto sample = static_cast<std::uint64_t>(first) * rows;
            auto camera = test::pixel_rows(1, 0, sample, count);
            for (CameraRow& each : camera) each.filter_weight = each.sample % 3 == 0 ? -0.25f : 1.5f;
            table.begin(camera);
            for (int row = 0; row < count; ++row) {
                Random random(sample + static_cast<std::uint64_t>(row));
                // From below the quantum to so large that a block is added separately; some are too large.
                const auto value = [&] {
                    const int exponent = random.below(50) == 0 ? 47 : random.below(120) - 80;
                    return static_cast<float>(std::ldexp(random.uniform() - 0.5, exponent));
                };
                services.write_opacity(row, Rgb(random.uniform_float()));
                if (random.below(4) == 0) continue;
                services.write_distance(row, static_cast<float>(random.below(40)));
                services.splat(0, row, Rgb(value(), value(), value()));
                for (const ChannelId id : {1, 2, 4, 6}) services.write(id, row, Rgb(value(), value(), value()));
                services.write(3, row, static_cast<std::int32_t>(random.below(1000)));
                services.write(5, row, value());
                services.write(7, row, value());
                ExtraSample veil;
                veil.depth = static_cast<float>(random.below(40));
                veil.opacity = RgbD(0.5);
                if (first * rows + row > blocks * rows / 2 && random.below(3) == 0)
                    services.splat(0, services.add_sample(row, veil), Rgb(value()));
            }
            buffer.accumulate(table);
        }
        return buffer;
    };
    const FrameBuffer one = filled_by(1);
    CHECK(one.rejected_count(7) > 0);
    CHECK(one.rejected_count(0) + one.rejected_count(1) > 0);
    for (const int together : {2, 5, blocks}) {
        CAPTURE(together);
        const FrameBuffer many = filled_by(together);
        for (ChannelId id = 0; id < 9; ++id) {
            CAPTURE(id);
            CHECK(many.rejected_count(id) == one.rejected_count(id));
            CHECK((many.resolve(id) == one.resolve(id)));
        }
        CHECK((record_of(many) == record_of(one)));
    }
}

TEST_CASE("a record that ends early or has another version is refused", "[framebuffer][record][law7][gate]") {
    const std::string bytes = record_of(filled(every_recorded_rule(), 0));
    for (std::size_t size = 0; size < bytes.size(); size += 64) {
        CAPTURE(size);
        CHECK_FALSE(FrameBuffer::from_record(std::string_view(bytes).substr(0, size)).ok());
    }
    CHECK_FALSE(FrameBuffer::from_record(bytes + "x").ok());
    std::string other = bytes;
    other[0] = 9;
    const auto refused = FrameBuffer::from_record(other);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message.find("version 9; expected 6") != std::string::npos);
    // A size that exceeds any memory is an error, too.
    other = bytes;
    other[7] = 0x7f;
    CHECK_FALSE(FrameBuffer::from_record(other).ok());
    // So is a quantum that, combined with a channel's scale, exceeds the range of exponents.
    other = bytes;
    const int largest = std::numeric_limits<int>::max();
    std::memcpy(&other[16], &largest, sizeof largest);
    const auto coarse = FrameBuffer::from_record(other);
    REQUIRE_FALSE(coarse.ok());
    CHECK(coarse.error().message.find("expected -512 to 512") != std::string::npos);
}

TEST_CASE("sums of every width are written to bytes and read back", "[framebuffer][record]") {
    // A page has 256 numbers: one page for each width, shift and sign, whose widest number has the full width.
    std::vector<Int128> values(256, 0);  // a page of zeros, which is not written
    Random random(7);
    for (int width = 1; width <= 16; ++width)
        for (int low = 0; low + width <= 16; ++low)
            for (const bool negative : {false, true}) {
                const Int128 most = static_cast<Int128>(~UnsignedInt128{0} >> (129 - 8 * width));
                for (int i = 0; i < 256; ++i) {
                    const Int128 any = most >> random.below(8 * width);
                    const Int128 value = i == 77 ? most : any;
                    values.push_back((negative ? -value - 1 : value) << (8 * low));
                }
            }
    values.resize(values.size() - 100);  // the last page is incomplete
    const std::span<const Int128> all = values;
    const auto through = [](std::span<const Int128> given, std::span<const Int128> like, std::size_t& bytes) {
        std::string record;
        RecordWriter(record).sums(given, like);
        bytes = record.size();
        std::vector<Int128> back(given.size());
        RecordReader reader(record);
        reader.sums(back, like);
        CHECK(reader.at_end());
        for (std::size_t size = 0; size < record.size(); size += 4099) {
            std::vector<Int128> part(given.size());
            RecordReader cut(std::string_view(record).substr(0, size));
            cut.sums(part, like);
            CHECK_FALSE(cut.ok());
        }
        return back;
    };
    std::size_t bytes = 0;
    CHECK((through(all, {}, bytes) == values));
    CHECK(bytes < all.size_bytes() * 6 / 10);  // the mean width is below 6 of 16, if shifts are as frequent as widths
    // Equal to another plane except for one number: only the page of that number is written.
    std::vector<Int128> changed = values;
    changed[256 * 40 + 3] += 1;
    CHECK((through(changed, all, bytes) == changed));
    CHECK(bytes < 16 * 256 + 12 * (values.size() / 256 + 2));
    // An impossible width or shift is refused.
    std::string record;
    RecordWriter(record).sums(all.subspan(256, 256));
    for (const auto& [at, value] : {std::pair(16, 0), std::pair(16, 17), std::pair(16, 255), std::pair(17, 16)}) {
        std::string damaged = record;
        damaged[static_cast<std::size_t>(at)] = static_cast<char>(value);
        std::vector<Int128> back(256);
        RecordReader reader(damaged);
        reader.sums(back);
        CAPTURE(at, value);
        CHECK_FALSE(reader.ok());
    }
}

TEST_CASE("coverage is written to bytes and read back", "[coverage][record][law3]") {
    RankedCoverage coverage(7, 5, {0, 11, 22, 33});
    for (std::size_t pixel = 0; pixel < 35; ++pixel)
        for (std::uint32_t id = 0; id < 3 * pixel; ++id) {  // some pixels drop ids into the remainder
            coverage.add(pixel, id, 1, 0.3);
            coverage.add_weight(pixel, 1);
        }
    std::string bytes;
    coverage.append_record(bytes);
    RankedCoverage back(7, 5, {0, 11, 22, 33});
    REQUIRE(back.restore_record(bytes).ok());
    std::string again;
    back.append_record(again);
    CHECK((again == bytes));
    std::array<RankedCoverage::Rank, 6> a, b;
    for (std::size_t pixel = 0; pixel < 35; ++pixel) {
        CHECK(coverage.resolve(pixel, a) == back.resolve(pixel, b));
        for (std::size_t i = 0; i < a.size(); ++i) CHECK((a[i].id == b[i].id && a[i].coverage == b[i].coverage));
    }
    RankedCoverage other(7, 6, {});
    CHECK_FALSE(other.restore_record(bytes).ok());
    for (std::size_t size = 0; size < bytes.size(); size += 64)
        CHECK_FALSE(back.restore_record(std::string_view(bytes).substr(0, size)).ok());
}

}  // namespace raylex::display
