// Media from grids, made from a scene's parameters.
#pragma once

#include "transport/media/medium.h"

namespace raylex::transport {

/// uniformgrid, rgbgrid, cloud, nanovdb.
void register_grid_media(Registry<MediumFactory>& registry);
/// nanovdb alone.
void register_nanovdb_medium(Registry<MediumFactory>& registry);

/// What "Le", "Lescale" and grids beside the density make of a medium.
struct TemperatureParameters {
    Real offset = 0, kelvin = 1;
};
/// "temperatureoffset" (or "temperaturecutoff") and "temperaturescale": t stands for (t - offset) * scale kelvin.
Result<TemperatureParameters> read_temperature(const ParameterSet& set);
/// Sets what an emission needs of a grid of temperatures and takes the grid.
void set_temperature(GridEmission& emission, VoxelGrid grid, const TemperatureParameters& parameters,
                     const ColorContext& color);

/// "raylex:majorant", from 1 up: a factor on majorants, which changes cost and nothing else.
Result<Real> read_majorant_factor(const ParameterSet& set);
/// A grid's medium as paths see it. `parts` is not looked at where only words are wanted.
Result<Medium> finish_grid_medium(const SceneMedium& entity, const MediumContext& context, GridMediumParts parts,
                                  bool scatters, bool emits);
/// Says how many values of a grid are taken as 0.
void warn_of(const BadValues& bad, const SceneMedium& entity, const SourceLocation& where, const std::string& grid,
             std::vector<Error>& warnings);

}  // namespace raylex::transport
