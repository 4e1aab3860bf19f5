// A scene with its render and its variants, as input of invariants.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "experiments/invariants/invariants.h"
#include "transport/render/built_scene.h"
#include "transport/render/render.h"

namespace raylex::experiments {

class SceneUnderTest {
  public:
    static Result<SceneUnderTest> make(const std::string& text, const std::string& path,
                                       const InvariantOptions& options);

    const InvariantOptions& options;
    std::string path;
    transport::SceneDescription scene;
    std::shared_ptr<const transport::BuiltScene> built;
    transport::RenderSettings settings;  ///< few pixels and samples, one thread, layers that split the light
    std::size_t layers = 0;              ///< number of channels that split the beauty; they come first
    std::shared_ptr<const transport::RenderOutput> output;  ///< the render with these settings

    [[nodiscard]] std::string integrator() const { return output->used.integrator; }
    /// Number of channels of light: the beauty and the layers that split it, with ids below this number.
    [[nodiscard]] std::size_t light_channels() const { return layers + 1; }
    /// Returns whether a pixel can be negative although all light is positive.
    [[nodiscard]] bool filter_has_negative_lobes() const {
        return output->used.filter == "mitchell" || output->used.filter == "sinc";
    }

  private:
    explicit SceneUnderTest(const InvariantOptions& check) : options(check) {}
};

/// The result of a check: the measured value and its bound, or why the check does not apply.
struct Measured {
    bool applies = true;
    double value = 0, bound = 0;
    std::string note;

    static Measured skip(std::string why) { return {false, 0, 0, std::move(why)}; }
};
using Check = std::function<Measured(const SceneUnderTest&)>;

struct Invariant {
    InvariantInfo info;
    Check check;
};
/// Return the invariants of invariants_of_bits.cpp and of invariants_of_means.cpp.
const std::vector<Invariant>& invariants_of_bits();
const std::vector<Invariant>& invariants_of_means();

/// Returns the largest difference between two images over all channels, relative to the channel's largest value;
/// infinite if a channel or pixel is missing, or if a value is finite in only one image.
double difference(const transport::RenderOutput& a, const transport::RenderOutput& b);

/// Returns the scene with everything, also camera and lights, transformed by `change`.
transport::SceneDescription moved(transport::SceneDescription scene, const transport::Transform& change);
/// Returns the scene in a unit of length that is shorter by `factor`: lengths are multiplied by `factor`; intensities
/// and coefficients are adjusted so that pixels keep their values.
transport::SceneDescription scaled(transport::SceneDescription scene, double factor);
/// Returns whether brightened() supports the scene. It does not support uniform grids whose light is given by
/// temperatures or only by a spectrum.
bool can_be_brightened(const transport::SceneDescription& scene);
/// Returns the scene with all emission multiplied by `factor`.
transport::SceneDescription brightened(transport::SceneDescription scene, double factor);
/// Returns the scene with constant material colours replaced by textures of one colour.
transport::SceneDescription textured(transport::SceneDescription scene);

}  // namespace raylex::experiments
