// Motion: interpolation between two transforms, its steps for Embree, and images of moving objects against closed
// forms.
#include <numbers>

#include "display/services/elementary.h"
#include "tests/transport/replicates.h"
#include "transport/geometry/shapes/instance_motion.h"
#include "transport/import/apply_effects.h"
#include "transport/math/animated_transform.h"
#include "transport/scene/effects/effects.h"

using namespace render_test;
using raylex::transport::AnimatedTransform;
using raylex::transport::DVec3;
using raylex::transport::Matrix34;
using raylex::transport::Transform;

namespace {

constexpr double exact_pi = std::numbers::pi;

AnimatedTransform way_between(const Transform& start, const Transform& end) {
    auto way = AnimatedTransform::between(start, end, {"here.pbrt", 3, 1});
    INFO((way ? std::string() : way.error().to_string()));
    REQUIRE(way.ok());
    return *std::move(way);
}

double distance(const Transform& a, const Transform& b, const DVec3& p) {
    return length(Matrix34(a.matrix()).point(p) - Matrix34(b.matrix()).point(p));
}

/// A black object before a white sky, seen straight on by a camera 100 away whose film is 2 x 2 at the object's depth.
std::string silhouette(const std::string& thing, const std::string& camera = {}, int pixels = 16, int samples = 1024) {
    const double fov = 2 * std::atan(1.0 / 100) * 180 / exact_pi;
    return "Film \"rgb\" \"integer xresolution\" " + std::to_string(pixels) + " \"integer yresolution\" " +
           std::to_string(pixels) +
           "\nPixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5\nSampler \"independent\" \"integer "
           "pixelsamples\" " +
           std::to_string(samples) + "\nLookAt 0 0 -100  0 0 0  0 1 0\n" + camera +
           "\nCamera \"perspective\" \"float fov\" " + std::to_string(fov) +
           "\nWorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 "
           "0]\n" +
           thing;
}

/// The share of the sky that is hidden in a pixel of the last column, and the standard error of that many binary
/// samples.
double hidden(const std::vector<double>& image, int width, int x, int y) {
    return 1 - image[3 * static_cast<std::size_t>(y * width + x)];
}

// A plane that fills the film from x = -1 to the edge at x0; the film's x grows to the right.
const std::string wall =
    "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" "
    "[-9 -9 0 0 -9 0 0 9 0 -9 9 0]\n";

std::string moving(const std::string& start, const std::string& end, const std::string& what) {
    return "AttributeBegin\nActiveTransform StartTime\n" + start + "\nActiveTransform EndTime\n" + end +
           "\nActiveTransform All\n" + what + "AttributeEnd\n";
}

/// Binomial counts are within this many standard errors of their mean except once in 3.5 million.
constexpr double quantile = 5.1;

}  // namespace

TEST_CASE("motion: interpolated transforms are exact at both ends", "[motion]") {
    const Transform start = Transform::translate(1, 2, 3) * Transform::rotate(20, 1, 2, -1) * Transform::scale(1, 2, 3),
                    end = Transform::translate(-1, 0, 3) * Transform::rotate(120, 0, 1, 0) * Transform::scale(2, 2, 1);
    const AnimatedTransform way = way_between(start, end);
    CHECK(way.at(0).matrix() == start.matrix());
    CHECK(way.at(1).matrix() == end.matrix());
    CHECK(way.at(-3).matrix() == start.matrix());
    CHECK(way.at(3).matrix() == end.matrix());
    // Near the ends nothing jumps. The way is at most 10 long, so 1e-9 of it is 1e-8, and 1e-14 is rounding.
    for (const DVec3& p : {DVec3(1, 0, 0), DVec3(0, 1, 0), DVec3(0, 0, 1)}) {
        CHECK(distance(way.at(1e-9), start, p) < 1.1e-8);
        CHECK(distance(way.at(1 - 1e-9), end, p) < 1.1e-8);
    }
}

TEST_CASE("motion: translation, rotation and scale are interpolated separately, the shorter way round", "[motion]") {
    const auto near = [](const Transform& a, const Transform& b) {
        for (const DVec3& p : {DVec3(1, 2, 3), DVec3(-1, 1, 0)})
            if (!(distance(a, b, p) < 1e-13)) return false;  // of numbers of a few units: some hundred roundings
        return true;
    };
    const AnimatedTransform quarter = way_between(Transform(), Transform::rotate(90, 0, 0, 1));
    CHECK(near(quarter.at(0.5), Transform::rotate(45, 0, 0, 1)));
    CHECK(near(quarter.at(1.0 / 3), Transform::rotate(30, 0, 0, 1)));
    CHECK(near(way_between(Transform(), Transform::rotate(270, 0, 0, 1)).at(0.5), Transform::rotate(-45, 0, 0, 1)));
    CHECK(near(way_between(Transform::rotate(10, 1, 1, 0), Transform::rotate(170, 1, 1, 0)).at(0.25),
               Transform::rotate(50, 1, 1, 0)));
    CHECK(near(way_between(Transform::scale(1, 1, 1), Transform::scale(3, 5, 1)).at(0.5), Transform::scale(2, 3, 1)));
    const AnimatedTransform all =
        way_between(Transform::translate(0, 0, 2) * Transform::rotate(30, 0, 1, 0),
                    Transform::translate(4, 0, 2) * Transform::rotate(90, 0, 1, 0) * Transform::scale(3, 3, 3));
    CHECK(
        near(all.at(0.5), Transform::translate(2, 0, 2) * Transform::rotate(60, 0, 1, 0) * Transform::scale(2, 2, 2)));
    // Mirrored at both ends: mirrored in between.
    const AnimatedTransform mirrored =
        way_between(Transform::scale(-1, 1, 1), Transform::rotate(90, 0, 0, 1) * Transform::scale(-1, 1, 1));
    CHECK(near(mirrored.at(0.5), Transform::rotate(45, 0, 0, 1) * Transform::scale(-1, 1, 1)));
}

TEST_CASE("motion: objects that would become flat in between are refused", "[motion][law7]") {
    const auto mirror = AnimatedTransform::between(Transform(), Transform::scale(-1, 1, 1), {"here.pbrt", 3, 1});
    REQUIRE_FALSE(mirror.ok());
    CHECK(import_test::contains(mirror.error().to_string(), "here.pbrt:3:1"));
    CHECK(import_test::contains(mirror.error().message, "mirrors"));
}

TEST_CASE("motion: Embree's steps stay within their bound", "[motion]") {
    const raylex::transport::DBounds box{{-1, -0.5, 2}, {1, 0.5, 3}};
    const auto check = [&](const Transform& start, const Transform& end, std::size_t most) {
        const AnimatedTransform way = way_between(start, end);
        const raylex::transport::InstanceMotion motion([&](double time) { return way.at(time); }, box);
        CHECK(motion.keys().size() <= most + 1);
        double off = 0, inverse_off = 0;
        double longest = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const DVec3 p{corner & 1 ? 1.0 : -1, corner & 2 ? 0.5 : -0.5, corner & 4 ? 3.0 : 2};
            double gone = 0;
            DVec3 last = Matrix34(start.matrix()).point(p);
            for (int i = 0; i <= 1000; ++i) {
                const double time = static_cast<float>(i / 1000.0);
                const DVec3 there = Matrix34(way.at(time).matrix()).point(p);
                const auto placement = motion.at(static_cast<transport::Real>(time));
                off = std::max(off, length(placement.to_world.point(p) - there));
                inverse_off = std::max(inverse_off, length(placement.to_object.point(placement.to_world.point(p)) - p));
                gone += length(there - last);
                last = there;
            }
            longest = std::max(longest, gone);
        }
        // In addition to the bound, keys are rounded to float: 2^-24 of coordinates below 8, in three terms and a
        // shift. Here and there the longest way is measured in chords, whose lengths differ by at most 1e-4.
        CHECK(off <= raylex::transport::InstanceMotion::tolerance * longest * 1.0002 + 4 * 8 * 0x1p-24);
        CHECK(inverse_off < 1e-13);  // in double, of matrices near rotations
        return motion.keys().size() - 1;
    };
    CHECK(check(Transform(), Transform::translate(5, 1, 0), 1) == 1);
    CHECK(check(Transform(), Transform::scale(2, 1, 1), 1) == 1);
    CHECK(check(Transform(), Transform::rotate(1, 0, 1, 0), 8) < 16);
    CHECK(check(Transform(), Transform::rotate(180, 0, 1, 0), 64) > 16);
    check(Transform::rotate(30, 1, 2, 3), Transform::rotate(-140, 3, 1, 0) * Transform::scale(2, 3, 0.5), 128);
}

TEST_CASE("motion: the edge of a moving object covers pixels by the share of time", "[motion][render]") {
    const int pixels = 16, samples = 4096;
    const double x0 = -0.7, x1 = 0.55;
    const auto image_of = [&](const std::string& text) {
        const transport::RenderOutput output = render_of(scene_of(text));
        return output.frame_buffer.resolve(output.beauty);
    };
    // A shape, an instance, and a camera that moves the opposite way.
    const std::string there = "Translate " + std::to_string(x1) + " 0 0",
                      here = "Translate " + std::to_string(x0) + " 0 0";
    const std::vector<std::string> scenes{
        silhouette(moving(here, there, wall), {}, pixels, samples),
        silhouette("ObjectBegin \"wall\"\n" + wall + "ObjectEnd\n" + moving(here, there, "ObjectInstance \"wall\"\n"),
                   {}, pixels, samples),
        silhouette(
            wall,
            "ActiveTransform StartTime\n" + here + "\nActiveTransform EndTime\n" + there + "\nActiveTransform All\n",
            pixels, samples)};
    for (const std::string& text : scenes) {
        CAPTURE(text);
        const std::vector<double> image = image_of(text);
        for (int x = 0; x < pixels; ++x) {
            // Left-handed, seen from -z: x grows to the right. Mean over the pixel of the share of time that the edge
            // has passed a point: the integral of a ramp.
            const auto passed = [&](double at) {  // integral of clamp((x1 - s) / (x1 - x0)) up to s = at
                const double s = std::clamp(at, x0, x1), w = x1 - x0;
                return std::min(at, x0) + (s - x0) - (s - x0) * (s - x0) / (2 * w);
            };
            const double left = -1 + 2.0 * x / pixels, right = left + 2.0 / pixels;
            const double expected = (passed(right) - passed(left)) / (right - left);
            double mean = 0;
            for (int y = 0; y < pixels; ++y) mean += hidden(image, pixels, x, y) / pixels;
            const double error = std::sqrt(expected * (1 - expected) / (samples * pixels));
            CAPTURE(x, expected);
            // 1e-6: what the film's edges are off by, from the tangent of a small angle in single precision.
            CHECK(std::abs(mean - expected) <= quantile * error + 1e-6);
        }
    }
}

TEST_CASE("motion: half a disk that turns by 180 degrees covers each direction by its share of time",
          "[motion][render]") {
    const int pixels = 24, samples = 1024;
    const std::string disk = "Shape \"disk\" \"float radius\" 9 \"float phimax\" 180\n";
    const transport::RenderOutput output =
        render_of(scene_of(silhouette(moving("", "Rotate 179.999 0 0 1", disk), {}, pixels, samples)));
    const std::vector<double> image = output.frame_buffer.resolve(output.beauty);
    // Blocks of 4 x 4 pixels beside the middle: the expected share is that of the direction, averaged over the block.
    for (int by = 0; by < 6; ++by)
        for (int bx = 0; bx < 6; ++bx) {
            double expected = 0, mean = 0;
            const int fine = 64;
            for (int i = 0; i < fine * fine; ++i) {
                const double x = -1 + (4 * bx + 4 * (i % fine + 0.5) / fine) * 2.0 / pixels,
                             y = 1 - (4 * by + 4 * (i / fine + 0.5) / fine) * 2.0 / pixels;
                double angle = std::atan2(y, x);
                if (angle < 0) angle += 2 * exact_pi;
                expected += angle < exact_pi ? angle / exact_pi : 2 - angle / exact_pi;
            }
            expected /= fine * fine;
            for (int y = 0; y < 4; ++y)
                for (int x = 0; x < 4; ++x) mean += hidden(image, pixels, 4 * bx + x, 4 * by + y) / 16;
            CAPTURE(bx, by, expected);
            // 16,384 binary samples per block. The sum over fine x fine points is off by less than its step, 1/(6 x 64)
            // of a turn at the middle; the turn is 1e-3 degrees short of 180, and steps move it by 1e-4 of the way.
            CHECK(std::abs(mean - expected) <=
                  quantile * 0.5 / std::sqrt(16.0 * samples) + 1.0 / (6 * fine * 8) + 1e-4);
        }
}

TEST_CASE("motion: the shutter and the transformation times select the visible part of the motion",
          "[motion][render]") {
    const auto covered = [&](const std::string& times, const std::string& shutter) {
        std::string text = silhouette(moving("Translate -1 0 0", "Translate 1 0 0", wall), times, 16, 256);
        text.replace(text.find("\"float fov\""), 0, shutter + " ");
        // The amount of light does not depend on the shutter.
        text.replace(text.find("\"integer xresolution\""), 0, "\"float exposuretime\" 1 ");
        const transport::RenderOutput output = render_of(scene_of(text));
        const std::vector<double> image = output.frame_buffer.resolve(output.beauty);
        double sum = 0;
        for (std::size_t i = 0; i < image.size(); i += 3) sum += 1 - image[i];
        return sum / (16 * 16);
    };
    // The mean edge as a share of the film; 65,536 samples.
    const double error = quantile * 0.5 / 256;
    CHECK(std::abs(covered("", "") - 0.5) <= error);
    CHECK(std::abs(covered("", "\"float shutteropen\" 0 \"float shutterclose\" 0.5") - 0.25) <= error);
    CHECK(std::abs(covered("", "\"float shutteropen\" 0.75 \"float shutterclose\" 0.75") - 0.75) <= error);
    CHECK(covered("", "\"float shutteropen\" 1 \"float shutterclose\" 2") == 1);
    CHECK(covered("", "\"float shutteropen\" -2 \"float shutterclose\" 0") == 0);
    CHECK(std::abs(covered("TransformTimes 0.25 0.75", "") - 0.5) <= error);
    // Half of the time at the start, half in motion: 0 and then 1/2 on average.
    CHECK(std::abs(covered("TransformTimes 0.5 1", "") - 0.25) <= error);
    CHECK(std::abs(covered("TransformTimes 0 4", "\"float shutterclose\" 4") - 0.5) <= error);
}

TEST_CASE("motion: a shutter that closes before it opens is swapped, with a warning", "[motion]") {
    const auto built = [](const std::string& shutter) {
        auto scene = transport::BuiltScene::build(
            scene_of("LookAt 0 0 -9  0 0 0  0 1 0\nCamera \"perspective\"\n" + shutter + "\nWorldBegin\n"));
        REQUIRE(scene.ok());
        return (*scene)->warnings;
    };
    for (const char* shutter :
         {"\"float shutteropen\" 1 \"float shutterclose\" 0", "\"float shutterclose\" -1", "\"float shutteropen\" 2"}) {
        const std::vector<raylex::Error> warnings = built(shutter);
        REQUIRE(warnings.size() == 1);
        CHECK(warnings[0].line == 3);
        CHECK(import_test::contains(warnings[0].message, "'shutteropen' is later than 'shutterclose'"));
    }
    CHECK(built("\"float shutteropen\" 1").empty());
}

TEST_CASE("motion: stopped, everything stands in the middle of its motion", "[motion][effects]") {
    using raylex::transport::Effect;
    transport::SceneDescription scene =
        scene_of(silhouette(moving("Translate -1 0 0", "Translate 0.5 0 0", wall), {}, 16, 4));
    raylex::transport::EffectChoices choices;
    choices[Effect::motion] = false;
    REQUIRE(apply_effects(scene, choices).ok());
    CHECK_FALSE(analyse_effects(scene)[static_cast<std::size_t>(Effect::motion)].called_for);
    const transport::RenderOutput output = render_of(scene);
    const std::vector<double> image = output.frame_buffer.resolve(output.beauty);
    for (int x = 0; x < 16; ++x) CHECK(hidden(image, 16, x, 3) == (x < 6 ? 1 : 0));  // the edge at -0.25
}

TEST_CASE("motion: positions and normals are those of each sample's time", "[motion][render][aovs]") {
    // A wall that moves away from the camera by 2 and turns about the view's axis.
    const std::string everywhere =
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" "
        "[-9 -9 0 9 -9 0 9 9 0 -9 9 0]\n";
    const int samples = 256;
    transport::RenderSettings settings;
    settings.channels.list = {aov("Pw"), aov("Nn")};
    const transport::RenderOutput output = render_of(
        scene_of(silhouette(moving("Translate 0 0 1", "Translate 0 0 3 Rotate 170 0 0 1", everywhere), {}, 8, samples)),
        settings);
    const auto channel = [&](const std::string& name) {
        for (std::size_t i = 0; i < output.frame_buffer.channels().size(); ++i)
            if (output.frame_buffer.channels()[i].name == name)
                return output.frame_buffer.resolve(static_cast<display::ChannelId>(i));
        FAIL(name);
        return std::vector<double>();
    };
    const std::vector<double> position = channel("Pw"), normal = channel("Nn");
    double depth = 0;
    for (std::size_t i = 0; i < position.size(); i += 3) {
        depth += position[i + 2] / 64;
        CHECK(std::abs(normal[i + 2] + 1) < 1e-6);  // towards the camera at all times
    }
    // Times are uniform: a mean of 2 with a variance of 2^2 / 12 per sample.
    CHECK(std::abs(depth - 2) <= quantile * 2 / std::sqrt(12.0 * 64 * samples));
}
