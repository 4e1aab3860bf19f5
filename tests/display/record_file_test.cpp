// The record file: any damage is detected and named, and an earlier file survives every failure.
#include "display/checkpoint/record_file.h"

#include <catch2/catch.hpp>

#include <cerrno>
#include <filesystem>

#include "display/output/atomic_file.h"
#include "files.h"

using namespace raylex::test;
using namespace raylex::display;

namespace {

RecordFile some_record(std::size_t size = 1500) {
    RecordFile record;
    record.identity = {{"seed", "3"}, {"resolution", "64x48"}};
    std::string& first = record.add("frame buffer");
    for (std::size_t i = 0; i < size; ++i) first += static_cast<char>(i * i);
    record.add("empty");
    record.add("progress") = "12";
    return record;
}

}  // namespace

TEST_CASE("a record reads back as it was written", "[display][record]") {
    const Folder folder;
    const RecordFile record = some_record();
    REQUIRE(write_record_file(folder.path("r"), record).ok());
    const auto back = read_record_file(folder.path("r"));
    REQUIRE(back.ok());
    CHECK(back->identity == record.identity);
    REQUIRE(back->sections.size() == 3);
    CHECK((back->find("frame buffer")->content == record.sections[0].content));
    CHECK(back->find("empty")->content.empty());
    CHECK(back->find("progress")->content == "12");
    CHECK(back->find("nothing") == nullptr);
    CHECK(folder.names().size() == 1);
}

TEST_CASE("a record truncated anywhere is refused", "[display][record][law7]") {
    const Folder folder;
    REQUIRE(write_record_file(folder.path("r"), some_record()).ok());
    const std::string bytes = read_bytes(folder.path("r"));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        if (size % 64 != 0 && size + 70 < bytes.size()) continue;  // every 64th byte, and all bytes near the end
        write_bytes(folder.path("cut"), bytes.substr(0, size));
        const auto refused = read_record_file(folder.path("cut"));
        CAPTURE(size);
        REQUIRE_FALSE(refused.ok());
        CHECK(refused.error().file == folder.path("cut"));
        CHECK(refused.error().message.find("truncated: it ends after " + std::to_string(size) + " bytes") !=
              std::string::npos);
    }
    write_bytes(folder.path("cut"), bytes + "x");
    CHECK(read_record_file(folder.path("cut")).error().message.find("extra bytes after its end") != std::string::npos);
}

TEST_CASE("a record with any flipped bit is refused", "[display][record][law7][gate]") {
    const Folder folder;
    REQUIRE(write_record_file(folder.path("r"), some_record(100)).ok());
    const std::string bytes = read_bytes(folder.path("r"));
    for (std::size_t at = 0; at < bytes.size(); ++at)
        for (int bit = 0; bit < 8; ++bit) {
            std::string damaged = bytes;
            damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
            write_bytes(folder.path("damaged"), damaged);
            CAPTURE(at, bit);
            REQUIRE_FALSE(read_record_file(folder.path("damaged")).ok());
        }
    std::string damaged = bytes;
    const std::size_t at = damaged.find("frame buffer") + 20;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write_bytes(folder.path("damaged"), damaged);
    CHECK(read_record_file(folder.path("damaged")).error().message.find("section 'frame buffer' is damaged") !=
          std::string::npos);
}

TEST_CASE("a file that is not a record is refused", "[display][record][law7]") {
    const Folder folder;
    write_bytes(folder.path("text"), std::string(200, 'x'));
    CHECK(read_record_file(folder.path("text")).error().message.find("not a raylex record") != std::string::npos);
    CHECK(read_record_file(folder.path("absent")).error().message.find("No such file") != std::string::npos);
    CHECK_FALSE(read_record_file(folder.path()).ok());
}

TEST_CASE("the differences between two identities are listed", "[display][record]") {
    const RecordIdentity there{{"seed", "3"}, {"channel a", "CDL"}, {"size", "4x4"}},
        here{{"seed", "4"}, {"size", "4x4"}, {"channel b", std::string(100, 'x')}};
    CHECK(identity_differences(there, there).empty());
    CHECK(identity_differences(there, here) ==
          std::vector<std::string>{"seed: 3 there, 4 here", "channel a: CDL there, nothing here",
                                   "channel b: nothing there, " + std::string(60, 'x') + "... here"});
}

TEST_CASE("an earlier record survives a fault in every call that writes the next", "[display][record][law7]") {
    const Folder folder;
    const std::string path = folder.path("r");
    RecordFile record = some_record(std::size_t{5} << 19);  // several writes
    REQUIRE(write_record_file(path, record).ok());
    record.identity[0].second = "4";
    std::vector<FileCall> calls;
    set_file_fault([&](FileCall call, const std::string&) { return calls.push_back(call), 0; });
    REQUIRE(write_record_file(folder.path("other"), record).ok());
    CHECK(std::count(calls.begin(), calls.end(), FileCall::write) >= 2);
    for (const FileCall kind :
         {FileCall::open, FileCall::sync, FileCall::close, FileCall::rename, FileCall::sync_folder})
        CHECK(std::count(calls.begin(), calls.end(), kind) == 1);
    for (std::size_t faulty = 0; faulty < calls.size(); ++faulty) {
        std::size_t call = 0;
        set_file_fault([&](FileCall, const std::string&) { return call++ == faulty ? ENOSPC : 0; });
        const raylex::Status status = write_record_file(path, record);
        CAPTURE(faulty);
        const auto back = read_record_file(path);
        REQUIRE(back.ok());
        if (calls[faulty] == FileCall::sync_folder) {  // best effort, after the rename
            CHECK(status.ok());
            CHECK(back->identity[0].second == "4");
            set_file_fault(nullptr);
            record.identity[0].second = "3";
            REQUIRE(write_record_file(path, record).ok());
        } else {
            REQUIRE_FALSE(status.ok());
            CHECK(status.error().file == path);
            CHECK(status.error().message.find("No space left on device; expected free space") != std::string::npos);
            CHECK(back->identity[0].second == "3");
        }
        CHECK(folder.names().size() == 2);
    }
    set_file_fault([&](FileCall call, const std::string&) { return call == FileCall::remove ? EACCES : 0; });
    CHECK_FALSE(remove_file(path).ok());
    set_file_fault(nullptr);
    CHECK(std::filesystem::exists(path));
    CHECK(remove_file(path).ok());
    CHECK(remove_file(path).ok());  // already removed
    CHECK_FALSE(std::filesystem::exists(path));
}
