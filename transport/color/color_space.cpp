#include "transport/color/color_space.h"

#include <cmath>

#include "transport/color/spectral_data.h"

namespace raylex::transport {

namespace {

constexpr std::size_t space_count = 4;

Triple xyz_of(const Chromaticity& xy) {
    return {xy[0] / xy[1], 1, (1 - xy[0] - xy[1]) / xy[1]};
}

// SMPTE RP 177: scale the primaries' XYZ so that they add up to the white.
Matrix3 derive_xyz_from_rgb(ColorSpace space) {
    const auto p = primaries(space);
    Matrix3 m{};
    for (std::size_t c = 0; c < 3; ++c) {
        const Triple xyz = xyz_of(p[c]);
        for (std::size_t r = 0; r < 3; ++r) m[r][c] = xyz[r];
    }
    const Triple scale = multiply(inverse(m), white_xyz(space));
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) m[r][c] *= scale[c];
    return m;
}

struct SpaceMatrices {
    Matrix3 to_xyz, from_xyz;
};

const SpaceMatrices& matrices(ColorSpace space) {
    static const std::array<SpaceMatrices, space_count> all = [] {
        std::array<SpaceMatrices, space_count> result{};
        for (std::size_t i = 0; i < space_count; ++i) {
            result[i].to_xyz = derive_xyz_from_rgb(static_cast<ColorSpace>(i));
            result[i].from_xyz = inverse(result[i].to_xyz);
        }
        return result;
    }();
    return all[static_cast<std::size_t>(space)];
}

}  // namespace

Triple multiply(const Matrix3& m, const Triple& v) {
    Triple result{};
    for (std::size_t r = 0; r < 3; ++r) result[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
    return result;
}

Matrix3 multiply(const Matrix3& a, const Matrix3& b) {
    Matrix3 result{};
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) result[r][c] = a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c];
    return result;
}

Matrix3 inverse(const Matrix3& m) {
    const auto minor = [&m](std::size_t r, std::size_t c) {
        const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
        return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];  // cyclic indices carry the sign
    };
    const double determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
    Matrix3 result{};
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) result[r][c] = minor(c, r) / determinant;
    return result;
}

Triple integrate_xyz(const VisibleSpectrum& spectrum) {
    const MatchingFunctions& f = matching_functions();
    Triple sum{};
    for (std::size_t i = 0; i < visible_samples; ++i) {
        sum[0] += f.x[i] * spectrum[i];
        sum[1] += f.y[i] * spectrum[i];
        sum[2] += f.z[i] * spectrum[i];
    }
    return sum;
}

std::string_view white_spectrum_name(ColorSpace space) {
    return space == ColorSpace::aces2065_1 ? "illum-acesD60" : "stdillum-D65";
}

Triple white_xyz(ColorSpace space) {
    VisibleSpectrum white{};
    find_named_spectrum(white_spectrum_name(space), white);
    const Triple xyz = integrate_xyz(white);
    return {xyz[0] / xyz[1], 1, xyz[2] / xyz[1]};
}

const Matrix3& xyz_from_rgb(ColorSpace space) {
    return matrices(space).to_xyz;
}
const Matrix3& rgb_from_xyz(ColorSpace space) {
    return matrices(space).from_xyz;
}

// An rgb reflectance is relative to its own space's white: in pbrt, (1, 1, 1) is the constant spectrum 1 in every
// space. An rgb light is a multiple of its space's white as a spectrum, and keeps that colour on any film.
Matrix3 rgb_from_rgb(ColorSpace to, ColorSpace from, bool white_to_white) {
    if (to == from) return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Matrix3 xyz = xyz_from_rgb(from);
    const Triple white_to = white_xyz(to), white_from = white_xyz(from);
    if (white_to_white)
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 3; ++c) xyz[r][c] *= white_to[r] / white_from[r];
    return multiply(rgb_from_xyz(to), xyz);
}

// sRGB: IEC 61966-2-1; DCI-P3 primaries with D65: SMPTE EG 432-1; Rec. 2020: ITU-R BT.2020; ACES2065-1: SMPTE ST
// 2065-1.
std::array<Chromaticity, 3> primaries(ColorSpace space) {
    switch (space) {
        case ColorSpace::srgb:
            break;
        case ColorSpace::dci_p3:
            return {{{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}}};
        case ColorSpace::rec2020:
            return {{{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}}};
        case ColorSpace::aces2065_1:
            return {{{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}}};
    }
    return {{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}}};
}

std::optional<ColorSpace> color_space_of(const std::array<Chromaticity, 3>& rgb, const Chromaticity& white) {
    const auto near = [](const Chromaticity& a, const Chromaticity& b) {
        return std::abs(a[0] - b[0]) <= 1e-3 * std::abs(b[0]) && std::abs(a[1] - b[1]) <= 1e-3 * std::abs(b[1]);
    };
    for (std::size_t i = 0; i < space_count; ++i) {
        const auto space = static_cast<ColorSpace>(i);
        const auto own = primaries(space);
        // Files name the white by its chromaticity: D65, or the white of ACES (SMPTE ST 2065-1).
        const Chromaticity own_white =
            space == ColorSpace::aces2065_1 ? Chromaticity{0.32168, 0.33767} : Chromaticity{0.3127, 0.3290};
        if (near(rgb[0], own[0]) && near(rgb[1], own[1]) && near(rgb[2], own[2]) && near(white, own_white))
            return space;
    }
    return std::nullopt;
}

}  // namespace raylex::transport
