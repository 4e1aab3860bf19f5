// Rows as OpenEXR's core unpacks them, compared with the values passed to its C++ interface.
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputPart.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <half.h>

#include "display/output/atlas/packed_rows.h"
#include "files.h"

using namespace raylex::test;
using namespace raylex::display;

namespace {

constexpr int packed_width = 5, packed_height = 4, min_x = -2, min_y = 3;

/// The number of samples per pixel: row 1 has none, and other rows have pixels without samples.
unsigned count_at(int x, int y) {
    return y == 1 ? 0 : static_cast<unsigned>((3 * x + 2 * y) % 4);
}

/// Writes a flat part with L (FLOAT), and a deep one with h (HALF), r (FLOAT) and u (UINT); the n-th sample is computed
/// from n.
void write_parts(const std::string& path, Imf::Compression of_flat, Imf::Compression of_deep) {
    const Imath::Box2i window({min_x, min_y}, {min_x + packed_width - 1, min_y + packed_height - 1});
    std::vector<Imf::Header> headers(2, Imf::Header(window, window));
    headers[0].setName("flat");
    headers[0].setType(Imf::SCANLINEIMAGE);
    headers[0].compression() = of_flat;
    headers[0].channels().insert("L", Imf::Channel(Imf::FLOAT));
    headers[1].setName("deep");
    headers[1].setType(Imf::DEEPSCANLINE);
    headers[1].compression() = of_deep;
    headers[1].channels().insert("h", Imf::Channel(Imf::HALF));
    headers[1].channels().insert("r", Imf::Channel(Imf::FLOAT));
    headers[1].channels().insert("u", Imf::Channel(Imf::UINT));
    for (Imf::Header& header : headers) header.setVersion(1);
    std::vector<float> flat, single(100);
    std::vector<Imath::half> half(100);
    std::vector<unsigned> whole(100), counts;
    for (unsigned n = 0; n < 100; ++n) {
        half[n] = Imath::half(static_cast<float>(n) / 4);
        single[n] = static_cast<float>(n) / 3;
        whole[n] = 0x10203040u + n;
    }
    std::vector<char*> of_half, of_single, of_whole;
    std::size_t at = 0;
    for (int y = 0; y < packed_height; ++y)
        for (int x = 0; x < packed_width; ++x) {
            flat.push_back(static_cast<float>(10 * y + x));
            counts.push_back(count_at(x, y));
            of_half.push_back(reinterpret_cast<char*>(half.data() + at));
            of_single.push_back(reinterpret_cast<char*>(single.data() + at));
            of_whole.push_back(reinterpret_cast<char*>(whole.data() + at));
            at += counts.back();
        }
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), 2);
    Imf::OutputPart flat_part(file, 0);
    Imf::FrameBuffer pixels;
    const auto base = [](auto* values, std::size_t size) {
        return reinterpret_cast<char*>(values) -
               (std::ptrdiff_t{min_y} * packed_width + min_x) * static_cast<std::ptrdiff_t>(size);
    };
    pixels.insert("L", Imf::Slice(Imf::FLOAT, base(flat.data(), 4), 4, 4 * packed_width));
    flat_part.setFrameBuffer(pixels);
    flat_part.writePixels(packed_height);
    Imf::DeepScanLineOutputPart deep_part(file, 1);
    Imf::DeepFrameBuffer samples;
    samples.insertSampleCountSlice(Imf::Slice(Imf::UINT, base(counts.data(), 4), 4, 4 * packed_width));
    constexpr std::size_t way = sizeof(char*);
    samples.insert("h", Imf::DeepSlice(Imf::HALF, base(of_half.data(), way), way, way * packed_width, 2));
    samples.insert("r", Imf::DeepSlice(Imf::FLOAT, base(of_single.data(), way), way, way * packed_width, 4));
    samples.insert("u", Imf::DeepSlice(Imf::UINT, base(of_whole.data(), way), way, way * packed_width, 4));
    deep_part.setFrameBuffer(samples);
    deep_part.writePixels(packed_height);
}

std::size_t plane_of(const PackedRows& rows, const char* name, PackedRows::Type type) {
    const int plane = rows.plane(name, type);
    REQUIRE(plane >= 0);
    return static_cast<std::size_t>(plane);
}

raylex::Result<std::unique_ptr<PackedRows>> open_part(const std::string& path, int part) {
    const auto file = PackedRows::open_file(path);
    if (!file) return file.error();
    return PackedRows::open(*file, part);
}

/// Replaces `stood` by `numbers` after part and row in the leader of a row.
template <class Number>
void change_leader(const std::string& path, std::int32_t part, std::int32_t y, const std::vector<Number>& stood,
                   const std::vector<Number>& numbers) {
    const auto bytes_of = [](const auto& values) {
        std::string bytes(values.size() * sizeof(values[0]), '\0');
        std::memcpy(bytes.data(), values.data(), bytes.size());
        return bytes;
    };
    std::string bytes = read_bytes(path);
    const std::string row = bytes_of(std::vector<std::int32_t>{part, y});
    const std::size_t at = bytes.find(row + bytes_of(stood));
    REQUIRE(at != std::string::npos);
    bytes.replace(at + row.size(), numbers.size() * sizeof(Number), bytes_of(numbers));
    std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace

TEST_CASE("packed rows have the values and counts that were written, rows without samples too", "[exr][packed-rows]") {
    using Type = PackedRows::Type;
    const Folder folder;
    const std::string path = folder.path("two.exr");
    const Imf::Compression how = GENERATE(Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION);
    CAPTURE(how);
    write_parts(path, GENERATE(Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION), how);
    const auto flat = open_part(path, 0), deep = open_part(path, 1);
    REQUIRE(flat);
    REQUIRE(deep);
    CHECK((*deep)->plane("u", Type::single) == -1);  // it is not a float
    CHECK((*deep)->plane("z", Type::single) == -1);
    const std::size_t h = plane_of(**deep, "h", Type::half), r = plane_of(**deep, "r", Type::single),
                      u = plane_of(**deep, "u", Type::uint), light = plane_of(**flat, "L", Type::single);
    unsigned n = 0;
    PackedRows::Row row;
    for (int y = 0; y < packed_height; ++y) {
        REQUIRE((*flat)->read(min_y + y, row));
        REQUIRE(row.sample_count() == packed_width);
        for (int x = 0; x < packed_width; ++x)
            CHECK(row.value<float>(light, static_cast<std::size_t>(x)) == static_cast<float>(10 * y + x));
        const raylex::Status read = (*deep)->read(min_y + y, row);
        INFO((read ? "" : read.error().message));
        REQUIRE(read);
        REQUIRE(row.begin().size() == packed_width + 1);
        for (int x = 0; x < packed_width; ++x) {
            const auto column = static_cast<std::size_t>(x);
            REQUIRE(row.begin()[column + 1] - row.begin()[column] == count_at(x, y));
            for (std::size_t i = row.begin()[column]; i < row.begin()[column + 1]; ++i, ++n) {
                CHECK(row.value<std::uint16_t>(h, i) == Imath::half(static_cast<float>(n) / 4).bits());
                CHECK(row.value<float>(r, i) == static_cast<float>(n) / 3);
                CHECK(row.value<std::uint32_t>(u, i) == 0x10203040u + n);
            }
        }
    }
    CHECK(n == 20);
    for (const int outside : {min_y - 1, min_y + packed_height}) CHECK_FALSE((*deep)->read(outside, row));
}

TEST_CASE("rows packed together, missing parts and truncated files are refused with the file's name",
          "[exr][packed-rows][law7]") {
    const Folder folder;
    const std::string path = folder.path("two.exr");
    write_parts(path, Imf::ZIP_COMPRESSION, Imf::RLE_COMPRESSION);
    const auto together = open_part(path, 0);
    REQUIRE_FALSE(together);
    CHECK(together.error().file == path);
    CHECK(together.error().message.find("packed 16 together") != std::string::npos);
    CHECK_FALSE(open_part(path, 2));
    write_parts(folder.path("plain.exr"), Imf::RLE_COMPRESSION, Imf::NO_COMPRESSION);
    const auto plain = open_part(folder.path("plain.exr"), 1);
    REQUIRE_FALSE(plain);
    CHECK(plain.error().message.find("expected rle") != std::string::npos);
    CHECK_FALSE(open_part(folder.path("absent.exr"), 0));
    // Remove the last byte of the last row.
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
    const auto cut = open_part(path, 1);
    REQUIRE_FALSE(cut);
    CHECK(cut.error().file == path);
}

TEST_CASE("a row with an inconsistent leader is refused before unpacking", "[exr][packed-rows][law7]") {
    const Folder folder;
    const std::string path = folder.path("two.exr");
    const auto check_refused = [&](int part, const char* why) {
        const auto rows = open_part(path, part);
        REQUIRE_FALSE(rows);
        CHECK(rows.error().file == path);
        INFO(rows.error().message);
        CHECK(rows.error().message.find(why) != std::string::npos);
    };
    write_parts(path, Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION);
    constexpr int pixel_bytes = 4 * packed_width;
    SECTION("unpacked pixels with a wrong size") {
        change_leader<std::int32_t>(path, 0, min_y + 1, {pixel_bytes}, {pixel_bytes - 1});
        check_refused(0, "does not match its pixels");
    }
    // Row 1 has no samples: 20 bytes of zeros packed to 4, and nothing else.
    SECTION("no table of counts") {
        change_leader<std::uint64_t>(path, 1, min_y + 1, {4, 0, 0}, {0, 0, 0});
        check_refused(1, "does not match its counts");
    }
    SECTION("a table of counts that is longer than the row") {
        change_leader<std::uint64_t>(path, 1, min_y + 1, {4, 0, 0}, {pixel_bytes + 1, 0, 0});
        check_refused(1, "does not match its counts");
    }
    SECTION("samples that the leader does not count") {
        std::string bytes = read_bytes(path);
        const auto rows = open_part(path, 1);
        REQUIRE(rows);
        PackedRows::Row row;
        REQUIRE((*rows)->read(min_y, row));
        const std::uint64_t unpacked = row.sample_count() * 10;  // a half, a float and a uint
        const auto leader = [&](std::uint64_t table, std::uint64_t packed) {
            return std::vector<std::uint64_t>{table, packed, unpacked};
        };
        bool found = false;
        for (std::uint64_t table = 1; !found && table <= pixel_bytes; ++table)
            for (std::uint64_t packed = 1; !found && packed <= unpacked; ++packed) {
                std::string wanted(32, '\0');
                const std::int32_t place[2] = {1, min_y};
                std::memcpy(wanted.data(), place, 8);
                std::memcpy(wanted.data() + 8, leader(table, packed).data(), 24);
                if (bytes.find(wanted) == std::string::npos) continue;
                found = true;
                change_leader<std::uint64_t>(path, 1, min_y, leader(table, packed), {table, 0, 0});
            }
        REQUIRE(found);
        const auto damaged = open_part(path, 1);
        REQUIRE(damaged);
        const auto read = (*damaged)->read(min_y, row);
        REQUIRE_FALSE(read);
        CHECK(read.error().file == path);
        CHECK(read.error().message.find("truncated or damaged") != std::string::npos);
        CHECK((*damaged)->read(min_y + 3, row));  // the other rows are unchanged
    }
}
