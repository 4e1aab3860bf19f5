#include "transport/media/emission.h"

#include <cmath>

#include "display/services/elementary.h"
#include "transport/color/spectrum.h"

namespace raylex::transport {
namespace {

constexpr double coldest = 100, step = 0.002;  // kelvin; step of the logarithm

Real largest_of(const VoxelGrid& grid) {
    float most = 0;
    for (std::size_t i = 0; i < grid.box().count(); ++i) most = std::max(most, grid.bounds(i).most);
    return static_cast<Real>(most);
}

}  // namespace

BlackbodyTable::BlackbodyTable(double hottest, const ColorContext& color) {
    if (!(hottest > coldest)) return;
    // Above 10^9 kelvin colours are constant.
    const auto steps = static_cast<int>(std::ceil(elementary::log(std::min(hottest, 1e9) / coldest) / step)) + 1;
    for (int i = 0; i <= steps; ++i)
        radiance_.push_back(blackbody_radiance(coldest * elementary::exp(i * step), color));
}

Rgb BlackbodyTable::at(Real kelvin) const {
    if (!(kelvin > Real(coldest)) || radiance_.empty()) return Rgb(0);
    const Real place = elementary::log(kelvin * Real(1 / coldest)) * Real(1 / step);
    const std::size_t below = std::min(static_cast<std::size_t>(place), radiance_.size() - 2);
    const Real rest = std::min(place - static_cast<Real>(below), Real(1));
    return radiance_[below] * (1 - rest) + radiance_[below + 1] * rest;
}

Rgb BlackbodyTable::brightest() const {
    Rgb most(0);
    for (const Rgb& each : radiance_)
        for (int c = 0; c < 3; ++c) most[c] = std::max(most[c], each[c]);
    return most;
}

Real GridEmission::temperature_at(std::size_t cell, const Vec3& local, const Vec3& in_box) const {
    if (!own_lattice) return temperature.real(cell, local);
    const DVec3 p = to_temperature.point(DVec3(in_box));
    const auto inside = [](double x, double low, double high) { return x >= low && x <= high; };
    if (!inside(p.x, temperature_lower.x, temperature_upper.x) ||
        !inside(p.y, temperature_lower.y, temperature_upper.y) ||
        !inside(p.z, temperature_lower.z, temperature_upper.z))
        return 0;
    const std::array<int, 3>& size = temperature.box().size;
    const auto cell_of = [](double x, int count) { return std::clamp(static_cast<int>(std::floor(x)), 0, count - 1); };
    const int x = cell_of(p.x, size[0]), y = cell_of(p.y, size[1]), z = cell_of(p.z, size[2]);
    return temperature.real(temperature.box().index(x, y, z), (p - DVec3(x, y, z)).to_real());
}

Rgb GridEmission::at(std::size_t cell, const Vec3& local, const Vec3& in_box) const {
    Rgb result = colour;
    if (!scale.empty()) result *= scale.real(cell, local);
    if (!radiance.empty()) result *= radiance.rgb(cell, local);
    if (!temperature.empty()) result *= blackbody.at((temperature_at(cell, local, in_box) - offset) * kelvin);
    return result;
}

bool GridEmission::may_shine(std::size_t cell) const {
    if (!scale.empty() && !(scale.bounds(cell).most > 0)) return false;
    if (!radiance.empty() && !(radiance.bounds(cell).most > 0)) return false;
    if (temperature.empty() || own_lattice) return true;
    const CellBounds bounds = temperature.bounds(cell);
    const auto kelvin_of = [&](float t) { return (static_cast<Real>(t) - offset) * kelvin; };
    return std::max(kelvin_of(bounds.least), kelvin_of(bounds.most)) > Real(coldest);
}

Rgb GridEmission::brightest() const {
    Rgb result = colour;
    if (!scale.empty()) result *= largest_of(scale);
    if (!radiance.empty()) result *= largest_of(radiance);
    if (!temperature.empty()) result *= blackbody.brightest();
    return result;
}

}  // namespace raylex::transport
