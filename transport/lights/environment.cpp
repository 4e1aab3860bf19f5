#include "transport/lights/environment.h"

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"
#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

/// What a pixel is sampled by: the mean of its channels serves every primary alike.
Real weight_of(const Rgb& c) {
    return std::max(c.average(), Real(0));
}

/// Of a pixel's own radiance in what by_excess_ draws by.
constexpr Real share_of_all = Real(0.1);

/// Largest i with cumulative[i] <= u, and where u stands within that step.
std::size_t find_step(const Real* cumulative, std::size_t steps, Real u, Real& within) {
    const Real* upper = std::upper_bound(cumulative, cumulative + steps + 1, u);
    std::size_t i = upper == cumulative ? 0 : static_cast<std::size_t>(upper - cumulative) - 1;
    i = std::min(i, steps - 1);
    const Real width = cumulative[i + 1] - cumulative[i];
    within = width > 0 ? std::clamp((u - cumulative[i]) / width, Real(0), one_minus_epsilon) : 0.5f;
    return i;
}

}  // namespace

Vec2 octahedral_from_direction(const Vec3& d) {
    const Real x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
    const Real r = safe_sqrt(1 - z);
    const Real a = std::max(x, y), b = std::min(x, y);
    Real phi = elementary::atan(a == 0 ? 0 : b / a) * (2 * inv_pi);
    if (x < y) phi = 1 - phi;
    Real v = phi * r, u = r - v;
    if (d.z < 0) {
        std::swap(u, v);
        u = 1 - u;
        v = 1 - v;
    }
    return {(std::copysign(u, d.x) + 1) * 0.5f, (std::copysign(v, d.y) + 1) * 0.5f};
}

Vec3 direction_from_octahedral(const Vec2& uv) {
    const Real u = 2 * uv.x - 1, v = 2 * uv.y - 1;
    const Real up = std::abs(u), vp = std::abs(v);
    const Real signed_distance = 1 - (up + vp);
    const Real r = 1 - std::abs(signed_distance);
    const Real phi = (r == 0 ? 1 : (vp - up) / r + 1) * (pi / 4);
    const Real z = std::copysign(1 - r * r, signed_distance);
    const Real s = r * safe_sqrt(2 - r * r);
    const auto [sine, cosine] = elementary::sin_cos(phi);
    return {std::copysign(cosine, u) * s, std::copysign(sine, v) * s, z};
}

EnvironmentImage::EnvironmentImage(int resolution, std::vector<Rgb> pixels, const Placement& placement)
    : resolution_(resolution), pixels_(std::move(pixels)), placement_(placement) {
    double weights = 0, luminances = 0;
    for (const Rgb& pixel : pixels_) {
        weights += weight_of(pixel);
        luminances += luminance(pixel);
    }
    const auto count = static_cast<double>(pixels_.size());
    mean_ = luminances / count;
    by_radiance_ = distribution(0, 0);  // max(w - 0, 0)
    by_excess_ = distribution(static_cast<Real>(weights / count), share_of_all);
}

/// By max(weight - mean, 0) + plain_share * weight.
EnvironmentImage::Distribution EnvironmentImage::distribution(Real mean, Real plain_share) const {
    const auto n = static_cast<std::size_t>(resolution_);
    Distribution d;
    d.rows.assign(n + 1, 0);
    d.columns.assign(n * (n + 1), 0);
    std::vector<double> row_sums(n);
    double total = 0;
    for (std::size_t y = 0; y < n; ++y) {
        const auto weight = [&](std::size_t x) {
            const Real w = weight_of(pixels_[y * n + x]);
            return double{std::max(w - mean, Real(0))} + double{plain_share} * double{w};
        };
        double sum = 0;
        for (std::size_t x = 0; x < n; ++x) sum += weight(x);
        double running = 0;
        Real* row = d.columns.data() + y * (n + 1);
        for (std::size_t x = 0; x < n; ++x) {
            running += weight(x);
            row[x + 1] = sum > 0 ? static_cast<Real>(running / sum) : static_cast<Real>(x + 1) / static_cast<Real>(n);
        }
        row[n] = 1;
        row_sums[y] = sum;
        total += sum;
    }
    double running = 0;
    for (std::size_t y = 0; y < n && total > 0; ++y) {
        running += row_sums[y];
        d.rows[y + 1] = static_cast<Real>(running / total);
    }
    if (total > 0) d.rows[n] = 1;
    return d;
}

std::size_t EnvironmentImage::pixel_of(const Vec3& world_direction) const {
    const DVec3 local = normalize(placement_.to_object.vector(DVec3(world_direction)));
    const Vec2 uv = octahedral_from_direction(local.to_real());
    const auto cell = [this](Real v) {
        return static_cast<std::size_t>(
            std::clamp(static_cast<int>(v * static_cast<Real>(resolution_)), 0, resolution_ - 1));
    };
    return cell(uv.y) * static_cast<std::size_t>(resolution_) + cell(uv.x);
}

Real EnvironmentImage::Distribution::density(std::size_t n, std::size_t pixel) const {
    // From the stored cumulative shares and not from the pixel's value: what sample() really does.
    const std::size_t y = pixel / n, x = pixel % n;
    const Real* row = columns.data() + y * (n + 1);
    const Real share = (rows[y + 1] - rows[y]) * (row[x + 1] - row[x]);
    return share * static_cast<Real>(n) * static_cast<Real>(n) * uniform_sphere_pdf();
}

Rgb EnvironmentImage::radiance(const Vec3& world_direction) const {
    return pixels_[pixel_of(world_direction)];
}
Real EnvironmentImage::pdf(const Vec3& world_direction, By by) const {
    return drawn(by).density(static_cast<std::size_t>(resolution_), pixel_of(world_direction));
}

bool EnvironmentImage::sample(const Vec2& u, Vec3& world_direction, Rgb& radiance, Real& pdf, By by) const {
    const auto n = static_cast<std::size_t>(resolution_);
    const Distribution& d = drawn(by);
    if (!(d.rows[n] > 0)) return false;
    Real within_x, within_y;
    const std::size_t y = find_step(d.rows.data(), n, u.y, within_y);
    const std::size_t x = find_step(d.columns.data() + y * (n + 1), n, u.x, within_x);
    const std::size_t pixel = y * n + x;
    pdf = d.density(n, pixel);
    if (!(pdf > 0)) return false;
    const Real scale = 1 / static_cast<Real>(n);
    const Vec3 local = direction_from_octahedral(
        {(static_cast<Real>(x) + within_x) * scale, (static_cast<Real>(y) + within_y) * scale});
    world_direction = normalize(placement_.to_world.vector(DVec3(local))).to_real();
    radiance = pixels_[pixel];
    return true;
}

}  // namespace raylex::transport
