// QOI images, written by hand from the specification, and BMP: the meaning of every chunk, and damaged files.
#include <catch2/catch.hpp>

#include <random>

#include "tests/transport/import_support.h"
#include "transport/files/images/image.h"

using namespace import_test;
using raylex::transport::Image;
using raylex::transport::read_image;

namespace image_qoi_test {
namespace {

using Bytes = std::vector<int>;

std::string text_of(const Bytes& bytes) {
    std::string text;
    for (const int byte : bytes) text += static_cast<char>(byte);
    return text;
}

std::string big_endian(std::uint32_t value) {
    return text_of({int(value >> 24), int(value >> 16 & 255), int(value >> 8 & 255), int(value & 255)});
}

std::string qoi(std::uint32_t width, std::uint32_t height, int channels, int space, const Bytes& chunks) {
    return "qoif" + big_endian(width) + big_endian(height) + text_of({channels, space}) + text_of(chunks) +
           text_of({0, 0, 0, 0, 0, 0, 0, 1});
}

Image read(const std::string& path, const std::string& encoding = {}) {
    auto image = read_image(path, encoding);
    if (!image) FAIL(image.error().to_string());
    return std::move(*image);
}

/// The values in units of 1/255.
std::vector<int> values(const Image& image) {
    std::vector<int> all;
    for (const float value : image.pixels) all.push_back(static_cast<int>(std::lround(value * 255)));
    return all;
}

// (200, 10, 20) is at index (600 + 50 + 140 + 2805) % 64 = 11.
const Bytes every_chunk{
    0xc1,  // a run of 2: black, opaque
    0xfe,
    200,
    10,
    20,                          // RGB
    0x40 | 3 << 4 | 0 << 2 | 2,  // differences of 1, -2 and 0
    0x80 | (32 - 9),
    0x8f,  // green by -9, red by the same, blue by 7 more
    11,    // the pixel at index 11
    0xff,
    1,
    2,
    3,
    4,  // RGBA
};
const std::vector<int> every_pixel{0,  0,   0,   255, 0,  0,   0,   255, 200, 10,  20, 255, 201, 8,
                                   20, 255, 192, 255, 18, 255, 200, 10,  20,  255, 1,  2,   3,   4};

}  // namespace

TEST_CASE("a QOI image has the pixels of its chunks", "[image]") {
    const Folder folder;
    const std::string whole = qoi(7, 1, 4, 1, every_chunk);
    const Image image = read(folder.write("a.qoi", whole));
    REQUIRE(image.channels == 4);
    CHECK(values(image) == every_pixel);
    // With another name, and without alpha; the header sets the length of rows.
    const Image rgb = read(folder.write("a.png", qoi(1, 7, 3, 1, every_chunk)));
    CHECK((rgb.width == 1 && rgb.height == 7 && rgb.channels == 3));
    CHECK(rgb.at(0, 4, 1) == 1);
    // The file declares whether its values are linear, unless the scene overrides it.
    const float half = 128 / 255.0f;
    CHECK(read(folder.write("l.qoi", qoi(1, 1, 3, 1, {0xfe, 128, 128, 128}))).pixels[0] == half);
    CHECK(read(folder.path("l.qoi"), "sRGB").pixels[0] == Approx(0.215861).margin(1e-6));  // IEC 61966-2-1 of 128/255
    CHECK(read(folder.write("s.qoi", qoi(1, 1, 3, 0, {0xfe, 128, 128, 128}))).pixels[0] ==
          Approx(0.215861).margin(1e-6));
    CHECK(read(folder.path("s.qoi"), "linear").pixels[0] == half);
}

TEST_CASE("a truncated, damaged or absurd QOI image is an error that names the file", "[image][law7]") {
    const Folder folder;
    const auto refused = [&](const std::string& content) {
        const auto image = read_image(folder.write("d.qoi", content));
        REQUIRE_FALSE(image);
        CHECK(image.error().file == folder.path("d.qoi"));
        return image.error().message;
    };
    const std::string whole = qoi(7, 1, 4, 1, every_chunk);
    for (std::size_t size = 4; size < whole.size(); ++size)
        CHECK(contains(refused(whole.substr(0, size)), "QOI is truncated"));
    CHECK(contains(refused(qoi(8, 1, 4, 1, every_chunk)), "as many pixels as its header states"));
    CHECK(contains(refused(qoi(1, 1, 4, 1, {0xc1})), "as many pixels as its header states"));  // a run of 2
    CHECK(contains(refused(qoi(0, 1, 4, 1, every_chunk)), "QOI header has no size"));
    CHECK(contains(refused(qoi(0x80000000, 1, 4, 1, every_chunk)), "QOI header has no size"));
    CHECK(contains(refused(qoi(7, 1, 5, 1, every_chunk)), "other than 3 or 4 channels"));
    CHECK(contains(refused(qoi(7, 1, 4, 2, every_chunk)), "unknown colour space"));
    // Refused by the header, before memory is allocated.
    CHECK(contains(refused(qoi(0x7fffffff, 0x7fffffff, 4, 0, every_chunk)), "the image has 2147483647 x 2147483647"));
    CHECK(contains(refused(qoi(20000, 2000, 4, 0, every_chunk)), "the image has 20000 x 2000 pixels"));
}

TEST_CASE("a QOI image with random changes is read or refused", "[image][law7][gate]") {
    const Folder folder;
    std::mt19937 random(7);
    const std::string whole = qoi(7, 1, 4, 1, every_chunk);
    int read = 0;
    for (int i = 0; i < 2000; ++i) {
        std::string changed = whole;
        for (int k = 0; k < 3; ++k) changed[4 + random() % (changed.size() - 4)] = static_cast<char>(random());
        const auto image = read_image(folder.write("r.qoi", changed));
        if (!image) continue;
        ++read;
        CHECK(image->pixels.size() ==
              std::size_t(image->width) * std::size_t(image->height) * std::size_t(image->channels));
    }
    CHECK(read > 100);  // often only pixels differ
}

TEST_CASE("BMP is read from both ends, and refused if rows are missing", "[image]") {
    const Folder folder;
    const auto bmp = [](int height, int rows) {  // two pixels of 24 bits a row, padded to 8 bytes
        Bytes bytes{'B', 'M', 70, 0, 0, 0, 0, 0, 0, 0, 54, 0, 0, 0, 40, 0, 0, 0, 2, 0, 0, 0};
        for (int shift = 0; shift < 32; shift += 8) bytes.push_back(height >> shift & 255);
        bytes.insert(bytes.end(), {1, 0, 24, 0});
        bytes.resize(54);
        for (int row = 0; row < rows; ++row) bytes.insert(bytes.end(), {row * 255, 0, 255 - row * 255, 0, 51, 0, 0, 0});
        return text_of(bytes);
    };
    const Image up = read(folder.write("a.bmp", bmp(2, 2)), "linear"),
                down = read(folder.write("b.bmp", bmp(-2, 2)), "linear");
    CHECK(values(up) == std::vector<int>{0, 0, 255, 0, 51, 0, 255, 0, 0, 0, 51, 0});
    CHECK(values(down) == std::vector<int>{255, 0, 0, 0, 51, 0, 0, 0, 255, 0, 51, 0});
    for (const std::string& content : {bmp(2, 1), bmp(2, 2).substr(0, 69), bmp(2, 0).substr(0, 40), bmp(1 << 30, 2)}) {
        const auto image = read_image(folder.write("t.bmp", content));
        REQUIRE_FALSE(image);
        CHECK(contains(image.error().message, "BMP is truncated"));
    }
}

}  // namespace image_qoi_test
