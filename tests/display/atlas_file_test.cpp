// Path atlases as files: they read back as written, and the result of a damaged file depends only on the file.
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "display/output/atlas/atlas_file.h"
#include "files.h"
#include "made_atlas.h"

using namespace raylex::test;
using namespace raylex::display;

namespace {

bool same_bits(double a, double b) {
    return std::memcmp(&a, &b, sizeof(a)) == 0;
}

bool same(const AtlasRow& a, const AtlasRow& b) {
    const auto same_sample = [](const PathStringSample& s, const PathStringSample& t) {
        return s.word == t.word && std::equal(s.rgb.begin(), s.rgb.end(), t.rgb.begin(), same_bits) &&
               std::equal(s.parts.begin(), s.parts.end(), t.parts.begin(), same_bits);
    };
    const auto same_pixel = [](const auto& s, const auto& t) {
        return std::equal(s.begin(), s.end(), t.begin(), same_bits);
    };
    return a.begin == b.begin &&
           std::equal(a.samples.begin(), a.samples.end(), b.samples.begin(), b.samples.end(), same_sample) &&
           std::equal(a.rgba.begin(), a.rgba.end(), b.rgba.begin(), b.rgba.end(), same_pixel) &&
           std::equal(a.counts.begin(), a.counts.end(), b.counts.begin(), b.counts.end(), same_pixel);
}

/// A row that already contains other light.
AtlasRow used_row() {
    AtlasRow row;
    PathStringSample sample;
    sample.word = MadeAtlas::words - 1;
    sample.rgb.fill(77);
    sample.parts.fill(0.75f);
    row.samples.assign(40, sample);
    row.rgba.assign(9, {7, 7, 7, 7});
    return row;
}

}  // namespace

TEST_CASE("an atlas reads back from its file as it was written, with every kind of row", "[exr][atlas]") {
    const Folder folder;
    MadeAtlas made(GENERATE(SignedLight::none, SignedLight::light));
    const std::string path = folder.path("a.exr");
    REQUIRE(write_atlas(path, made, {}));
    const auto file = AtlasFile::open(path);
    REQUIRE(file);
    CHECK((*file)->table().words == made.table().words);
    CHECK((*file)->table().negative == made.table().negative);
    AtlasRow written;
    for (const int y : {3, 0, 2, 1}) {
        AtlasRow read = used_row();
        REQUIRE((*file)->row(y, read));
        REQUIRE(made.row(y, written));
        // Signed light is stored as a float and its rounding error: 48 bits of a double's 53.
        for (std::size_t i = 0; i < written.samples.size() && i < read.samples.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                const double value = written.samples[i].rgb[c];
                CHECK(std::abs(read.samples[i].rgb[c] - value) <= 0x1p-47 * std::abs(value));
                written.samples[i].rgb[c] = read.samples[i].rgb[c];
            }
        CHECK(same(read, written));
    }
    CHECK_FALSE((*file)->row(MadeAtlas::rows, written));
}

TEST_CASE("a damaged atlas gives an error or valid rows, and the result depends only on the file",
          "[exr][atlas][law7][gate]") {
    const Folder folder;
    MadeAtlas made(SignedLight::none);
    const std::string path = folder.path("a.exr");
    REQUIRE(write_atlas(path, made, {}));
    const std::string bytes = read_bytes(path);
    // Find the rows, which follow the header and the tables of their positions; part 0 comes first.
    const std::int32_t first_leader[2] = {0, 0};
    const std::size_t rows_begin =
        bytes.rfind(std::string(reinterpret_cast<const char*>(first_leader), 8), bytes.size() - 400);
    REQUIRE(rows_begin != std::string::npos);
    std::size_t refused = 0, read = 0;
    const auto try_bytes = [&](const std::string& damaged) {
        std::ofstream(path, std::ios::binary) << damaged;
        const auto file = AtlasFile::open(path);
        if (!file) return ++refused, void();
        for (int y = 0; y < MadeAtlas::rows; ++y) {
            AtlasRow fresh, used = used_row();
            const raylex::Status status = (*file)->row(y, fresh);
            REQUIRE(static_cast<bool>((*file)->row(y, used)) == static_cast<bool>(status));
            if (!status) {
                CHECK(status.error().file == path);
                ++refused;
                continue;
            }
            ++read;
            REQUIRE(same(fresh, used));
            REQUIRE(fresh.begin.size() == MadeAtlas::columns + 1);
            REQUIRE(fresh.begin.back() == fresh.samples.size());
            for (const PathStringSample& sample : fresh.samples) REQUIRE(sample.word < MadeAtlas::words);
        }
    };
    for (std::size_t at = rows_begin; at < bytes.size(); ++at)
        for (const char change : {'\x01', '\x04', '\x80', '\xff'}) {
            CAPTURE(at, change);
            std::string damaged = bytes;
            damaged[at] = static_cast<char>(damaged[at] ^ change);
            try_bytes(damaged);
        }
    // A changed colour cannot be detected; most changes of counts, words and sizes are.
    CHECK(refused > bytes.size() - rows_begin);
    CHECK(read > bytes.size() - rows_begin);
}

TEST_CASE("an atlas with missing or extra eighths is refused", "[exr][atlas][law7]") {
    const Folder folder;
    MadeAtlas made(SignedLight::none);
    const std::string path = folder.path("a.exr");
    REQUIRE(write_atlas(path, made, {}));
    std::string bytes = read_bytes(path);
    // Part `parts` of row 2 becomes empty: its leader and counts replace those of another row.
    const auto leader = [&](std::int32_t y) {
        const std::int32_t place[2] = {2, y};
        const std::size_t at = bytes.rfind(std::string(reinterpret_cast<const char*>(place), 8));
        REQUIRE(at != std::string::npos);
        return at + 8;
    };
    std::uint64_t sizes[3];
    std::memcpy(sizes, bytes.data() + leader(2), sizeof(sizes));
    REQUIRE(sizes[1] == 0);
    REQUIRE(sizes[2] == 0);
    const std::int32_t row = GENERATE(0, 3);
    bytes.replace(leader(row), 24 + sizes[0], bytes, leader(2), 24 + sizes[0]);
    std::ofstream(path, std::ios::binary) << bytes;
    const auto file = AtlasFile::open(path);
    REQUIRE(file);
    AtlasRow read = used_row();
    const raylex::Status status = (*file)->row(row, read);
    REQUIRE_FALSE(status);
    CHECK(status.error().message.find("'words' and 'parts' have different samples") != std::string::npos);
    (*file)->read_parts(false);
    CHECK((*file)->row(row, read));  // its light is complete
}
