// A closed enclosure in which the light of every path string is known: walls of radiance 1 that scatter kd diffusely
// and ks as a mirror. Radiance is equal along every ray, so a path string with d diffuse and s mirror reflections
// carries kd^d ks^s for every camera.
#pragma once

#include "transport/replicates.h"

namespace render_test {

inline std::string enclosure(double kd, double ks, int fov = 60) {
    const auto grey = [](double value) {
        const std::string each = std::to_string(value) + " ";
        return "[" + each + each + each + "]";
    };
    return R"(
Film "rgb" "integer xresolution" 12 "integer yresolution" 12
Sampler "independent" "integer pixelsamples" 64
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
LookAt 0.2 0.1 0  0.2 0.3 -1  0 1 0
Camera "perspective" "float fov" )" +
           std::to_string(fov) + R"(
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1]
Material "raylex:diffuse-mirror" "rgb diffuse" )" +
           grey(kd) + R"( "rgb specular" )" + grey(ks) + R"(
ReverseOrientation
Shape "sphere" "float radius" 2
)";
}

/// A path of the enclosure: its reflections from the camera, 'D' and 'S', and its light.
struct EnclosurePathString {
    std::string reflections;
    double value;
};

/// All path strings of up to `longest` reflections, shorter ones first.
inline std::vector<EnclosurePathString> enclosure_path_strings(double kd, double ks, std::size_t longest) {
    std::vector<EnclosurePathString> words{{"", 1}};
    for (std::size_t i = 0; words[i].reflections.size() < longest; ++i) {
        words.push_back({words[i].reflections + "D", words[i].value * kd});
        words.push_back({words[i].reflections + "S", words[i].value * ks});
    }
    return words;
}

/// Whether the light tracer finds the path: it connects light paths with the camera at a vertex with a density, so it
/// finds no path that the camera sees through a mirror.
inline bool light_tracer_finds(const EnclosurePathString& word) {
    return word.reflections.rfind('S', 0) != 0;
}

}  // namespace render_test
