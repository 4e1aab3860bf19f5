#include "display/output/reader/exr_reader.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>
#include <random>

#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>

#include "files.h"

using namespace raylex::test;
using raylex::display::ExrImage;
using raylex::display::ImageLayer;
using raylex::display::read_exr;
using raylex::display::read_exr_set;
using raylex::display::StoredType;

namespace {

// 3 x 2 pixels with values that identify channel and position, exact in half.
std::vector<float> ramp(float start) {
    return {start, start + 1, start + 2, start + 3, start + 4, start + 5};
}

std::vector<ForeignChannel> rgb(const std::string& prefix, float start, Imf::PixelType type = Imf::FLOAT) {
    return {{prefix + "R", type, ramp(start)},
            {prefix + "G", type, ramp(start + 10)},
            {prefix + "B", type, ramp(start + 20)}};
}

std::vector<ForeignChannel> join(std::vector<std::vector<ForeignChannel>> lists) {
    std::vector<ForeignChannel> all;
    for (auto& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
}

ExrImage read(const std::string& path) {
    auto image = read_exr(path);
    if (!image) FAIL(image.error().message);
    return std::move(*image);
}

std::vector<std::string> plane_names(const ImageLayer& layer) {
    std::vector<std::string> names;
    for (const auto& plane : layer.planes) names.push_back(plane.name);
    return names;
}

void write_deep(const std::string& path) {
    Imf::Header header(2, 1);
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    unsigned counts[2] = {1, 1};
    float depth = 1;
    char* pointers[2] = {reinterpret_cast<char*>(&depth), reinterpret_cast<char*>(&depth)};
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts), 4, 8));
    buffer.insert("Z",
                  Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers), sizeof(char*), 2 * sizeof(char*), 4));
    Imf::DeepScanLineOutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(1);
}

}  // namespace

TEST_CASE("one part with nameless RGBA and Blender's dotted names becomes layers", "[display][exr]") {
    const Folder folder;
    write_foreign(folder.path("a.exr"),
                  join({rgb("", 0, Imf::HALF),
                        {{"A", Imf::HALF, ramp(30)}},
                        rgb("ViewLayer.DiffDir.", 100, Imf::HALF),
                        {{"ViewLayer.Depth.Z", Imf::FLOAT, ramp(7)}}}),
                  3, 2);
    const ExrImage image = read(folder.path("a.exr"));
    CHECK(image.width == 3);
    CHECK(image.height == 2);
    CHECK(image.layer_names() == std::vector<std::string>{"", "ViewLayer.Depth", "ViewLayer.DiffDir"});
    const ImageLayer* beauty = image.layer("beauty");
    REQUIRE(beauty != nullptr);
    CHECK(beauty == image.layer(""));
    CHECK(plane_names(*beauty) == std::vector<std::string>{"R", "G", "B", "A"});
    CHECK(beauty->planes[0].stored == StoredType::half_float);
    CHECK(beauty->planes[1].values == ramp(10));
    CHECK(beauty->is_color());
    const ImageLayer* diffuse = image.layer("ViewLayer.DiffDir");
    CHECK(diffuse->triple()[2]->values == ramp(120));
    const ImageLayer* depth = image.layer("ViewLayer.Depth");
    CHECK(!depth->is_color());
    CHECK(depth->triple()[0] == depth->triple()[2]);
    CHECK(depth->planes[0].stored == StoredType::single_float);
}

TEST_CASE("parts whose channels carry the part's name read like parts with nameless channels", "[display][exr]") {
    const Folder folder;
    write_foreign_parts(
        folder.path("ours.exr"),
        {{"rgba", rgb("", 0)},
         {"diffuse", rgb("diffuse.", 50)},
         {"z", {{"Z", Imf::FLOAT, ramp(3)}}},
         {"id", {{"id", Imf::UINT, ramp(70)}}},
         {"P", {{"P.X", Imf::FLOAT, ramp(1)}, {"P.Y", Imf::FLOAT, ramp(2)}, {"P.Z", Imf::FLOAT, ramp(3)}}}},
        3, 2);
    write_foreign_parts(folder.path("theirs.exr"),
                        {{"beauty", rgb("", 0)},
                         {"diffuse", rgb("", 50)},
                         {"z", {{"Z", Imf::FLOAT, ramp(3)}}},
                         {"id", {{"id", Imf::UINT, ramp(70)}}},
                         {"P", {{"X", Imf::FLOAT, ramp(1)}, {"Y", Imf::FLOAT, ramp(2)}, {"Z", Imf::FLOAT, ramp(3)}}}},
                        3, 2);
    for (const char* name : {"ours.exr", "theirs.exr"}) {
        CAPTURE(name);
        const ExrImage image = read(folder.path(name));
        REQUIRE(image.layers.size() == 5);
        for (const char* beauty : {"", "beauty"}) {
            REQUIRE(image.layer(beauty) != nullptr);
            CHECK(image.layer(beauty)->triple()[0]->values == ramp(0));
        }
        REQUIRE(image.layer("diffuse") != nullptr);
        CHECK(image.layer("diffuse")->triple()[1]->values == ramp(60));
        CHECK(image.layer("diffuse")->part == "diffuse");
        REQUIRE(image.layer("z") != nullptr);
        CHECK(image.layer("z")->plane("Z")->values == ramp(3));
        CHECK(image.layer("id")->planes[0].stored == StoredType::unsigned_int);
        CHECK(image.layer("id")->planes[0].values == ramp(70));
        CHECK(image.layer("P")->triple()[2]->values == ramp(3));
        CHECK(image.layer("specular") == nullptr);
    }
}

TEST_CASE("nameless channels that are not colours are layers of their own", "[display][exr]") {
    const Folder folder;
    write_foreign(folder.path("a.exr"), join({rgb("", 0), {{"Z", Imf::FLOAT, ramp(3)}, {"id", Imf::UINT, ramp(9)}}}), 3,
                  2);
    const ExrImage image = read(folder.path("a.exr"));
    CHECK(image.layer_names() == std::vector<std::string>{"", "Z", "id"});
    CHECK(plane_names(*image.layer("")) == std::vector<std::string>{"R", "G", "B"});
    write_foreign(folder.path("depth.exr"), {{"Z", Imf::FLOAT, ramp(3)}}, 3, 2);
    CHECK(read(folder.path("depth.exr")).layer_names() == std::vector<std::string>{"Z"});
}

TEST_CASE("two parts that give the same name keep both layers", "[display][exr]") {
    const Folder folder;
    write_foreign_parts(folder.path("a.exr"), {{"left", rgb("diffuse.", 0)}, {"right", rgb("diffuse.", 50)}}, 3, 2);
    const ExrImage image = read(folder.path("a.exr"));
    CHECK(image.layer_names() == std::vector<std::string>{"diffuse", "right.diffuse"});
    CHECK(image.layer("right.diffuse")->triple()[0]->values == ramp(50));
}

TEST_CASE("tiled files and lower-case or spelled-out planes read the same", "[display][exr]") {
    const Folder folder;
    write_foreign(folder.path("tiled.exr"), rgb("", 0), box(3, 2), box(3, 2), 2);
    CHECK(read(folder.path("tiled.exr")).layer("")->triple()[2]->values == ramp(20));
    write_foreign(folder.path("small.exr"),
                  {{"d.r", Imf::FLOAT, ramp(0)},
                   {"d.g", Imf::FLOAT, ramp(1)},
                   {"d.b", Imf::FLOAT, ramp(2)},
                   {"s.red", Imf::FLOAT, ramp(3)},
                   {"s.green", Imf::FLOAT, ramp(4)},
                   {"s.blue", Imf::FLOAT, ramp(5)},
                   {"grey.Y", Imf::FLOAT, ramp(6)},
                   {"grey.A", Imf::FLOAT, ramp(7)},
                   {"uv.U", Imf::FLOAT, ramp(8)},
                   {"uv.V", Imf::FLOAT, ramp(9)}},
                  3, 2);
    const ExrImage image = read(folder.path("small.exr"));
    CHECK(image.layer("d")->triple()[0]->values == ramp(0));
    CHECK(image.layer("d")->triple()[1]->values == ramp(1));
    CHECK(image.layer("s")->triple()[2]->values == ramp(5));
    CHECK(image.layer("grey")->triple()[2]->values == ramp(6));
    CHECK(image.layer("uv")->triple()[0] == nullptr);
}

TEST_CASE("a data window inside or beyond the display window is positioned correctly", "[display][exr]") {
    const Folder folder;
    // Display 4 x 3; data 3 x 2 with its first pixel at (-1, 1): one column is cropped, the rest filled with 0.
    write_foreign(folder.path("a.exr"), rgb("", 1), box(4, 3), Imath::Box2i({-1, 1}, {1, 2}));
    const ExrImage image = read(folder.path("a.exr"));
    CHECK(image.width == 4);
    CHECK(image.height == 3);
    CHECK(image.layer("")->planes[0].values == std::vector<float>{0, 0, 0, 0, 2, 3, 0, 0, 5, 6, 0, 0});
}

TEST_CASE("subsampled channels are expanded to full resolution", "[display][exr]") {
    const Folder folder;
    Imf::Header header(4, 2);
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    header.channels().insert("RY", Imf::Channel(Imf::FLOAT, 2, 2));
    float luma[8] = {1, 2, 3, 4, 5, 6, 7, 8}, chroma[2] = {10, 20};
    Imf::FrameBuffer buffer;
    buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(luma), 4, 16));
    buffer.insert("RY", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(chroma), 4, 8, 2, 2));
    {
        Imf::OutputFile file(folder.path("a.exr").c_str(), header);
        file.setFrameBuffer(buffer);
        file.writePixels(2);
    }
    const ExrImage image = read(folder.path("a.exr"));
    CHECK(image.layer("")->plane("RY")->values == std::vector<float>{10, 10, 20, 20, 10, 10, 20, 20});
    CHECK(image.layer("")->plane("Y")->values == std::vector<float>(luma, luma + 8));
}

TEST_CASE("one file per layer makes one image named after the files", "[display][exr]") {
    const Folder folder;
    write_foreign(folder.path("beauty.exr"), rgb("", 0), 3, 2);
    write_foreign(folder.path("shot_diffuse.0001.exr"), join({rgb("", 50), {{"Z", Imf::FLOAT, ramp(1)}}}), 3, 2);
    write_foreign(folder.path("specular.v2.exr"), join({rgb("", 80), {{"Z", Imf::FLOAT, ramp(2)}}}), 3, 2);
    auto set =
        read_exr_set({folder.path("beauty.exr"), folder.path("shot_diffuse.0001.exr"), folder.path("specular.v2.exr")});
    REQUIRE(set.ok());
    CHECK(set->layer_names() ==
          std::vector<std::string>{"beauty", "shot_diffuse", "Z", "specular.v2", "specular.v2.Z"});
    CHECK(set->layer("")->triple()[0]->values == ramp(0));
    CHECK(set->layer("shot_diffuse")->triple()[0]->values == ramp(50));

    write_foreign(folder.path("wide.exr"), {{"R", Imf::FLOAT, std::vector<float>(8)}}, 4, 2);
    auto sizes = read_exr_set({folder.path("beauty.exr"), folder.path("wide.exr")});
    REQUIRE(!sizes.ok());
    CHECK(sizes.error().file == folder.path("wide.exr"));
    CHECK(sizes.error().message.find("4 x 2") != std::string::npos);
    CHECK(sizes.error().message.find("3 x 2") != std::string::npos);
    CHECK(!read_exr_set({folder.path("beauty.exr"), folder.path("missing.exr")}).ok());
    CHECK(!read_exr_set({}).ok());
    std::filesystem::create_directory(folder.path("b"));
    write_foreign(folder.path("b/beauty.exr"), rgb("", 0), 3, 2);
    CHECK(!read_exr_set({folder.path("beauty.exr"), folder.path("b/beauty.exr")}).ok());  // the same name twice
}

TEST_CASE("string attributes, chromaticities and declared partitions come with the image", "[display][exr]") {
    const Folder folder;
    Imf::Header header(1, 1);
    header.insert("owner", Imf::StringAttribute("somebody"));
    header.insert("partition/light groups", Imf::StringAttribute("beauty = key light + fill + rest"));
    Imf::addChromaticities(
        header, Imf::Chromaticities({0.713f, 0.293f}, {0.165f, 0.83f}, {0.128f, 0.044f}, {0.32168f, 0.33767f}));
    const ForeignPixels pixels({{"R", Imf::FLOAT, {1}}, {"G", Imf::FLOAT, {1}}, {"B", Imf::FLOAT, {1}}}, box(1, 1),
                               header);
    {
        Imf::OutputFile file(folder.path("a.exr").c_str(), header);
        file.setFrameBuffer(pixels.buffer());
        file.writePixels(1);
    }
    const ExrImage image = read(folder.path("a.exr"));
    CHECK(image.attributes.at("owner") == "somebody");
    REQUIRE(image.chromaticities.has_value());
    CHECK(image.chromaticities->green[1] == Approx(0.83).margin(1e-6));  // stored as float
    REQUIRE(image.partitions.size() == 1);
    CHECK(image.partitions[0].name == "light groups");
    CHECK(image.partitions[0].of == "beauty");
    CHECK(image.partitions[0].layers == std::vector<std::string>{"key light", "fill", "rest"});
}

TEST_CASE("missing, foreign, deep and oversized files get errors that name the file", "[display][exr][law7]") {
    const Folder folder;
    const auto failure = [](const std::string& path) {
        auto image = read_exr(path);
        REQUIRE(!image.ok());
        CHECK(image.error().file == path);
        return image.error().message;
    };
    CHECK(failure(folder.path("missing.exr")).find("No such file") != std::string::npos);
    CHECK(failure(folder.path()).find("directory") != std::string::npos);
    write_bytes(folder.path("empty.exr"), "");
    CHECK(failure(folder.path("empty.exr")).find("empty") != std::string::npos);
    write_bytes(folder.path("text.exr"), "P6 3 2 255 not an EXR");
    CHECK(failure(folder.path("text.exr")).find("not an OpenEXR file") != std::string::npos);
    write_deep(folder.path("deep.exr"));
    CHECK(failure(folder.path("deep.exr")).find("deep") != std::string::npos);

    write_foreign(folder.path("huge.exr"), rgb("", 0), 3, 2);
    std::string bytes = read_bytes(folder.path("huge.exr"));
    for (const char* window : {"dataWindow", "displayWindow"}) {
        const std::size_t at = bytes.find(window) + std::string(window).size() + 1 + 6 + 4;  // name, "box2i", size
        const std::int32_t far[2] = {1'000'000'000, 1'000'000'000};
        bytes.replace(at + 8, 8, reinterpret_cast<const char*>(far), 8);
    }
    write_bytes(folder.path("huge.exr"), bytes);
    CHECK(!failure(folder.path("huge.exr")).empty());
}

TEST_CASE("a file that is truncated or damaged anywhere is refused or read, and never crashes",
          "[display][exr][law7]") {
    const Folder folder;
    write_foreign_parts(folder.path("whole.exr"), {{"rgba", rgb("", 0)}, {"diffuse", rgb("diffuse.", 50, Imf::HALF)}},
                        3, 2);
    const std::string bytes = read_bytes(folder.path("whole.exr"));
    REQUIRE(read_exr(folder.path("whole.exr")).ok());
    for (std::size_t length = 0; length < bytes.size(); length += 7) {
        write_bytes(folder.path("cut.exr"), bytes.substr(0, length));
        const auto image = read_exr(folder.path("cut.exr"));
        CAPTURE(length);
        REQUIRE(!image.ok());
        REQUIRE(!image.error().message.empty());
    }
    std::mt19937 random(1);
    std::size_t refused = 0;
    for (int i = 0; i < 400; ++i) {
        std::string damaged = bytes;
        damaged[8 + random() % (bytes.size() - 8)] = static_cast<char>(random());
        write_bytes(folder.path("damaged.exr"), damaged);
        refused += read_exr(folder.path("damaged.exr")).ok() ? 0 : 1;
    }
    CHECK(refused > 0);  // most damage hits pixels and is not detected; damage to headers and tables is
}

TEST_CASE("several threads read the parts of a large file, and every value is in its place",
          "[display][exr][law7][gate]") {
    constexpr int width = 400, height = 256;
    const Folder folder;
    std::mt19937 random(2);
    const auto noise = [&] {
        std::vector<float> values(std::size_t{width} * height);
        for (float& value : values) value = static_cast<float>(random());
        return values;
    };
    std::vector<ForeignPart> parts;
    for (const char* name : {"beauty", "a", "b", "c", "d"})
        parts.push_back({name, {{"R", Imf::FLOAT, noise()}, {"G", Imf::FLOAT, noise()}, {"B", Imf::FLOAT, noise()}}});
    const std::string path = folder.path("large.exr");
    write_foreign_parts(path, parts, width, height);
    REQUIRE(std::filesystem::file_size(path) > std::uintmax_t{1} << 22);  // a single thread reads smaller files

    const ExrImage image = read(path);
    REQUIRE(image.layers.size() == parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
        CHECK(image.layers[i].name == parts[i].name);
        for (std::size_t c = 0; c < 3; ++c)
            CHECK(image.layers[i].planes[c].values == parts[i].channels[c].values);  // exact, because nothing is
                                                                                     // rounded
    }

    std::string damaged = read_bytes(path);
    damaged.replace(damaged.size() / 2, 4096, std::string(4096, '\x55'));  // packed pixels, protected by zlib's
                                                                           // checksum
    write_bytes(path, damaged);
    const auto refused = read_exr(path);
    REQUIRE(!refused.ok());
    CHECK(refused.error().message.find("damaged") != std::string::npos);
}
