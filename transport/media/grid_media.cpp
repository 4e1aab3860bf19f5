#include "transport/media/grid_media.h"

#include <cmath>

#include "display/services/short_number.h"
#include "lpe/input/budgets.h"
#include "transport/color/spectrum.h"
#include "transport/media/medium_parameters.h"

namespace raylex::transport {
namespace {

/// The number of values of a grid along each axis, and the box that they fill.
struct GridShape {
    std::array<int, 3> values{1, 1, 1};
    DVec3 p0, p1{1, 1, 1};

    [[nodiscard]] std::size_t count() const { return CellBox{values, 1}.count(); }
    [[nodiscard]] std::string text() const {
        return "nx x ny x nz = " + std::to_string(values[0]) + " x " + std::to_string(values[1]) + " x " +
               std::to_string(values[2]) + " = " + std::to_string(count());
    }
    /// The cells of the lattice with a border of zeros around it.
    [[nodiscard]] CellBox cells() const { return CellBox::holding({values[0] + 1, values[1] + 1, values[2] + 1}); }
};

Status read_box(const SceneMedium& entity, DVec3& p0, DVec3& p1) {
    auto a = point_or(entity.parameters, "p0", {0, 0, 0});
    if (!a) return a.error();
    auto b = point_or(entity.parameters, "p1", {1, 1, 1});
    if (!b) return b.error();
    p0 = {std::min(a->x, b->x), std::min(a->y, b->y), std::min(a->z, b->z)};
    p1 = {std::max(a->x, b->x), std::max(a->y, b->y), std::max(a->z, b->z)};
    if (!(p0.x < p1.x && p0.y < p1.y && p0.z < p1.z))
        return error_at(entity.location,
                        "medium '" + entity.name + "': the box from 'p0' to 'p1' is flat; expected one with a volume");
    return success();
}

Result<GridShape> read_shape(const SceneMedium& entity) {
    GridShape shape;
    const std::array<const char*, 3> names{"nx", "ny", "nz"};
    std::uint64_t all = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        auto n = entity.parameters.integer_or(names[a], 1);
        if (!n) return n.error();
        if (*n < 1 || *n > 1'000'000)
            return error_at(entity.parameters.find(names[a])->location,
                            std::string("'") + names[a] + "' is " + std::to_string(*n) + "; expected 1 to 1000000");
        shape.values[a] = static_cast<int>(*n);
        all *= static_cast<std::uint64_t>(*n);
    }
    const CellBox cells = shape.cells();
    if (cells.count() > budget(Budget::volume_cells))
        return over_budget(Budget::volume_cells,
                           "medium '" + entity.name + "' has " + std::to_string(all) + " voxels in " +
                               std::to_string(cells.count()) + " cells",
                           entity.location.file, entity.location.line, entity.location.column);
    if (Status s = read_box(entity, shape.p0, shape.p1); !s) return s.error();
    return shape;
}

/// The transform from render space to the cell space of a box of `size` cells whose corner p0 is at `lower` cells.
Matrix34 cells_from_render(const SceneMedium& entity, const MediumContext& context, const DVec3& p0, const DVec3& p1,
                           const DVec3& lower, const DVec3& size) {
    const DVec3 extent = p1 - p0;
    const Transform to_cells = Transform::translate(lower.x, lower.y, lower.z) *
                               Transform::scale(size.x / extent.x, size.y / extent.y, size.z / extent.z) *
                               Transform::translate(-p0.x, -p0.y, -p0.z);
    return Matrix34((to_cells * context.space->placed(entity.to_world).inverse()).matrix());
}

/// The frame of a grid as in pbrt: values are at voxel centres, and beyond the outermost ones they fall to 0 over a
/// voxel, half of which lies in the box.
CellFrame frame_of(const SceneMedium& entity, const MediumContext& context, const GridShape& shape) {
    const CellBox box = shape.cells();
    const double half = 0.5 / box.side;
    const auto cells = [&](int n) { return static_cast<double>(n) / box.side; };
    const DVec3 size{cells(shape.values[0]), cells(shape.values[1]), cells(shape.values[2])}, lower{half, half, half};
    return {cells_from_render(entity, context, shape.p0, shape.p1, lower, size), lower, lower + size, box};
}

/// The values of a grid parameter, or null if it is absent. Errors: a wrong type or number of values.
Result<const Parameter*> find_grid(const SceneMedium& entity, const char* name, ParameterType type,
                                   const GridShape& shape) {
    const Parameter* p = entity.parameters.find(name);
    if (p == nullptr) return p;
    const bool right = p->type == type || (type == ParameterType::real && p->type == ParameterType::integer);
    if (!right)
        return error_at(p->location, "medium '" + entity.name + "': '" + name + "' is of type " + type_name(p->type) +
                                         "; expected " + type_name(type) + " values, one for each voxel");
    const std::size_t values = p->numbers.size() / (type == ParameterType::rgb ? 3 : 1);
    if (values != shape.count())
        return error_at(p->location, "medium '" + entity.name + "': '" + name + "' has " + std::to_string(values) +
                                         " values; expected " + shape.text());
    return p;
}

/// Makes a lattice with a border of zeros from values in the order of files, x fastest.
VoxelGrid grid_of(const Parameter& parameter, const GridShape& shape, int channels, bool may_be_negative,
                  const SceneMedium& entity, std::vector<Error>& warnings) {
    BadValues bad;
    const CellBox voxels{shape.values, 1}, cells = shape.cells();
    std::vector<float> values(parameter.numbers.size());
    std::size_t i = 0;
    for (int z = 0; z < shape.values[2]; ++z)
        for (int y = 0; y < shape.values[1]; ++y)
            for (int x = 0; x < shape.values[0]; ++x)
                for (int c = 0; c < channels; ++c, ++i)
                    values[i] = bad.checked(static_cast<float>(parameter.numbers[i]), may_be_negative, x, y, z);
    warn_of(bad, entity, parameter.location, parameter.name, warnings);
    const auto fill = [&](int cell_x, int cell_y, int cell_z, float* to) {
        VoxelGrid::for_each_point(cells.side, cell_x, cell_y, cell_z, [&](int x, int y, int z) {
            const bool inside =
                x > 0 && y > 0 && z > 0 && x <= shape.values[0] && y <= shape.values[1] && z <= shape.values[2];
            const float* from =
                inside ? &values[voxels.index(x - 1, y - 1, z - 1) * static_cast<std::size_t>(channels)] : nullptr;
            for (int c = 0; c < channels; ++c) *to++ = inside ? from[c] : 0.0f;
        });
    };
    return VoxelGrid::build(cells, channels, fill);
}

/// A grid with one grey value everywhere, including the border.
VoxelGrid constant_grid(const GridShape& shape, float value) {
    const CellBox cells = shape.cells();
    return VoxelGrid::build(cells, 3, [&](int, int, int, float* to) { std::fill_n(to, 3 * cells.points(), value); });
}

/// Reads "Le", "Lescale" and "temperature" of a uniformgrid.
Result<std::optional<GridEmission>> read_emission(const SceneMedium& entity, const MediumContext& context,
                                                  const GridShape& shape) {
    const ColorContext& color = context.scene.color;
    auto radiance = spectrum_or(entity.parameters, "Le", Rgb(0), SpectrumRole::illuminant, color);
    if (!radiance) return radiance.error();
    auto scale = find_grid(entity, "Lescale", ParameterType::real, shape);
    if (!scale) return scale.error();
    auto temperature = find_grid(entity, "temperature", ParameterType::real, shape);
    if (!temperature) return temperature.error();
    auto parameters = read_temperature(entity.parameters);
    if (!parameters) return parameters.error();
    if (*temperature != nullptr && entity.parameters.find("Le") != nullptr)
        return error_at((*temperature)->location,
                        "medium '" + entity.name + "' has both 'Le' and 'temperature'; expected one of them");
    if (radiance->is_black() && *temperature == nullptr) return std::optional<GridEmission>();
    GridEmission emission;
    if (context.space == nullptr) return std::optional(emission);
    if (*scale != nullptr) emission.scale = grid_of(**scale, shape, 1, false, entity, context.warnings);
    if (*temperature != nullptr)
        set_temperature(emission, grid_of(**temperature, shape, 1, true, entity, context.warnings), *parameters, color);
    else emission.colour = *radiance;
    return std::optional(std::move(emission));
}

Result<Medium> make_uniform_grid(const SceneMedium& entity, const MediumContext& context) {
    auto shape = read_shape(entity);
    if (!shape) return shape.error();
    auto density = find_grid(entity, "density", ParameterType::real, *shape);
    if (!density) return density.error();
    if (*density == nullptr)
        return error_at(entity.location, "medium '" + entity.name + "' (uniformgrid) has no 'density'; expected " +
                                             shape->text() + " values");
    auto coefficients = read_coefficients(entity, context);
    if (!coefficients) return coefficients.error();
    auto emission = read_emission(entity, context, *shape);
    if (!emission) return emission.error();
    GridMediumParts parts;
    parts.sigma_a = coefficients->sigma_a;
    parts.sigma_s = coefficients->sigma_s;
    const bool emits = emission->has_value();
    if (context.space != nullptr) {
        parts.frame = frame_of(entity, context, *shape);
        parts.density = grid_of(**density, *shape, 1, false, entity, context.warnings);
        parts.emission = std::move(*emission);
    }
    return finish_grid_medium(entity, context, std::move(parts), !coefficients->sigma_s.is_black(), emits);
}

Result<Medium> make_rgb_grid(const SceneMedium& entity, const MediumContext& context) {
    auto shape = read_shape(entity);
    if (!shape) return shape.error();
    std::array<const Parameter*, 3> grids{};
    const std::array<const char*, 3> names{"sigma_a", "sigma_s", "Le"};
    for (std::size_t i = 0; i < names.size(); ++i) {
        auto found = find_grid(entity, names[i], ParameterType::rgb, *shape);
        if (!found) return found.error();
        grids[i] = *found;
    }
    const auto& [sigma_a, sigma_s, radiance] = grids;
    if (sigma_a == nullptr && sigma_s == nullptr)
        return error_at(entity.location, "medium '" + entity.name +
                                             "' (rgbgrid) has neither 'sigma_a' nor 'sigma_s'; expected one or both");
    if (radiance != nullptr && sigma_a == nullptr)
        return error_at(
            radiance->location,
            "medium '" + entity.name + "' has 'Le' without 'sigma_a': a medium that does not absorb does not emit");
    auto scale = entity.parameters.real_or("scale", 1);
    if (!scale) return scale.error();
    auto radiance_scale = entity.parameters.real_or("Lescale", 1);
    if (!radiance_scale) return radiance_scale.error();
    GridMediumParts parts;
    parts.sigma_a = parts.sigma_s = Rgb(static_cast<Real>(*scale));
    if (Status s = check_coefficients(parts.sigma_a, "scale", entity); !s) return s.error();
    const bool emits = radiance != nullptr && *radiance_scale > 0;
    if (context.space != nullptr) {
        const auto grid = [&](const Parameter* p) {
            return p != nullptr ? grid_of(*p, *shape, 3, false, entity, context.warnings) : constant_grid(*shape, 1);
        };
        parts.frame = frame_of(entity, context, *shape);
        parts.absorption = grid(sigma_a);
        parts.scattering = grid(sigma_s);
        if (emits) {
            parts.emission.emplace();
            parts.emission->radiance = grid(radiance);
            // pbrt reads these colours as spectra without dividing by their luminance.
            parts.emission->colour = Rgb(static_cast<Real>(*radiance_scale * flat_luminance()));
        }
    }
    return finish_grid_medium(entity, context, std::move(parts), true, emits);
}

Result<Medium> make_cloud(const SceneMedium& entity, const MediumContext& context) {
    DVec3 p0, p1;
    if (Status s = read_box(entity, p0, p1); !s) return s.error();
    auto coefficients = read_coefficients(entity, context);
    if (!coefficients) return coefficients.error();
    CloudDensity cloud;
    for (const auto& [name, value] :
         {std::pair{"density", &cloud.density}, {"wispiness", &cloud.wispiness}, {"frequency", &cloud.frequency}}) {
        auto number = entity.parameters.real_or(name, static_cast<double>(*value));
        if (!number) return number.error();
        if (!(*number >= 0) || !std::isfinite(*number))
            return error_at(entity.parameters.find(name)->location,
                            std::string("'") + name + "' is " + short_number(*number, 6) + "; expected 0 or more");
        *value = static_cast<Real>(*number);
    }
    GridMediumParts parts;
    parts.sigma_a = coefficients->sigma_a;
    parts.sigma_s = coefficients->sigma_s;
    if (context.space != nullptr) {
        const DVec3 extent = p1 - p0;
        const double longest = std::max({extent.x, extent.y, extent.z});
        // About eight cells per billow, with a limit on the time to evaluate them.
        const double wanted = std::clamp(std::ceil(longest * static_cast<double>(cloud.frequency) * 8), 8.0, 64.0);
        const auto cells = [&](double length) {
            return std::max(static_cast<int>(std::ceil(wanted * length / longest)), 1);
        };
        CellFrame& frame = parts.frame;
        frame.box.size = {cells(extent.x), cells(extent.y), cells(extent.z)};
        frame.upper = {static_cast<double>(frame.box.size[0]), static_cast<double>(frame.box.size[1]),
                       static_cast<double>(frame.box.size[2])};
        frame.to_cells = cells_from_render(entity, context, p0, p1, {0, 0, 0}, frame.upper);
        cloud.lower = p0.to_real();
        cloud.cell = DVec3(extent.x / frame.upper.x, extent.y / frame.upper.y, extent.z / frame.upper.z).to_real();
        parts.cloud = cloud;
    }
    return finish_grid_medium(entity, context, std::move(parts), !coefficients->sigma_s.is_black(), false);
}

}  // namespace

void warn_of(const BadValues& bad, const SceneMedium& entity, const SourceLocation& where, const std::string& grid,
             std::vector<Error>& warnings) {
    if (bad.count == 0) return;
    warnings.push_back(error_at(where, "medium '" + entity.name + "': " + std::to_string(bad.count) + " values of '" +
                                           grid + "' are negative or not finite and count as 0; the first is voxel (" +
                                           std::to_string(bad.first[0]) + ", " + std::to_string(bad.first[1]) + ", " +
                                           std::to_string(bad.first[2]) + ")"));
}

Result<TemperatureParameters> read_temperature(const ParameterSet& set) {
    auto cutoff = set.real_or("temperaturecutoff", 0);
    if (!cutoff) return cutoff.error();
    auto offset = set.real_or("temperatureoffset", *cutoff);
    if (!offset) return offset.error();
    auto scale = set.real_or("temperaturescale", 1);
    if (!scale) return scale.error();
    return TemperatureParameters{static_cast<Real>(*offset), static_cast<Real>(*scale)};
}

void set_temperature(GridEmission& emission, VoxelGrid grid, const TemperatureParameters& parameters,
                     const ColorContext& color) {
    emission.offset = parameters.offset;
    emission.kelvin = parameters.kelvin;
    double hottest = 0;
    for (std::size_t i = 0; i < grid.box().count(); ++i)
        for (const float t : {grid.bounds(i).least, grid.bounds(i).most})
            hottest =
                std::max(hottest, static_cast<double>((static_cast<Real>(t) - emission.offset) * emission.kelvin));
    emission.temperature = std::move(grid);
    emission.blackbody = BlackbodyTable(hottest, color);
}

Result<Real> read_majorant_factor(const ParameterSet& set) {
    auto factor = set.real_or("raylex:majorant", 1);
    if (!factor) return factor.error();
    if (!(*factor >= 1) || !(*factor <= 1e6))
        return error_at(set.find("raylex:majorant")->location,
                        "'raylex:majorant' is " + short_number(*factor, 6) + "; expected 1 to 1000000");
    return static_cast<Real>(*factor);
}

Result<Medium> finish_grid_medium(const SceneMedium& entity, const MediumContext& context, GridMediumParts parts,
                                  bool scatters, bool emits) {
    auto g = read_asymmetry(entity, context);
    if (!g) return g.error();
    auto factor = read_majorant_factor(entity.parameters);
    if (!factor) return factor.error();
    Medium medium;
    medium.g = *g;
    medium.scatters = scatters;
    medium.emits = emits;
    if (context.space == nullptr) return medium;
    parts.majorant_factor = *factor;
    medium.grid = std::make_shared<const GridMedium>(std::move(parts));
    medium.emits = emits && !medium.grid->brightest_emission().is_black();
    // Rays are up to 1e18 long, and their optical depths must be floats.
    constexpr Real most = 1e20f;
    if (!(medium.grid->largest_majorant() <= most))
        return error_at(entity.location,
                        "medium '" + entity.name + "': its extinction (density times coefficients) reaches " +
                            short_number(medium.grid->largest_majorant()) +
                            " per unit of length; expected at most 1e20",
                        "another unit of length, or smaller values, bring it into range");
    if (const Rgb& brightest = medium.grid->brightest_emission(); !(brightest.max() <= Real(1e30f)))
        return error_at(entity.location,
                        "medium '" + entity.name + "' emits up to " + short_number(brightest.max()) +
                            " per unit of length; expected at most 1e30, so that sums "
                            "along rays fit into floats",
                        "smaller values bring it into range");
    return medium;
}

void register_grid_media(Registry<MediumFactory>& registry) {
    using T = ParameterType;
    const std::vector<ParameterDescription> coefficients{
        {"sigma_a", T::spectrum, "1", "absorption per unit length where the density is 1"},
        {"sigma_s", T::spectrum, "1", "scattering per unit length where the density is 1"},
        {"preset", T::string, "", "a measured medium's name, instead of both; per millimetre"}};
    const std::vector<ParameterDescription> common{
        {"scale", T::real, "1", "factor on both"},
        {"g", T::real, "0", "asymmetry: -1 backward, 0 isotropic, 1 forward"},
        {"raylex:majorant", T::real, "1", "factor on majorants, from 1 up: more null collisions, the same mean"}};
    const std::vector<ParameterDescription> box{{"p0", T::point3, "0 0 0", "a corner of the grid's box"},
                                                {"p1", T::point3, "1 1 1", "the opposite corner"}};
    const std::vector<ParameterDescription> counts{{"nx", T::integer, "1", "values along x, which runs fastest"},
                                                   {"ny", T::integer, "1", "along y"},
                                                   {"nz", T::integer, "1", "along z"}};
    const std::vector<ParameterDescription> heat{
        {"temperatureoffset", T::real, "0", "subtracted from the temperatures before they are scaled"},
        {"temperaturecutoff", T::real, "0", "an older name of temperatureoffset"},
        {"temperaturescale", T::real, "1", "factor from temperatures to kelvin"}};
    const auto all = [](std::initializer_list<std::vector<ParameterDescription>> lists) {
        std::vector<ParameterDescription> result;
        for (const auto& list : lists) result.insert(result.end(), list.begin(), list.end());
        return result;
    };
    registry.add({"uniformgrid", "densities on a grid, linearly interpolated, that scale coefficients",
                  all({{{"density", T::real, "", "one for each voxel"},
                        {"Le", T::spectrum, "0", "radiance; emission is density sigma_a Le Lescale"},
                        {"Lescale", T::real, "1", "factors on the emission, one for each voxel"},
                        {"temperature", T::real, "", "one for each voxel: blackbodies above 100 K, instead of Le"}},
                       coefficients,
                       heat,
                       counts,
                       box,
                       common}),
                  make_uniform_grid});
    registry.add({"rgbgrid", "coefficients on a grid, separate for each colour",
                  all({{{"sigma_a", T::rgb, "1", "absorption, one colour for each voxel"},
                        {"sigma_s", T::rgb, "1", "scattering, one colour for each voxel"},
                        {"Le", T::rgb, "", "radiance, one colour for each voxel, times 106.86 as in pbrt"},
                        {"Lescale", T::real, "1", "factor on Le"}},
                       counts,
                       box,
                       common}),
                  make_rgb_grid});
    registry.add({"cloud", "clouds made of noise",
                  all({{{"density", T::real, "1", "factor on the density"},
                        {"wispiness", T::real, "1", "strength of the noise that moves the edges"},
                        {"frequency", T::real, "5", "billows per unit of length"}},
                       coefficients,
                       box,
                       common}),
                  make_cloud});
    register_nanovdb_medium(registry);
}

}  // namespace raylex::transport
