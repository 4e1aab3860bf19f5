// pbrt-v4's "nanovdb" medium: densities, and optionally temperatures, from a file.
#include <algorithm>

#include "transport/files/nanovdb_file.h"
#include "transport/media/grid_media.h"
#include "transport/media/medium_parameters.h"

namespace raylex::transport {
namespace {

/// The transform from the space of the medium to a grid's cells.
Transform cells_of(const NanoVdbGrid& grid) {
    const double per_voxel = 1.0 / grid.values.box().side;
    return Transform::scale(per_voxel, per_voxel, per_voxel) *
           Transform::translate(-grid.origin[0], -grid.origin[1], -grid.origin[2]) *
           Transform(grid.world_from_index).inverse();
}

DVec3 in_cells(const NanoVdbGrid& grid, const DVec3& index) {
    const DVec3 origin(grid.origin[0], grid.origin[1], grid.origin[2]);
    return (index - origin) * (1.0 / grid.values.box().side);
}

Error at_parameter(Error error, const Parameter& parameter) {
    return error_at(parameter.location, error.file + ": " + error.message, error.hint);
}

std::string list_of(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "'" : ", '") + name + "'";
    return list.empty() ? "none" : list;
}

struct Grids {
    NanoVdbGrid density;
    std::optional<NanoVdbGrid> temperature;
};

/// The names of the grids in the file.
struct GridNames {
    std::string density, temperature;
};

Result<GridNames> read_grid_names(const ParameterSet& set) {
    auto density = set.string_or("gridname", "density"), temperature = set.string_or("temperaturename", "temperature");
    if (!density) return density.error();
    if (!temperature) return temperature.error();
    return GridNames{*std::move(density), *std::move(temperature)};
}

Result<Grids> read_grids(const SceneMedium& entity, const Parameter& file, const GridNames& called, bool emits,
                         std::vector<Error>& warnings) {
    const std::string& path = file.strings.front();
    auto density = read_nanovdb_grid(path, called.density, false);
    if (!density) return at_parameter(density.error(), file);
    Grids grids{std::move(**density), {}};
    warn_of(grids.density.bad, entity, file.location, called.density.c_str(), warnings);
    if (!emits) return grids;
    auto temperature = read_nanovdb_grid(path, called.temperature, true);
    if (!temperature) return at_parameter(temperature.error(), file);
    grids.temperature = *std::move(temperature);
    warn_of(grids.temperature->bad, entity, file.location, called.temperature.c_str(), warnings);
    return grids;
}

/// Reads "Lescale", or "LeScale", its name in older files.
Result<double> radiance_scale(const ParameterSet& set) {
    auto older = set.real_or("LeScale", 1);
    if (!older) return older;
    return set.real_or("Lescale", *older);
}

Result<Medium> make_nanovdb(const SceneMedium& entity, const MediumContext& context) {
    const Parameter* file = entity.parameters.find("filename");
    if (file == nullptr || file->type != ParameterType::string || file->strings.size() != 1)
        return error_at(file != nullptr ? file->location : entity.location,
                        "medium '" + entity.name + "' (nanovdb) has no 'filename'; expected one NanoVDB file");
    auto coefficients = read_coefficients(entity, context);
    if (!coefficients) return coefficients.error();
    auto scale = radiance_scale(entity.parameters);
    if (!scale) return scale.error();
    auto temperature = read_temperature(entity.parameters);
    if (!temperature) return temperature.error();
    auto names = nanovdb_grid_names(file->strings.front());
    if (!names) return at_parameter(names.error(), *file);
    auto called = read_grid_names(entity.parameters);
    if (!called) return called.error();
    const auto has = [&](const std::string& name) {
        return std::find(names->begin(), names->end(), name) != names->end();
    };
    if (!has(called->density))
        return error_at(file->location,
                        file->strings.front() + " has no grid '" + called->density + "'; it has: " + list_of(*names));
    const bool emits = has(called->temperature) && *scale > 0 && !coefficients->sigma_a.is_black();
    GridMediumParts parts;
    parts.sigma_a = coefficients->sigma_a;
    parts.sigma_s = coefficients->sigma_s;
    if (context.space != nullptr) {
        auto grids = read_grids(entity, *file, *called, emits, context.warnings);
        if (!grids) return grids.error();
        const Transform to_cells = cells_of(grids->density);
        CellFrame& frame = parts.frame;
        frame.to_cells = Matrix34((to_cells * context.space->placed(entity.to_world).inverse()).matrix());
        frame.box = grids->density.values.box();
        frame.lower = in_cells(grids->density, grids->density.lower);
        frame.upper = in_cells(grids->density, grids->density.upper);
        parts.density = std::move(grids->density.values);
        if (emits) {
            GridEmission& emission = parts.emission.emplace();
            NanoVdbGrid& heat = *grids->temperature;
            emission.colour = Rgb(static_cast<Real>(*scale));
            emission.own_lattice = true;
            emission.to_temperature = Matrix34((cells_of(heat) * to_cells.inverse()).matrix());
            const std::array<int, 3>& size = heat.values.box().size;
            emission.temperature_upper = DVec3(size[0], size[1], size[2]);
            set_temperature(emission, std::move(heat.values), *temperature, context.scene.color);
        }
    }
    return finish_grid_medium(entity, context, std::move(parts), !coefficients->sigma_s.is_black(), emits);
}

}  // namespace

void register_nanovdb_medium(Registry<MediumFactory>& registry) {
    using T = ParameterType;
    registry.add(
        {"nanovdb",
         "densities from a NanoVDB file that scale coefficients",
         {{"filename", T::string, "", "NanoVDB file with a grid of densities, and optionally one of temperatures"},
          {"gridname", T::string, "density", "name of the grid of densities"},
          {"temperaturename", T::string, "temperature", "name of the grid of temperatures, which is optional"},
          {"sigma_a", T::spectrum, "1", "absorption per unit length where the density is 1"},
          {"sigma_s", T::spectrum, "1", "scattering per unit length where the density is 1"},
          {"preset", T::string, "", "a measured medium's name, instead of both; per millimetre"},
          {"scale", T::real, "1", "factor on both"},
          {"g", T::real, "0", "asymmetry: -1 backward, 0 isotropic, 1 forward"},
          {"Lescale", T::real, "1", "factor on the emission of blackbodies"},
          {"LeScale", T::real, "1", "an older name of Lescale"},
          {"temperatureoffset", T::real, "0", "subtracted from the temperatures before they are scaled"},
          {"temperaturecutoff", T::real, "0", "an older name of temperatureoffset"},
          {"temperaturescale", T::real, "1", "factor from temperatures to kelvin"},
          {"raylex:majorant", T::real, "1", "factor on majorants, from 1 up: more null collisions, the same mean"}},
         make_nanovdb});
}

}  // namespace raylex::transport
