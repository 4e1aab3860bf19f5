// Invariants of the mean of an image. Renders with independent seeds are compared by Student's t.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "experiments/invariants/random.h"
#include "experiments/invariants/scene_under_test.h"
#include "experiments/study/analysis/distributions.h"
#include "transport/embree/embree_scene.h"
#include "transport/math/sampling.h"
#include "transport/scene/typed_parameters.h"

namespace raylex::experiments {
namespace {

using transport::RenderSettings;
using transport::SceneDescription;

/// Levels of one comparison. `level` is Sidak's for a million comparisons and a total of 0.001. A suspicion, far more
/// frequent, is checked again.
constexpr double level = 1e-9, suspicion = 1e-3;

/// The mean over the image of every channel, for each seed.
using Means = std::vector<std::vector<double>>;

struct Render {
    SceneDescription scene;
    std::string integrator;  ///< empty: the scene's integrator
    std::vector<Parameter> parameters;
};

/// Renders with several seeds and returns the means of `expressions`, or of the test's channels if there are none.
Result<Means> means_of(const SceneUnderTest& test, const Render& render, const std::vector<std::string>& expressions,
                       int replicates, std::uint64_t first_seed) {
    auto built = transport::BuiltScene::build(render.scene, {.threads = 1});
    if (!built) return built.error();
    RenderSettings settings = test.settings;
    settings.samples.per_pixel = static_cast<std::uint64_t>(test.options.samples_of_means);
    if (!expressions.empty()) {
        const display::ChannelDefinition like = settings.channels.list.front();
        settings.channels.list.clear();
        for (const std::string& expression : expressions) {
            settings.channels.list.push_back(like);
            settings.channels.list.back().name = "c" + std::to_string(settings.channels.list.size());
            settings.channels.list.back().expression = expression;
        }
        settings.channels.beauty = false;
    }
    if (!render.integrator.empty()) {
        transport::SceneEntity integrator;
        integrator.type = render.integrator;
        integrator.parameters.parameters = render.parameters;
        const auto depth = test.scene.integrator.parameters.integer_or("maxdepth", 5);
        settings.paths.max_depth = depth ? *depth : 5;
        settings.paths.integrator = integrator;
    }
    Means means;
    for (int i = 0; i < replicates; ++i) {
        settings.samples.seed = first_seed + static_cast<std::uint64_t>(i);
        const auto output = transport::render(**built, settings);
        if (!output) return output.error();
        std::vector<double>& of_seed = means.emplace_back();
        for (std::size_t id = 0; id < output->frame_buffer.channels().size(); ++id) {
            if (output->frame_buffer.channels()[id].style != display::ChannelStyle::expression) continue;
            const auto values = output->frame_buffer.resolve(static_cast<display::ChannelId>(id));
            of_seed.push_back(std::accumulate(values.begin(), values.end(), 0.0) / double(values.size()));
        }
    }
    return means;
}

struct Comparison {
    double mean_a = 0, mean_b = 0, error = 0;  ///< `error` is the standard error of the difference
    double t = 0, freedom = 1;
    [[nodiscard]] double threshold(double at) const { return -student_t_quantile(at / 2, freedom); }
};

double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}
double variance_of_mean(const std::vector<double>& values) {
    const double mean = mean_of(values);
    double squares = 0;
    for (const double v : values) squares += (v - mean) * (v - mean);
    return squares / (double(values.size()) * double(values.size() - 1));
}
std::vector<double> column(const Means& means, std::size_t channel) {
    std::vector<double> values;
    for (const auto& each : means) values.push_back(each[channel]);
    return values;
}

/// Welch's t test for independent seeds.
Comparison compare(const std::vector<double>& a, const std::vector<double>& b) {
    Comparison result{mean_of(a), mean_of(b)};
    const double va = variance_of_mean(a), vb = variance_of_mean(b), n = double(a.size());
    result.error = std::sqrt(va + vb);
    if (va + vb > 0) result.freedom = (va + vb) * (va + vb) * (n - 1) / (va * va + vb * vb);
    const double apart = std::abs(result.mean_a - result.mean_b);
    result.t = result.error > 0 ? apart / result.error : apart > 0 ? 1e9 : 0;
    return result;
}

/// The t test for equal seeds on both sides, by the differences of pairs. It is more sensitive if paths are similar.
Comparison compare_pairs(const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> apart;
    for (std::size_t i = 0; i < a.size(); ++i) apart.push_back(a[i] - b[i]);
    Comparison result{mean_of(a), mean_of(b), std::sqrt(variance_of_mean(apart)), 0, double(a.size() - 1)};
    const double distance = std::abs(result.mean_a - result.mean_b);
    result.t = result.error > 0 ? distance / result.error : distance > 0 ? 1e9 : 0;
    return result;
}

std::string text_of(const Comparison& worst) {
    const auto number = [](double v) {
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "%.5g", v);
        return std::string(text.data());
    };
    return number(worst.mean_a) + " and " + number(worst.mean_b) + ", difference +- " + number(worst.error);
}

/// Returns whether most of the light is in a few samples. Further rare samples may be missing, so the standard error is
/// unreliable.
bool is_rare(const std::vector<double>& values) {
    const double mean = mean_of(values);
    return mean != 0 && std::sqrt(variance_of_mean(values)) > 0.05 * std::abs(mean);
}

bool has_borders(const SceneDescription& scene) {
    return std::any_of(scene.shapes.begin(), scene.shapes.end(),
                       [](const auto& shape) { return shape.inside_medium != shape.outside_medium; });
}

/// Returns whether the scene has rough coats without raylex:unbiased. As in pbrt-v4, their evaluation and their
/// sampling differ (transport/materials/closures/layered.h), so estimators disagree.
bool has_biased_coats(const SceneDescription& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(), [](const transport::SceneEntity& material) {
        const auto unbiased = material.parameters.boolean_or("raylex:unbiased", false);
        return material.type.starts_with("coated") && (!unbiased || !*unbiased);
    });
}

/// The brightest emission in the scene.
struct Brightest {
    double radiance = 0;  ///< the largest known radiance of a light
    bool all = true;      ///< the radiance of all lights is known
};

Brightest brightest(const SceneDescription& scene) {
    Brightest found;
    const auto take = [&](const ParameterSet& set, bool has_radiance) {
        double color = 1, factor = 1;
        for (const Parameter& p : set.parameters) {
            if (p.name == "L" && p.type == ParameterType::rgb)
                color = *std::max_element(p.numbers.begin(), p.numbers.end());
            else if (p.name == "scale" && p.numbers.size() == 1) factor = p.numbers.front();
            else if (p.name != "twosided") has_radiance = false;
        }
        if (has_radiance) found.radiance = std::max(found.radiance, color * factor);
        found.all = found.all && has_radiance;
    };
    for (const auto& light : scene.lights) take(light.parameters, light.type == "infinite");
    for (const auto& light : scene.area_lights) take(light.parameters, true);
    return found;
}

/// Returns whether one side found no light at all in `draws` samples, although this may be chance. A mean needs at
/// least mean / brightest of all samples; the probability that they all miss is e^-20, twice `level`. If a light has no
/// largest radiance, this is also assumed if no sample of the test's own image hits a surface.
bool is_unseen(const Comparison& found, const SceneUnderTest& test, double draws) {
    if (found.mean_a != 0 && found.mean_b != 0) return false;
    const double mean = std::max(std::abs(found.mean_a), std::abs(found.mean_b));
    const Brightest most = brightest(test.scene);
    if (most.radiance > 0 && draws * mean / most.radiance < 20) return true;
    if (most.all) return false;
    const std::vector<double> covered = test.output->frame_buffer.resolve_alpha();
    return std::all_of(covered.begin(), covered.end(), [](double alpha) { return alpha == 0; });
}

/// Returns whether any surface is closer to the point than `near`, by tracing rays in all directions.
bool is_near_surface(const transport::EmbreeScene& geometry, const transport::Vec3& point, transport::Real near) {
    Random random(1);
    for (int i = 0; i < 256; ++i) {
        transport::Ray ray;
        ray.direction = transport::sample_uniform_sphere(
            {static_cast<transport::Real>(random.unit()), static_cast<transport::Real>(random.unit())});
        // starts before the point, because a hit at distance 0 would not count
        ray.origin = point - ray.direction * near;
        transport::Hit hit;
        geometry.intersect({&ray, 1}, {&hit, 1});
        if (hit.valid() && hit.t < 2 * near) return true;
    }
    return false;
}

/// Returns "the camera" or "a light" if it lies on a surface; else an empty string. Rays that start on a surface hit it
/// or not depending on rounding, and rays from a vertex lie in the plane of a triangle. A point light close to a
/// surface lights a spot that few camera rays meet, too few to know their errors.
std::string what_stands_on_a_surface(const SceneUnderTest& test) {
    const transport::SceneView view = test.built->view();
    const transport::EmbreeScene& geometry = *view.geometry;
    const transport::Vec3 eye = geometry.space().placed(test.built->camera_to_world).point({0, 0, 0});
    const transport::Real near = 1e-5f * (geometry.bounds().radius() + length(eye));
    const auto is_here = [&](const transport::Vec3& vertex) { return length(vertex - eye) < near; };
    for (const transport::ShapeGeometry& shape : geometry.shapes().first(geometry.top_level_shapes())) {
        if (std::any_of(shape.patch_positions.begin(), shape.patch_positions.end(), is_here)) return "the camera";
        for (const transport::Triangle& triangle : shape.triangles)
            for (const std::uint32_t corner : triangle.corners)
                if (is_here(shape.positions[corner])) return "the camera";
    }
    if (is_near_surface(geometry, eye, near)) return "the camera";
    for (const transport::Light& light : view.lights->lights())
        if (light.is_at_point())
            if (is_near_surface(geometry, light.position, 0.05f * length(light.position - eye))) return "a light";
    return {};
}

/// Returns the largest t over all channels, divided by the allowed t. `rounding` is a relative difference that does not
/// count as noise.
Measured agreement(const SceneUnderTest& test, const Render& a, const Render& b, bool paired, double rounding,
                   const std::vector<std::string>& expressions = {}) {
    if (test.output->statistics.invalid_samples > 0) return Measured::skip("numbers leave the range of float");
    if (const std::string what = what_stands_on_a_surface(test); !what.empty())
        return Measured::skip(what + " lies on a surface, or almost");
    if ((a.integrator != "path" || b.integrator != "path") && has_borders(test.scene))
        return Measured::skip(
            "surfaces separate media, so the medium at the camera and at a light is consistent only for closed "
            "surfaces");
    const display::FrameBufferLayout& layout = test.output->frame_buffer.layout();
    const double pixels = static_cast<double>(layout.width) * layout.height;
    Measured result{true, 0, 1, {}};
    for (const bool again : {false, true}) {
        const int replicates = test.options.replicates * (again ? 4 : 1);
        const std::uint64_t seed = 1000 * (test.options.seed % 100000) + (again ? 500 : 0);
        const auto x = means_of(test, a, expressions, replicates, seed);
        const auto y = means_of(test, b, expressions, replicates, paired ? seed : seed + 100);
        if (!x || !y) return Measured::skip("refused: " + (x ? y : x).error().message);
        result.value = 0;
        result.note.clear();
        for (std::size_t channel = 0; channel < x->front().size(); ++channel) {
            const auto u = column(*x, channel), v = column(*y, channel);
            const Comparison found = paired ? compare_pairs(u, v) : compare(u, v);
            // All light paths may miss the small part of a surface that a camera close to it sees.
            const bool passed_by = b.integrator == "lighttracer" && found.mean_b == 0;
            const double draws = static_cast<double>(replicates) * test.options.samples_of_means * pixels;
            if (again && !paired && (passed_by || is_rare(u) || is_rare(v) || is_unseen(found, test, draws))) {
                result.note += result.note.empty() ? "too rare for a comparison" : "";
                continue;
            }
            const double allowed = found.threshold(again ? level : suspicion) * found.error +
                                   rounding * std::max(std::abs(found.mean_a), std::abs(found.mean_b));
            const double ratio = std::abs(found.mean_a - found.mean_b) / std::max(allowed, 1e-300);
            if (ratio <= result.value && !result.note.empty()) continue;
            result.value = ratio;
            result.note = text_of(found) + "; values up to 1 are chance";
        }
        if (result.value <= 1) break;
    }
    return result;
}

/// Bound on the effect of rounding on the mean of an image. Points move by 2^-24 of the scene's size, and edges and
/// everything seen along thousands of paths move with them. For scenes of ordinary size the measured effect is below a
/// tenth of this.
constexpr double rounding_of_points = 1e-3;

Measured translated(const SceneUnderTest& test) {
    Random random(test.options.seed);
    const double reach = std::pow(10.0, random.between(0, 6));
    const auto far = transport::Transform::translate(reach * random.between(-1, 1), reach * random.between(-1, 1),
                                                     reach * random.between(-1, 1));
    return agreement(test, {test.scene, {}, {}}, {moved(test.scene, far), {}, {}}, true, rounding_of_points);
}

Measured rotated(const SceneUnderTest& test) {
    Random random(test.options.seed + 1);
    const auto turn = transport::Transform::rotate(random.between(0, 360), random.between(-1, 1), random.between(-1, 1),
                                                   random.between(0.1, 1));
    return agreement(test, {test.scene, {}, {}}, {moved(test.scene, turn), {}, {}}, false, rounding_of_points);
}

Measured resized(const SceneUnderTest& test) {
    Random random(test.options.seed + 2);
    return agreement(test, {test.scene, {}, {}}, {scaled(test.scene, std::pow(10.0, random.between(-5, 5))), {}, {}},
                     true, rounding_of_points);
}

Measured reordered(const SceneUnderTest& test) {
    if (test.scene.shapes.size() < 2) return Measured::skip("there is only one shape");
    SceneDescription other = test.scene;
    std::reverse(other.shapes.begin(), other.shapes.end());
    std::reverse(other.lights.begin(), other.lights.end());
    return agreement(test, {test.scene, {}, {}}, {other, {}, {}}, false, rounding_of_points);
}

/// Compares estimators on diffuse words, which every estimator finds without rare events. Special scenes test specular
/// words.
Measured estimators(const SceneUnderTest& test, const std::string& other, std::vector<Parameter> parameters) {
    if (has_biased_coats(test.scene)) return Measured::skip("coats without raylex:unbiased are biased, as in pbrt");
    return agreement(test, {test.scene, "path", {}}, {test.scene, other, std::move(parameters)}, false,
                     rounding_of_points, {"C<RD>{1,3}[LO]"});
}
Measured own_integrator(const SceneUnderTest& test) {
    // The comparison with that integrator below accounts for paths that it cannot find.
    if (test.integrator() == "lighttracer" || test.integrator() == "pssmlt")
        return Measured::skip("see the line of this integrator");
    if (test.integrator() == "path") return Measured::skip("the scene's integrator is path");
    return agreement(test, {test.scene, "path", {}}, {test.scene, {}, {}}, false, rounding_of_points,
                     {"C<RD>{1,3}[LO]"});
}
Measured bidirectional(const SceneUnderTest& test) {
    return estimators(test, "bdpt", {});
}
Measured light_tracer(const SceneUnderTest& test) {
    for (const auto& medium : test.scene.media)
        if (medium.parameters.find("Le") != nullptr) return Measured::skip("it does not find light that media emit");
    return estimators(test, "lighttracer", {});
}
Measured metropolis(const SceneUnderTest& test) {
    return estimators(test, "pssmlt",
                      {transport::typed::integer("chains", 16), transport::typed::integer("bootstrapsamples", 4096)});
}
Measured light_samples(const SceneUnderTest& test) {
    return estimators(test, "path", {transport::typed::text("strategy", "light")});
}

/// Returns whether no surface can emit more light than it receives: no shading normals, no scaling of radiance at
/// interfaces, albedos of at most 1.
bool conserves(const SceneDescription& scene) {
    for (const auto& material : scene.materials) {
        if (material.type == "dielectric" || material.type == "raylex:additive" ||
            material.type == "raylex:diffuse-mirror" || material.type == "mix")
            return false;
        for (const Parameter& p : material.parameters.parameters)
            if (p.name == "normalmap" || p.type == ParameterType::texture ||
                (p.type == ParameterType::rgb && *std::max_element(p.numbers.begin(), p.numbers.end()) > 1))
                return false;
    }
    const auto smooth = [](const transport::SceneShape& shape) { return !shape.normals.empty(); };
    if (std::any_of(scene.shapes.begin(), scene.shapes.end(), smooth)) return false;
    for (const auto& object : scene.objects)
        if (std::any_of(object.shapes.begin(), object.shapes.end(), smooth)) return false;
    return true;
}

/// After k events radiance is at most the brightest emission E, so with at most n events the image's mean is at most (n
/// + 1) E. The bound holds for the true mean, so the estimate may exceed it by its error.
Measured energy(const SceneUnderTest& test) {
    const Brightest most = brightest(test.scene);
    if (!most.all || !test.scene.media.empty()) return Measured::skip("light without a largest radiance");
    if (!conserves(test.scene)) return Measured::skip("a surface can emit more light than it receives");
    const auto depth = test.scene.integrator.parameters.integer_or("maxdepth", 5);
    const double bound = most.radiance * double((depth ? *depth : 5) + 1);
    const auto means = means_of(test, {test.scene, {}, {}}, {}, test.options.replicates, 77);
    if (!means) return Measured::skip("refused: " + means.error().message);
    const auto beauty = column(*means, static_cast<std::size_t>(test.output->beauty));
    const double error = std::sqrt(variance_of_mean(beauty));
    const Comparison quantile{0, 0, 0, 0, double(beauty.size() - 1)};
    return {true, mean_of(beauty) - quantile.threshold(level) * error, bound * (1 + 1e-5),
            "mean of the image minus its error; the brightest emission times events + 1"};
}

}  // namespace

const std::vector<Invariant>& invariants_of_means() {
    static const std::vector<Invariant> all{
        {{"energy", "mean brightness at most the brightest emission times (events + 1)", true, true}, energy},
        {{"translation", "a transform to a distant place does not change the mean image", true, true}, translated},
        {{"rotation", "a rotation of scene and camera does not change the mean image", true, true}, rotated},
        {{"scale", "the unit of length does not change the mean image", true, true}, resized},
        {{"order", "the order of shapes and lights does not change the mean image", true, true}, reordered},
        {{"integrator", "the scene's own integrator and path agree on diffuse paths", true, true}, own_integrator},
        {{"bdpt", "path and bdpt agree on diffuse paths", true, true}, bidirectional},
        {{"lighttracer", "path and lighttracer agree on diffuse paths", true, true}, light_tracer},
        {{"pssmlt", "path and pssmlt agree on diffuse paths", true, true}, metropolis},
        {{"strategies", "path by multiple importance sampling and by light samples agree on diffuse paths", true, true},
         light_samples},
    };
    return all;
}

}  // namespace raylex::experiments
