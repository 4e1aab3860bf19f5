#include "geoaovs/geoaovs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer.h"

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

/// A camera at (10, 20, 30) that looks along world +x, its right along world -y, up along world +z: rows of the matrix
/// are the camera's axes in world space, the last column minus their products with its position.
ShadingBatch one_hit() {
    ShadingBatch hits;
    hits.resize(1);
    const float matrix[3][4] = {{0, -1, 0, 20}, {0, 0, 1, -30}, {1, 0, 0, -10}};
    for (int r = 0; r < 3; ++r) std::copy_n(matrix[r], 4, hits.world_to_camera[r]);
    hits.row[0] = 1;
    set(hits.position, 0, 14, 20, 33);      // 4 ahead, 3 up
    set(hits.shading_normal, 0, -1, 0, 0);  // towards the camera
    set(hits.geometric_normal, 0, 0, 0.6f, 0.8f);
    hits.s[0] = 0.25f;
    hits.t[0] = 0.75f;
    hits.distance[0] = 5;
    hits.object_id[0] = 42;
    set(hits.albedo, 0, 0.1f, 0.2f, 0.3f);
    return hits;
}

TEST_CASE("every AOV has its value in its space", "[geoaovs]") {
    const std::vector<ChannelDefinition> channels = all_channels();
    SampleTable table(channels, 4, 0);
    table.begin(std::vector<display::CameraRow>(2));
    display::DisplayServices services(table);
    const GeometricAovs aovs(channels);
    CHECK(aovs.wants_albedo());
    aovs.write(one_hit(), services);
    const auto value = [&](const std::string& name) {
        const ChannelId id = id_of(channels, name);
        const int n = component_count(channels[static_cast<std::size_t>(id)].type);
        return std::vector<double>(table.values(id) + n, table.values(id) + 2 * n);  // row 1
    };
    const auto f = [](float v) { return static_cast<double>(v); };
    CHECK(value("P") == std::vector<double>{0, 3, 4});
    CHECK(value("Pw") == std::vector<double>{14, 20, 33});
    CHECK(value("Nn") == std::vector<double>{0, 0, -1});
    CHECK(value("Ngn") == std::vector<double>{f(-0.6f), f(0.8f), 0});
    CHECK(value("z") == std::vector<double>{4});     // along the axis
    CHECK(value("VLen") == std::vector<double>{5});  // radial: 3-4-5
    CHECK(value("st") == std::vector<double>{0.25, 0.75, 0});
    CHECK(value("id") == std::vector<double>{42});
    CHECK(value("albedo") == std::vector<double>{f(0.1f), f(0.2f), f(0.3f)});
    CHECK(table.depth[1] == 5.0f);
    CHECK(std::all_of(services.refused().begin(), services.refused().end(), [](auto n) { return n == 0; }));
}

TEST_CASE("a pixel that misses is infinitely far and 0 otherwise", "[geoaovs]") {
    const std::vector<ChannelDefinition> channels = all_channels();
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 4, 0);
    table.begin(std::vector<display::CameraRow>(4));
    buffer.accumulate(table);
    for (std::size_t i = 0; i < channels.size(); ++i) {
        CAPTURE(channels[i].name);
        const double expected = channels[i].name == "z" || channels[i].name == "VLen" ? infinity : 0;
        for (const double v : buffer.resolve(static_cast<ChannelId>(i))) CHECK(v == expected);
    }
}

TEST_CASE("at an edge depth and id are those of the nearest sample, normals fade with coverage", "[geoaovs]") {
    const std::vector<ChannelDefinition> channels = all_channels();
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 4, 0);
    std::vector<display::CameraRow> rows(4);
    for (std::size_t i = 0; i < 4; ++i) rows[i].sample = i;
    table.begin(rows);
    display::DisplayServices services(table);
    const GeometricAovs aovs(channels);
    ShadingBatch hits = one_hit();
    aovs.write(hits, services);  // row 1: 5 away
    hits.row[0] = 2;             // row 2: nearer, another object; rows 0 and 3 miss
    hits.position[0][0] = 12;
    hits.distance[0] = 3.5f;
    hits.object_id[0] = 7;
    aovs.write(hits, services);
    buffer.accumulate(table);
    CHECK(buffer.resolve(id_of(channels, "z"))[0] == 2);
    CHECK(buffer.resolve(id_of(channels, "VLen"))[0] == 3.5);
    CHECK(buffer.resolve(id_of(channels, "id"))[0] == 7);
    CHECK(buffer.resolve(id_of(channels, "Nn"))[2] == -0.5);
}

TEST_CASE("z does not depend on where in the image a plane facing the camera is hit, VLen does", "[geoaovs]") {
    const std::vector<ChannelDefinition> channels{*channel_definition("z"), *channel_definition("VLen")};
    SampleTable table(channels, 16, 0);
    table.begin(std::vector<display::CameraRow>(16));
    display::DisplayServices services(table);
    ShadingBatch hits = one_hit();
    const GeometricAovs aovs(channels);
    CHECK_FALSE(aovs.wants_albedo());
    for (int i = 0; i < 16; ++i) {
        const auto up = static_cast<float>(i);
        hits.row[0] = i;
        set(hits.position, 0, 14, 20, 30 + up);
        hits.distance[0] = std::sqrt(16 + up * up);
        aovs.write(hits, services);
        CHECK(table.values(0)[i] == 4);
        CHECK(table.values(1)[i] == Approx(std::hypot(4.0, i)).epsilon(1e-6));  // a float square root
    }
}

TEST_CASE("definitions say type, space and rule; unknown names say what there is", "[geoaovs][law7]") {
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
}

TEST_CASE("channels that are no geometric AOV are passed over", "[geoaovs]") {
    ChannelDefinition beauty, wrong_type = *channel_definition("z"), expression = *channel_definition("P");
    beauty.name = "beauty";
    wrong_type.type = ChannelType::rgb;
    expression.style = display::ChannelStyle::expression;
    const std::vector<ChannelDefinition> channels{beauty, wrong_type, expression};
    CHECK(GeometricAovs(channels).empty());
    CHECK_FALSE(GeometricAovs(all_channels()).empty());
}

}  // namespace
}  // namespace raylex::geoaovs
