#include "transport/math/noise.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace raylex::transport {
namespace {

// The numbers 0 to 255 in the order of Perlin's program of 2002, which all implementations share.
constexpr std::array<std::uint8_t, 256> permutation{
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,  69,  142,
    8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,  94,  252, 219, 203,
    117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136, 171, 168, 68,  175, 74,  165,
    71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122, 60,  211, 133, 230, 220, 105, 92,  41,
    55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161, 1,   216, 80,  73,  209, 76,  132, 187, 208, 89,
    18,  169, 200, 196, 135, 130, 116, 188, 159, 86,  164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250,
    124, 123, 5,   202, 38,  147, 118, 126, 255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189,
    28,  42,  223, 183, 170, 213, 119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,
    129, 22,  39,  253, 19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,
    242, 193, 238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,  222, 114,
    67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

constexpr bool is_permutation_of_bytes() {
    std::array<bool, 256> seen{};
    for (const std::uint8_t value : permutation) {
        if (seen[value]) return false;
        seen[value] = true;
    }
    return true;
}
static_assert(is_permutation_of_bytes());

/// Gradients by a hash of 4 bits, in x, y, z. Two components are 1 or -1, the third is 0.
constexpr std::array<std::array<Real, 3>, 16> gradients = [] {
    std::array<std::array<Real, 3>, 16> all{};
    for (std::size_t h = 0; h < 16; ++h) {
        const bool xy = h == 12 || h == 13;
        all[h][h < 8 || xy ? 0 : 1] += (h & 1) != 0 ? -1 : 1;
        all[h][h < 4 || xy ? 1 : 2] += (h & 2) != 0 ? -1 : 1;
    }
    return all;
}();

Real fade(Real t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

Real blend(Real t, Real a, Real b) {
    return a + t * (b - a);
}

struct Cell {
    int index = 0;
    Real within = 0;
};

/// The cell of a coordinate. The lattice repeats after 256 cells.
Cell cell_of(Real x) {
    const Real below = std::floor(x);
    return {static_cast<int>(below - 256 * std::floor(below / 256)) & 255, x - below};
}

/// The gradients at a cell's corners, side by side and without branches, which would be unpredictable.
class Corners {
  public:
    Corners(int x, int y, int z) {
        const auto at = [](int i) { return static_cast<int>(permutation[static_cast<std::size_t>(i) & 255]); };
        for (int i = 0; i < 2; ++i) {
            const int of_x = at(x + i) + y;
            for (int j = 0; j < 2; ++j) {
                const int of_y = at(of_x + j) + z;
                for (int k = 0; k < 2; ++k) {
                    const std::array<Real, 3>& g = gradients[static_cast<std::size_t>(at(of_y + k) & 15)];
                    const auto c = static_cast<std::size_t>(4 * k + 2 * j + i);
                    x_[c] = g[0];
                    y_[c] = g[1];
                    z_[c] = g[2];
                }
            }
        }
    }
    [[nodiscard]] Real noise(Real x, Real y, Real z) const {
        std::array<Real, 8> from;  // the dot product of each corner's gradient and the offset from the corner
        for (std::size_t c = 0; c < 8; ++c)
            from[c] = x_[c] * (x - static_cast<Real>(c & 1)) + y_[c] * (y - static_cast<Real>(c >> 1 & 1)) +
                      z_[c] * (z - static_cast<Real>(c >> 2));
        const Real wx = fade(x), wy = fade(y), wz = fade(z);
        const auto plane = [&](std::size_t c) {
            return blend(wy, blend(wx, from[c], from[c + 1]), blend(wx, from[c + 2], from[c + 3]));
        };
        return blend(wz, plane(0), plane(4));
    }

  private:
    std::array<Real, 8> x_, y_, z_;
};

}  // namespace

Real gradient_noise(const Vec3& p) {
    if (!is_finite(p)) return 0;
    const Cell x = cell_of(p.x), y = cell_of(p.y), z = cell_of(p.z);
    return Corners(x.index, y.index, z.index).noise(x.within, y.within, z.within);
}

Vec3 noise_differences(const Vec3& p, Real step) {
    if (!is_finite(p)) return {0, 0, 0};
    const Cell x = cell_of(p.x), y = cell_of(p.y), z = cell_of(p.z);
    const Cell next_x = cell_of(p.x + step), next_y = cell_of(p.y + step), next_z = cell_of(p.z + step);
    const Corners corners(x.index, y.index, z.index);
    const auto noise = [&](const Cell& i, const Cell& j, const Cell& k) {
        if (i.index == x.index && j.index == y.index && k.index == z.index)
            return corners.noise(i.within, j.within, k.within);
        return Corners(i.index, j.index, k.index).noise(i.within, j.within, k.within);
    };
    const Real here = corners.noise(x.within, y.within, z.within);
    return {noise(next_x, y, z) - here, noise(x, next_y, z) - here, noise(x, y, next_z) - here};
}

Real noise_sum(const Vec3& p, const Octaves& octaves) {
    Real sum = 0, frequency = 1, height = 1;
    for (int i = 0; i < octaves.count; ++i, frequency *= Real(1.99), height *= octaves.roughness)
        sum += height * gradient_noise(p * frequency);
    return sum;
}

Real absolute_noise_sum(const Vec3& p, const Octaves& octaves) {
    Real sum = 0, frequency = 1, height = 1;
    for (int i = 0; i < octaves.count; ++i, frequency *= Real(1.99), height *= octaves.roughness)
        sum += height * std::abs(gradient_noise(p * frequency));
    return sum + Real(0.2) * height;  // as pbrt-v4's Turbulence: the mean of the next octave
}

}  // namespace raylex::transport
