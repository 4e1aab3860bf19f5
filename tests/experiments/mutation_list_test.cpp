// Checks that the lines that tests/mutate.sh changes exist in the sources. Code changes, and a mutation that applies
// nowhere tests nothing.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include "tests/support/paths.h"

namespace {

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t times_in(const std::string& text, const std::string& part) {
    std::size_t times = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++times;
    return times;
}

}  // namespace

TEST_CASE("every mutation occurs in its file exactly once", "[layout]") {
    const std::filesystem::path root = raylex::test::source_dir();
    std::istringstream list(text_of(root / "tests/mutations.txt"));
    std::size_t mutations = 0;
    for (std::string line; std::getline(list, line);) {
        if (line.empty() || line.front() == '#') continue;
        std::istringstream fields(line);
        std::string file, from, to;
        REQUIRE(std::getline(std::getline(std::getline(fields, file, '\t'), from, '\t'), to, '\t'));
        CAPTURE(file, from);
        CHECK(times_in(text_of(root / file), from) == 1);
        CHECK(from != to);
        ++mutations;
    }
    CHECK(mutations > 30);
}
