// Settings and scenes that the tests of guides share.
#pragma once

#include "tests/transport/interrupted_render.h"
#include "transport/replicates.h"

namespace render_test {

/// An integrator with a guide. `mode`: "on" or "auto"; `training`: samples of each pixel, 0: a share of the render.
inline transport::SceneEntity with_guide(transport::SceneEntity entity, const std::string& mode, int training) {
    entity.parameters.parameters.push_back(text_parameter("guide", mode));
    if (training > 0) entity.parameters.parameters.push_back(number_parameter("guidesamples", training));
    return entity;
}

/// A render on two threads with a guide. Roulette and splits of `path` are by expected gain, its default.
inline transport::RenderSettings guided_settings(int training, std::uint64_t per_pixel,
                                                 const std::string& method = "path") {
    transport::RenderSettings settings;
    settings.paths.integrator = with_guide(integrator_named(method), "on", training);
    settings.samples.per_pixel = per_pixel;
    settings.machine.threads = 2;
    return settings;
}

/// The sums of all samples of a render.
inline std::string frame_bits(const transport::RenderOutput& output) {
    std::string bytes;
    output.frame_buffer.append_record(bytes);
    return bytes;
}

/// A render in sessions, each interrupted after a number of camera samples of a counted() integrator and resumed.
struct RenderInSessions {
    transport::RenderOutput output;  ///< of the last session
    int sessions = 0;
};
inline RenderInSessions render_in_sessions(const transport::SceneDescription& scene, transport::RenderSettings settings,
                                           std::uint64_t samples, const std::string& file) {
    settings.checkpoint = transport::CheckpointSettings{.file = file, .seconds = 0.01};
    for (int sessions = 1;; ++sessions) {
        std::atomic<bool> stop{false};
        settings.machine.threads = 1 + sessions % 3;
        interruption().begin(samples, &stop);
        auto output = transport::render(scene, settings, {}, &stop);
        interruption().begin(0, nullptr);
        REQUIRE(output.ok());
        REQUIRE(sessions < 100);
        if (output->samples.complete) return {*std::move(output), sessions};
        settings.checkpoint->resume = true;
    }
}

/// A closed box with a lamp in a globe of glass, which no light sample passes: two radii in units of half the box's
/// width, and the lamp's radiance.
inline std::string lamp_in_globe(double globe, double lamp, int light) {
    const std::string radiance = std::to_string(light) + " ";
    return film + R"(
Integrator "path" "integer maxdepth" 6
LookAt 0 1 3.9  0 1 0  0 1 0
Camera "perspective" "float fov" 39
WorldBegin
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 4 1 0 4 1 0 -1 -1 0 -1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 2 -1 1 2 -1 1 2 4 -1 2 4]
Shape "bilinearmesh" "point3 P" [-1 0 -1 1 0 -1 -1 2 -1 1 2 -1]
Shape "bilinearmesh" "point3 P" [-1 0 4 1 0 4 -1 2 4 1 2 4]
Shape "bilinearmesh" "point3 P" [-1 0 -1 -1 0 4 -1 2 -1 -1 2 4]
Shape "bilinearmesh" "point3 P" [1 0 -1 1 0 4 1 2 -1 1 2 4]
AttributeBegin Translate 0.1 1.3 0.2
  AttributeBegin Material "dielectric" Shape "sphere" "float radius" )" +
           std::to_string(globe) + R"( AttributeEnd
  AreaLightSource "diffuse" "rgb L" [)" +
           radiance + radiance + radiance + R"(]
  Shape "sphere" "float radius" )" +
           std::to_string(lamp) + R"(
AttributeEnd
)";
}

}  // namespace render_test
