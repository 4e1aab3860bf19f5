// A scene, its renders and its variants, as invariants ask for them.
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
    std::size_t layers = 0;              ///< how many of the channels split the beauty, the first ones
    std::shared_ptr<const transport::RenderOutput> output;  ///< by those settings

    [[nodiscard]] std::string integrator() const { return output->used.integrator; }
    /// Channels of light: the beauty and the layers that split it, ids 0 to this.
    [[nodiscard]] std::size_t light_channels() const { return layers + 1; }
    /// Whether a pixel can be negative though all light is positive.
    [[nodiscard]] bool filter_has_negative_lobes() const {
        return output->used.filter == "mitchell" || output->used.filter == "sinc";
    }

  private:
    explicit SceneUnderTest(const InvariantOptions& check) : options(check) {}
};

/// How a check went: what it measured, or why there is nothing to measure.
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
/// Of bits: invariants_of_bits.cpp; of means: invariants_of_means.cpp.
const std::vector<Invariant>& invariants_of_bits();
const std::vector<Invariant>& invariants_of_means();

/// The largest difference between the images of any channel, relative to the channel's largest value; infinite where a
/// channel or pixel is missing or one value is not finite alone.
double difference(const transport::RenderOutput& a, const transport::RenderOutput& b);

/// The scene in another place: everything, camera and lights too, goes through `change`.
transport::SceneDescription moved(transport::SceneDescription scene, const transport::Transform& change);
/// The scene in another unit of length, 1/`factor` of the old one: lengths times `factor`, intensities and coefficients
/// so that every pixel stays the same.
transport::SceneDescription scaled(transport::SceneDescription scene, double factor);
/// Whether brightened() can be made: not of uniform grids whose light goes by temperatures, or by a spectrum alone.
bool can_be_brightened(const transport::SceneDescription& scene);
/// All emission times `factor`.
transport::SceneDescription brightened(transport::SceneDescription scene, double factor);
/// Constant colours of materials as textures of one colour.
transport::SceneDescription textured(transport::SceneDescription scene);

}  // namespace raylex::experiments
