#include "transport/materials/noise.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace raylex::transport {
namespace {

// The numbers 0 to 255 in the order of Perlin's program of 2002, which everybody's noise has.
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

/// (0, 1) of a lattice point's gradient times the way from it.
Real gradient(int x, int y, int z, const Vec3& d) {
    const auto at = [](int i) { return static_cast<int>(permutation[static_cast<std::size_t>(i) & 255]); };
    const int h = at(at(at(x) + y) + z) & 15;
    const bool xy = h == 12 || h == 13;
    const Real u = h < 8 || xy ? d.x : d.y, v = h < 4 || xy ? d.y : d.z;
    return ((h & 1) != 0 ? -u : u) + ((h & 2) != 0 ? -v : v);
}

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

/// The lattice repeats after 256 cells.
Cell cell_of(Real x) {
    const Real below = std::floor(x);
    return {static_cast<int>(below - 256 * std::floor(below / 256)) & 255, x - below};
}

}  // namespace

Real gradient_noise(const Vec3& p) {
    if (!is_finite(p)) return 0;
    const Cell x = cell_of(p.x), y = cell_of(p.y), z = cell_of(p.z);
    const auto corner = [&](int i, int j, int k) {
        return gradient(
            x.index + i, y.index + j, z.index + k,
            {x.within - static_cast<Real>(i), y.within - static_cast<Real>(j), z.within - static_cast<Real>(k)});
    };
    const Real wx = fade(x.within), wy = fade(y.within), wz = fade(z.within);
    const auto plane = [&](int k) {
        return blend(wy, blend(wx, corner(0, 0, k), corner(1, 0, k)), blend(wx, corner(0, 1, k), corner(1, 1, k)));
    };
    return blend(wz, plane(0), plane(1));
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
    return sum;
}

}  // namespace raylex::transport
