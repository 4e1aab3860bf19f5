// Image files: orientation, byte order, encodings, and truncated files.
#include <catch2/catch.hpp>

#include <zlib.h>

#include <bit>
#include <cstring>

#include "tests/support/paths.h"
#include "tests/transport/import_support.h"
#include "transport/files/images/image.h"

using namespace import_test;
using raylex::transport::Image;
using raylex::transport::read_image;

namespace {

const std::string data_folder = raylex::test::source_dir() + "/tests/transport/data/";

Image read(const std::string& path, const std::string& encoding = {}) {
    auto image = read_image(path, encoding);
    if (!image) FAIL(image.error().to_string());
    return std::move(*image);
}

std::string big_endian(std::uint32_t value) {
    return {static_cast<char>(value >> 24), static_cast<char>(value >> 16 & 255), static_cast<char>(value >> 8 & 255),
            static_cast<char>(value & 255)};
}

std::string png_chunk(const std::string& type, const std::string& content) {
    std::string body = type;
    body += content;
    const auto crc = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
    std::string chunk = big_endian(static_cast<std::uint32_t>(content.size()));
    chunk += body;
    chunk += big_endian(static_cast<std::uint32_t>(crc));
    return chunk;
}

std::string deflated(const std::string& bytes) {
    std::string packed(compressBound(static_cast<uLong>(bytes.size())), '\0');
    auto size = static_cast<uLongf>(packed.size());
    REQUIRE(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                     static_cast<uLong>(bytes.size())) == Z_OK);
    packed.resize(size);
    return packed;
}

/// Makes a PNG. `rows`: filter byte 0 and big-endian samples for each row. color: 0 grey, 2 RGB, 3 palette, 4 grey with
/// alpha, 6 RGBA. `chunks` precede the pixels.
std::string png(std::uint32_t width, std::uint32_t height, int depth, int color, const std::string& rows,
                const std::string& chunks = {}, int interlacing = 0) {
    std::string header = big_endian(width);
    header += big_endian(height);
    header += {static_cast<char>(depth), static_cast<char>(color), 0, 0, static_cast<char>(interlacing)};
    return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + chunks + png_chunk("IDAT", deflated(rows)) +
           png_chunk("IEND", "");
}

std::string float_bytes(std::initializer_list<float> values, std::endian order) {
    std::string bytes;
    for (const float value : values) {
        char four[4];
        std::memcpy(four, &value, 4);
        if (order != std::endian::native) std::reverse(std::begin(four), std::end(four));
        bytes.append(four, 4);
    }
    return bytes;
}

/// Checks that every proper prefix of `content` of at least `least` bytes is refused with the file's name.
void check_truncation(const Folder& folder, const std::string& name, const std::string& content, std::size_t step = 1) {
    for (std::size_t size = 0; size < content.size(); size += step) {
        const auto image = read_image(folder.write(name, content.substr(0, size)));
        INFO(name << " cut to " << size << " of " << content.size());
        REQUIRE_FALSE(image);
        REQUIRE(image.error().file == folder.path(name));
    }
}

}  // namespace

TEST_CASE("an 8-bit PNG is sRGB by default, linear or gamma on demand, row 0 on top", "[image]") {
    const Folder folder;
    using namespace std::string_literals;
    const std::string path = folder.write("a.png", png(2, 2, 8, 2, "\0\xff\0\0\0\x80\0"s + "\0\0\0\xff\x40\x40\x40"s));
    const Image srgb = read(path);
    REQUIRE(srgb.width == 2);
    REQUIRE(srgb.height == 2);
    REQUIRE(srgb.channels == 3);
    CHECK(srgb.at(0, 0, 0) == 1);
    CHECK(srgb.at(0, 0, 1) == 0);
    CHECK(srgb.at(1, 0, 1) == Approx(0.215861).margin(1e-6));  // IEC 61966-2-1 of 128/255
    CHECK(srgb.at(0, 1, 2) == 1);
    CHECK(srgb.at(1, 1, 0) == Approx(0.051269).margin(1e-6));  // of 64/255
    CHECK(read(path, "sRGB").pixels == srgb.pixels);
    CHECK(read(path, "linear").at(1, 0, 1) == Approx(128 / 255.0));
    CHECK(read(path, "gamma 2").at(1, 1, 0) == Approx(64 / 255.0 * 64 / 255.0));
    for (const char* bad : {"srgb8", "gamma", "gamma x", "gamma 0", "gamma 2 2"}) {
        const auto image = read_image(path, bad);
        REQUIRE_FALSE(image);
        CHECK(contains(image.error().message, "unknown image encoding"));
        CHECK(image.error().file == path);
    }
}

TEST_CASE("a 16-bit PNG keeps its precision, and alpha is decoded like colours", "[image]") {
    const Folder folder;
    using namespace std::string_literals;
    const Image grey = read(folder.write("g.png", png(2, 1, 16, 0, "\0\x80\x01\xff\xff"s)), "linear");
    CHECK(grey.channels == 1);
    CHECK(grey.at(0, 0, 0) == Approx(32769 / 65535.0));
    CHECK(grey.at(1, 0, 0) == 1);
    const Image alpha = read(folder.write("a.png", png(1, 1, 16, 4, "\0\x80\x00\x80\x00"s)));
    CHECK(alpha.channels == 2);
    CHECK(alpha.at(0, 0, 0) == Approx(0.2140).margin(1e-3));
    CHECK(alpha.at(0, 0, 1) == Approx(0.2140).margin(1e-3));
    const Image rgba = read(folder.write("c.png", png(1, 1, 8, 6, "\0\x80\x80\x80\x80"s)));
    CHECK(rgba.channels == 4);
    CHECK(rgba.at(0, 0, 3) == Approx(0.215861).margin(1e-6));
    CHECK(rgba.at(0, 0, 2) == Approx(0.215861).margin(1e-6));
}

TEST_CASE("TGA is read from both ends, raw and run-length encoded", "[image]") {
    const Folder folder;
    using namespace std::string_literals;
    const auto header = [](char type, char descriptor) {
        return "\0\0"s + type + "\0\0\0\0\0\0\0\0\0\2\0\2\0\x18"s + descriptor;
    };
    const std::string raw =
        header(2, 0) + "\0\0\xff\0\0\xff"s + "\xff\0\0\xff\0\0"s;  // bottom row red, top row blue (BGR)
    const std::string packed =
        header(10, 0x20) + "\x81\xff\0\0\x01\0\0\xff\0\0\xff"s;  // from the top: blue run, red pair
    for (const std::string& content : {raw, packed}) {
        const Image image = read(folder.write("a.tga", content));
        CHECK(image.at(0, 0, 2) == 1);
        CHECK(image.at(1, 0, 0) == 0);
        CHECK(image.at(0, 1, 0) == 1);
        check_truncation(folder, "t.tga", content);
    }
}

TEST_CASE("JPEG is read top-down", "[image]") {
    const Image image = read(data_folder + "halves.jpg");
    REQUIRE(image.width == 16);
    CHECK(image.at(8, 1, 0) > 0.9f);
    CHECK(image.at(8, 1, 2) < 0.1f);
    CHECK(image.at(8, 14, 0) < 0.1f);
    CHECK(image.at(8, 14, 2) > 0.9f);
}

TEST_CASE("JPEG may be progressive, grey or CMYK", "[image]") {
    // 3 / 255: the quantisation error of one colour at quality 95 (steps of 1 to 3 for the mean of a block).
    const float step = 3 / 255.0f;
    CHECK(read(data_folder + "progressive.jpg").at(4, 4, 0) > 0.9f);
    const Image grey = read(data_folder + "grey.jpg", "linear");
    CHECK(grey.channels == 1);
    CHECK(grey.at(8, 8, 0) == Approx(128 / 255.0).margin(step));
    const Image inks = read(data_folder + "inks.jpg", "linear");
    REQUIRE(inks.channels == 3);
    const float above[] = {1, 0, 0}, below[] = {0, 64 / 255.0f, 128 / 255.0f};
    for (int c = 0; c < 3; ++c) {
        CHECK(inks.at(4, 4, c) == Approx(above[c]).margin(step));
        CHECK(inks.at(4, 12, c) == Approx(below[c]).margin(step));
    }
}

TEST_CASE("the existing part of a truncated JPEG is read, with a warning", "[image][gate]") {
    const Folder folder;
    const std::string whole = raylex::test::read_bytes(data_folder + "halves.jpg"), scan = "\xff\xda";
    const std::size_t header = whole.rfind(scan), data = header + 14;
    const Image intact = read(data_folder + "halves.jpg");
    CHECK(intact.warning.empty());
    for (std::size_t size = 0; size < whole.size(); ++size) {
        INFO("cut to " << size << " of " << whole.size());
        const auto image = read_image(folder.write("t.jpg", whole.substr(0, size)));
        if (size <= header) REQUIRE_FALSE(image);
        if (size >= data) REQUIRE(image);
        if (!image) {
            REQUIRE(image.error().file == folder.path("t.jpg"));
            continue;
        }
        REQUIRE(image->pixels.size() == intact.pixels.size());
        REQUIRE(contains(image->warning, "JPEG: Premature end of JPEG file; expected a whole image"));
        if (size + 2 == whole.size()) CHECK(image->pixels == intact.pixels);  // only the end marker is missing
    }
}

TEST_CASE("a damaged JPEG is an error with the decoder's reason", "[law7][image]") {
    const Folder folder;
    // The next scan's table cannot be read, after a warning that the file ends: the result is an error, not an image.
    const std::string progressive = raylex::test::read_bytes(data_folder + "progressive.jpg"), table = "\xff\xc4";
    const std::size_t next = progressive.find(table, progressive.find("\xff\xda"));
    const auto broken = read_image(folder.write("p.jpg", progressive.substr(0, next + 6)));
    REQUIRE_FALSE(broken);
    CHECK(contains(broken.error().message, "JPEG: "));
    CHECK(read(folder.write("p.jpg", progressive.substr(0, next))).warning.find("Premature end") != std::string::npos);
    // Found by fuzzing: Huffman tables with more codes than any decoder stores.
    const std::string tables = std::string("\xff\xd8\xff\xff\xc4\x02\x13\x00", 8) + std::string(16, '\x20') +
                               std::string(512, '\0') + "\xff\xda\xff\xd9";
    const auto image = read_image(folder.write("d.jpg", tables));
    REQUIRE_FALSE(image);
    CHECK(contains(image.error().message, "JPEG: "));
}

TEST_CASE("a PNG may be interlaced, and have a palette, 1-bit samples and a transparent colour", "[image]") {
    const Folder folder;
    using namespace std::string_literals;
    // Adam7 of 2 x 2: pass 1 is the pixel (0, 0), pass 6 is (1, 0), pass 7 is the second row.
    const Image adam7 = read(folder.write("i.png", png(2, 2, 8, 0, "\0\x10\0\x20\0\x30\x40"s, {}, 1)), "linear");
    CHECK(adam7.pixels == std::vector<float>{16 / 255.0f, 32 / 255.0f, 48 / 255.0f, 64 / 255.0f});
    const std::string palette = png_chunk("PLTE", "\xff\0\0\0\xff\0"s), half = png_chunk("tRNS", "\x80"s);
    const Image indexed = read(folder.write("p.png", png(2, 1, 1, 3, "\0\x40"s, palette)), "linear");
    CHECK(indexed.pixels == std::vector<float>{1, 0, 0, 0, 1, 0});
    const Image transparent = read(folder.write("t.png", png(2, 1, 1, 3, "\0\x40"s, palette + half)), "linear");
    CHECK(transparent.pixels == std::vector<float>{1, 0, 0, 128 / 255.0f, 0, 1, 0, 1});
    const Image bits = read(folder.write("b.png", png(4, 1, 2, 0, "\0\x1b"s)), "linear");
    CHECK(bits.pixels == std::vector<float>{0, 85 / 255.0f, 170 / 255.0f, 1});
    // The scene decides how values are encoded, not the file.
    const std::string gamma = png_chunk("gAMA", big_endian(100'000));
    const Image marked = read(folder.write("g.png", png(1, 1, 8, 0, "\0\x80"s, gamma)), "linear");
    CHECK(marked.at(0, 0, 0) == 128 / 255.0f);
}

TEST_CASE("OpenEXR gives RGB, RGBA in its data window, luminance or a lone channel", "[image]") {
    // Fixtures contain channel + 10 y + 100 x, exact in half.
    const auto check = [](const Image& image, int channels) {
        REQUIRE(image.width == 3);
        REQUIRE(image.height == 2);
        REQUIRE(image.channels == channels);
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 3; ++x)
                for (int c = 0; c < channels; ++c) CHECK(image.at(x, y, c) == static_cast<float>(c + 10 * y + 100 * x));
    };
    check(read(data_folder + "rgb_half.exr"), 3);
    check(read(data_folder + "rgba_window.exr"), 4);
    check(read(data_folder + "luminance.exr"), 1);
    check(read(data_folder + "depth.exr"), 1);
    const auto normals = read_image(data_folder + "normals.exr");
    REQUIRE_FALSE(normals);
    CHECK(contains(normals.error().message, "has channels N.X N.Y N.Z; expected R G B, Y or a single one"));
}

TEST_CASE("PFM is read bottom-up in both byte orders, with its scale", "[image]") {
    const Folder folder;
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        const std::string scale = order == std::endian::little ? "-2" : "2";
        const Image grey = read(folder.write("g.pfm", "Pf\n1 2\n" + scale + "\n" + float_bytes({0.5f, 3}, order)));
        CHECK(grey.channels == 1);
        CHECK(grey.at(0, 0, 0) == 6);
        CHECK(grey.at(0, 1, 0) == 1);
        const std::string color = "PF 1 1 " + scale + "\n" + float_bytes({1, 2, 4}, order);
        CHECK(read(folder.write("c.pfm", color)).pixels == std::vector<float>{2, 4, 8});
        check_truncation(folder, "t.pfm", color);
    }
    for (const char* header : {"PF\n0 1\n-1\n", "PF\n1 -1\n-1\n", "PF\nx\n", "Pf\n1 1\n0\n", "Pf\n1 1\nnan\n",
                               "PF\n2000000000 2000000000\n-1\n"})
        CHECK_FALSE(read_image(folder.write("b.pfm", std::string(header) + "0123456789abcdef")));
}

TEST_CASE("Radiance HDR keeps values above 1 and ignores the encoding", "[image]") {
    const Folder folder;
    using namespace std::string_literals;
    // Shared exponent: mantissa 128 at exponent 130 is 128 * 2^(130 - 136) = 2.
    const std::string file =
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"s + "\x80\x40\x20\x82"s + "\x80\x80\x80\x81"s;
    const Image image = read(folder.write("a.hdr", file), "linear");
    CHECK(image.pixels == std::vector<float>{2, 1, 0.5f, 1, 1, 1});
    CHECK(read(folder.path("a.hdr")).pixels == image.pixels);
}

TEST_CASE("an image truncated anywhere is an error that names the file", "[image][law7]") {
    const Folder folder;
    using raylex::test::read_bytes;
    check_truncation(folder, "a.exr", read_bytes(data_folder + "rgb_half.exr"), 5);
    const std::string whole = read_bytes(raylex::test::source_dir() + "/experiments/scenes/still-life/leaf.png");
    // The last 12 bytes are the empty end chunk; without it all pixels are complete.
    check_truncation(folder, "a.png", whole.substr(0, whole.size() - 12), 3);
}

TEST_CASE("a file that is not an image is an error that lists the formats", "[image][law7]") {
    const Folder folder;
    const auto image = read_image(folder.write("a.png", "hello, I am text"));
    REQUIRE_FALSE(image);
    CHECK(contains(image.error().message,
                   "unknown image format; expected PNG, JPEG, TGA, BMP, QOI, HDR, OpenEXR or PFM"));
    const auto gif = read_image(folder.write("a.gif", "GIF89a and the rest"));
    REQUIRE_FALSE(gif);
    CHECK(contains(gif.error().message, "GIF images are not supported; expected PNG"));
    CHECK_FALSE(read_image(folder.path("missing.png")));
}
