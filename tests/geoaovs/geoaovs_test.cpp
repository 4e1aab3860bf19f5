#include "geoaovs/geoaovs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"

namespace raylex::geoaovs {
namespace {

using display::ChannelDefinition;
using display::ChannelId;
using display::ChannelType;
using display::FilterRule;
using display::FrameBuffer;
using display::SampleTable;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<ChannelDefinition> all_channels() {
    std::vector<ChannelDefinition> channels;
    for (const std::string& name : channel_names()) channels.push_back(*channel_definition(name));
    return channels;
}

ChannelId id_of(const std::vector<ChannelDefinition>& channels, const std::string& name) {
    const auto at = std::find_if(channels.begin(), channels.end(), [&](const auto& c) { return c.name == name; });
    REQUIRE(at != channels.end());
    return static_cast<ChannelId>(at - channels.begin());
}

void set(std::vector<float> (&to)[3], std::size_t hit, float x, float y, float z) {
    to[0][hit] = x;
    to[1][hit] = y;
    to[2][hit] = z;
}

/// A camera at (10, 20, 30) that looks along world +x, with right along world -y and up along world +z. The rows of the
/// matrix are the camera's axes in world space; the last column is minus their products with its position.
constexpr float camera_matrix[3][4] = {{0, -1, 0, 20}, {0, 0, 1, -30}, {1, 0, 0, -10}};

ShadingBatch one_hit() {
    ShadingBatch hits;
    hits.resize(1);
    for (int r = 0; r < 3; ++r) std::copy_n(camera_matrix[r], 4, hits.world_to_camera[r]);
    hits.row[0] = 1;
    set(hits.position, 0, 14, 20, 33);      // 4 ahead, 3 up
    set(hits.shading_normal, 0, -1, 0, 0);  // towards the camera
    set(hits.geometric_normal, 0, 0, 0.6f, 0.8f);
    set(hits.plain_normal, 0, 0, 0, 1);
    set(hits.view, 0, -0.8f, 0, -0.6f);
    set(hits.object_position, 0, 7, 8, 9);
    set(hits.dpdu, 0, 0, 2, 0);
    set(hits.dpdv, 0, 0, 0, 3);
    hits.s[0] = 0.25f;
    hits.t[0] = 0.75f;
    hits.u[0] = 0.125f;
    hits.v[0] = 0.5f;
    hits.curvature[0] = -2;
    hits.outside_ior[0] = 1.5f;
    hits.object_id[0] = 42;
    hits.part_id[0] = 3;
    hits.surface_id[0] = 99;
    hits.edge_pixels[0] = 0.25f;
    set(hits.albedo, 0, 0.1f, 0.2f, 0.3f);
    return hits;
}

/// Rays of `count` rows through the hit of one_hit(): 4 / 5 of every unit of distance is along the camera's axis.
RayBatch rays_to_hit(std::size_t count) {
    RayBatch rays;
    rays.origin_z.assign(count, 0.0f);
    rays.direction_z.assign(count, 0.8f);
    return rays;
}

TEST_CASE("every AOV has its value in its space", "[geoaovs]") {
    const std::vector<ChannelDefinition> channels = all_channels();
    SampleTable table(channels, 4);
    std::vector<display::CameraRow> rows(2);
    rows[1].shutter_time = 0.75f;
    table.begin(rows);
    display::DisplayServices services(table);
    const GeometricAovs aovs(channels);
    CHECK(aovs.inputs() == inputs::all);
    CHECK(aovs.wants_time());
    aovs.write(one_hit(), services);
    services.write_distance(1, 5);
    services.write_opacity(1, Rgb(1, 0.5f, 0));
    aovs.write_rays(rays_to_hit(2), table, services);
    aovs.write_samples(0.5, table, services);
    const auto f = [](float v) { return static_cast<double>(v); };
    const std::map<std::string, std::vector<double>> expected{{"P", {0, 3, 4}},
                                                              {"Po", {7, 8, 9}},
                                                              {"Pw", {14, 20, 33}},
                                                              {"Nn", {0, 0, -1}},
                                                              {"Ngn", {f(-0.6f), f(0.8f), 0}},
                                                              {"Non", {0, 1, 0}},
                                                              {"Tn", {-1, 0, 0}},
                                                              {"Vn", {0, f(-0.6f), f(-0.8f)}},
                                                              {"VLen", {5}},  // radial: 3-4-5
                                                              {"z", {4}},     // along the axis
                                                              {"zback", {4}},
                                                              {"zfiltered", {4}},
                                                              {"u", {0.125}},
                                                              {"v", {0.5}},
                                                              {"st", {0.25, 0.75, 0}},
                                                              {"dPdu", {-2, 0, 0}},
                                                              {"dPdv", {0, 3, 0}},
                                                              {"curvature", {-2}},
                                                              {"outsideIOR", {1.5}},
                                                              {"incidenceAngle", {std::atan2(0.6, 0.8)}},
                                                              {"time", {0.75}},
                                                              {"id", {42}},
                                                              {"id2", {3}},
                                                              {"rawId", {99}},
                                                              {"a", {0.5}},
                                                              {"Ci", {0, 0, 0}},  // light, of which there is none
                                                              {"Oi", {1, 0.5, 0}},
                                                              {"cpuTime", {0.25}},
                                                              {"sampleCount", {1}},
                                                              {"invalidSamples", {0}},
                                                              {"__Pworld", {14, 20, 33}},
                                                              {"__Nworld", {-1, 0, 0}},
                                                              {"__Vworld", {f(-0.8f), 0, f(-0.6f)}},
                                                              {"__st", {0.25, 0.75, 0}},
                                                              {"__depth", {4, 20, f(0.8f)}},
                                                              {"albedo", {f(0.1f), f(0.2f), f(0.3f)}},
                                                              {"wireframe", {1}}};
    CHECK(expected.size() == channels.size());
    for (std::size_t i = 0; i < channels.size(); ++i) {
        CAPTURE(channels[i].name);
        const auto n = static_cast<std::size_t>(component_count(channels[i].type));
        const double* values = table.values(static_cast<ChannelId>(i)) + n;  // row 1
        REQUIRE(expected.count(channels[i].name) == 1);
        const std::vector<double>& wanted = expected.at(channels[i].name);
        REQUIRE(wanted.size() == n);
        // Sums and products of floats of size 5 that are not powers of two: a few ulps.
        for (std::size_t c = 0; c < n; ++c) CHECK(values[c] == Approx(wanted[c]).margin(1e-6));
    }
    CHECK(std::all_of(services.refusals().begin(), services.refusals().end(), [](auto& n) { return n.total() == 0; }));
}

TEST_CASE("a pixel that misses is infinitely far and 0 otherwise", "[geoaovs]") {
    const std::vector<ChannelDefinition> channels = all_channels();
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 4);
    table.begin(std::vector<display::CameraRow>(4));
    display::DisplayServices services(table);
    const GeometricAovs aovs(channels);
    aovs.write_rays(rays_to_hit(4), table, services);
    aovs.write_samples(0, table, services);
    buffer.accumulate(table);
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const std::string& name = channels[i].name;
        CAPTURE(name);
        const double expected = name == "z" || name == "zback" || name == "VLen" ? infinity
                                : name == "sampleCount"                          ? 4
                                                                                 : 0;
        for (const double v : buffer.resolve(static_cast<ChannelId>(i))) CHECK(v == expected);
    }
}

TEST_CASE("at an edge depth and id are those of the nearest sample, normals fade with coverage", "[geoaovs]") {
    const std::vector<ChannelDefinition> channels = all_channels();
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 4);
    std::vector<display::CameraRow> rows(4);
    for (std::size_t i = 0; i < 4; ++i) rows[i].sample = i;
    table.begin(rows);
    display::DisplayServices services(table);
    const GeometricAovs aovs(channels);
    ShadingBatch hits = one_hit();
    aovs.write(hits, services);  // row 1: 5 away
    hits.row[0] = 2;             // row 2: nearer, another object; rows 0 and 3 miss
    hits.object_id[0] = 7;
    aovs.write(hits, services);
    for (const int row : {1, 2}) {
        services.write_distance(row, row == 1 ? 5.0f : 2.5f);
        services.write_opacity(row, Rgb(1));
    }
    aovs.write_rays(rays_to_hit(4), table, services);
    aovs.write_samples(2, table, services);
    buffer.accumulate(table);
    const auto value = [&](const char* name) { return buffer.resolve(id_of(channels, name)); };
    CHECK(value("z")[0] == 2);
    CHECK(value("zback")[0] == 2);
    CHECK(value("VLen")[0] == 2.5);
    CHECK(value("id")[0] == 7);
    CHECK(value("Nn")[2] == -0.5);
    CHECK(value("zfiltered")[0] == 1.5);  // 4 and 2 over four samples: the mean depth times the alpha
    CHECK(value("a")[0] == 0.5);
    CHECK(value("a") == buffer.resolve_alpha());
    CHECK(value("Oi") == std::vector<double>{0.5, 0.5, 0.5});
    CHECK(value("sampleCount")[0] == 4);
    CHECK(value("cpuTime")[0] == 2);
}

TEST_CASE("depth follows WriteDistance, and ignores rows that are completely transparent", "[geoaovs]") {
    const std::vector<ChannelDefinition> channels{*channel_definition("z"), *channel_definition("a"),
                                                  *channel_definition("zfiltered"), *channel_definition("time")};
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 1);
    std::vector<display::CameraRow> rows(1);
    rows[0].shutter_time = 0.5f;
    table.begin(rows);
    display::DisplayServices services(table);
    const GeometricAovs aovs(channels);
    CHECK(aovs.inputs() == 0);                       // these need no shaded hits
    services.add_sample(0, {5, RgbD(0.0), false});   // a cutout, passed
    services.add_sample(0, {10, RgbD(0.25), true});  // haze
    services.write_distance(0, 20, true);
    services.write_opacity(0, Rgb(1));
    aovs.write_rays(rays_to_hit(1), table, services);
    aovs.write_samples(0, table, services);
    buffer.accumulate(table);
    const double nearest = static_cast<double>(10 * 0.8f), farther = static_cast<double>(20 * 0.8f);
    CHECK(buffer.resolve(0)[0] == nearest);
    CHECK(buffer.resolve(1)[0] == 1);
    CHECK(buffer.resolve(2)[0] == Approx(0.25 * nearest + 0.75 * farther));
    CHECK(buffer.resolve(3)[0] == 0.5);  // one per sample, whatever it passed
}

TEST_CASE("definitions have type, space and rule; errors for unknown names list the known ones", "[geoaovs][law7]") {
    const ChannelDefinition normal = *channel_definition("Nn");
    CHECK(normal.type == ChannelType::normal);
    CHECK(normal.space == "camera");
    CHECK(normal.rule == FilterRule::filter);
    CHECK(channel_definition("Pw")->space == "world");
    CHECK(channel_definition("id")->type == ChannelType::integer);
    CHECK(channel_definition("id")->rule == FilterRule::zmin);
    const auto missing = channel_definition("NN");
    REQUIRE_FALSE(missing);
    CHECK(missing.error().hint == "did you mean 'Nn'?");
    CHECK(missing.error().message.find("VLen") != std::string::npos);
    CHECK(channel_definition("incidence_angle").error().hint == "did you mean 'incidenceAngle'?");
    for (const char* name : {"id", "id2", "rawId", "z", "zback"})
        CHECK(channel_definition(name)->rule == FilterRule::zmin);
    for (const char* name : {"cpuTime", "sampleCount"}) CHECK(channel_definition(name)->rule == FilterRule::sum);
}

TEST_CASE("names of motion AOVs are refused with the reason", "[geoaovs][law7]") {
    for (const char* name : {"dPdtime", "dPcameradtime", "motionFore", "motionBack"}) {
        const auto refused = channel_definition(name);
        REQUIRE_FALSE(refused);
        CHECK(refused.error().message.find("does not compute yet") != std::string::npos);
    }
}

TEST_CASE("channels that are not geometric AOVs are skipped", "[geoaovs]") {
    ChannelDefinition beauty, wrong_type = *channel_definition("z"), expression = *channel_definition("P");
    beauty.name = "beauty";
    wrong_type.type = ChannelType::rgb;
    expression.style = display::ChannelStyle::expression;
    const std::vector<ChannelDefinition> channels{beauty, wrong_type, expression};
    const GeometricAovs none(channels);
    CHECK(none.inputs() == 0);
    CHECK_FALSE(none.wants_rays());
    CHECK_FALSE(none.wants_samples());
    CHECK_FALSE(none.wants_time());
}

}  // namespace
}  // namespace raylex::geoaovs
