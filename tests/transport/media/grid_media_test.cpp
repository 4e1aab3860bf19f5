// Media from grids, without rendering: look-ups, majorants, flights, transmittance and emission against integrals.
#include "tests/transport/media/grid_media_support.h"

#include <cmath>
#include <random>

#include "transport/color/spectrum.h"

using namespace grid_media_test;
using import_test::contains;

namespace {

constexpr int nx = 7, ny = 6, nz = 9;

std::vector<double> numbers(std::size_t count, unsigned seed, double empty_share) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform;
    std::vector<double> values(count);
    for (double& value : values)
        value = uniform(generator) < empty_share ? 0 : std::round(uniform(generator) * 1000) / 500;
    return values;
}

std::string list(const std::vector<double>& values) {
    std::string text = " [";
    for (const double value : values) text += " " + std::to_string(value);
    return text + "]";
}

const std::string counts = " \"integer nx\" 7 \"integer ny\" 6 \"integer nz\" 9 ";
const std::string box = " \"point3 p0\" [-1 -2 0] \"point3 p1\" [2 1 4] ";

/// pbrt's look-up, written for one point: values at voxel centres, 0 beyond the outermost.
double looked_up(const std::vector<double>& values, int channels, int channel, double x, double y, double z) {
    const double p[3] = {(x + 1) / 3 * nx - 0.5, (y + 2) / 3 * ny - 0.5, z / 4 * nz - 0.5};
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        int at[3];
        for (int a = 0; a < 3; ++a) {
            const double below = std::floor(p[a]);
            const int bit = corner >> a & 1;
            at[a] = static_cast<int>(below) + bit;
            weight *= bit == 1 ? p[a] - below : 1 - (p[a] - below);
        }
        if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= nx || at[1] >= ny || at[2] >= nz) continue;
        const auto index = static_cast<std::size_t>(at[0] + nx * (at[1] + ny * at[2]));
        sum += weight * values[index * static_cast<std::size_t>(channels) + static_cast<std::size_t>(channel)];
    }
    return sum;
}

struct Integrals {
    double passed[3]{}, scattered[3]{}, emitted[3]{};
};

/// Integrals along the segment by the midpoint rule.
Integrals integrals(const Built& built, const DVec3& from, const DVec3& to) {
    constexpr int steps = 20000;
    const double whole = length(to - from);
    double depth[3]{};
    Integrals result;
    for (int i = 0; i < steps; ++i) {
        const DVec3 p = from + (to - from) * ((i + 0.5) / steps);
        const MediumPoint m = built.at(p.x, p.y, p.z);
        for (int c = 0; c < 3; ++c) {
            const double extinction = double(m.sigma_a[c] + m.sigma_s[c]) * whole / steps;
            const double here = std::exp(-(depth[c] + extinction / 2)) * whole / steps;
            result.scattered[c] += here * double(m.sigma_s[c]);
            result.emitted[c] += here * double(m.emission[c]);
            depth[c] += extinction;
        }
    }
    for (int c = 0; c < 3; ++c) result.passed[c] = std::exp(-depth[c]);
    return result;
}

/// Mean and standard error of the added values.
struct Mean {
    double sum = 0, squares = 0;
    int count = 0;
    void add(double value) { sum += value, squares += value * value, ++count; }
    [[nodiscard]] double mean() const { return sum / count; }
    [[nodiscard]] double error() const {
        return std::sqrt(std::max(squares / count - mean() * mean(), 0.0) / (count - 1));
    }
};

/// Compares all estimates along one segment with integrals. By chance one of them is off once in 10,000 runs of the
/// tests.
void check_estimates(const Built& built, const DVec3& from, const DVec3& to) {
    constexpr int flights = 40000;
    const GridMedium& grid = *built.medium().grid;
    const MediumSegment segment = built.segment(from, to);
    const Integrals exact = integrals(built, from, to);
    const Rgb throughput{Real(0.5), 1, Real(0.2)};
    Mean passed[3], scattered[3], through[3], lost[3], emitted[3];
    for (int i = 0; i < flights; ++i) {
        const auto key = static_cast<std::uint32_t>(i);
        FlightNumbers first(key, 7);
        const FreeFlight flight = grid.sample_free_flight(segment, throughput, first.next_2d(), FlightNumbers(key));
        const Rgb ratio = grid.transmittance(segment, FlightNumbers(key, 1)),
                  emission = grid.emission(segment, FlightNumbers(key, 2));
        Real at = 0;
        const Rgb absorbed = grid.transmittance(segment, FlightNumbers(key, 3), at);
        CHECK_FALSE((flight.distance < 0 || flight.distance > segment.end || at < 0 || at > segment.end));
        for (int c = 0; c < 3; ++c) {
            passed[c].add(flight.collided ? 0 : double(flight.weight[c]));
            scattered[c].add(flight.collided ? double(flight.weight[c]) : 0);
            through[c].add(double(ratio[c]));
            lost[c].add(double(absorbed[c]));
            emitted[c].add(double(emission[c]));
        }
    }
    for (int c = 0; c < 3; ++c) {
        CAPTURE(c, exact.passed[c], exact.scattered[c], exact.emitted[c]);
        const auto agrees = [](const Mean& mean, double value) {
            CAPTURE(mean.mean(), mean.error(), value);
            // The integral's steps and the float rounding of the sum: 1e-4 of it.
            CHECK(std::abs(mean.mean() - value) <= 4.5 * mean.error() + 1e-4 * value);
            CHECK(mean.error() <= 0.05 * std::max(value, 0.1));
        };
        agrees(passed[c], exact.passed[c]);
        agrees(scattered[c], exact.scattered[c]);
        agrees(through[c], exact.passed[c]);
        agrees(lost[c], exact.passed[c]);
        agrees(emitted[c], exact.emitted[c]);
    }
}

}  // namespace

TEST_CASE("grids are looked up as in pbrt, and majorants bound them", "[media][grids]") {
    const std::vector<double> density = numbers(nx * ny * nz, 1, 0.3), colours = numbers(3 * nx * ny * nz, 2, 0);
    const Built grey = build_medium(
        "\"string type\" \"uniformgrid\" \"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [0 0 0] \"float density\"" +
        list(density) + counts + box);
    const Built coloured =
        build_medium("\"string type\" \"rgbgrid\" \"float scale\" 2 \"rgb sigma_s\"" + list(colours) + counts + box,
                     "Translate 100 0 0 Rotate 90 0 0 1");
    std::mt19937 generator(3);
    std::uniform_real_distribution<double> uniform;
    for (int i = 0; i < 2000; ++i) {
        const double x = -1.2 + 3.4 * uniform(generator), y = -2.2 + 3.4 * uniform(generator),
                     z = -0.2 + 4.4 * uniform(generator);
        const bool inside = x > -1 && x < 2 && y > -2 && y < 1 && z > 0 && z < 4;
        const double expected = inside ? looked_up(density, 1, 0, x, y, z) : 0;
        CAPTURE(x, y, z);
        const MediumPoint p = grey.at(x, y, z);
        // Places are floats in cells, 2^-22 of a cell here, and values change by 2 over a voxel.
        CHECK(std::abs(double(p.sigma_a.g) - 2 * expected) <= 2e-5);
        CHECK(p.sigma_a.g * 1.5f <= grey.medium().grid->majorant(grey.here(x, y, z)) * (1 + 1e-6f));
        // Rotated by 90 degrees and moved: (x, y) becomes (100 - y, x).
        const MediumPoint q = coloured.at(100 - y, x, z);
        for (int c = 0; c < 3; ++c) {
            CHECK(std::abs(double(q.sigma_s[c]) - (inside ? 2 * looked_up(colours, 3, c, x, y, z) : 0)) <= 6e-5);
            CHECK(q.sigma_a[c] == (inside ? 2 : 0));
        }
    }
    CHECK(grey.medium().scatters == false);
    CHECK(coloured.medium().scatters);
    CHECK(grey.media.any_grids());
    CHECK(grey.media.grid_bytes() > nx * ny * nz * sizeof(float));
}

TEST_CASE("flights, transmittance and emission have the right means for every majorant",
          "[media][grids][statistical][gate]") {
    const std::string density = " \"float density\"" + list(numbers(nx * ny * nz, 4, 0.4)) + counts + box;
    const std::string radiance = " \"float Lescale\"" + list(numbers(nx * ny * nz, 5, 0.5));
    const std::string colours = " \"rgb sigma_a\"" + list(numbers(3 * nx * ny * nz, 6, 0.2)) + " \"rgb sigma_s\"" +
                                list(numbers(3 * nx * ny * nz, 7, 0.2)) + " \"rgb Le\"" +
                                list(numbers(3 * nx * ny * nz, 8, 0.2)) + counts + box;
    for (const std::string factor :
         {" \"float raylex:majorant\" 1", " \"float raylex:majorant\" 10", " \"float raylex:majorant\" 100"}) {
        CAPTURE(factor);
        for (const std::string& medium : {"\"string type\" \"uniformgrid\" \"rgb sigma_a\" [.3 .3 .3] \"rgb sigma_s\" "
                                          "[.5 .5 .5] \"rgb Le\" [2 1 3]" +
                                              density + radiance,
                                          "\"string type\" \"uniformgrid\" \"rgb sigma_a\" [.1 .2 .8] \"rgb sigma_s\" "
                                          "[.6 0.1 1.5] \"rgb Le\" [2 1 3]" +
                                              density,
                                          "\"string type\" \"rgbgrid\" \"float Lescale\" 0.01" + colours}) {
            const Built built = build_medium(medium + factor);
            check_estimates(built, {-3, -0.3, 0.4}, {3, 0.1, 3.1});
            check_estimates(built, {0.4, -0.6, 2}, {0.4, -0.6, 3.2});  // along an axis, from and to the inside
        }
    }
}

TEST_CASE("clouds stay within the bounds of their cells", "[media][grids][gate]") {
    for (const std::string& parameters :
         {std::string(), std::string("\"float density\" 3 \"float wispiness\" 2"),
          std::string("\"float frequency\" 2 \"float density\" 0.5 \"point3 p1\" [3 1 2]"),
          std::string("\"float frequency\" 40")}) {
        CAPTURE(parameters);
        const Built built = build_medium("\"string type\" \"cloud\" \"rgb sigma_a\" [0 0 0] " + parameters);
        CloudDensity cloud;
        if (contains(parameters, "density\" 3")) cloud.density = 3, cloud.wispiness = 2;
        if (contains(parameters, "frequency\" 2")) cloud.frequency = 2, cloud.density = Real(0.5);
        if (contains(parameters, "frequency\" 40")) cloud.frequency = 40;
        const bool wide = contains(parameters, "p1");
        std::mt19937 generator(9);
        std::uniform_real_distribution<double> uniform;
        int beyond = 0;
        double mean = 0, majorants = 0, cut_off = 0;
        constexpr int points = 200000;
        for (int i = 0; i < points; ++i) {
            const double x = uniform(generator) * (wide ? 3 : 1), y = uniform(generator),
                         z = uniform(generator) * (wide ? 2 : 1);
            const auto density = double(cloud.at(Vec3{float(x), float(y), float(z)}));
            const double cut = std::abs(density - double(built.at(x, y, z).sigma_s.r));
            // Places are floats, off by 1e-7, and densities change by less than 1,000 per unit of length.
            if (cut > 1e-3) ++beyond, cut_off += cut / points;
            majorants += double(built.medium().grid->majorant(built.here(x, y, z))) / points;
            mean += density / points;
        }
        CAPTURE(beyond, cut_off, mean, majorants);
        // Clipped: at most a thousandth of the points, and less than a hundred-thousandth of the cloud.
        CHECK(beyond <= points / 1000);
        CHECK(cut_off <= 1e-5 * mean);
        // A single majorant for the whole box would be 2.1 to 3.2 times the mean.
        if (cloud.frequency <= 5) CHECK(majorants < 1.9 * mean);
    }
}

TEST_CASE("blackbodies in a grid emit by Planck's law", "[media][grids]") {
    std::vector<double> heat(27, 30), dense(27, 1);
    const Built built = build_medium(
        "\"string type\" \"uniformgrid\" \"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [0 0 0] \"integer nx\" 3 \"integer "
        "ny\" 3 "
        "\"integer nz\" 3 \"point3 p0\" [-3 -3 -3] \"point3 p1\" [3 3 3] \"float temperatureoffset\" 5 "
        "\"float temperaturescale\" 120 \"float density\"" +
        list(dense) + "\"float temperature\"" + list(heat));
    const Rgb expected = blackbody_radiance(3000, built.scene.color);
    const MediumPoint here = built.at(0.1, 0.2, -0.3);
    // The table is linear between steps of 0.2 %: 5e-5 at this temperature.
    for (int c = 0; c < 3; ++c) CHECK(here.emission[c] == Approx(double(expected[c])).epsilon(2e-4));
    // Planck over its maximum at 3000 K, at 550 nm: 0.4256; the luminance is of that order times 106.86.
    CHECK(expected.g > 20);
    CHECK(expected.r > expected.g);
    CHECK(expected.g > expected.b);
    const Built cold =
        build_medium("\"string type\" \"uniformgrid\" \"integer nx\" 1 \"float density\" 1 \"float temperature\" 99");
    CHECK_FALSE(cold.medium().emits);
    CHECK(cold.at(0.5, 0.5, 0.5).emission.is_black());
    Mean sum;
    for (std::uint32_t i = 0; i < 20000; ++i)
        sum.add(double(built.medium().grid->emission(built.segment({0, 0, -1}, {0, 0, 1}), FlightNumbers(i)).g));
    CHECK(std::abs(sum.mean() - double(expected.g) * (1 - std::exp(-2))) <=
          4.5 * sum.error() + 2e-4 * double(expected.g));
}

TEST_CASE("invalid values are replaced by 0 and counted", "[media][grids]") {
    const Built built =
        build_medium("\"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 2 \"float density\" [1 -1 -2 1]");
    REQUIRE(built.warnings.size() == 1);
    CHECK(contains(built.warnings[0].message,
                   "2 values of 'density' are negative or not finite and count as 0; the first is voxel (1, 0, 0)"));
    CHECK(built.warnings[0].line == 2);
    CHECK(built.at(0.75, 0.25, 0.5).sigma_a.r == 0);
    CHECK(built.at(0.25, 0.25, 0.5).sigma_a.r == 1);
}

TEST_CASE("an unknown preset and an asymmetry out of bounds are repaired in grids, too", "[media][grids]") {
    const Built built = build_medium(
        "\"string type\" \"uniformgrid\" \"float density\" 1 \"string preset\" \"None\" \"rgb sigma_a\" [2 2 2] "
        "\"float g\" 1.5");
    CHECK(built.medium().g == Real(0.99));
    CHECK(built.at(0.5, 0.5, 0.5).sigma_a == Rgb(2));
    REQUIRE(built.warnings.size() == 2);
    CHECK(contains(built.warnings[0].message, "there is no measured medium 'None'"));
    CHECK(contains(built.warnings[1].message, "'g' is 1.5"));
    for (const auto& warning : built.warnings) CHECK(warning.line == 2);
}

TEST_CASE("invalid grids are errors at their position", "[media][grids][law7]") {
    const std::string uniform = "\"string type\" \"uniformgrid\" ", rgb = "\"string type\" \"rgbgrid\" ",
                      cloud = "\"string type\" \"cloud\" ";
    const std::pair<std::string, const char*> slips[] = {
        {uniform, "has no 'density'; expected nx x ny x nz = 1 x 1 x 1 = 1 values"},
        {uniform + "\"float density\" [1 2 3] \"integer nx\" 2",
         "'density' has 3 values; expected nx x ny x nz = 2 x 1 x 1 = 2"},
        {uniform + "\"float density\" 1 \"float temperature\" [1 2]",
         "'temperature' has 2 values; expected nx x ny x nz"},
        {uniform + "\"float density\" 1 \"rgb Le\" [1 1 1] \"float Lescale\" [1 2]", "'Lescale' has 2 values"},
        {uniform + "\"float density\" 1 \"rgb Le\" [1 1 1] \"float temperature\" 1", "has both 'Le' and 'temperature'"},
        {uniform + "\"rgb density\" [1 1 1]", "'density' is of type rgb; expected float"},
        {uniform + "\"float density\" 1 \"integer nx\" 0", "'nx' is 0; expected 1 to 1000000"},
        {uniform + "\"float density\" 1 \"integer nx\" 100000 \"integer ny\" 100000 \"integer nz\" 100000",
         "the budget volume_cells is"},
        {uniform + "\"float density\" 1 \"point3 p1\" [1 0 1]", "the box from 'p0' to 'p1' is flat"},
        {uniform + "\"float density\" 1 \"float raylex:majorant\" 0.5", "'raylex:majorant' is 0.5"},
        {uniform + "\"float density\" 1 \"float scale\" -1", "expected 0 or more"},
        // Cells of 1/2 x 1 x 1: 1.5 along the diagonal.
        {uniform + "\"integer nx\" 2 \"float density\" [0 1] \"rgb sigma_a\" [1e7 0 0] \"rgb sigma_s\" [0 0 0]",
         "mean free paths thick"},
        {uniform + "\"float density\" 1e38", "reaches 2e+38 per unit of length; expected at most 1e20"},
        {uniform + "\"float density\" 1 \"float scale\" 1e21", "expected at most 1e20"},
        {uniform + "\"float density\" 1e15 \"rgb Le\" [1e20 1e20 1e20]", "expected at most 1e30"},
        {rgb + "\"rgb sigma_s\" [1e38 1 1]", "reaches 1e+38 per unit of length"},
        {rgb, "has neither 'sigma_a' nor 'sigma_s'"},
        {rgb + "\"rgb sigma_s\" [1 1 1] \"rgb Le\" [1 1 1]", "'Le' without 'sigma_a'"},
        {rgb + "\"rgb sigma_s\" [1 1 1 2 2 2]", "'sigma_s' has 2 values; expected nx x ny x nz = 1"},
        {cloud + "\"float frequency\" -1", "'frequency' is -1"},
        {cloud + "\"point3 p0\" [1 1 1]", "is flat"},
        {"\"string type\" \"nanovdb\"", "has no 'filename'"},
    };
    for (const auto& [medium, message] : slips) {
        const raylex::Error error = refused_medium(medium);
        CAPTURE(medium, error.message);
        CHECK(contains(error.message, message));
        CHECK(error.file == "test.pbrt");
        CHECK(error.line == 2);
    }
}
