// Emission of a grid of particles: a radiance for each place, which absorption turns into emission.
#pragma once

#include <vector>

#include "transport/math/matrix34.h"
#include "transport/math/voxel_grid.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// RGB of blackbodies as in pbrt-v4's media: Planck's law over its maximum, integrated with the observer's functions
/// without dividing by the integral of y. In steps of 0.2 %, linear in between.
class BlackbodyTable {
  public:
    BlackbodyTable() = default;
    /// Builds the table up to `hottest`, in kelvin.
    BlackbodyTable(double hottest, const ColorContext& color);
    /// The radiance at a temperature; black up to 100 K, as in pbrt.
    [[nodiscard]] Rgb at(Real kelvin) const;
    /// The largest values in the table, colour by colour.
    [[nodiscard]] Rgb brightest() const;

  private:
    std::vector<Rgb> radiance_;
};

/// The radiance Le from grids. Look-ups take a cell of the density grid and a place in it.
struct GridEmission {
    Rgb colour{1};                ///< factor on all of the emission
    VoxelGrid scale;              ///< empty: 1 everywhere
    VoxelGrid radiance;           ///< three channels; empty: 1 everywhere
    VoxelGrid temperature;        ///< empty: no blackbody
    Real offset = 0, kelvin = 1;  ///< a temperature t means (t - offset) * kelvin
    BlackbodyTable blackbody;
    bool own_lattice = false;  ///< the temperatures have a lattice of their own,
    Matrix34 to_temperature;   ///< and this leads to its cells
    DVec3 temperature_lower, temperature_upper;

    /// The radiance at a place; `in_box` is the place in the space of all cells.
    [[nodiscard]] Rgb at(std::size_t cell, const Vec3& local, const Vec3& in_box) const;
    /// Whether a cell may emit.
    [[nodiscard]] bool may_shine(std::size_t cell) const;
    /// An upper bound on the radiance.
    [[nodiscard]] Rgb brightest() const;
    [[nodiscard]] std::size_t bytes() const { return scale.bytes() + radiance.bytes() + temperature.bytes(); }

  private:
    [[nodiscard]] Real temperature_at(std::size_t cell, const Vec3& local, const Vec3& in_box) const;
};

}  // namespace raylex::transport
