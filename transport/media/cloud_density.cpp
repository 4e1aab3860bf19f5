#include "transport/media/cloud_density.h"

#include <tbb/parallel_for.h>

#include <limits>

#include "transport/math/noise.h"

namespace raylex::transport {
namespace {

/// Slopes by differences over 0.01, as in pbrt.
Vec3 noise_slope(const Vec3& p) {
    constexpr Real step = Real(0.01);
    return noise_differences(p, step) / step;
}

Real bottom(Real y) {
    return 2 * std::max(Real(0), Real(0.5) - y);
}

}  // namespace

Real CloudDensity::raised(const Vec3& p) const {
    const Real thinning = (1 - p.y) * Real(4.5) * density;
    if (thinning == 0) return 0;
    Vec3 at = p * frequency;
    if (wispiness > 0) {
        Real most = Real(0.05) * wispiness, fineness = 10;
        for (int octave = 0; octave < 2; ++octave, most *= Real(0.5), fineness *= Real(1.99))
            at = at + noise_slope(at * fineness) * most;
    }
    return thinning * (Real(0.5) * noise_sum(at, {5, Real(0.5)}));
}

Real CloudDensity::at(const Vec3& p) const {
    const Real base = bottom(p.y);
    if (base >= 1) return 1;
    return std::clamp(std::clamp(raised(p), Real(0), Real(1)) + base, Real(0), Real(1));
}

/// The lattice of raised(): points half a cell apart, the box's ends included.
CellBox CloudDensity::points_of(const CellBox& box) {
    return {{box.size[0] * 2 + 1, box.size[1] * 2 + 1, box.size[2] * 2 + 1}, 1};
}

std::vector<float> CloudDensity::raised_at_points(const CellBox& box) const {
    const CellBox points = points_of(box);
    std::vector<float> found(points.count());
    tbb::parallel_for(0, points.size[2], [&](int z) {
        for (int y = 0; y < points.size[1]; ++y)
            for (int x = 0; x < points.size[0]; ++x) {
                const auto along = [](Real from, Real size, int i) { return from + size * static_cast<Real>(i) / 2; };
                const Vec3 p{along(lower.x, cell.x, x), along(lower.y, cell.y, y), along(lower.z, cell.z, z)};
                found[points.index(x, y, z)] = to_float(raised(p));
            }
    });
    return found;
}

std::vector<CellBounds> CloudDensity::bounds(const CellBox& box) const {
    // The range of the finest octaves and of the warp between the points.
    const Real margin = Real(0.16) + Real(0.07) * wispiness;
    const CellBox points = points_of(box);
    const bool resolved = frequency * std::max({cell.x, cell.y, cell.z}) <= Real(0.2);
    const std::vector<float> found = resolved ? raised_at_points(box) : std::vector<float>();
    /// The largest value at the points in a cell and one point around it.
    const auto largest = [&](int cx, int cy, int cz) {
        const auto first = [](int c) { return std::max(2 * c - 1, 0); };
        const auto last = [&](std::size_t a, int c) { return std::min(2 * c + 3, points.size[a] - 1); };
        float most = -std::numeric_limits<float>::infinity();
        for (int z = first(cz); z <= last(2, cz); ++z)
            for (int y = first(cy); y <= last(1, cy); ++y)
                for (int x = first(cx); x <= last(0, cx); ++x) most = std::max(most, found[points.index(x, y, z)]);
        return static_cast<Real>(most);
    };
    std::vector<CellBounds> result(box.count());
    for (int z = 0; z < box.size[2]; ++z)
        for (int y = 0; y < box.size[1]; ++y)
            for (int x = 0; x < box.size[0]; ++x) {
                const Real low = lower.y + cell.y * static_cast<Real>(y), high = low + cell.y;
                const Real varies =
                    margin * std::min(std::max(std::abs(1 - low), std::abs(1 - high)) * density, Real(1));
                const Real most = resolved ? std::clamp(largest(x, y, z) + varies, Real(0), Real(1)) : 1;
                result[box.index(x, y, z)] = {to_float(std::min(bottom(high), Real(1))),
                                              to_float(std::min(most + bottom(low), Real(1)))};
            }
    return result;
}

}  // namespace raylex::transport
