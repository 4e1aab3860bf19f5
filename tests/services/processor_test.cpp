#include <catch2/catch.hpp>

#include <algorithm>
#include <limits>
#include <thread>

#include "display/services/processor.h"

using namespace raylex;

namespace {

template <class Number>
struct Denormals {
    Number result, argument;

    /// Volatile numbers, because the compiler computes with denormals.
    static Denormals here() {
        volatile Number smallest = std::numeric_limits<Number>::min(), half = Number(0.5);
        volatile Number tiny = std::numeric_limits<Number>::denorm_min(), large = 1 / smallest;
        return {smallest * half, tiny * large};
    }
};

}  // namespace

TEMPLATE_TEST_CASE("a thread that flushes denormals computes zeros from them, and other threads do not", "[processor]",
                   float, double) {
    Denormals<TestType> flushed{}, plain{};
    std::thread([&] {
        plain = Denormals<TestType>::here();
        display::flush_denormals();
        flushed = Denormals<TestType>::here();
    }).join();
    CHECK(plain.result > 0);
    CHECK(plain.argument > 0);
    CHECK(flushed.result == 0);
    CHECK(flushed.argument == 0);
    CHECK(Denormals<TestType>::here().result > 0);
}

TEST_CASE("the narrowest instruction set is supported, and the choice of --help lists all", "[processor]") {
    const auto& sets = display::instruction_sets();
    CHECK(display::supports(sets.back()));
    CHECK_FALSE(display::supports("sse9"));
    for (const std::string& set : sets) CHECK(display::instruction_set_names.find(set) != std::string_view::npos);
    const auto first = std::find_if(sets.begin(), sets.end(), [](const auto& set) { return display::supports(set); });
    CHECK(std::all_of(first, sets.end(), [](const auto& set) { return display::supports(set); }));
}
