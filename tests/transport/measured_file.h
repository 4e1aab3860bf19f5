// Writes measured materials of analytic surfaces in the format of RGL's files, whose values are known in closed form.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace measured_test {

struct Direction {
    double x, y, z;
};
inline double dot(const Direction& a, const Direction& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Direction polar(double theta, double phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// A surface by its normals D, their projected area sigma(wo), and f |cos| / (D / (4 sigma)).
struct Surface {
    std::function<double(const Direction&)> normals, area;
    std::function<double(const Direction& wo, const Direction& wi, const Direction& m)> rest;
};

/// A Lambertian surface with normals spread evenly over the hemisphere.
inline Surface lambert(double albedo) {
    const auto area = [](const Direction& wo) { return (1 + wo.z) / 2; };
    return {[](const Direction&) { return 1 / std::acos(-1.0); }, area,
            [=](const Direction& wo, const Direction& wi, const Direction&) { return 4 * area(wo) * albedo * wi.z; }};
}

/// GGX with height-correlated masking and the constant reflectance `fresnel`.
inline Surface ggx(double ax, double ay, double fresnel) {
    const auto lambda = [=](const Direction& w) {
        const double t = (ax * ax * w.x * w.x + ay * ay * w.y * w.y) / (w.z * w.z);
        return (std::sqrt(1 + t) - 1) / 2;
    };
    return {[=](const Direction& m) {
                const double s = m.x * m.x / (ax * ax) + m.y * m.y / (ay * ay) + m.z * m.z;
                return 1 / (std::acos(-1.0) * ax * ay * s * s);
            },
            [=](const Direction& w) { return w.z * (1 + lambda(w)); },
            [=](const Direction& wo, const Direction& wi, const Direction&) {
                return fresnel * (1 + lambda(wo)) / (1 + lambda(wo) + lambda(wi));
            }};
}

class TensorWriter {
  public:
    void add(const std::string& name, const std::vector<std::uint64_t>& shape, const std::vector<float>& values) {
        fields_.push_back({name, shape, values});
    }
    [[nodiscard]] std::string bytes() const {
        std::string head("tensor_file\0\1\0", 14);
        append(head, fields_.size(), 4);
        std::size_t at = head.size();
        for (const Field& f : fields_) at += 2 + f.name.size() + 2 + 1 + 8 + 8 * f.shape.size();
        std::string data;
        for (const Field& f : fields_) {
            append(head, f.name.size(), 2);
            head += f.name;
            append(head, f.shape.size(), 2);
            append(head, 10, 1);  // single precision
            append(head, at + data.size(), 8);
            for (const std::uint64_t n : f.shape) append(head, n, 8);
            for (const float v : f.values) append(data, std::bit_cast<std::uint32_t>(v), 4);
        }
        return head + data;
    }

  private:
    struct Field {
        std::string name;
        std::vector<std::uint64_t> shape;
        std::vector<float> values;
    };
    static void append(std::string& to, std::uint64_t value, int size) {
        for (int i = 0; i < size; ++i) to += static_cast<char>(value >> (8 * i) & 255);
    }
    std::vector<Field> fields_;
};

/// The density of a table on a grid of the square, inverted slowly: cumulative sums and bisection.
class SlowWarp {
  public:
    SlowWarp(std::vector<double> values, int rows, int columns)
        : v_(std::move(values)), rows_(rows), columns_(columns) {
        for (int y = 0; y < rows_; ++y) row_.push_back(integral_of_row(y, 1));
        total_ = 0;
        for (int y = 0; y + 1 < rows_; ++y) total_ += (row_[at(y)] + row_[at(y + 1)]) / 2;
    }
    void sample(double ux, double uy, double& x, double& y) const {
        y = halve([&](double c) { return up_to(c); }, uy * total_);
        const int r = std::min(static_cast<int>(y * (rows_ - 1)), rows_ - 2);
        const double t = y * (rows_ - 1) - r;
        const auto along = [&](double c) { return (1 - t) * integral_of_row(r, c) + t * integral_of_row(r + 1, c); };
        x = halve(along, ux * along(1));
    }

  private:
    static std::size_t at(int i) { return static_cast<std::size_t>(i); }
    template <class F>
    static double halve(const F& f, double wanted) {
        double low = 0, high = 1;
        for (int i = 0; i < 50; ++i) {
            const double middle = (low + high) / 2;
            (f(middle) < wanted ? low : high) = middle;
        }
        return low;
    }
    [[nodiscard]] double integral_of_row(int y, double to) const {
        double sum = 0;
        for (int x = 0; x + 1 < columns_; ++x) {
            const double s = std::clamp(to * (columns_ - 1) - x, 0.0, 1.0), a = v_[at(y * columns_ + x)],
                         b = v_[at(y * columns_ + x + 1)];
            sum += s * (a + s * (b - a) / 2);
        }
        return sum;
    }
    [[nodiscard]] double up_to(double to) const {
        double sum = 0;
        for (int y = 0; y + 1 < rows_; ++y) {
            const double t = std::clamp(to * (rows_ - 1) - y, 0.0, 1.0), a = row_[at(y)], b = row_[at(y + 1)];
            sum += t * (a + t * (b - a) / 2);
        }
        return sum;
    }
    std::vector<double> v_, row_;
    int rows_, columns_;
    double total_ = 0;
};

struct Resolution {
    int theta = 5, phi = 1, normals = 64, square = 32;
    std::vector<float> wavelengths{360, 1000}, spectrum{1, 1};
};

/// The file of `surface`, times `spectrum` at each wavelength. One phi: isotropic.
inline std::string file_of(const Surface& surface, const Resolution& n) {
    const double pi = std::acos(-1.0);
    const int rows = n.normals, columns = n.normals;
    const auto theta_of = [&](double u) { return u * u * pi / 2; };
    const auto phi_of = [&](double v) { return (2 * v - 1) * pi; };
    std::vector<float> thetas, phis, normals, sigma, vndf, luminance, spectra;
    for (int i = 0; i < n.theta; ++i) thetas.push_back(static_cast<float>(i * 1.4 / (n.theta - 1)));
    for (int i = 0; i < n.phi; ++i) phis.push_back(static_cast<float>(n.phi == 1 ? 0 : -pi + 2 * pi * i / (n.phi - 1)));
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const Direction m = polar(theta_of(double(x) / (columns - 1)), phi_of(double(y) / (rows - 1)));
            normals.push_back(static_cast<float>(surface.normals(m)));
            const Direction grazing =
                polar(std::min(theta_of(double(x) / (columns - 1)), 1.57), phi_of(double(y) / (rows - 1)));
            sigma.push_back(static_cast<float>(surface.area(grazing)));
        }
    for (const float phi : phis)
        for (const float theta : thetas) {
            const Direction wo = polar(theta, phi);
            std::vector<double> visible;
            for (int y = 0; y < rows; ++y)
                for (int x = 0; x < columns; ++x) {
                    // Normals rotate with wo if the surface is isotropic.
                    const double u = double(x) / (columns - 1), t = theta_of(u);
                    const Direction m = polar(t, phi_of(double(y) / (rows - 1)));
                    visible.push_back(surface.normals(m) * std::max(dot(wo, m), 0.0) * u * std::sin(t));
                }
            for (const double each : visible) vndf.push_back(static_cast<float>(each));
            const SlowWarp warp(visible, rows, columns);
            std::vector<float> plane;
            for (int y = 0; y < n.square; ++y)
                for (int x = 0; x < n.square; ++x) {
                    double a, b;
                    warp.sample(double(x) / (n.square - 1), double(y) / (n.square - 1), a, b);
                    const Direction m = polar(theta_of(a), phi_of(b));
                    const double c = dot(wo, m);
                    const Direction wi{2 * c * m.x - wo.x, 2 * c * m.y - wo.y, 2 * c * m.z - wo.z};
                    plane.push_back(static_cast<float>(c > 0 && wi.z > 0 ? surface.rest(wo, wi, m) : 0));
                }
            luminance.insert(luminance.end(), plane.begin(), plane.end());
            for (const float each : n.spectrum)
                for (const float value : plane) spectra.push_back(each * value);
        }
    const auto size = [](int i) { return static_cast<std::uint64_t>(i); };
    TensorWriter file;
    file.add("theta_i", {thetas.size()}, thetas);
    file.add("phi_i", {phis.size()}, phis);
    file.add("wavelengths", {n.wavelengths.size()}, n.wavelengths);
    file.add("ndf", {size(rows), size(columns)}, normals);
    file.add("sigma", {size(rows), size(columns)}, sigma);
    file.add("vndf", {phis.size(), thetas.size(), size(rows), size(columns)}, vndf);
    file.add("luminance", {phis.size(), thetas.size(), size(n.square), size(n.square)}, luminance);
    file.add("spectra", {phis.size(), thetas.size(), n.spectrum.size(), size(n.square), size(n.square)}, spectra);
    return file.bytes();
}

}  // namespace measured_test
