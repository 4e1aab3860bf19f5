// Budgets and reading of files: endless and too large input is refused by name.
#include <catch2/catch.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "lpe/input/read_input.h"
#include "lpe/match.h"
#include "lpe/vectors.h"
#include "tests/support/budget_guard.h"
#include "tests/support/folder.h"

using namespace raylex;
using test::BudgetGuard;
using test::Folder;

namespace {

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::string refusal(const std::string& path, NamedBy by = NamedBy::file) {
    const auto read = read_input(path, by, "a file of numbers");
    return read ? "" : read.error().to_string();
}

}  // namespace

TEST_CASE("a budget is set by name, with a unit; an error names the exceeded budget and its value", "[budget]") {
    const BudgetGuard guard("image_pixels=3K,text_bytes=10");
    REQUIRE(guard.good());
    CHECK(budget(Budget::image_pixels) == 3072);
    const Error error = over_budget(Budget::image_pixels, "the image has 9 x 999 pixels", "a.png");
    CHECK(contains(error.message, "the budget image_pixels is 3072"));
    CHECK(contains(error.hint, "--budget image_pixels=VALUE"));
    for (const char* wrong :
         {"image_pixel=3", "image_pixels", "image_pixels=", "image_pixels=-1", "image_pixels=0", "image_pixels=3X",
          "image_pixels=99999999999999999999", "image_pixels=9999999999G", "texture_depth=1G"}) {
        INFO(wrong);
        CHECK_FALSE(set_budget(wrong));
    }
    CHECK(contains(set_budget("image_pixel=3").error().message, "image_pixels"));
    CHECK(budget(Budget::image_pixels) == 3072);
}

TEST_CASE("a file is read whole, without a byte order mark, up to its budget", "[law7][budget]") {
    const Folder folder;
    const auto text = read_input(folder.write("a", "\xef\xbb\xbfone\ntwo"), NamedBy::file, "text");
    REQUIRE(text);
    CHECK(*text == "one\ntwo");
    const auto zero = read_input(folder.write("b", std::string("\0\1", 2)), NamedBy::file, "text");
    REQUIRE(zero);
    CHECK(zero->size() == 2);
    const BudgetGuard guard("text_bytes=4");
    CHECK(contains(refusal(folder.write("large", "12345")), "the budget text_bytes is 4"));
    CHECK(refusal(folder.write("just", "1234")).empty());
}

TEST_CASE("devices, pipes and folders are not files; the command line can name the first two", "[law7][budget]") {
    const Folder folder;
    CHECK(contains(refusal(folder.path()), "this is a directory; expected a file of numbers"));
    CHECK(contains(refusal(folder.path("no")), "No such file"));
    CHECK(contains(refusal(""), "empty"));
    CHECK(contains(refusal(std::string("a\0b", 3)), "zero byte"));
    CHECK(contains(refusal("/dev/zero"), "this is a device"));
    const std::string pipe = folder.path("pipe");
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    CHECK(contains(refusal(pipe), "this is a pipe"));
    CHECK(contains(check_regular_file(pipe, "a number").error().message, "this is a pipe"));
    const BudgetGuard guard("pipe_bytes=64K");
    CHECK(contains(refusal("/dev/zero", NamedBy::command_line), "the budget pipe_bytes is 65536"));
    std::thread writer([&] {
        const int end = open(pipe.c_str(), O_WRONLY);
        for (const char* part : {"12 ", "13"}) {
            if (write(end, part, std::char_traits<char>::length(part)) < 0) break;
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        close(end);
    });
    const auto read = read_input(pipe, NamedBy::command_line, "numbers");
    writer.join();
    REQUIRE(read);
    CHECK(*read == "12 13");
}

TEST_CASE("an interrupt ends the wait for a pipe without a writer", "[law7][budget]") {
    const Folder folder;
    const std::string pipe = folder.path("pipe");
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    std::atomic<bool> stop{false};
    stop_reading_when(&stop);
    std::thread later([&stop] {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        stop = true;
    });
    CHECK(contains(refusal(pipe, NamedBy::command_line), "interrupted"));
    later.join();
    // A stopped program still reads its records, which it needs to end in order; pipes are not records.
    const std::string record = folder.write("record.json", "{}");
    CHECK(contains(refusal(record, NamedBy::file), "interrupted"));
    const auto read = read_record(record, "a record");
    stop_reading_when(nullptr);
    REQUIRE(read);
    CHECK(*read == "{}");
    CHECK_FALSE(read_record(pipe, "a record"));
}

TEST_CASE("a file of vectors can begin with a byte order mark and must end", "[law7][budget]") {
    const Folder folder;
    const auto report = lpe::run_vectors(folder.write("a.tsv",
                                                      "\xef\xbb\xbf"
                                                      "CL\tC,- L,-\t1\n"),
                                         lpe::Dialect::renderman);
    REQUIRE(report);
    const BudgetGuard guard("pipe_bytes=64K");
    CHECK(contains(lpe::run_vectors("/dev/zero", lpe::Dialect::renderman).error().message, "pipe_bytes"));
}

TEST_CASE("a label of a thousand stars is matched in time that grows with its length", "[budget]") {
    std::string glob;
    for (int i = 0; i < 1000; ++i) glob += "*a";
    const auto events = lpe::parse_events("C,- R,D," + std::string(1000, 'a') + " L,-");
    REQUIRE(events);
    const auto matches = lpe::match("C<RD'" + glob + "'>L", *events, lpe::Dialect::renderman);
    REQUIRE(matches);
    CHECK(*matches);
    const auto shorter = lpe::parse_events("C,- R,D," + std::string(999, 'a') + " L,-");
    REQUIRE(shorter);
    const auto fails = lpe::match("C<RD'" + glob + "'>L", *shorter, lpe::Dialect::renderman);
    REQUIRE(fails);
    CHECK_FALSE(*fails);
}
