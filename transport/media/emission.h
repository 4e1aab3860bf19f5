// Light that a grid of particles sends out: a radiance for each place, which its absorption turns into emission.
#pragma once

#include <vector>

#include "transport/math/matrix34.h"
#include "transport/math/voxel_grid.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// RGB of black bodies as pbrt-v4's media have them: Planck's law over its peak, integrated by the observer's functions
/// without dividing by the integral of y. Steps of 0.2 %, linear between.
class BlackbodyTable {
  public:
    BlackbodyTable() = default;
    /// Up to `hottest`, in kelvin.
    BlackbodyTable(double hottest, const ColorContext& color);
    /// Black up to 100 K, as in pbrt.
    [[nodiscard]] Rgb at(Real kelvin) const;
    /// Of any of the table.
    [[nodiscard]] Rgb brightest() const;

  private:
    std::vector<Rgb> radiance_;
};

/// What grids say of Le. Look-ups are by cell and place in it, of the grid of densities.
struct GridEmission {
    Rgb colour{1};                ///< factor on everything
    VoxelGrid scale;              ///< empty: 1 everywhere
    VoxelGrid radiance;           ///< of three channels; empty: 1 everywhere
    VoxelGrid temperature;        ///< empty: no black body
    Real offset = 0, kelvin = 1;  ///< a temperature t stands for (t - offset) * kelvin
    BlackbodyTable blackbody;
    bool own_lattice = false;  ///< the temperatures stand in cells of their own,
    Matrix34 to_temperature;   ///< which this leads to
    DVec3 temperature_lower, temperature_upper;

    /// `in_box`: the same place in the space of all cells.
    [[nodiscard]] Rgb at(std::size_t cell, const Vec3& local, const Vec3& in_box) const;
    /// Whether anything may shine in a cell.
    [[nodiscard]] bool may_shine(std::size_t cell) const;
    /// Above which nothing shines.
    [[nodiscard]] Rgb brightest() const;
    [[nodiscard]] std::size_t bytes() const { return scale.bytes() + radiance.bytes() + temperature.bytes(); }

  private:
    [[nodiscard]] Real temperature_at(std::size_t cell, const Vec3& local, const Vec3& in_box) const;
};

}  // namespace raylex::transport
