// Images over footprints: levels, look-ups, footprints of cones, and images of them against many samples.
#include <numbers>

#include "tests/transport/render_support.h"
#include "transport/paths/footprints.h"
#include "transport/scene/effects/effects.h"
#include "transport/textures/image_filter.h"

using namespace render_test;
using raylex::transport::Image;
using raylex::transport::ImagePyramid;
using raylex::transport::Real;
using raylex::transport::SurfaceFootprint;
using raylex::transport::TextureMapping;
using raylex::transport::TexturePoint;
using raylex::transport::Vec2;
using raylex::transport::Vec3;

namespace {

/// Numbers that tell texels apart, from 0 to 1.
Image some_image(int width, int height, int channels) {
    Image image{width, height, channels, {}};
    const int count = width * height * channels;
    for (int i = 0; i < count; ++i) image.pixels.push_back(static_cast<float>((i * 7919 + i * i * 31) % 101) / 100.0f);
    return image;
}

double mean_of(const Image& image, int channel) {
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, channel));
    return sum / (image.width * image.height);
}

/// A PFM of black and white squares, `squares` a side of as many texels each.
std::string checkers(const import_test::Folder& folder, int squares, int texels) {
    const int n = squares * texels;
    std::string text = "PF\n" + std::to_string(n) + " " + std::to_string(n) + "\n-1.0\n";
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const float value = (x / texels + y / texels) % 2 == 0 ? 0.0f : 1.0f;
            for (int c = 0; c < 3; ++c) text.append(reinterpret_cast<const char*>(&value), sizeof value);
        }
    folder.write("checkers.pfm", text);
    return folder.path("checkers.pfm");
}

/// A floor to the horizon under an even sky, by which a diffuse floor of reflectance r shows radiance r; `floor` is
/// its texture's further parameters.
std::string plain_to_the_horizon(const std::string& image, const std::string& filter, int samples,
                                 const std::string& more = {}) {
    return R"(
Film "rgb" "integer xresolution" 48 "integer yresolution" 32
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "independent" "integer pixelsamples" )" +
           std::to_string(samples) + R"(
Integrator "path" "integer maxdepth" 3
LookAt 0 1 0  0.13 0.93 -1  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Texture "t" "spectrum" "imagemap" "string filename" ")" +
           image + R"(" "string encoding" "linear" "float uscale" 500 "float vscale" 500 "string filter" ")" + filter +
           "\"\n" + more + R"(
Material "diffuse" "texture reflectance" "t"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1000 0 1000 1000 0 1000 1000 0 -1000 -1000 0 -1000]
    "point2 uv" [0 0 1 0 1 1 0 1]
)";
}

std::vector<double> pixels_of(const std::string& text) {
    const transport::RenderOutput output = render_of(scene_of(text));
    return output.frame_buffer.resolve(output.beauty);
}

double root_mean_square(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace

TEST_CASE("texture filter: every level has the image's mean, whatever its size", "[texture-filter]") {
    for (const auto& [width, height, channels] : {std::array{8, 8, 3}, std::array{5, 3, 1}, std::array{17, 1, 4}}) {
        const Image image = some_image(width, height, channels);
        const ImagePyramid pyramid = ImagePyramid::of(image);
        REQUIRE_FALSE(pyramid.levels.empty());
        CHECK(pyramid.levels.back().width == 1);
        CHECK(pyramid.levels.back().height == 1);
        for (const Image& level : pyramid.levels)
            for (int c = 0; c < channels; ++c)
                // Each level rounds to float once: at most six roundings of numbers below 1.
                CHECK(std::abs(mean_of(level, c) - mean_of(image, c)) <= 6 * 0x1p-24);
    }
}

TEST_CASE("texture filter: look-ups of a constant, of a tiny footprint and of a huge one", "[texture-filter]") {
    using raylex::transport::ImageFilter;
    using raylex::transport::TextureFilter;
    const Image image = some_image(12, 7, 3), grey{9, 5, 1, std::vector<float>(45, 0.375f)};
    const ImagePyramid pyramid = ImagePyramid::of(image), grey_pyramid = ImagePyramid::of(grey);
    for (const auto kind : {TextureFilter::bilinear, TextureFilter::point, TextureFilter::trilinear, TextureFilter::ewa,
                            TextureFilter::unfiltered}) {
        const ImageFilter filter{&pyramid, kind, 8}, of_grey{&grey_pyramid, kind, 8};
        const bool nearest = kind == TextureFilter::point;
        const raylex::transport::ImageSampler sampler{&image, raylex::transport::WrapMode::repeat, nearest, false},
            grey_sampler{&grey, raylex::transport::WrapMode::repeat, nearest, false};
        for (const Real size : {Real(0), Real(1e-6), Real(0.03), Real(0.3), Real(5), Real(1e30)})
            for (const Vec2 st : {Vec2{0.21f, 0.4f}, Vec2{-3.7f, 12.2f}})
                for (const auto& axes : {raylex::transport::TexelFootprint{{size, 0}, {0, size * 0.01f}},
                                         raylex::transport::TexelFootprint{{size, size}, {-0.2f * size, 0.1f * size}},
                                         raylex::transport::TexelFootprint{{size, 0}, {0, 0}}}) {
                    CAPTURE(static_cast<int>(kind), size);
                    // Weights sum to 1 up to the rounding of some hundred of them.
                    CHECK(std::abs(of_grey.real(grey_sampler, st, axes) - 0.375f) <= 1e-5f);
                    const auto value = filter.rgb(sampler, st, axes);
                    CHECK(value.r >= -1e-6f);
                    CHECK(value.r <= 1 + 1e-6f);
                    if (size == 0 || kind == TextureFilter::unfiltered) CHECK(value == sampler.rgb(st));
                    if (size == Real(1e30) && kind != TextureFilter::unfiltered)
                        for (int c = 0; c < 3; ++c)
                            CHECK(std::abs(static_cast<double>(value[c]) - mean_of(image, c)) <= 1e-5);
                }
    }
}

TEST_CASE("texture filter: footprints through every mapping are its derivatives", "[texture-filter]") {
    SurfaceFootprint seen{{0.3f, -0.2f, 0.5f}, {0.1f, 0.4f, -0.1f}, {0.02f, 0.03f}, {-0.01f, 0.05f}};
    TexturePoint at;
    at.u = 0.3f, at.v = 0.7f;
    at.position = {1.2f, -0.7f, 0.4f};
    at.footprint = &seen;
    for (const auto kind : {TextureMapping::Kind::uv, TextureMapping::Kind::spherical,
                            TextureMapping::Kind::cylindrical, TextureMapping::Kind::planar}) {
        TextureMapping mapping;
        mapping.kind = kind;
        mapping.scale_u = 3, mapping.scale_v = -2, mapping.offset_u = 0.25f;
        mapping.axis_u = {1, 2, 0}, mapping.axis_v = {0, -1, 3};
        mapping.texture_from_world = transport::Transform::rotate(30, 1, 2, 3) * transport::Transform::scale(1, 2, 0.5);
        const auto found = mapping.footprint(at);
        const auto difference = [&](const Vec3& along, const Vec2& uv) {
            const Real h = 1.0f / 256;
            TexturePoint before = at, after = at;
            before.position = before.position - along * h, after.position += along * h;
            before.u -= h * uv.x, after.u += h * uv.x;
            before.v -= h * uv.y, after.v += h * uv.y;
            const Vec2 a = mapping.map(before), b = mapping.map(after);
            return Vec2{(b.x - a.x) / (2 * h), (b.y - a.y) / (2 * h)};
        };
        CAPTURE(static_cast<int>(kind));
        for (const auto& [exact, numeric] : {std::pair{found.first, difference(seen.first, seen.first_uv)},
                                             std::pair{found.second, difference(seen.second, seen.second_uv)}}) {
            // Float coordinates of order 1 over a step of 1/128: 2^-23 x 128 and the third derivative's h^2.
            CHECK(std::abs(exact.x - numeric.x) <= 2e-4f);
            CHECK(std::abs(exact.y - numeric.y) <= 2e-4f);
        }
    }
}

TEST_CASE("texture filter: cones on planes, mirrors and balls", "[texture-filter]") {
    using namespace raylex::transport;
    const SurfaceTangents plane{{2, 0, 0}, {0, 4, 0}, {}, {}};
    SurfacePoint point;
    point.geometric_normal = point.shading_normal = {0, 0, 1};
    point.wo = {0.8f, 0, 0.6f};
    const SurfaceFootprint seen = footprint_of(plane, point, Real(0.03));
    CHECK(seen.first.x == Approx(0.05));  // over the cosine
    CHECK(seen.first_uv.x == Approx(0.025));
    CHECK(std::abs(seen.second.y) == Approx(0.03));
    CHECK(std::abs(seen.second_uv.y) == Approx(0.0075));
    CHECK(pixel_share(0) == 1);
    CHECK(pixel_share(3) == 0.5f);
    CHECK(pixel_share(63) == 0.125f);
    CHECK(pixel_share(100'000) == 0.125f);
    // Cameras without a vanishing point give all of the pixel as width, the others as spread: both shrink.
    const RayCone quarter = cone_of_sample({2, 1}, 15);
    CHECK(quarter.width == 0.5f);
    CHECK(quarter.spread == 0.25f);

    // A ball of radius 2 seen straight on: its normal turns by width / 2, the mirrored cone by twice that.
    const SceneDescription scene = scene_of("WorldBegin\nShape \"sphere\" \"float radius\" 2\n");
    TextureTable textures;
    auto geometry = EmbreeScene::build(scene, textures, {});
    REQUIRE(geometry.ok());
    Ray ray[1];
    ray[0].origin = {5, 0.01f, 0.02f};
    ray[0].direction = {-1, 0, 0};
    ray[0].cone.spread = 0.01f;
    Hit hit[1];
    geometry->intersect(ray, hit);
    REQUIRE(hit[0].valid());
    SurfacePoint on_ball[1];
    SurfaceSource source[1];
    geometry->surfaces(ray, hit, on_ball, source);
    BsdfSample mirror;
    mirror.delta = true;
    mirror.pdf = 1;
    const double width = 0.01 * 3;
    // 1e-3: the cosine of 0.01 of a radius beside the middle, and float.
    CHECK(scattered_cone(*geometry, hit[0], on_ball[0], mirror).spread == Approx(0.01 + 2 * width / 2).epsilon(1e-3));
    BsdfSample diffuse;
    diffuse.pdf = static_cast<Real>(1 / std::numbers::pi);
    CHECK(scattered_cone(*geometry, hit[0], on_ball[0], diffuse).spread == Approx(0.25));
}

TEST_CASE("texture filter: squares to the horizon become grey, and every filter is nearer to 1,024 samples",
          "[texture-filter][render]") {
    const import_test::Folder folder;
    const std::string image = checkers(folder, 8, 16);
    const std::vector<double> many = pixels_of(plain_to_the_horizon(image, "unfiltered", 1024));
    const double unfiltered = root_mean_square(pixels_of(plain_to_the_horizon(image, "unfiltered", 1)), many);
    for (const char* filter : {"bilinear", "trilinear", "EWA", "point"}) {
        const std::vector<double> one = pixels_of(plain_to_the_horizon(image, filter, 1));
        const double error = root_mean_square(one, many);
        CAPTURE(filter, error, unfiltered);
        CHECK(error < 0.7 * unfiltered);
        // Rows just below the horizon, where a pixel holds hundreds of squares: the mean of black and white. A light
        // path of diffuse floor and sky alone has no noise but the texture's.
        double highest = 0, lowest = 1;
        for (int y = 14; y < 16; ++y)
            for (int x = 0; x < 48; ++x) {
                const double value = one[3 * static_cast<std::size_t>(y * 48 + x)];
                if (value == 1) continue;  // the sky
                highest = std::max(highest, value), lowest = std::min(lowest, value);
            }
        REQUIRE(highest > 0);
        // Level sizes are whole and pixels are not: a hundredth at most is left of hundreds of squares.
        CHECK(lowest >= 0.49);
        CHECK(highest <= 0.51);
    }
}

TEST_CASE("texture filter: pbrt's option turns filtering off", "[texture-filter]") {
    using raylex::transport::Effect;
    const import_test::Folder folder;
    const std::string scene = plain_to_the_horizon(checkers(folder, 2, 1), "EWA", 1);
    const auto filters = [](const std::string& text) {
        return analyse_effects(scene_of(text))[static_cast<std::size_t>(Effect::texture_filtering)].called_for;
    };
    CHECK(filters(scene));
    CHECK(filters("Option \"bool disabletexturefiltering\" false\n" + scene));
    CHECK_FALSE(filters("Option \"bool disabletexturefiltering\" true\n" + scene));
}

TEST_CASE("texture filter: what cannot be filtered is said", "[texture-filter][law7]") {
    const import_test::Folder folder;
    const std::string image = checkers(folder, 2, 1);
    const auto refused = [&](const std::string& filter, const std::string& more) {
        const transport::SceneDescription scene =
            scene_of("WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + image +
                     "\" \"string filter\" \"" + filter + "\" " + more + "\n");
        const auto table = transport::TextureTable::build(scene);
        REQUIRE_FALSE(table.ok());
        return table.error().to_string();
    };
    const auto misspelled = transport::TextureTable::build(
        scene_of("WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + image +
                 "\" \"string filter\" \"trilinaer\"\n"));
    REQUIRE(misspelled.ok());
    REQUIRE(misspelled->warnings().size() == 1);
    CHECK(import_test::contains(misspelled->warnings()[0].to_string(), "did you mean 'trilinear'?"));
    CHECK(import_test::contains(refused("EWA", "\"float maxanisotropy\" 0.5"), "expected 1 or more"));
}
