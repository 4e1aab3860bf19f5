#include "transport/cameras/aperture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "display/services/elementary.h"
#include "transport/files/images/image.h"

namespace raylex::transport {
namespace {

constexpr std::array<const char*, 5> built_in{"circular", "gaussian", "square", "pentagon", "star"};

struct Corner {
    double x, y;
};

/// A pentagon around the origin with a corner pointing down, as in pbrt-v4 (RealisticCamera::Create).
std::vector<Corner> pentagon() {
    std::vector<Corner> corners;
    for (int i = 0; i < 5; ++i) {
        const auto angle = elementary::sin_cos(2 * std::numbers::pi * i / 5);
        corners.push_back({-0.8 * angle.sin, -0.8 * angle.cos});
    }
    return corners;
}

/// A star around the origin with a tip pointing left, as in pbrt-v4.
std::vector<Corner> star() {
    constexpr double degree = std::numbers::pi / 180;
    const double inner = elementary::sin_cos(72 * degree).cos / elementary::sin_cos(36 * degree).cos;
    std::vector<Corner> corners;
    for (int i = 0; i < 10; ++i) {
        const auto angle = elementary::sin_cos(36 * degree * i);
        const double radius = i % 2 == 1 ? 1 : inner;
        corners.push_back({radius * angle.cos, radius * angle.sin});
    }
    return corners;
}

/// Counts how often a line from (x, y) to the right crosses the sides; (x, y) is inside if the count is odd.
bool inside(const std::vector<Corner>& corners, double x, double y) {
    bool within = false;
    for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
        const Corner &a = corners[i], &b = corners[j];
        if ((a.y > y) != (b.y > y) && x < (b.x - a.x) * (y - a.y) / (b.y - a.y) + a.x) within = !within;
    }
    return within;
}

std::function<double(double, double)> shape_named(const std::string& name) {
    if (name == "gaussian")
        return
            [](double x, double y) { return std::max(0.0, elementary::exp(-x * x - y * y) - elementary::exp(-1.0)); };
    if (name == "square")
        return [](double x, double y) { return std::max(std::abs(x), std::abs(y)) < 0.5 ? 1.0 : 0.0; };
    return [corners = name == "pentagon" ? pentagon() : star()](double x, double y) {
        return inside(corners, x, y) ? 1.0 : 0.0;
    };
}

}  // namespace

bool Aperture::is_built_in(const std::string& name) {
    return name.empty() || std::find(built_in.begin(), built_in.end(), name) != built_in.end();
}

Result<Aperture> Aperture::named(const std::string& name, const SourceLocation& where) {
    Aperture aperture;
    if (name.empty() || name == "circular") return aperture;
    if (is_built_in(name)) {
        constexpr int resolution = 256;
        aperture.width_ = aperture.height_ = resolution;
        constexpr double half = resolution / 2.0;
        const auto shape = shape_named(name);
        for (int y = 0; y < resolution; ++y)
            for (int x = 0; x < resolution; ++x)
                aperture.pixels_.push_back(static_cast<float>(shape((x + 0.5) / half - 1, 1 - (y + 0.5) / half)));
    } else {
        auto image = read_image(name);
        if (!image) return named_by(image.error(), "'aperture'", where);
        static_cast<void>(clear_invalid_texels(*image, NegativeTexels::cleared));
        aperture.width_ = image->width;
        aperture.height_ = image->height;
        const int colours = image->channels < 3 ? 1 : 3;
        for (int y = 0; y < image->height; ++y)
            for (int x = 0; x < image->width; ++x) {
                float sum = 0;
                for (int c = 0; c < colours; ++c) sum += image->at(x, y, c);
                aperture.pixels_.push_back(sum / static_cast<float>(colours));
            }
    }
    double sum = 0;
    for (const float value : aperture.pixels_) sum += static_cast<double>(value);
    if (!(sum > 0)) return error_at(where, "the aperture '" + name + "' transmits no light");
    const double scale = std::numbers::pi / 4 / (sum / static_cast<double>(aperture.pixels_.size()));
    for (float& value : aperture.pixels_) value = static_cast<float>(static_cast<double>(value) * scale);
    return aperture;
}

double Aperture::transmittance(double x, double y) const {
    if (pixels_.empty()) return x * x + y * y <= 1 ? 1 : 0;
    if (!(std::abs(x) < 1 && std::abs(y) < 1)) return 0;
    const double px = (x + 1) / 2 * width_ - 0.5, py = (1 - y) / 2 * height_ - 0.5;
    const int ix = static_cast<int>(std::floor(px)), iy = static_cast<int>(std::floor(py));
    const auto at = [this](int i, int j) {
        if (i < 0 || j < 0 || i >= width_ || j >= height_) return 0.0;
        return static_cast<double>(
            pixels_[static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(i)]);
    };
    const double fx = px - ix, fy = py - iy;
    return (at(ix, iy) * (1 - fx) + at(ix + 1, iy) * fx) * (1 - fy) +
           (at(ix, iy + 1) * (1 - fx) + at(ix + 1, iy + 1) * fx) * fy;
}

}  // namespace raylex::transport
