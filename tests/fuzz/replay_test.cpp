// What the fuzz targets were ever given, and what they found, once through each of them: with whatever compiler and
// sanitizers the other tests are built. New inputs are looked for by --full alone.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include <catch2/catch.hpp>

#include "tests/fuzz/fuzz.h"
#include "tests/support/paths.h"

// LLVMFuzzerTestOneInput of fuzz_<name>.cpp, which the build calls so here.
#define RAYLEX_FUZZ_TARGET(name) extern "C" int fuzz_input_of_##name(const std::uint8_t* data, std::size_t size);
#include "fuzz_targets.inc"
#undef RAYLEX_FUZZ_TARGET

namespace fuzz {

// Sanitizers count allocations for fuzzers alone.
AllocationMeter::AllocationMeter(long long /*bound*/) {}
AllocationMeter::~AllocationMeter() = default;

}  // namespace fuzz

namespace {

using Target = int (*)(const std::uint8_t*, std::size_t);

const std::map<std::string, Target>& targets() {
    static const std::map<std::string, Target> all{
#define RAYLEX_FUZZ_TARGET(name) {#name, fuzz_input_of_##name},
#include "fuzz_targets.inc"
#undef RAYLEX_FUZZ_TARGET
    };
    return all;
}

/// Whole groups of four letters, "=" for what the last lacks.
std::string from_base64(const std::string& text) {
    static const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char letter : text) {
        if (letter == '=') break;
        const std::size_t value = letters.find(letter);
        REQUIRE(value != std::string::npos);
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes += static_cast<char>(bits >> count & 0xff);
    }
    return bytes;
}

std::filesystem::path corpus() {
    return std::filesystem::path(raylex::test::source_dir()) / "tests" / "fuzz" / "corpus";
}

TEST_CASE("every fuzz target has a corpus, and every corpus a target", "[fuzz]") {
    std::set<std::string> with_corpus, with_target;
    for (const auto& entry : std::filesystem::directory_iterator(corpus()))
        with_corpus.insert(entry.path().stem().string());
    for (const auto& [name, target] : targets()) with_target.insert(name);
    CHECK(with_corpus == with_target);
}

TEST_CASE("the inputs that fuzzing kept end in a result or an error", "[fuzz][law7]") {
    std::size_t inputs = 0;
    for (const auto& [name, target] : targets()) {
        std::ifstream file(corpus() / (name + ".txt"));
        std::string line;
        for (int number = 1; std::getline(file, line); ++number) {
            CAPTURE(name, number);
            const std::string bytes = from_base64(line);
            CHECK(target(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()) == 0);
            ++inputs;
        }
    }
    CHECK(inputs > 1000);
}

}  // namespace
