// Images in bands of rows, one of which is in memory at a time: written, checked, recorded and merged to the same bits
// as whole images.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "display/checkpoint/banded_record.h"
#include "display/output/splits/split_sum.h"
#include "display/output/writer/exr_writer.h"
#include "display/services/parameters.h"
#include "tests/display/files.h"
#include "tests/services/helpers.h"

using namespace raylex::test;
using namespace raylex::display;

namespace {

constexpr int band_width = 37, band_height = 53;

std::vector<ChannelDefinition> banded_channels() {
    std::vector<ChannelDefinition> channels{
        expression_channel("beauty", "C.*L"),
        expression_channel("direct", "CDL"),
        expression_channel("rest", "C"),
        plain_channel("z", ChannelType::real, FilterRule::zmin, std::numeric_limits<float>::infinity()),
        plain_channel("mean", ChannelType::rgb, FilterRule::average),
        plain_channel("even", ChannelType::rgb),
    };
    channels[1].statistics = true;
    channels[5].statistic = Statistic::even;
    channels[5].source = 1;
    return channels;
}

/// A band with blocks [first, end) of 16 samples for the rows [rows.first, rows.end); its layers sum to the beauty.
FrameBuffer filled_band(const RowRange& rows, int first, int end) {
    const std::vector<ChannelDefinition> channels = banded_channels();
    FrameBufferLayout layout{band_width, rows.end - rows.first};
    layout.first_row = rows.first;
    FrameBuffer buffer(layout, channels);
    SampleTable table(channels, 16);
    for (int y = rows.first; y < rows.end; ++y)
        for (int x = 0; x < band_width; ++x)
            for (int block = first; block < end; ++block) {
                Random random(static_cast<std::uint64_t>((y * band_width + x) * 64 + block));
                table.begin(pixel_rows(x, y, static_cast<std::uint64_t>(block * 16), 16));
                for (std::size_t row = 0; row < 16; ++row) {
                    for (std::size_t c = 0; c < 3; ++c) {
                        const double a = std::ldexp(random.uniform(), random.below(40) - 30), b = random.uniform();
                        table.raw_values(0)[3 * row + c] = a + b;
                        table.raw_values(1)[3 * row + c] = a;
                        table.raw_values(2)[3 * row + c] = b;
                        table.raw_values(4)[3 * row + c] = b;
                    }
                    table.raw_values(3)[row] = y == 50 ? 1e300 : random.uniform();  // larger than any float
                    table.depth[row] = static_cast<float>(random.below(9));
                    table.opacity[row] = raylex::RgbD(1.0);
                    for (const ChannelId id : {3, 4})
                        table.set_row_state(id, static_cast<int>(row), SampleTable::RowState::written);
                }
                for (const ChannelId id : {0, 1, 2, 3, 4}) table.touch(id);
                buffer.accumulate(table);
            }
    return buffer;
}

const RowRange all_rows{0, band_height};

BandedImage banded(int rows) {
    const FrameBufferLayout layout{band_width, band_height};
    return {layout, banded_channels(), bands_of(all_rows, rows),
            [](const RowRange& band) -> raylex::Result<FrameBuffer> { return filled_band(band, 0, 2); }};
}

std::string record_of(const FrameBuffer& buffer) {
    std::string bytes;
    buffer.append_record(bytes);
    return bytes;
}

ImageDescription banded_description() {
    ImageDescription description;
    description.partitions = {{"auto", "", {"direct", "rest"}}};
    return description;
}

void check_same_layers(const ExrImage& a, const ExrImage& b) {
    REQUIRE(a.layer_names() == b.layer_names());
    for (std::size_t i = 0; i < a.layers.size(); ++i)
        for (std::size_t p = 0; p < a.layers[i].planes.size(); ++p) {
            CAPTURE(a.layers[i].name, p);
            CHECK(a.layers[i].planes[p].values == b.layers[i].planes[p].values);
        }
}

/// Writes a record file with these blocks of the image.
std::string write_banded(const Folder& folder, const std::string& name, int first, int end) {
    const FrameBuffer buffer = filled_band(all_rows, first, end);
    const auto bands = record_bands(buffer.layout(), buffer.channels(), false);
    auto writer = RecordFileWriter::create(folder.path(name), {{"seed", "1"}}, bands.size());
    REQUIRE(writer.ok());
    REQUIRE(add_bands(*writer, buffer).ok());
    REQUIRE(writer->commit().ok());
    return folder.path(name);
}

BandedRecord opened(const std::string& path) {
    auto file = RecordFileReader::open(path);
    REQUIRE(file.ok());
    auto record = BandedRecord::open(*std::move(file));
    INFO((record ? std::string() : record.error().to_string()));
    REQUIRE(record.ok());
    return *std::move(record);
}

}  // namespace

TEST_CASE("an image in bands is written with the pixels and split results of the whole image",
          "[display][bands][law3][gate]") {
    const Folder folder;
    const FrameBuffer whole = filled_band(all_rows, 0, 2);
    for (const bool single : {false, true}) {
        ImageDescription description = banded_description();
        description.single_part = single;
        std::vector<SplitResult> results, in_bands;
        REQUIRE(write_exr(folder.path("whole.exr"), whole, 0, description, &results).ok());
        REQUIRE(results.size() == 1);
        CHECK(results[0].holds);
        auto expected = read_exr(folder.path("whole.exr"));
        REQUIRE(expected.ok());
        CHECK(expected->attributes.at("repaired/z").starts_with("0 values not a number, set to 0; 37 beyond float"));
        for (const int rows : {1, 7, 16, 52, 53}) {
            CAPTURE(single, rows);
            REQUIRE(write_exr(folder.path("bands.exr"), banded(rows), 0, description, &in_bands).ok());
            auto image = read_exr(folder.path("bands.exr"));
            REQUIRE(image.ok());
            check_same_layers(*image, *expected);
            CHECK(image->attributes == expected->attributes);  // includes the split results
            CHECK(in_bands[0].largest_relative == results[0].largest_relative);
            CHECK(in_bands[0].relative_y == results[0].relative_y);
        }
    }
    ImageDescription crop = banded_description();
    crop.data_window = PixelRegion{3, 10, 20, 40};
    REQUIRE(write_exr(folder.path("whole.exr"), whole, 0, crop).ok());
    REQUIRE(write_exr(folder.path("bands.exr"), banded(7), 0, crop).ok());
    check_same_layers(*read_exr(folder.path("bands.exr")), *read_exr(folder.path("whole.exr")));
}

TEST_CASE("a band that cannot be loaded is an error and leaves no image", "[display][bands][law7]") {
    const Folder folder;
    const BandedImage image({band_width, band_height}, banded_channels(), bands_of(all_rows, 20),
                            [](const RowRange& rows) -> raylex::Result<FrameBuffer> {
                                if (rows.first == 20) return raylex::error_at({"lost.bucket", 0, 0}, "it is gone");
                                return filled_band(rows, 0, 1);
                            });
    const raylex::Status status = write_exr(folder.path("a.exr"), image, 0, banded_description());
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().file == "lost.bucket");
    CHECK(status.error().message == "it is gone");
    CHECK(folder.names().empty());
}

TEST_CASE("rows outside all bands are pixels without samples", "[display][bands]") {
    const BandedImage image(
        {band_width, band_height}, banded_channels(), {{10, 15}, {20, 30}},
        [](const RowRange& rows) -> raylex::Result<FrameBuffer> { return filled_band(rows, 0, 2); });
    const FrameBuffer whole = filled_band(all_rows, 0, 2);
    for (int y = 0; y < band_height; ++y) {
        const bool there = (y >= 10 && y < 15) || (y >= 20 && y < 30);
        CAPTURE(y);
        CHECK(image.resolve(1, {0, y, band_width, y + 1}) ==
              (there ? whole.resolve(1, {0, y, band_width, y + 1}) : std::vector<double>(3 * band_width, 0.0)));
        CHECK(std::isinf(image.resolve(3, {0, y, 1, y + 1})[0]) == !there);
    }
}

TEST_CASE("a file read in bands gives the rows and split results of the whole file", "[display][bands][exr]") {
    const Folder folder;
    ImageDescription description = banded_description();
    description.data_window = PixelRegion{3, 10, 20, 40};
    REQUIRE(write_exr(folder.path("crop.exr"), filled_band(all_rows, 0, 2), 0, description).ok());
    description.data_window.reset();
    description.partitions = {{"wrong", "", {"direct"}}, {"auto", "", {"direct", "rest"}}};
    description.storage[static_cast<std::size_t>(ChannelKind::light)].compression = ExrCompression::piz;
    REQUIRE(write_exr(folder.path("whole.exr"), filled_band(all_rows, 0, 2), 0, description).ok());
    for (const char* name : {"crop.exr", "whole.exr"}) {
        const auto image = read_exr(folder.path(name));
        auto file = ExrBands::open(folder.path(name));
        REQUIRE((image.ok() && file.ok()));
        CHECK(file->image().layer_names() == image->layer_names());
        CHECK(file->image().attributes == image->attributes);
        for (const std::uint64_t bytes : {std::uint64_t{1}, std::uint64_t{30'000}, std::uint64_t{1} << 30}) {
            std::vector<std::vector<float>> planes;
            int next = 0;
            for (const RowRange& rows : file->bands(bytes)) {
                CHECK(rows.first == next);
                next = rows.end;
                const auto band = file->read(rows);
                REQUIRE(band.ok());
                CHECK(band->height == rows.end - rows.first);
                std::size_t at = 0;
                for (const ImageLayer& layer : band->layers)
                    for (const ImagePlane& plane : layer.planes) {
                        if (planes.size() == at) planes.emplace_back();
                        planes[at].insert(planes[at].end(), plane.values.begin(), plane.values.end());
                        ++at;
                    }
            }
            CHECK(next == band_height);
            std::size_t at = 0;
            for (const ImageLayer& layer : image->layers)
                for (const ImagePlane& plane : layer.planes) CHECK((planes[at++] == plane.values));
        }
    }
    const auto image = read_exr(folder.path("whole.exr"));
    auto file = ExrBands::open(folder.path("whole.exr"));
    const auto expected = check_declared_splits(*image), found = check_declared_splits(*file);
    REQUIRE((expected.ok() && found.ok()));
    REQUIRE(found->size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
        CHECK((*found)[i].holds == (i == 0));  // "auto" comes before "wrong"
        CHECK((*found)[i].exceeding == (*expected)[i].exceeding);
        CHECK((*found)[i].residual == (*expected)[i].residual);
        CHECK((*found)[i].largest_absolute == (*expected)[i].largest_absolute);
        CHECK((*found)[i].never_above == (*expected)[i].never_above);
    }
}

TEST_CASE("the split results of bands combine to that of the image", "[display][bands]") {
    const Folder folder;
    REQUIRE(write_exr(folder.path("a.exr"), filled_band(all_rows, 0, 1), 0, banded_description()).ok());
    auto file = ExrBands::open(folder.path("a.exr"));
    REQUIRE(file.ok());
    auto whole = file->read(all_rows);
    REQUIRE(whole.ok());
    const auto expected = check_split(*whole, "", {"direct"});  // does not hold, never above
    REQUIRE(expected.ok());
    for (const int rows : {1, 10, 52}) {
        std::optional<SplitResult> sum;
        for (const RowRange& band : bands_of(all_rows, rows)) {
            const auto result = check_split(*file->read(band), "", {"direct"});
            REQUIRE(result.ok());
            if (sum) add_rows(*sum, *result, band.first);
            else sum = *result;
        }
        CHECK(sum->largest_absolute == expected->largest_absolute);
        CHECK(sum->absolute_x == expected->absolute_x);
        CHECK(sum->absolute_y == expected->absolute_y);
        CHECK(sum->relative_y == expected->relative_y);
        CHECK(sum->exceeding == expected->exceeding);
        CHECK(sum->never_above == expected->never_above);
        CHECK(sum->answer == expected->answer);
        CHECK(sum->residual == expected->residual);
    }
}

TEST_CASE("a record in bands equals the frame buffer, and records merge to the whole in any order",
          "[display][bands][law3]") {
    const Folder folder;
    const std::string expected = record_of(filled_band(all_rows, 0, 5));
    std::vector<BandedRecord> records;
    for (int shard = 0; shard < 5; ++shard)
        records.push_back(opened(write_banded(folder, std::to_string(shard), shard, shard + 1)));
    CHECK(record_of(*sum_of_records({&records[2], 1})) == record_of(filled_band(all_rows, 2, 3)));
    std::vector<std::size_t> order{0, 1, 2, 3, 4};
    do {
        std::vector<BandedRecord> shuffled;
        for (const std::size_t i : order) shuffled.push_back(records[i]);
        const auto sum = sum_of_band(shuffled, all_rows);
        REQUIRE(sum.ok());
        CHECK((record_of(*sum) == expected));
    } while (std::next_permutation(order.begin(), order.begin() + 3));
}

TEST_CASE("an image in other bands gives the same rows", "[display][bands]") {
    const FrameBuffer whole = filled_band(all_rows, 0, 2);
    const BandedImage image = banded(7);
    for (const RowRange& rows : {RowRange{0, 53}, RowRange{7, 14}, RowRange{8, 13}, RowRange{5, 31}}) {
        std::string expected, found = "as it was";
        whole.append_record(expected, rows.first, rows.end);
        REQUIRE(image.append_record(found, rows).ok());
        CHECK((found == "as it was" + expected));
    }
}

TEST_CASE("incomplete, truncated and damaged records are refused by name", "[display][bands][law7]") {
    const Folder folder;
    const std::string path = write_banded(folder, "a", 0, 1);
    const auto error_of = [](const std::string& file) {
        auto reader = RecordFileReader::open(file);
        if (!reader) return reader.error();
        auto record = BandedRecord::open(*std::move(reader));
        REQUIRE_FALSE(record.ok());
        return record.error();
    };
    const std::string bytes = read_bytes(path);
    write_bytes(folder.path("cut"), bytes.substr(0, bytes.size() / 2));
    CHECK(error_of(folder.path("cut")).message.find("truncated: it ends after") != std::string::npos);
    CHECK(error_of(folder.path("cut")).file == folder.path("cut"));
    std::string damaged = bytes;
    damaged[bytes.size() / 2] = static_cast<char>(damaged[bytes.size() / 2] ^ 4);
    write_bytes(folder.path("damaged"), damaged);
    CHECK(error_of(folder.path("damaged")).message.find("is damaged: its checksum does not match") !=
          std::string::npos);
    auto other = RecordFileWriter::create(folder.path("other"), {}, 1);
    REQUIRE((other.ok() && other->add("something", "else").ok() && other->commit().ok()));
    CHECK(error_of(folder.path("other")).message == "the record contains no image");
    auto hole = RecordFileWriter::create(folder.path("hole"), {}, 1);
    REQUIRE(hole.ok());
    REQUIRE(add_bands(*hole, {{5, 9}}, banded(7)).ok());
    REQUIRE(hole->commit().ok());
    CHECK(error_of(folder.path("hole")).message == "the record's bands do not form an image");
}

namespace {

/// One block of a render of 128 x 128 pixels; the light of all blocks is merged.
FrameBuffer block_of_many(int block) {
    const std::vector<ChannelDefinition> channels{expression_channel("beauty", "C.*L"),
                                                  plain_channel("z", ChannelType::real, FilterRule::zmin)};
    FrameBuffer buffer({128, 128}, channels);
    SampleTable table(channels, 256);
    for (int y = 0; y < 128; ++y)
        for (int tile = 0; tile < 8; ++tile) {
            std::vector<CameraRow> rows;
            for (int x = 16 * tile; x < 16 * tile + 16; ++x)
                for (const CameraRow& row : pixel_rows(x, y, static_cast<std::uint64_t>(block) * 16, 16))
                    rows.push_back(row);
            table.begin(rows);
            Random random(static_cast<std::uint64_t>((block * 128 + y) * 8 + tile));
            for (std::size_t row = 0; row < rows.size(); ++row) {
                for (std::size_t c = 0; c < 3; ++c) table.raw_values(0)[3 * row + c] = random.uniform();
                table.raw_values(1)[row] = random.uniform();
                table.depth[row] = random.uniform_float();
                table.opacity[row] = raylex::RgbD(1.0);
                table.set_row_state(1, static_cast<int>(row), SampleTable::RowState::written);
            }
            table.touch(0);
            table.touch(1);
            buffer.accumulate(table);
        }
    return buffer;
}

/// Merges `shards` records of one block each in two orders, and one by one.
void check_many(int shards) {
    const Folder folder;
    std::vector<BandedRecord> records;
    std::optional<FrameBuffer> sum;
    for (int shard = 0; shard < shards; ++shard) {
        const FrameBuffer buffer = block_of_many(shard);
        auto writer = RecordFileWriter::create(folder.path(std::to_string(shard)), {}, 1, FileSync::later);
        REQUIRE((writer.ok() && add_bands(*writer, buffer).ok() && writer->commit().ok()));
        records.push_back(opened(folder.path(std::to_string(shard))));
        if (!sum) sum.emplace(block_of_many(shard));
        else REQUIRE(sum->merge(buffer).ok());
    }
    const std::string expected = record_of(*sum);
    for (const std::uint64_t order : {1, 2}) {
        Random random(order);
        for (std::size_t i = records.size(); i > 1; --i)
            std::swap(records[i - 1], records[static_cast<std::size_t>(random.below(static_cast<int>(i)))]);
        const auto merged = sum_of_records(records);
        REQUIRE(merged.ok());
        CHECK((record_of(*merged) == expected));
    }
}

}  // namespace

TEST_CASE("fifty shards add up in any order", "[display][bands][law3][gate]") {
    check_many(50);
}

TEST_CASE("a thousand shards add up in any order", "[.full][display][bands][law3]") {
    check_many(1000);
}
