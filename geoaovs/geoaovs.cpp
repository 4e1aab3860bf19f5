#include "geoaovs/geoaovs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "display/services/parameters.h"
#include "geoaovs/shading_values.h"

namespace raylex::geoaovs {
namespace {

using display::ChannelDefinition;
using display::ChannelId;
using display::ChannelStyle;
using display::ChannelType;
using display::DisplayServices;
using display::FilterRule;
using display::SampleTable;

constexpr float infinity = std::numeric_limits<float>::infinity();

using WriteHits = void (*)(const ShadingBatch&, ChannelId, DisplayServices&);
using WriteRays = void (*)(const RayBatch&, const SampleTable&, ChannelId, DisplayServices&);
using WriteSamples = void (*)(const SampleTable&, double seconds, ChannelId, DisplayServices&);

std::span<const std::int32_t> rows_of(const ShadingBatch& batch) {
    return {batch.row.data(), static_cast<std::size_t>(batch.count)};
}

/// Writes one or three columns of the batch unchanged.
template <auto column>
void as_it_is(const ShadingBatch& batch, ChannelId id, DisplayServices& services) {
    const auto& values = batch.*column;
    const auto rows = rows_of(batch);
    if constexpr (requires { values.data(); }) services.write(id, rows, std::span(values.data(), rows.size()));
    else services.write(id, rows, DisplayServices::Columns{values[0].data(), values[1].data(), values[2].data()});
}

/// Writes three columns transformed to camera space; `moved`: as points, not as vectors. The transform is rigid, so
/// normals transform like vectors.
template <auto columns, bool moved = false>
void in_camera_space(const ShadingBatch& batch, ChannelId id, DisplayServices& services) {
    constexpr std::size_t chunk = 64;
    std::array<std::array<float, chunk>, 3> values;
    const auto rows = rows_of(batch);
    for (std::size_t first = 0; first < rows.size(); first += chunk) {
        const std::size_t n = std::min(chunk, rows.size() - first);
        const float *const x = (batch.*columns)[0].data() + first, *const y = (batch.*columns)[1].data() + first,
                           *const z = (batch.*columns)[2].data() + first;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float* const m = batch.world_to_camera[axis];
            const float a = m[0], b = m[1], c = m[2], d = m[3];
            float* __restrict to = values[axis].data();
            for (std::size_t i = 0; i < n; ++i) {
                const float turned = a * x[i] + b * y[i] + c * z[i];
                to[i] = moved ? turned + d : turned;
            }
        }
        services.write(id, rows.subspan(first, n),
                       DisplayServices::Columns{values[0].data(), values[1].data(), values[2].data()});
    }
}

/// Writes one AOV for a whole batch of hits; `function` is inlined into the loop. A chunk fits in the first-level
/// cache.
template <auto function>
void hits(const ShadingBatch& batch, ChannelId id, DisplayServices& services) {
    using Value = decltype(function(batch, std::size_t{0}));
    constexpr std::size_t chunk = 64;
    std::array<Value, chunk> values;
    const auto count = static_cast<std::size_t>(batch.count);
    for (std::size_t first = 0; first < count; first += chunk) {
        const std::size_t n = std::min(chunk, count - first);
        for (std::size_t i = 0; i < n; ++i) values[i] = function(batch, first + i);
        services.write(id, std::span<const std::int32_t>(batch.row.data() + first, n),
                       std::span<const Value>(values.data(), n));
    }
}

/// Writes a depth for every camera ray with a hit, and for every extra row that is not completely transparent: (origin,
/// direction, distance) -> value.
template <auto function>
void depths(const RayBatch& rays, const SampleTable& table, ChannelId id, DisplayServices& services) {
    constexpr std::size_t chunk = 64;
    std::array<std::int32_t, chunk> to;
    std::array<float, chunk> values;
    std::size_t n = 0;
    int row = 0;
    // Chunks in which all camera rays have a hit are written as a whole; the other rows one by one.
    const float *const origins = rays.origin_z.data(), *const directions = rays.direction_z.data(),
                       *const distances = table.depth.data();
    for (; row + static_cast<int>(chunk) <= table.camera_row_count(); row += static_cast<int>(chunk)) {
        const auto first = static_cast<std::size_t>(row);
        float* __restrict out = values.data();
        std::int32_t* __restrict out_rows = to.data();
        int missed = 0;
        for (std::size_t i = 0; i < chunk; ++i) {
            missed += std::abs(distances[first + i]) <= std::numeric_limits<float>::max() ? 0 : 1;
            out[i] = function(origins[first + i], directions[first + i], distances[first + i]);
            out_rows[i] = row + static_cast<std::int32_t>(i);
        }
        if (missed != 0) break;
        services.write(id, std::span<const std::int32_t>(to), std::span<const float>(values));
    }
    const auto flush = [&] {
        services.write(id, std::span<const std::int32_t>(to.data(), n), std::span<const float>(values.data(), n));
        n = 0;
    };
    for (; row < table.row_count(); ++row) {
        const auto i = static_cast<std::size_t>(row), camera = static_cast<std::size_t>(table.original(row));
        if (!std::isfinite(table.depth[i])) continue;
        if (row >= table.camera_row_count() && table.opacity[i].is_black()) continue;
        to[n] = row;
        values[n++] = function(rays.origin_z[camera], rays.direction_z[camera], table.depth[i]);
        if (n == chunk) flush();
    }
    flush();
}

constexpr auto axial_depth = [](float origin_z, float direction_z, float d) { return origin_z + d * direction_z; };
constexpr auto radial_depth = [](float, float, float distance) { return distance; };

/// Splats one value per camera ray. Splats of a sample's rows add up, so rows behind a cutout do not count twice.
template <auto function>
void samples(const SampleTable& table, double seconds, ChannelId id, DisplayServices& services) {
    for (int row = 0; row < table.camera_row_count(); ++row) services.splat(id, row, function(table, row, seconds));
}

constexpr auto shutter_time = [](const SampleTable& table, int row, double) {
    return table.camera_row(row).shutter_time;
};
/// The count as a float: exact up to 2^24 per sample, and added exactly.
constexpr auto invalid_values = [](const SampleTable& table, int row, double) {
    return static_cast<float>(table.invalid_count(row));
};
constexpr auto one = [](const SampleTable&, int, double) { return 1.0f; };
constexpr auto cpu_time = [](const SampleTable& table, int, double seconds) {
    return static_cast<float>(seconds / table.camera_row_count());
};

/// The opacity of each sample over its rows, per colour: 1 - (1 - o_1)(1 - o_2)...
std::vector<RgbD> sample_opacities(const SampleTable& table) {
    std::vector<RgbD> through(static_cast<std::size_t>(table.camera_row_count()), RgbD(1.0));
    for (int row = 0; row < table.row_count(); ++row)
        through[static_cast<std::size_t>(table.original(row))] *=
            RgbD(1.0) - table.opacity[static_cast<std::size_t>(row)];
    for (RgbD& each : through) each = RgbD(1.0) - each;
    return through;
}

void opacity(const SampleTable& table, double, ChannelId id, DisplayServices& services) {
    const std::vector<RgbD> opacities = sample_opacities(table);
    for (int row = 0; row < table.camera_row_count(); ++row)
        services.splat(id, row, Rgb(opacities[static_cast<std::size_t>(row)]));
}

void alpha(const SampleTable& table, double, ChannelId id, DisplayServices& services) {
    const std::vector<RgbD> opacities = sample_opacities(table);
    for (int row = 0; row < table.camera_row_count(); ++row)
        services.splat(id, row, static_cast<float>(opacities[static_cast<std::size_t>(row)].average()));
}

/// The source of an AOV's values: exactly one of the functions, or an expression.
struct Source {
    WriteHits hits = nullptr;
    Inputs inputs = 0;  // columns that `hits` uses
    WriteRays rays = nullptr;
    WriteSamples samples = nullptr;
    bool timed = false;
    const char* expression = nullptr;
};
constexpr Source from_hits(WriteHits write, Inputs read) {
    return {write, read, nullptr, nullptr, false, nullptr};
}
constexpr Source from_rays(WriteRays write) {
    return {nullptr, 0, write, nullptr, false, nullptr};
}
constexpr Source from_samples(WriteSamples write, bool timed = false) {
    return {nullptr, 0, nullptr, write, timed, nullptr};
}
constexpr Source from_expression(const char* expression) {
    return {nullptr, 0, nullptr, nullptr, false, expression};
}

struct Aov {
    const char* name;
    ChannelType type;
    const char* space;
    FilterRule rule;
    float miss_value;
    Source source;
    int length_power = 0;  ///< 1: a length in the scene's unit, -1: an inverse length
};

using T = ChannelType;
using R = FilterRule;
namespace in = inputs;

// The only definition of the AOVs.
constexpr std::array aovs{
    Aov{"P", T::point, "camera", R::filter, 0, from_hits(in_camera_space<&ShadingBatch::position, true>, in::position),
        1},
    Aov{"Po", T::point, "object", R::filter, 0,
        from_hits(as_it_is<&ShadingBatch::object_position>, in::object_position), 1},
    Aov{"Pw", T::point, "world", R::filter, 0, from_hits(hits<values::world_position>, in::position), 1},
    Aov{"Nn", T::normal, "camera", R::filter, 0,
        from_hits(in_camera_space<&ShadingBatch::shading_normal>, in::shading_normal)},
    Aov{"Ngn", T::normal, "camera", R::filter, 0,
        from_hits(in_camera_space<&ShadingBatch::geometric_normal>, in::geometric_normal)},
    Aov{"Non", T::normal, "camera", R::filter, 0,
        from_hits(in_camera_space<&ShadingBatch::plain_normal>, in::plain_normal)},
    Aov{"Tn", T::vector, "camera", R::filter, 0, from_hits(hits<values::tangent>, in::dpdu)},
    Aov{"Vn", T::vector, "camera", R::filter, 0, from_hits(in_camera_space<&ShadingBatch::view>, in::view)},
    Aov{"VLen", T::real, "world", R::zmin, infinity, from_rays(depths<radial_depth>), 1},
    Aov{"z", T::real, "camera", R::zmin, infinity, from_rays(depths<axial_depth>), 1},
    Aov{"zback", T::real, "camera", R::zmin, infinity, from_rays(depths<axial_depth>), 1},
    Aov{"zfiltered", T::real, "camera", R::filter, 0, from_rays(depths<axial_depth>), 1},
    Aov{"u", T::real, "parameter", R::filter, 0, from_hits(as_it_is<&ShadingBatch::u>, in::parameters)},
    Aov{"v", T::real, "parameter", R::filter, 0, from_hits(as_it_is<&ShadingBatch::v>, in::parameters)},
    Aov{"st", T::vector, "texture", R::filter, 0, from_hits(hits<values::st>, in::texture)},
    Aov{"dPdu", T::vector, "camera", R::filter, 0, from_hits(in_camera_space<&ShadingBatch::dpdu>, in::dpdu), 1},
    Aov{"dPdv", T::vector, "camera", R::filter, 0, from_hits(in_camera_space<&ShadingBatch::dpdv>, in::dpdv), 1},
    Aov{"curvature", T::real, "world", R::filter, 0, from_hits(as_it_is<&ShadingBatch::curvature>, in::curvature), -1},
    Aov{"outsideIOR", T::real, "", R::filter, 0, from_hits(as_it_is<&ShadingBatch::outside_ior>, in::outside_ior)},
    Aov{"incidenceAngle", T::real, "radians", R::filter, 0,
        from_hits(hits<values::incidence_angle>, in::shading_normal | in::view)},
    Aov{"time", T::real, "shutter", R::filter, 0, from_samples(samples<shutter_time>)},
    Aov{"id", T::integer, "", R::zmin, 0, from_hits(as_it_is<&ShadingBatch::object_id>, in::ids)},
    Aov{"id2", T::integer, "", R::zmin, 0, from_hits(as_it_is<&ShadingBatch::part_id>, in::ids)},
    Aov{"rawId", T::integer, "", R::zmin, 0, from_hits(as_it_is<&ShadingBatch::surface_id>, in::ids)},
    Aov{"a", T::real, "", R::filter, 0, from_samples(alpha)},
    Aov{"Ci", T::rgb, "rendering colour space", R::filter, 0, from_expression("C.*")},
    Aov{"Oi", T::rgb, "opacity", R::filter, 0, from_samples(opacity)},
    Aov{"cpuTime", T::real, "seconds", R::sum, 0, from_samples(samples<cpu_time>, true)},
    Aov{"sampleCount", T::real, "", R::sum, 0, from_samples(samples<one>)},
    Aov{"invalidSamples", T::real, "", R::sum, 0, from_samples(samples<invalid_values>)},
    Aov{"__Pworld", T::point, "world", R::filter, 0, from_hits(hits<values::world_position>, in::position), 1},
    Aov{"__Nworld", T::normal, "world", R::filter, 0,
        from_hits(as_it_is<&ShadingBatch::shading_normal>, in::shading_normal)},
    Aov{"__Vworld", T::vector, "world", R::filter, 0, from_hits(as_it_is<&ShadingBatch::view>, in::view)},
    Aov{"__st", T::vector, "texture", R::filter, 0, from_hits(hits<values::st>, in::texture)},
    Aov{"__depth", T::vector, "camera depth, world height, cosine", R::filter, 0,
        from_hits(hits<values::depth_height_facing>, in::position | in::shading_normal | in::view), 1},
    Aov{"albedo", T::rgb, "rendering colour space", R::filter, 0,
        from_hits(as_it_is<&ShadingBatch::albedo>, in::albedo)},
    Aov{"wireframe", T::real, "", R::filter, 0, from_hits(hits<values::wireframe>, in::edges)},
};

constexpr std::array motion_names{"dPdtime", "dPcameradtime", "motionFore", "motionBack", "motionvector"};

Error unknown_name(std::string_view name) {
    if (std::find(motion_names.begin(), motion_names.end(), name) != motion_names.end())
        return error_at({}, "the geometric AOV '" + std::string(name) +
                                "' describes motion during the exposure, which raylex does not compute yet; "
                                "expected an AOV of the still scene, such as P or z");
    std::string known;
    for (const std::string& each : channel_names()) known += (known.empty() ? "" : ", ") + each;
    return error_at({}, "unknown geometric AOV '" + std::string(name) + "'; expected one of: " + known,
                    near_miss(name, channel_names()));
}

}  // namespace

void ShadingBatch::resize(int new_count, Inputs wanted) {
    count = new_count;
    const auto size = static_cast<std::size_t>(new_count);
    const auto grow = [size](auto& column) {  // never shrinks, because batches are filled many times
        if (column.size() < size) column.resize(size);
    };
    const auto grow_three = [&grow](auto(&columns)[3]) {
        for (auto& column : columns) grow(column);
    };
    grow(row);
    if (wanted & inputs::position) grow_three(position);
    if (wanted & inputs::shading_normal) grow_three(shading_normal);
    if (wanted & inputs::geometric_normal) grow_three(geometric_normal);
    if (wanted & inputs::plain_normal) grow_three(plain_normal);
    if (wanted & inputs::view) grow_three(view);
    if (wanted & inputs::texture) grow(s), grow(t);
    if (wanted & inputs::parameters) grow(u), grow(v);
    if (wanted & inputs::dpdu) grow_three(dpdu);
    if (wanted & inputs::dpdv) grow_three(dpdv);
    if (wanted & inputs::object_position) grow_three(object_position);
    if (wanted & inputs::curvature) grow(curvature);
    if (wanted & inputs::outside_ior) grow(outside_ior);
    if (wanted & inputs::ids) grow(object_id), grow(part_id), grow(surface_id);
    if (wanted & inputs::edges) grow(edge_pixels);
    if (wanted & inputs::albedo) grow_three(albedo);
}

std::vector<std::string> channel_names() {
    std::vector<std::string> names;
    for (const Aov& aov : aovs) names.emplace_back(aov.name);
    return names;
}

Result<ChannelDefinition> channel_definition(std::string_view name) {
    for (const Aov& aov : aovs) {
        if (name != aov.name) continue;
        ChannelDefinition definition;
        definition.name = aov.name;
        definition.style = aov.source.expression ? ChannelStyle::expression : ChannelStyle::name;
        if (aov.source.expression) definition.expression = aov.source.expression;
        definition.type = aov.type;
        definition.space = aov.space;
        definition.rule = aov.rule;
        definition.miss_value = aov.miss_value;
        return definition;
    }
    return unknown_name(name);
}

int length_power(const ChannelDefinition& channel) {
    for (const Aov& aov : aovs)
        if (channel.name == aov.name && channel.type == aov.type) return aov.length_power;
    return 0;
}

GeometricAovs::GeometricAovs(std::span<const ChannelDefinition> channels) {
    for (std::size_t i = 0; i < channels.size(); ++i) {
        if (channels[i].style != ChannelStyle::name || !takes_samples(channels[i])) continue;
        for (std::size_t row = 0; row < aovs.size(); ++row) {
            const Aov& aov = aovs[row];
            if (channels[i].name != aov.name || channels[i].type != aov.type) continue;
            const Request request{row, static_cast<ChannelId>(i)};
            if (aov.source.hits) hits_.push_back(request);
            if (aov.source.rays) rays_.push_back(request);
            if (aov.source.samples) samples_.push_back(request);
            inputs_ |= aov.source.inputs;
            wants_time_ = wants_time_ || aov.source.timed;
        }
    }
}

void GeometricAovs::write(const ShadingBatch& batch, DisplayServices& services) const {
    for (const Request& request : hits_) aovs[request.aov].source.hits(batch, request.id, services);
}

void GeometricAovs::write_rays(const RayBatch& rays, SampleTable& table, DisplayServices& services) const {
    for (const Request& request : rays_) aovs[request.aov].source.rays(rays, table, request.id, services);
}

void GeometricAovs::write_samples(double seconds, SampleTable& table, DisplayServices& services) const {
    for (const Request& request : samples_) aovs[request.aov].source.samples(table, seconds, request.id, services);
}

}  // namespace raylex::geoaovs
