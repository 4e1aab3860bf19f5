// Law 7 for external images: header fields are checked against the file before memory is allocated.
#include <catch2/catch.hpp>

#include <sys/stat.h>

#include <cstring>

#include "display/output/reader/exr_guard.h"
#include "tests/display/files.h"
#include "tests/support/budget_guard.h"

using namespace raylex;
using namespace raylex::test;

namespace {

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::string refusal(const std::string& path) {
    const auto image = display::read_exr(path);
    return image ? "" : image.error().to_string();
}

std::vector<ForeignChannel> rgb(std::size_t pixels) {
    std::vector<ForeignChannel> channels;
    for (const char* name : {"R", "G", "B"}) channels.push_back({name, Imf::FLOAT, std::vector<float>(pixels, 1.0f)});
    return channels;
}

/// Returns the file's bytes with both windows resized to `width` by `height`.
std::string resized(std::string bytes, std::int32_t width, std::int32_t height, bool display_window = true) {
    for (const char* window : {"dataWindow", "displayWindow"}) {
        if (!display_window && std::string(window) == "displayWindow") continue;
        const std::size_t at = bytes.find(window) + std::strlen(window) + 1 + std::strlen("box2i") + 1 + 4;
        const std::int32_t box[4] = {0, 0, width - 1, height - 1};
        std::memcpy(bytes.data() + at, box, sizeof box);
    }
    return bytes;
}

}  // namespace

TEST_CASE("an EXR header that declares more than its bytes can contain is refused", "[law7][budget]") {
    const Folder folder;
    const std::string path = folder.path("a.exr");
    write_foreign(path, rgb(12), box(4, 3), box(4, 3));
    const std::string sound = read_bytes(path);
    CHECK(refusal(path).empty());
    // 16 M x 32 pixels in less than a kilobyte: the data window alone, and both windows.
    for (const bool both : {false, true}) {
        write_bytes(path, resized(sound, 1 << 24, 32, both));
        CHECK(contains(refusal(path), "the budget image_pixels is 268435456"));
        const BudgetGuard more("image_pixels=4G");
        CHECK(contains(refusal(path), "the budget exr_ratio is 1032"));
    }
    write_bytes(path, resized(sound, 20'000, 10'000));
    CHECK(contains(refusal(path), "exr_ratio"));
    // The flag for deep data in the version field does not change how the library reads a part that is not deep.
    std::string marked = resized(sound, 1 << 22, 16);
    marked[5] = static_cast<char>(marked[5] | 0x08);
    write_bytes(path, marked);
    CHECK(contains(refusal(path), "exr_ratio"));
    write_bytes(path, resized(sound, 0x7fffffff, 0x7fffffff));
    CHECK(contains(refusal(path), "image_pixels"));
}

TEST_CASE("uncompressed pixels are checked against the size of the file", "[law7][budget]") {
    const Folder folder;
    const std::string path = folder.path("a.exr");
    write_foreign(path, rgb(12), box(4, 3), box(4, 3));
    std::string bytes = read_bytes(path);
    const std::size_t compression = bytes.find("compression");
    bytes[bytes.find(std::string("compression\0compression\0", 24), compression) + 28] = 0;  // none
    write_bytes(path, resized(bytes, 4'000, 3'000));
    CHECK(contains(refusal(path), "the file is truncated: its header declares 144000000 bytes of uncompressed pixels"));
}

TEST_CASE("an attribute that ends after the end of the file is refused before it is read", "[law7][budget]") {
    const Folder folder;
    const std::string path = folder.path("a.exr");
    write_foreign(path, rgb(12), box(4, 3), box(4, 3));
    std::string bytes = read_bytes(path);
    const std::size_t size = bytes.find(std::string("channels\0chlist\0", 16)) + 16;
    const std::int32_t huge = 0x7fffffff;
    std::memcpy(bytes.data() + size, &huge, 4);
    write_bytes(path, bytes);
    CHECK(contains(refusal(path), "its header claims 2147483647 bytes for 'channels'"));
    for (std::size_t cut = 0; cut < size; cut += 7) {
        write_bytes(path, bytes.substr(0, cut));
        CHECK_FALSE(refusal(path).empty());
    }
}

TEST_CASE("an image is a regular file", "[law7][budget]") {
    const Folder folder;
    REQUIRE(mkfifo(folder.path("pipe").c_str(), 0600) == 0);
    CHECK(contains(refusal(folder.path("pipe")), "this is a pipe; expected an OpenEXR file"));
    CHECK(contains(refusal("/dev/zero"), "this is a device"));
    CHECK(contains(refusal(folder.path()), "this is a directory"));
}

TEST_CASE("an attribute with a wrong size is refused, because the library would continue at a wrong position",
          "[law7][budget]") {
    const Folder folder;
    const std::string path = folder.path("a.exr");
    write_foreign(path, rgb(12), box(4, 3), box(4, 3));
    const std::string sound = read_bytes(path);
    // The bytes after the header's first attribute move by the number of bytes that it grows.
    const auto with_size = [&](const std::string& name_and_type, std::uint32_t size, const std::string& more) {
        std::string bytes = sound;
        const std::size_t at = bytes.find(name_and_type) + name_and_type.size();
        std::uint32_t old = 0;
        std::memcpy(&old, bytes.data() + at, sizeof old);
        std::memcpy(bytes.data() + at, &size, sizeof size);
        bytes.insert(at + 4 + old, more);
        return bytes;
    };
    const std::string chlist("channels\0chlist\0", 16), order("lineOrder\0lineOrder\0", 20);
    REQUIRE(sound.find(chlist) != std::string::npos);
    write_bytes(path, with_size(chlist, 3 * 18 + 1 + 8, std::string(8, '\0')));
    CHECK(contains(refusal(path), "a list of channels with a wrong end"));
    write_bytes(path, with_size(order, 5, "abcd"));
    CHECK(contains(refusal(path), "claims 5 bytes for 'lineOrder' of type lineOrder, which has 1"));
    // 4 x 2^20 pixels of a preview in 16 bytes.
    std::string preview("preview\0preview\0\x10\0\0\0\0\0\x10\0\x04\0\0\0\0\0\0\0\0\0\0\0", 36);
    std::string bytes = sound;
    bytes.insert(8, preview);
    write_bytes(path, bytes);
    CHECK(contains(refusal(path), "a preview whose size does not match"));
    write_bytes(path, sound);
    CHECK(refusal(path).empty());
}
