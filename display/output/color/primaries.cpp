#include "display/output/color/primaries.h"

#include <cmath>

namespace raylex::display {

namespace {

constexpr std::array<double, 2> d65_white{0.3127, 0.3290};

std::array<double, 3> xyz_of(const std::array<double, 2>& xy) {
    return {xy[0] / xy[1], 1.0, (1.0 - xy[0] - xy[1]) / xy[1]};
}

// The direction of a primary in XYZ, not divided by y, which is zero or negative for imaginary primaries (AP0).
std::array<double, 3> direction_of(const std::array<double, 2>& xy) {
    return {xy[0], xy[1], 1.0 - xy[0] - xy[1]};
}

}  // namespace

Matrix3 identity_matrix() {
    return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

Matrix3 multiply(const Matrix3& a, const Matrix3& b) {
    Matrix3 result{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k) result[i][j] += a[i][k] * b[k][j];
    return result;
}

Matrix3 inverse(const Matrix3& m) {
    const auto minor = [&m](std::size_t r0, std::size_t r1, std::size_t c0, std::size_t c1) {
        return m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0];
    };
    const Matrix3 adjugate{{{minor(1, 2, 1, 2), -minor(0, 2, 1, 2), minor(0, 1, 1, 2)},
                            {-minor(1, 2, 0, 2), minor(0, 2, 0, 2), -minor(0, 1, 0, 2)},
                            {minor(1, 2, 0, 1), -minor(0, 2, 0, 1), minor(0, 1, 0, 1)}}};
    const double determinant = m[0][0] * adjugate[0][0] + m[0][1] * adjugate[1][0] + m[0][2] * adjugate[2][0];
    Matrix3 result{};
    if (determinant == 0) return result;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) result[i][j] = adjugate[i][j] / determinant;
    return result;
}

std::array<double, 3> transform_colour(const Matrix3& m, const std::array<double, 3>& colour) {
    std::array<double, 3> result{};
    for (std::size_t i = 0; i < 3; ++i) result[i] = m[i][0] * colour[0] + m[i][1] * colour[1] + m[i][2] * colour[2];
    return result;
}

Matrix3 rgb_to_xyz(const Chromaticities& primaries) {
    const std::array<std::array<double, 3>, 3> columns{direction_of(primaries.red), direction_of(primaries.green),
                                                       direction_of(primaries.blue)};
    Matrix3 unscaled{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) unscaled[i][j] = columns[j][i];
    const std::array<double, 3> scale = transform_colour(inverse(unscaled), xyz_of(primaries.white));
    for (auto& row : unscaled)
        for (std::size_t j = 0; j < 3; ++j) row[j] *= scale[j];
    return unscaled;
}

Matrix3 bradford(const std::array<double, 2>& from_white, const std::array<double, 2>& to_white) {
    if (from_white == to_white) return identity_matrix();
    const Matrix3 cone{{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
    const std::array<double, 3> from = transform_colour(cone, xyz_of(from_white)),
                                to = transform_colour(cone, xyz_of(to_white));
    Matrix3 gain{};
    for (std::size_t i = 0; i < 3; ++i) gain[i][i] = to[i] / from[i];
    return multiply(inverse(cone), multiply(gain, cone));
}

Matrix3 rgb_to_xyz_d65(const Chromaticities& primaries) {
    return multiply(bradford(primaries.white, d65_white), rgb_to_xyz(primaries));
}

Matrix3 rgb_to_rgb(const Chromaticities& from, const Chromaticities& to) {
    if (equivalent(from, to)) return identity_matrix();
    return multiply(inverse(rgb_to_xyz_d65(to)), rgb_to_xyz_d65(from));
}

bool equivalent(const Chromaticities& a, const Chromaticities& b) {
    const auto near = [](const std::array<double, 2>& p, const std::array<double, 2>& q) {
        return std::abs(p[0] - q[0]) <= 1e-4 && std::abs(p[1] - q[1]) <= 1e-4;
    };
    return near(a.red, b.red) && near(a.green, b.green) && near(a.blue, b.blue) && near(a.white, b.white);
}

std::array<double, 3> luminance_weights(const Chromaticities& primaries) {
    if (equivalent(primaries, rec709_primaries())) return {0.2126, 0.7152, 0.0722};
    return rgb_to_xyz(primaries)[1];
}

Chromaticities rec709_primaries() {
    return {};
}
Chromaticities rec2020_primaries() {
    return {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, d65_white};
}
Chromaticities p3d65_primaries() {
    return {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, d65_white};
}
Chromaticities adobe_rgb_primaries() {
    return {{0.6400, 0.3300}, {0.2100, 0.7100}, {0.1500, 0.0600}, d65_white};
}
Chromaticities aces_ap0_primaries() {
    return {{0.73470, 0.26530}, {0.00000, 1.00000}, {0.00010, -0.07700}, {0.32168, 0.33767}};
}
Chromaticities aces_ap1_primaries() {
    return {{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}};
}

}  // namespace raylex::display
