// Small scenes and statistics for the tests of rendering.
#pragma once

#include <catch2/catch.hpp>

#include <cmath>
#include <string>
#include <vector>

#include "tests/transport/import_support.h"
#include "transport/render/built_scene.h"

namespace render_test {

using raylex::Parameter;
using raylex::ParameterType;
namespace display = raylex::display;
namespace transport = raylex::transport;

/// A channel with a built-in name.
inline display::ChannelDefinition aov(const std::string& name) {
    display::ChannelDefinition channel;
    channel.name = name;
    return channel;
}

using import_test::scene_of;

inline transport::RenderOutput render_of(const transport::SceneDescription& scene,
                                         const transport::RenderSettings& settings = {}) {
    auto output = transport::render(scene, settings);
    INFO((output ? std::string() : output.error().to_string()));
    REQUIRE(output.ok());
    CHECK(output->statistics.invalid_samples == 0);
    return *std::move(output);
}

inline display::ChannelDefinition lpe_channel(const std::string& name, const std::string& expression) {
    display::ChannelDefinition channel;
    channel.name = name;
    channel.style = display::ChannelStyle::expression;
    channel.expression = expression;
    channel.statistics = true;
    return channel;
}

inline Parameter text_parameter(const std::string& name, const std::string& value) {
    Parameter p;
    p.name = name;
    p.type = ParameterType::string;
    p.strings = {value};
    return p;
}
inline Parameter number_parameter(const std::string& name, double value) {
    Parameter p;
    p.name = name;
    p.type = ParameterType::integer;
    p.numbers = {value};
    return p;
}
inline Parameter flag_parameter(const std::string& name, bool value) {
    Parameter p;
    p.name = name;
    p.type = ParameterType::boolean;
    p.booleans = {static_cast<std::uint8_t>(value)};
    return p;
}
inline transport::SceneEntity path_with(const Parameter& parameter) {
    transport::SceneEntity entity;
    entity.type = "path";
    entity.parameters.parameters.push_back(parameter);
    return entity;
}

/// The mean of a channel's green component over the image, and its standard error from the pixels' variances. The error
/// is exact for the independent sampler and too large for scrambled Sobol' points, which vary less: tests with those
/// are conservative.
struct Estimate {
    double mean = 0, error = 0;
};
inline Estimate estimate(const transport::RenderOutput& output, display::ChannelId id) {
    const std::vector<double> values = output.frame_buffer.resolve(id),
                              variances = output.frame_buffer.resolve_variance_of_mean(id);
    const std::size_t pixels = values.size() / 3;
    REQUIRE(variances.size() == values.size());
    Estimate e;
    double variance = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        e.mean += values[3 * i + 1];
        variance += variances[3 * i + 1];
    }
    e.mean /= static_cast<double>(pixels);
    e.error = std::sqrt(variance) / static_cast<double>(pixels);
    return e;
}
inline Estimate estimate(const transport::RenderOutput& output) {
    return estimate(output, output.beauty);
}

/// |a - b| in standard errors of the difference. Above 4.5 by chance once in 150,000 comparisons.
inline double deviation(const Estimate& a, const Estimate& b) {
    return std::abs(a.mean - b.mean) / std::hypot(a.error, b.error);
}

inline const std::string film = R"(
Film "rgb" "integer xresolution" 24 "integer yresolution" 24
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "independent" "integer pixelsamples" 64
)";

/// A closed room with a ceiling light, a glossy block and a glass ball: every kind of event, and walls of several
/// albedos.
inline const std::string room = film + R"(
Integrator "path" "integer maxdepth" 6
LookAt 0 1 3.9  0 1 0  0 1 0
Camera "perspective" "float fov" 39
WorldBegin
Material "diffuse" "rgb reflectance" [0.7 0.6 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 1 1 0 1 1 0 -1 -1 0 -1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 2 -1 1 2 -1 1 2 1 -1 2 1]
Shape "bilinearmesh" "point3 P" [-1 0 -1 1 0 -1 -1 2 -1 1 2 -1]
Material "diffuse" "rgb reflectance" [0.6 0.1 0.1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 1 -1 0 -1 -1 2 -1 -1 2 1]
Material "conductor" "rgb reflectance" [0.8 0.7 0.6] "float roughness" 0.1
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [1 0 -1 1 0 1 1 2 1 1 2 -1]
AttributeBegin
  Material "dielectric"
  Translate 0.3 0.4 0.2
  Shape "sphere" "float radius" 0.4
AttributeEnd
AttributeBegin
  Material "coateddiffuse" "rgb reflectance" [0.2 0.5 0.7] "float roughness" 0.05
  Translate -0.5 0.35 0
  Shape "cylinder" "float radius" 0.25 "float zmin" -0.3 "float zmax" 0.3
  Shape "disk" "float radius" 0.25 "float height" 0.3
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 8 8]
  Material "diffuse" "rgb reflectance" [0 0 0]
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.4 1.98 -0.4 0.4 1.98 -0.4 0.4 1.98 0.4 -0.4 1.98 0.4]
AttributeEnd
LightSource "infinite" "rgb L" [0.2 0.3 0.4]
LightSource "spot" "rgb I" [1 1 1] "point3 from" [0 1.8 0.9] "point3 to" [0 0 0]
)";

/// The room with all its objects, filled with coloured fog; the glass ball contains another medium, which emits.
inline std::string foggy_room() {
    std::string text = room;
    const std::string camera = "LookAt";
    text.replace(text.find(camera), camera.size(), R"(
MakeNamedMedium "haze" "string type" "homogeneous"
    "rgb sigma_a" [0.02 0.05 0.1] "rgb sigma_s" [0.3 0.25 0.2] "float g" 0.4
MakeNamedMedium "juice" "string type" "homogeneous" "rgb sigma_a" [0.2 1 2] "rgb sigma_s" [1 1 1] "rgb Le" [0.5 0.2 0.1]
MediumInterface "" "haze"
LookAt)");
    const std::string glass = "Material \"dielectric\"";
    text.replace(text.find(glass), glass.size(), "MediumInterface \"juice\" \"haze\"\n  Material \"dielectric\"");
    return text;
}

}  // namespace render_test
