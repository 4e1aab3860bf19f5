#include "display/output/atomic_file.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "display/output/color/color_manager.h"
#include "files.h"

using namespace raylex::test;
using raylex::display::AtomicFile;
using raylex::display::check_writable;
using raylex::display::write_text_file;

TEST_CASE("a file appears whole, under its own name only", "[display][files][law7]") {
    const Folder folder;
    const std::string path = folder.path("a.txt");
    {
        auto file = AtomicFile::create(path);
        REQUIRE(file.ok());
        CHECK(file->write("hello", 5));
        CHECK(!std::filesystem::exists(path));
        CHECK(folder.names().size() == 1);  // the temporary file
        REQUIRE(file->commit().ok());
        CHECK(!file->commit().ok());  // a file can be committed once only
    }
    CHECK(read_bytes(path) == "hello");
    CHECK(folder.names().size() == 1);
    REQUIRE(write_text_file(path, "again").ok());
    CHECK(read_bytes(path) == "again");
}

TEST_CASE("an uncommitted file leaves no trace", "[display][files][law7]") {
    const Folder folder;
    REQUIRE(write_text_file(folder.path("a.txt"), "earlier").ok());
    {
        auto file = AtomicFile::create(folder.path("a.txt"));
        REQUIRE(file.ok());
        CHECK(file->write("later", 5));
        auto moved = std::move(*file);
        CHECK(moved.write("!", 1));
        CHECK(folder.names().size() == 2);
    }
    CHECK(read_bytes(folder.path("a.txt")) == "earlier");
    CHECK(folder.names().size() == 1);
}

TEST_CASE("seeking back overwrites in place", "[display][files]") {
    const Folder folder;
    auto file = AtomicFile::create(folder.path("a.txt"));
    REQUIRE(file.ok());
    CHECK(file->write("0123456789", 10));
    CHECK(file->seek(2));
    CHECK(file->write("ab", 2));
    CHECK(file->position() == 4);
    CHECK(file->seek(10));
    CHECK(file->write("!", 1));
    REQUIRE(file->commit().ok());
    CHECK(read_bytes(folder.path("a.txt")) == "01ab456789!");
}

TEST_CASE("a disk that fills up fails with the reason and keeps the earlier file", "[display][files][law7]") {
    const Folder folder;
    const std::string path = folder.path("a.txt");
    REQUIRE(write_text_file(path, "earlier").ok());
    const FileSizeLimit limit(1 << 20);
    const auto status = write_text_file(path, std::string(3 << 20, 'x'));
    REQUIRE(!status.ok());
    CHECK(status.error().file == path);
    CHECK(status.error().message.find("File too large") != std::string::npos);
    CHECK(read_bytes(path) == "earlier");
    CHECK(folder.names().size() == 1);

    auto file = AtomicFile::create(path);
    REQUIRE(file.ok());
    CHECK(!file->write(std::string(3 << 20, 'x').data(), 3 << 20));
    CHECK(!file->write("x", 1));  // every later write fails, too
    CHECK(file->failed());
    CHECK(!file->commit().ok());
    CHECK(folder.names().size() == 1);
}

TEST_CASE("targets that cannot be files are refused by kind", "[display][files][law7]") {
    const Folder folder;
    const auto failure = [](const std::string& path) {
        const auto status = check_writable(path);
        REQUIRE(!status.ok());
        CHECK(status.error().file == path);
        return status.error().message;
    };
    CHECK(failure(folder.path()).find("directory") != std::string::npos);
    CHECK(failure(folder.path() + "/").find("directory") != std::string::npos);
    CHECK(failure("/dev/full").find("device") != std::string::npos);
    CHECK(
        failure(folder.path("no/such/folder/a.exr")).find("No such file or directory; expected a folder that exists") !=
        std::string::npos);
    REQUIRE(write_text_file(folder.path("plain"), "x").ok());
    CHECK(failure(folder.path("plain/a.exr")).find("Not a directory") != std::string::npos);
    CHECK(!check_writable("").ok());
    CHECK(check_writable(folder.path("fine.exr")).ok());
    CHECK(!std::filesystem::exists(folder.path("fine.exr")));
    CHECK(folder.names().size() == 1);
}

TEST_CASE("a folder without write permission is refused", "[display][files][law7]") {
    if (geteuid() == 0) {
        WARN("skipped: root may write anywhere");
        return;
    }
    const Folder folder;
    std::filesystem::permissions(folder.path(),
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    const auto status = check_writable(folder.path("a.exr"));
    std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
    REQUIRE(!status.ok());
    CHECK(status.error().message.find("Permission denied") != std::string::npos);
}

TEST_CASE("a symbolic link stays a link, and its target is replaced", "[display][files]") {
    const Folder folder;
    REQUIRE(write_text_file(folder.path("real.txt"), "earlier").ok());
    std::filesystem::create_symlink("real.txt", folder.path("link.txt"));
    REQUIRE(write_text_file(folder.path("link.txt"), "later").ok());
    CHECK(std::filesystem::is_symlink(folder.path("link.txt")));
    CHECK(read_bytes(folder.path("real.txt")) == "later");
}

TEST_CASE("temporary files of killed processes are removed, and nothing else", "[display][files]") {
    const Folder folder;
    const std::string path = folder.path("a.exr"), mine = path + "." + std::to_string(getpid()) + "-7.partial";
    // No process has a number above the largest that Linux permits, 2^22.
    for (const std::string& name : {path, path + ".99999999-0.partial", path + ".99999999-12.partial", mine,
                                    path + ".99999999-0.partial.bak", folder.path("b.exr.99999999-0.partial")})
        write_bytes(name, "x");
    raylex::display::remove_abandoned(path);
    CHECK(folder.names().size() == 4);
    for (const std::string& name :
         {path, mine, path + ".99999999-0.partial.bak", folder.path("b.exr.99999999-0.partial")})
        CHECK(std::filesystem::exists(name));
}

TEST_CASE("a PNG holds the pixels it was given", "[display][png]") {
    const Folder folder;
    const std::vector<unsigned char> rgb{255, 0, 0, 0, 255, 0, 0, 0, 255, 1, 2, 3, 40, 50, 60, 255, 255, 255};
    REQUIRE(raylex::display::write_png(folder.path("a.png"), 3, 2, rgb).ok());
    const auto bytes = raylex::display::encode_png(3, 2, rgb);
    REQUIRE(bytes.ok());
    CHECK(read_bytes(folder.path("a.png")) == std::string(bytes->begin(), bytes->end()));
    CHECK(std::string(bytes->begin(), bytes->begin() + 4) == "\x89PNG");
    CHECK(folder.names().size() == 1);
    CHECK(!raylex::display::encode_png(3, 3, rgb).ok());
    CHECK(!raylex::display::encode_png(0, 0, {}).ok());
    CHECK(!raylex::display::encode_png(-3, -2, rgb).ok());
    const auto unwritable = raylex::display::write_png(folder.path("no/a.png"), 3, 2, rgb);
    REQUIRE(!unwritable.ok());
    CHECK(unwritable.error().file == folder.path("no/a.png"));
}
