#include "geoaovs/geoaovs.h"

#include <array>
#include <limits>

#include "display/services/parameters.h"

namespace raylex::geoaovs {
namespace {

using display::ChannelDefinition;
using display::ChannelId;
using display::ChannelStyle;
using display::ChannelType;
using display::DisplayServices;
using display::FilterRule;

constexpr float infinity = std::numeric_limits<float>::infinity();

Rgb triple(const std::vector<float> (&values)[3], std::size_t hit) {
    return {values[0][hit], values[1][hit], values[2][hit]};
}

float camera_row_product(const ShadingBatch& hits, int axis, const Rgb& v) {
    const float* m = hits.world_to_camera[axis];
    return m[0] * v.r + m[1] * v.g + m[2] * v.b;
}

/// The transform is rigid, so normals turn like vectors.
Rgb camera_vector(const ShadingBatch& hits, const Rgb& v) {
    return {camera_row_product(hits, 0, v), camera_row_product(hits, 1, v), camera_row_product(hits, 2, v)};
}

Rgb camera_point(const ShadingBatch& hits, const Rgb& v) {
    return camera_vector(hits, v) +
           Rgb(hits.world_to_camera[0][3], hits.world_to_camera[1][3], hits.world_to_camera[2][3]);
}

using Value = float (*)(const ShadingBatch&, std::size_t hit);
using Triple = Rgb (*)(const ShadingBatch&, std::size_t hit);
using Index = std::int32_t (*)(const ShadingBatch&, std::size_t hit);

/// Writes one AOV for a whole batch; `function` is inlined into the loop.
template <auto function>
void write_all(const ShadingBatch& hits, ChannelId id, DisplayServices& services) {
    for (std::size_t hit = 0; hit < static_cast<std::size_t>(hits.count); ++hit)
        services.write(id, hits.row[hit], function(hits, hit));
}

constexpr Triple shading_normal = [](const ShadingBatch& h, std::size_t i) {
    return camera_vector(h, triple(h.shading_normal, i));
};
constexpr Triple geometric_normal = [](const ShadingBatch& h, std::size_t i) {
    return camera_vector(h, triple(h.geometric_normal, i));
};
constexpr Triple position = [](const ShadingBatch& h, std::size_t i) { return camera_point(h, triple(h.position, i)); };
constexpr Triple world_position = [](const ShadingBatch& h, std::size_t i) { return triple(h.position, i); };
constexpr Value axial_depth = [](const ShadingBatch& h, std::size_t i) {
    return camera_row_product(h, 2, triple(h.position, i)) + h.world_to_camera[2][3];
};
constexpr Value ray_length = [](const ShadingBatch& h, std::size_t i) { return h.distance[i]; };
constexpr Triple texture_coordinates = [](const ShadingBatch& h, std::size_t i) { return Rgb(h.s[i], h.t[i], 0.0f); };
constexpr Index object_id = [](const ShadingBatch& h, std::size_t i) { return h.object_id[i]; };
constexpr Triple albedo = [](const ShadingBatch& h, std::size_t i) { return triple(h.albedo, i); };

struct Aov {
    const char* name;
    ChannelType type;
    const char* space;
    FilterRule rule;
    float miss_value;
    bool needs_albedo;
    void (*write)(const ShadingBatch&, ChannelId, DisplayServices&);
};

// The only place that knows what an AOV is.
constexpr std::array aovs{
    Aov{"Nn", ChannelType::normal, "camera", FilterRule::filter, 0, false, write_all<shading_normal>},
    Aov{"Ngn", ChannelType::normal, "camera", FilterRule::filter, 0, false, write_all<geometric_normal>},
    Aov{"P", ChannelType::point, "camera", FilterRule::filter, 0, false, write_all<position>},
    Aov{"Pw", ChannelType::point, "world", FilterRule::filter, 0, false, write_all<world_position>},
    Aov{"z", ChannelType::real, "camera", FilterRule::zmin, infinity, false, write_all<axial_depth>},
    Aov{"VLen", ChannelType::real, "world", FilterRule::zmin, infinity, false, write_all<ray_length>},
    Aov{"st", ChannelType::vector, "texture", FilterRule::filter, 0, false, write_all<texture_coordinates>},
    Aov{"id", ChannelType::integer, "", FilterRule::zmin, 0, false, write_all<object_id>},
    Aov{"albedo", ChannelType::rgb, "rendering colour space", FilterRule::filter, 0, true, write_all<albedo>},
};

}  // namespace

void ShadingBatch::resize(int hits) {
    count = hits;
    const auto size = static_cast<std::size_t>(hits);
    row.resize(size);
    for (int axis = 0; axis < 3; ++axis) {
        position[axis].resize(size);
        shading_normal[axis].resize(size);
        geometric_normal[axis].resize(size);
        albedo[axis].resize(size);
    }
    s.resize(size);
    t.resize(size);
    distance.resize(size);
    object_id.resize(size);
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
        definition.style = ChannelStyle::name;
        definition.type = aov.type;
        definition.space = aov.space;
        definition.rule = aov.rule;
        definition.miss_value = aov.miss_value;
        return definition;
    }
    std::string known;
    for (const std::string& each : channel_names()) known += (known.empty() ? "" : ", ") + each;
    const std::string near = nearest_name(name, channel_names());
    return error_at({}, "unknown geometric AOV '" + std::string(name) + "'; expected one of: " + known,
                    near.empty() ? std::string() : "did you mean '" + near + "'?");
}

GeometricAovs::GeometricAovs(std::span<const ChannelDefinition> channels) {
    for (std::size_t id = 0; id < channels.size(); ++id) {
        if (channels[id].style != ChannelStyle::name) continue;
        for (std::size_t aov = 0; aov < aovs.size(); ++aov)
            if (channels[id].name == aovs[aov].name && channels[id].type == aovs[aov].type)
                requests_.push_back({aov, static_cast<ChannelId>(id)});
    }
}

bool GeometricAovs::wants_albedo() const {
    for (const Request& request : requests_)
        if (aovs[request.aov].needs_albedo) return true;
    return false;
}

void GeometricAovs::write(const ShadingBatch& hits, DisplayServices& services) const {
    if (requests_.empty()) return;
    for (std::size_t hit = 0; hit < static_cast<std::size_t>(hits.count); ++hit)
        services.write_distance(hits.row[hit], hits.distance[hit]);
    for (const Request& request : requests_) aovs[request.aov].write(hits, request.id, services);
}

}  // namespace raylex::geoaovs
