#include "transport/media/cloud_density.h"

#include <tbb/parallel_for.h>

#include "transport/geometry/ray.h"
#include "transport/materials/noise.h"

namespace raylex::transport {
namespace {

/// Differences of noise over a step of 0.01 along each axis, as pbrt takes its slope.
Vec3 noise_slope(const Vec3& p) {
    constexpr Real step = Real(0.01);
    const Real here = gradient_noise(p);
    return {(gradient_noise({p.x + step, p.y, p.z}) - here) / step,
            (gradient_noise({p.x, p.y + step, p.z}) - here) / step,
            (gradient_noise({p.x, p.y, p.z + step}) - here) / step};
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

std::vector<CellBounds> CloudDensity::bounds(const CellBox& box) const {
    // Points stand half a cell apart. The margin is of what the finest octaves and the warp move between them.
    constexpr int per_cell = 2;
    constexpr Real margin = Real(0.3);
    std::vector<CellBounds> result(box.count(), CellBounds{0, 1});
    const Real coarsest = frequency * std::max({cell.x, cell.y, cell.z});
    const bool resolved = coarsest <= Real(0.2);
    const std::array<int, 3> n{box.size[0] * per_cell + 1, box.size[1] * per_cell + 1, box.size[2] * per_cell + 1};
    const CellBox points{n};
    std::vector<float> found(resolved ? points.count() : 0);
    if (resolved)
        tbb::parallel_for(0, n[2], [&](int z) {
            for (int y = 0; y < n[1]; ++y)
                for (int x = 0; x < n[0]; ++x)
                    found[points.index(x, y, z)] =
                        to_float(raised(lower + Vec3(cell.x * static_cast<Real>(x), cell.y * static_cast<Real>(y),
                                                     cell.z * static_cast<Real>(z)) *
                                                    (1 / Real(per_cell))));
        });
    for (int z = 0; z < box.size[2]; ++z)
        for (int y = 0; y < box.size[1]; ++y)
            for (int x = 0; x < box.size[0]; ++x) {
                CellBounds& bounds = result[box.index(x, y, z)];
                const Real low = lower.y + cell.y * static_cast<Real>(y), high = low + cell.y;
                Real most = 1;
                if (resolved) {
                    most = -infinity;
                    const auto each = [&](int axis, int at) {
                        const auto a = static_cast<std::size_t>(axis);
                        return std::pair(std::max(at * per_cell - 1, 0), std::min((at + 1) * per_cell + 1, n[a] - 1));
                    };
                    const auto [x0, x1] = each(0, x);
                    const auto [y0, y1] = each(1, y);
                    const auto [z0, z1] = each(2, z);
                    for (int k = z0; k <= z1; ++k)
                        for (int j = y0; j <= y1; ++j)
                            for (int i = x0; i <= x1; ++i)
                                most = std::max(most, static_cast<Real>(found[points.index(i, j, k)]));
                    most =
                        std::clamp(most + margin * std::min(std::abs((1 - low) * density), Real(1)), Real(0), Real(1));
                }
                bounds.most = to_float(std::min(most + bottom(low), Real(1)));
                bounds.least = to_float(std::min(bottom(high), Real(1)));
            }
    return result;
}

}  // namespace raylex::transport
