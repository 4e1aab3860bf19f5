#include "transport/lights/images/portal_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "display/services/elementary.h"
#include "transport/lights/images/environment.h"

namespace raylex::transport {
namespace {

/// Maps the angle in (-pi/2, pi/2) of the coordinates x and z to [0, 1].
double share_of_half_turn(double x, double z) {
    return std::clamp(elementary::atan2(x, z) / std::numbers::pi + 0.5, 0.0, 1.0);
}

/// The direction in the portal's frame of a point (x, y) in (0, 1)^2.
DVec3 direction_of(double x, double y) {
    const auto a = elementary::sin_cos((x - 0.5) * std::numbers::pi),
               b = elementary::sin_cos((y - 0.5) * std::numbers::pi);
    // (tan a, tan b, 1) times both cosines: at the border this is 0 instead of infinite.
    return normalize(DVec3{a.sin * b.cos, b.sin * a.cos, a.cos * b.cos});
}

/// Solid angle per area of the rectified image: pi^2 (1 - x^2) (1 - y^2) / z (Bitterli et al. 2015, section 3).
double solid_angle(const DVec3& w) {
    return std::numbers::pi * std::numbers::pi * (1 - w.x * w.x) * (1 - w.y * w.y) / w.z;
}

}  // namespace

std::optional<std::string> PortalImage::problem_of(const Corners& c) {
    std::array<DVec3, 4> sides;
    for (std::size_t i = 0; i < 4; ++i) {
        sides[i] = c[(i + 1) % 4] - c[i];
        if (!(length(sides[i]) > 0)) return "two of its corners are the same point";
        sides[i] = normalize(sides[i]);
    }
    constexpr double tolerance = 0.01;
    for (std::size_t i = 0; i < 4; ++i)
        if (std::abs(dot(sides[i], sides[(i + 1) % 4])) > tolerance) return "its sides are not at right angles";
    const double twist = std::abs(dot(cross(sides[0], sides[1]), c[3] - c[0]));
    if (twist > tolerance * length(c[3] - c[0])) return "its corners are not in a plane";
    return std::nullopt;
}

PortalImage::PortalImage(const RgbImage& image, const Placement& placement, const Corners& corners)
    : resolution_(image.width),
      corner_(corners[0]),
      opposite_(corners[2]),
      side_x_(corners[3] - corners[0]),
      side_y_(corners[1] - corners[0]) {
    s_ = normalize(side_x_);
    t_ = normalize(side_y_ - s_ * dot(s_, side_y_));
    n_ = cross(s_, t_);
    area_ = length(cross(side_x_, side_y_));
    const auto n = static_cast<std::size_t>(resolution_);
    const double cell = 1 / static_cast<double>(n);
    sums_.assign((n + 1) * (n + 1), 0);
    for (std::size_t y = 0; y < n; ++y) {
        double row = 0;
        for (std::size_t x = 0; x < n; ++x) {
            const DVec3 local =
                direction_of((static_cast<double>(x) + 0.5) * cell, (static_cast<double>(y) + 0.5) * cell);
            const DVec3 world = s_ * local.x + t_ * local.y + n_ * local.z;
            const DVec3 of_image = normalize(placement.to_object.vector(world));
            pixels_.push_back(octahedral_bilinear(image, octahedral_from_direction(of_image.to_real())));
            const double angle = solid_angle(local) * cell * cell;
            weights_.push_back(sampling_weight(pixels_.back()) * angle);
            row += weights_.back();
            sums_[(y + 1) * (n + 1) + x + 1] = sums_[y * (n + 1) + x + 1] + row;
            flux_ += luminance(pixels_.back()) * angle * local.z * area_;
        }
    }
}

Vec2 PortalImage::image_point(const DVec3& local) {
    return {static_cast<Real>(share_of_half_turn(local.x, local.z)),
            static_cast<Real>(share_of_half_turn(local.y, local.z))};
}

std::size_t PortalImage::pixel_of(const Vec2& at) const {
    const auto cell = [this](Real v) {
        return static_cast<std::size_t>(
            std::clamp(static_cast<int>(v * static_cast<Real>(resolution_)), 0, resolution_ - 1));
    };
    return cell(at.y) * static_cast<std::size_t>(resolution_) + cell(at.x);
}

double PortalImage::sum(double x, double y) const {
    const double n = resolution_;
    const double px = x * n, py = y * n;
    const auto i = static_cast<std::size_t>(std::min(px, n - 1)), j = static_cast<std::size_t>(std::min(py, n - 1));
    const double fx = px - static_cast<double>(i), fy = py - static_cast<double>(j);
    const double* row = sums_.data() + j * (static_cast<std::size_t>(resolution_) + 1) + i;
    const double* next = row + resolution_ + 1;
    return (row[0] * (1 - fx) + row[1] * fx) * (1 - fy) + (next[0] * (1 - fx) + next[1] * fx) * fy;
}

bool PortalImage::window_from(const Vec3& from, Window& window) const {
    const DVec3 near = to_frame(corner_ - DVec3(from)), far = to_frame(opposite_ - DVec3(from));
    if (!(near.z > 0)) return false;  // in the portal's plane or outside
    window.x0 = share_of_half_turn(near.x, near.z);
    window.y0 = share_of_half_turn(near.y, near.z);
    window.x1 = share_of_half_turn(far.x, near.z);
    window.y1 = share_of_half_turn(far.y, near.z);
    return window.x0 < window.x1 && window.y0 < window.y1;
}

Rgb PortalImage::radiance(const Vec3& from, const Vec3& direction) const {
    const DVec3 local = to_frame(DVec3(direction));
    Window window;
    if (!(local.z > 0) || !window_from(from, window)) return {};
    const double x = share_of_half_turn(local.x, local.z), y = share_of_half_turn(local.y, local.z);
    if (x < window.x0 || x > window.x1 || y < window.y0 || y > window.y1) return {};
    return pixels_[pixel_of({static_cast<Real>(x), static_cast<Real>(y)})];
}

Real PortalImage::density(const Window& window, const Vec2& at, const DVec3& local) const {
    const double whole = sum(window);
    if (!(whole > 0)) return 0;
    const double n = resolution_;
    return static_cast<Real>(weights_[pixel_of(at)] * n * n / (whole * solid_angle(local)));
}

Real PortalImage::pdf(const Vec3& from, const Vec3& direction) const {
    const DVec3 local = to_frame(DVec3(direction));
    Window window;
    if (!(local.z > 0) || !window_from(from, window)) return 0;
    const double x = share_of_half_turn(local.x, local.z), y = share_of_half_turn(local.y, local.z);
    if (x < window.x0 || x > window.x1 || y < window.y0 || y > window.y1) return 0;
    return density(window, {static_cast<Real>(x), static_cast<Real>(y)}, local);
}

bool PortalImage::sample(const Window& window, const Vec2& u, Vec3& direction, Rgb& radiance, Real& pdf) const {
    const double whole = sum(window);
    if (!(whole > 0)) return false;
    // Finds the column in which the integral reaches a share u.x and the position within it; then the same along the
    // column.
    const auto find = [this](double lower, double upper, double wanted, auto integral_up_to, double& at) {
        const double n = resolution_;
        int first = std::min(static_cast<int>(lower * n), resolution_ - 1),
            last = std::min(static_cast<int>(std::ceil(upper * n)), resolution_) - 1;
        while (first < last) {
            const int middle = (first + last) / 2;
            if (integral_up_to((middle + 1) / n) > wanted) last = middle;
            else first = middle + 1;
        }
        const double from = std::max(first / n, lower), to = std::min((first + 1) / n, upper);
        const double before = integral_up_to(from), after = integral_up_to(to);
        const double share = after > before ? std::clamp((wanted - before) / (after - before), 0.0, 1.0) : 0.5;
        at = from + (to - from) * share;
        return first;
    };
    double x = 0, y = 0;
    const double n = resolution_;
    const int column = find(
        window.x0, window.x1, static_cast<double>(u.x) * whole,
        [&](double to) {
            return sum({window.x0, window.y0, to, window.y1});
        },
        x);
    const Window strip{column / n, window.y0, (column + 1) / n, window.y1};
    const double of_strip = sum(strip);
    if (!(of_strip > 0)) return false;
    const int row = find(
        window.y0, window.y1, static_cast<double>(u.y) * of_strip,
        [&](double to) {
            return sum({strip.x0, window.y0, strip.x1, to});
        },
        y);
    const std::size_t pixel =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(resolution_) + static_cast<std::size_t>(column);
    const DVec3 local = direction_of(x, y);
    if (!(weights_[pixel] > 0) || !(local.z > 0)) return false;
    direction = normalize(s_ * local.x + t_ * local.y + n_ * local.z).to_real();
    radiance = pixels_[pixel];
    pdf = static_cast<Real>(weights_[pixel] * n * n / (whole * solid_angle(local)));
    return pdf > 0;
}

bool PortalImage::sample(const Vec3& from, const Vec2& u, Vec3& direction, Rgb& radiance, Real& pdf) const {
    Window window;
    return window_from(from, window) && sample(window, u, direction, radiance, pdf);
}

bool PortalImage::sample_emission(const Vec2& u, Vec3& direction, Rgb& radiance, Real& pdf) const {
    return sample(Window(), u, direction, radiance, pdf);
}

Real PortalImage::emission_pdf(const Vec3& direction) const {
    const DVec3 local = to_frame(DVec3(direction));
    return local.z > 0 ? density(Window(), image_point(local), local) : Real(0);
}

Vec3 PortalImage::point(const Vec2& u) const {
    return (corner_ + side_x_ * static_cast<double>(u.x) + side_y_ * static_cast<double>(u.y)).to_real();
}

Real PortalImage::density_across(const Vec3& direction) const {
    const double cosine = dot(DVec3(direction), n_);
    return cosine > 0 ? static_cast<Real>(1 / (area_ * cosine)) : Real(0);
}

}  // namespace raylex::transport
