// Makes media from grids in a scene's parameters.
#pragma once

#include "transport/media/medium.h"

namespace raylex::transport {

/// Registers uniformgrid, rgbgrid, cloud and nanovdb.
void register_grid_media(Registry<MediumFactory>& registry);
/// Registers nanovdb only.
void register_nanovdb_medium(Registry<MediumFactory>& registry);

/// The offset and scale of a temperature grid.
struct TemperatureParameters {
    Real offset = 0, kelvin = 1;
};
/// Reads "temperatureoffset" (or "temperaturecutoff") and "temperaturescale": t means (t - offset) * scale kelvin.
Result<TemperatureParameters> read_temperature(const ParameterSet& set);
/// Stores the grid of temperatures in the emission, with its parameters.
void set_temperature(GridEmission& emission, VoxelGrid grid, const TemperatureParameters& parameters,
                     const ColorContext& color);

/// Reads "raylex:majorant", at least 1: a factor on majorants, which changes the cost only.
Result<Real> read_majorant_factor(const ParameterSet& set);
/// Makes a grid's medium for paths. `parts` is not used if only the scene's alphabet is needed.
Result<Medium> finish_grid_medium(const SceneMedium& entity, const MediumContext& context, GridMediumParts parts,
                                  bool scatters, bool emits);
/// Warns about the values of a grid that were replaced by 0.
void warn_of(const BadValues& bad, const SceneMedium& entity, const SourceLocation& where, const std::string& grid,
             std::vector<Error>& warnings);

}  // namespace raylex::transport
