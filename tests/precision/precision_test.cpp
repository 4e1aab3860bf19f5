// Transport compiled in double against closed forms, and against the float that users get: what float costs.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "precision/measure.h"
#include "tests/support/folder.h"
#include "tests/support/paths.h"
#include "transport/math/real.h"

using namespace raylex;
using namespace raylex::test;

static_assert(transport::real_is_double);

namespace {

Measurements in_float() {
    const Folder folder;
    const std::string path = folder.path("float");
    REQUIRE(std::system(("'" + binary_dir() + "/measure_in_float' '" + path + "'").c_str()) == 0);
    std::ifstream file(path, std::ios::binary);
    Measurements measurements;
    for (std::vector<double>* list : measurements.all()) {
        std::uint64_t size = 0;
        file.read(reinterpret_cast<char*>(&size), sizeof size);
        REQUIRE(size < 1'000'000);
        list->resize(size);
        file.read(reinterpret_cast<char*>(list->data()), static_cast<std::streamsize>(size * sizeof(double)));
    }
    REQUIRE(file.good());
    return measurements;
}

const Measurements& of_double() {
    static const Measurements measurements = measure();
    return measurements;
}
const Measurements& of_float() {
    static const Measurements measurements = in_float();
    return measurements;
}

double furnace_radiance(double albedo, int depth) {
    return (1 - std::pow(albedo, depth + 1)) / (1 - albedo);
}

double worst_relative_error(const std::vector<double>& image, double expected) {
    double worst = 0;
    for (const double value : image) worst = std::max(worst, std::abs(value / expected - 1));
    return worst;
}

double mean(const std::vector<double>& image) {
    double sum = 0;
    for (const double value : image) sum += value;
    return sum / static_cast<double>(image.size());
}

double median_difference(const std::vector<double>& a, const std::vector<double>& b) {
    REQUIRE(a.size() == b.size());
    std::vector<double> differences;
    for (std::size_t i = 0; i < a.size(); ++i)  // pixels beside the room are black in both
        differences.push_back(a[i] == b[i] ? 0 : std::abs(a[i] - b[i]) / a[i]);
    const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
    std::nth_element(differences.begin(), middle, differences.end());
    return *middle;
}

/// Mean absolute difference over the mean.
double mean_difference(const std::vector<double>& a, const std::vector<double>& b) {
    REQUIRE(a.size() == b.size());
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
    return sum / static_cast<double>(a.size()) / mean(a);
}

}  // namespace

TEST_CASE("in double the furnace has its closed form, by paths and from both ends", "[precision]") {
    // Weights look at distances to lights that rays hit, which are Embree's and float: hence not 1e-7, what is left of
    // contributions in display/.
    const double expected = furnace_radiance(short_albedo, short_depth);
    CHECK(worst_relative_error(of_double().path_furnace, expected) < 1e-6);
    CHECK(worst_relative_error(of_double().bdpt_furnace, expected) < 1e-6);
}

TEST_CASE("ten thousand bounces leave double its digits, and float what 10^4 roundings leave", "[precision]") {
    // Every path has all 10^4 events, so the image is the sum of the throughput's powers. Roundings of float to nearest
    // have a bias here, the factor being always the same; they are at most 2^-24 each.
    const double expected = furnace_radiance(long_albedo, long_depth);
    const double error_of_float = worst_relative_error(of_float().long_furnace, expected);
    CHECK(worst_relative_error(of_double().long_furnace, expected) < 1e-8);
    CHECK(error_of_float < long_depth * 0x1p-24);
    CHECK(error_of_float > 1e-6);  // else this says nothing about double
}

TEST_CASE("images in float and in double are of the same paths", "[precision]") {
    // Rounding moves a pixel by 1e-7 of itself. A sample that a rounding sends another way moves the mean by about 1e-5
    // (1 in 65,536): the mean leaves room for ten of them, and half of the pixels have none.
    for (const auto& [in_double, in_float] : {std::pair{&of_double().path_room, &of_float().path_room},
                                              std::pair{&of_double().bdpt_room, &of_float().bdpt_room}}) {
        CHECK(mean_difference(*in_double, *in_float) < 1e-4);
        CHECK(median_difference(*in_double, *in_float) < 1e-6);
    }
}
