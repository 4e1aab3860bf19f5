// Orthographic, spherical and realistic cameras: rays against connections, importance against finite differences,
// light paths against camera paths, lenses against optics in closed form.
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "transport/cameras/aperture.h"
#include "transport/cameras/camera.h"
#include "transport/cameras/lens_system.h"
#include "transport/math/sampling.h"
#include "transport/replicates.h"
#include "transport/samplers/pixel_sampler.h"
#include "transport/scene/typed_parameters.h"

using namespace raylex;
using namespace raylex::transport;

namespace cameras {

constexpr double pi_d = std::numbers::pi;

SceneEntity camera_of(const std::string& type, std::initializer_list<Parameter> parameters) {
    SceneEntity entity;
    entity.type = type;
    entity.location = {"test.pbrt", 3, 1};
    entity.parameters.parameters = parameters;
    for (Parameter& each : entity.parameters.parameters) each.location = entity.location;
    return entity;
}

/// A camera transform that rotates, mirrors and stretches by 1.5 x 2 x 0.7.
Transform crooked() {
    return Transform::look_at({1, 2, 3}, {0, 0.5, -1}, {0, 1, 0}).inverse() * Transform::scale(-1.5, 2, 0.7);
}

std::unique_ptr<Camera> made(const SceneEntity& entity, const CameraPlacement& placement) {
    std::vector<Error> warnings;
    auto camera = make_camera(entity, placement, warnings);
    INFO((camera ? std::string() : camera.error().to_string()));
    REQUIRE(camera.ok());
    CHECK(warnings.empty());
    return *std::move(camera);
}

/// A file that is removed at the end.
class TextFile {
  public:
    explicit TextFile(const std::string& text)
        : path_((std::filesystem::temp_directory_path() /
                 ("raylex_lens_" + std::to_string(std::random_device{}()) + ".dat"))
                    .string()) {
        std::ofstream(path_) << text;
    }
    ~TextFile() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    TextFile(const TextFile&) = delete;
    TextFile& operator=(const TextFile&) = delete;
    [[nodiscard]] const std::string& path() const { return path_; }

  private:
    std::string path_;
};

TEST_CASE("cameras connect a point of a ray to its raster position, with the raster area that it covers", "[camera]") {
    const SceneEntity kinds[] = {
        camera_of("orthographic", {typed::real("frameaspectratio", 1.5)}),
        camera_of("orthographic", {typed::real("lensradius", 0.3), typed::real("focaldistance", 4)}),
        camera_of("orthographic", {typed::numbers("screenwindow", ParameterType::real, {-2, 1, -0.5, 1.5}),
                                   typed::real("lensradius", 0)}),
        camera_of("spherical", {}), camera_of("spherical", {typed::text("mapping", "equirectangular")})};
    for (const SceneEntity& kind : kinds)
        for (const Transform& to_world : {Transform(), crooked()}) {
            CAPTURE(kind.type);
            const auto camera = made(kind, {to_world, 64, 48});
            for (std::uint64_t i = 0; i < 200; ++i) {
                const PixelSampler numbers(SamplerKind::sobol, 1, 0, 0, i);
                const Vec2 at = numbers.get_2d(0), lens = camera->has_lens() ? numbers.get_2d(1) : Vec2{0, 0};
                const Vec2 raster{2 + 60 * at.x, 2 + 44 * at.y};
                const Ray ray = camera->generate({raster.x, raster.y, lens});
                const Real distance = 1 + 4 * numbers.get_1d(2);
                const Vec3 point = ray.origin + ray.direction * distance;
                CameraConnection seen;
                REQUIRE(camera->connect(point, lens, 0, seen));
                // 1e-4 of a pixel per unit: raster positions are rounded to float; at poles angles are less accurate by
                // the sine.
                const Vec3 back = camera->generate({seen.x, seen.y, lens}).direction;
                CHECK(length(back - ray.direction) < 2e-5);
                CHECK(length(seen.position - ray.origin) < 2e-5f * (1 + length(point)));
                CHECK(camera->importance(point, seen.position, 0) ==
                      Approx(seen.importance).epsilon(1e-4));  // the position was rounded
                // Two steps across the ray span a parallelogram, whose raster area is computed.
                const Frame frame = Frame::from_normal(ray.direction);
                const Real step = 0.01f;
                CameraConnection s1, s2, t1, t2;
                if (!camera->connect(point + frame.s * step, lens, 0, s2) ||
                    !camera->connect(point - frame.s * step, lens, 0, s1) ||
                    !camera->connect(point + frame.t * step, lens, 0, t2) ||
                    !camera->connect(point - frame.t * step, lens, 0, t1))
                    continue;
                const double sx = s2.x - s1.x, sy = s2.y - s1.y, tx = t2.x - t1.x, ty = t2.y - t1.y;
                // The folds of the octahedral layout and the seam of the other mapping are within some steps.
                if (std::abs(sx) + std::abs(sy) + std::abs(tx) + std::abs(ty) > 12) continue;
                const double area = std::abs(sx * ty - sy * tx) / (4 * double{step} * double{step});
                if (kind.type == "spherical" && std::abs(area / double{seen.importance} - 1) > 0.02) {
                    // A step over a fold of the layout: the octant's edges and diagonals.
                    const Vec2 c{std::abs(2 * seen.x / 64 - 1), std::abs(2 * seen.y / 48 - 1)};
                    const Real near = 0.12f;
                    CHECK((std::abs(c.x + c.y - 1) < near || c.x < near || c.y < near || std::abs(c.x - c.y) < near ||
                           seen.y < 6 || seen.y > 42));
                    continue;
                }
                // Central differences with steps of 0.01 at distances of 1 and more; raster positions have 24 bits, so
                // differences over steps are less accurate.
                CHECK(area == Approx(seen.importance).epsilon(0.02));
            }
            CameraConnection seen;
            if (kind.type == "orthographic") {
                const Ray ray = camera->generate({20, 20, {0.5f, 0.5f}});
                CHECK_FALSE(camera->connect(ray.origin - ray.direction, {0.5f, 0.5f}, 0, seen));
                CHECK(camera->importance(ray.origin - ray.direction, ray.origin, 0) == 0);
            }
        }
}

TEST_CASE("spherical cameras have pbrt's directions and cover the sphere", "[camera]") {
    const auto equirectangular =
        made(camera_of("spherical", {typed::text("mapping", "equirectangular")}), {{}, 40, 20});
    // theta from +y down, phi from +x to +z.
    for (const auto& [x, y, direction] : {std::tuple{0.f, 10.f, Vec3{1, 0, 0}},
                                          {10.f, 10.f, Vec3{0, 0, 1}},
                                          {20.f, 10.f, Vec3{-1, 0, 0}},
                                          {0.f, 0.f, Vec3{0, 1, 0}},
                                          {5.f, 20.f, Vec3{0, -1, 0}}})
        CHECK(length(equirectangular->generate({x, y, {}}).direction - direction) < 1e-6f);
    const auto equal_area = made(camera_of("spherical", {}), {{}, 32, 32});
    CHECK(length(equal_area->generate({16, 16, {}}).direction - Vec3{0, 1, 0}) < 1e-6f);
    CHECK(length(equal_area->generate({0, 0, {}}).direction - Vec3{0, -1, 0}) < 1e-3f);
    // Outside the image the sphere continues: beyond the left edge at a quarter is the left edge at three quarters.
    CHECK(length(equal_area->generate({-0.5f, 8, {}}).direction - equal_area->generate({0.5f, 24, {}}).direction) <
          1e-5f);
    // The mean of pixels / importance over the raster is the whole solid angle.
    for (const Camera* camera : {equirectangular.get(), equal_area.get()}) {
        const double width = camera == equal_area.get() ? 32 : 40, height = camera == equal_area.get() ? 32 : 20;
        double sum = 0;
        constexpr int count = 4096;
        for (std::uint64_t i = 0; i < count; ++i) {
            const Vec2 at = PixelSampler(SamplerKind::sobol, 1, 0, 0, i).get_2d(0);
            const Ray ray = camera->generate({at.x * static_cast<Real>(width), at.y * static_cast<Real>(height), {}});
            sum += width * height / double{camera->importance(ray.origin + ray.direction, ray.origin, 0)};
        }
        CHECK(sum / count == Approx(4 * pi_d).epsilon(1e-3));  // 4096 Sobol' points of a smooth function
    }
}

TEST_CASE("integrators that trace paths from lights find the path tracer's image with every camera",
          "[camera][bdpt][lighttracer][render][statistical][gate]") {
    const std::string integrator = GENERATE("bdpt", "lighttracer");
    const std::string camera = GENERATE(
        "LookAt 0 2 3  0 0.3 0  0 1 0 Scale 0.7 0.7 0.7\nCamera \"orthographic\"\n",
        "LookAt 0 2 3  0 0.3 0  0 1 0\nCamera \"orthographic\" \"float lensradius\" 0.4 \"float focaldistance\" 3\n",
        "LookAt 0 0.7 1.4  0 0.5 0  0 1 0\nCamera \"spherical\"\n",
        "LookAt 0 0.7 1.4  0 0.5 0  0 1 0\nCamera \"spherical\" \"string mapping\" \"equirectangular\"\n");
    CAPTURE(camera);
    const std::string scene =
        render_test::plain_film + "PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5\n" + camera + R"(
WorldBegin
LightSource "point" "rgb I" [3 3 3] "point3 from" [-1 3 0]
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 -0.5 2 2 -0.5 2 2 -0.5 -2 -2 -0.5 -2]
AttributeBegin AreaLightSource "diffuse" "rgb L" [6 6 6] Translate 1 2 -1 Shape "sphere" "float radius" 0.3 AttributeEnd
AttributeBegin Translate 0 0.3 0 Shape "sphere" "float radius" 0.5 AttributeEnd
)";
    RenderSettings settings;
    settings.paths.max_depth = 2;
    settings.samples.per_pixel = 96;
    render_test::compare_with_path(scene, settings, render_test::integrator_named(integrator), 10, 96,
                                   {"C<RD>L", "C<RD><RD>L", "C.*L"});
}

TEST_CASE("the irradiance of a film behind a hole is that of the hole's solid angle", "[camera][render]") {
    // A stop of radius r at distance z before the film, and a white sky. In the middle E = pi r^2 / (r^2 + z^2). At
    // distance a from the middle E = pi/2 (1 - (a^2 + z^2 - r^2) / sqrt((a^2 + z^2 + r^2)^2 - 4 a^2 r^2)) (a disk's
    // configuration factor, Howell C-13).
    const TextFile lens("# a hole\n0 40 1 20\n");
    std::vector<Error> warnings;
    auto hole = LensSystem::read(lens.path(), 0, {}, {"test.pbrt", 1, 1}, warnings);
    REQUIRE(hole.ok());
    CHECK_FALSE(hole->focus(1, {"test.pbrt", 1, 1}).ok());  // a hole focuses nothing
    // So a weak lens is placed before the hole: 2 mm of index 1.0001, flat except for a radius of 100 m.
    const TextFile weak("100000 2 1.0001 60\n0 1 1 20\n0 40 1 200\n");
    CHECK(LensSystem::read(weak.path(), 0, {}, {"test.pbrt", 1, 1}, warnings).ok());
    for (const char* shape : {"circular", "square", "pentagon", "star", "gaussian"}) {
        const auto aperture = Aperture::named(shape, {"test.pbrt", 1, 1});
        REQUIRE(aperture.ok());
        double sum = 0;
        constexpr int n = 400;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) sum += aperture->transmittance((x + 0.5) * 2 / n - 1, (y + 0.5) * 2 / n - 1);
        // The same transmittance as the disk: pi/4 of the square, up to the cells at the edges.
        CHECK(sum / (n * n) == Approx(pi_d / 4).epsilon(0.01));
    }
    CHECK_FALSE(Aperture::named("no such.png", {"test.pbrt", 1, 1}).ok());
    // The orientation is pbrt's: the pentagon stands on a corner, and the star points to the left.
    const auto open_at = [](const char* shape, double x, double y) {
        return Aperture::named(shape, {"test.pbrt", 1, 1})->transmittance(x, y) > 0;
    };
    CHECK((open_at("pentagon", 0, -0.75) && !open_at("pentagon", 0, 0.75)));
    CHECK((open_at("star", -0.9, 0) && !open_at("star", 0.9, 0)));
    CHECK((open_at("star", -0.29, 0.88) && open_at("star", -0.29, -0.88)));
}

// A biconvex lens of 50 mm radii, 6 mm thick, index 1.5, and a stop behind it.
const char* const biconvex = "50 6 1.5 30  # front\n-50 2 1 30\n0 40 0 20\n";

TEST_CASE("a lens in focus makes the rays of a film point converge", "[camera]") {
    const TextFile file(biconvex);
    std::vector<Error> warnings;
    for (const double distance : {0.25, 0.5, 2.0, 50.0}) {
        auto lens = LensSystem::read(file.path(), 4e-3, {}, {"test.pbrt", 1, 1}, warnings);
        REQUIRE(lens.ok());
        REQUIRE(lens->focus(distance, {"test.pbrt", 1, 1}).ok());
        // Rays near the axis from the film's middle meet the axis at the focus. A height of 0.1 mm has a spherical
        // aberration of (0.1 / 50)^2 of the distance's curvature: below 1e-3 of it up to 2 m, and 1 / f of the farther
        // one.
        for (const double height : {1e-4, -2e-4}) {
            LensRay ray{{0, 0, 0}, normalize(DVec3{height, 0, lens->rear_z()})};
            REQUIRE(lens->trace(ray) == 1);
            const double z = ray.origin.z - ray.origin.x / ray.direction.x * ray.direction.z;
            CHECK(1 / z == Approx(1 / distance).margin(2e-3));
        }
        // The stop of 4 mm is used, not the file's 20 mm.
        LensRay outside{{0, 0, 0}, normalize(DVec3{2.1e-3, 0, lens->rear_z()})},
            within{{0, 0, 0}, normalize(DVec3{1.9e-3, 0, lens->rear_z()})};
        CHECK(lens->trace(outside) == 0);
        CHECK(lens->trace(within) == 1);
    }
    CHECK(warnings.empty());
    auto lens = LensSystem::read(file.path(), 4e-3, {}, {"test.pbrt", 1, 1}, warnings);
    const Status near = lens->focus(0.06, {"test.pbrt", 7, 1});
    REQUIRE_FALSE(near.ok());
    CHECK(near.error().line == 7);
    REQUIRE(LensSystem::read(file.path(), 30e-3, {}, {"test.pbrt", 7, 1}, warnings).ok());
    REQUIRE(warnings.size() == 1);  // more than the file's stop
}

TEST_CASE("the irradiance on a realistic camera's film is the lens's, and its pupils contain all rays", "[camera]") {
    const TextFile file(biconvex);
    const SceneEntity entity = camera_of(
        "realistic",
        {typed::text("lensfile", file.path()), typed::real("aperturediameter", 12), typed::real("focusdistance", 2)});
    const auto camera = made(entity, {crooked(), 60, 40, false, {}, 30});
    REQUIRE(camera->weighs_rays());
    std::vector<Error> warnings;
    auto lens = LensSystem::read(file.path(), 12e-3, {}, {"test.pbrt", 1, 1}, warnings);
    REQUIRE(lens->focus(2, {"test.pbrt", 1, 1}).ok());
    for (const Vec2& at : {Vec2{30, 20}, Vec2{3, 2}, Vec2{55, 20}}) {
        constexpr int count = 1 << 14;
        std::vector<CameraSample> samples;
        for (std::uint64_t i = 0; i < count; ++i)
            samples.push_back({at.x, at.y, PixelSampler(SamplerKind::sobol, 4, 0, 0, i).get_2d(0)});
        std::vector<Ray> rays(count);
        std::vector<Real> weights(count);
        camera->generate_weighed(samples, rays, weights);
        double mean = 0;
        for (std::size_t i = 0; i < count; ++i) {
            mean += double{weights[i]} / count;
            CHECK((weights[i] > 0) == (rays[i].t_max > 0));
            CHECK(is_finite(rays[i].direction));
        }
        // Computed with a grid over the whole plane of the last element, without pupils.
        const double film_x = 0.03 / std::sqrt(1 + 4.0 / 9), film_y = film_x * 2 / 3;
        const DVec3 from{(0.5 - double{at.x} / 60) * film_x, (double{at.y} / 40 - 0.5) * film_y, 0};
        double expected = 0;
        constexpr int n = 600;
        const double reach = 0.02, cell = 2 * reach / n;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                LensRay ray{
                    from, normalize(DVec3{(x + 0.5) * cell - reach, (y + 0.5) * cell - reach, lens->rear_z()} - from)};
                const double cosine = ray.direction.z;
                expected += lens->trace(ray) * std::pow(cosine, 4) * cell * cell / (lens->rear_z() * lens->rear_z());
            }
        CAPTURE(at.x, at.y);
        // The discretised edge of a pupil 300 cells across, and 2^14 points: 3e-3.
        CHECK(mean == Approx(expected).epsilon(3e-3));
        if (at.x == 30 && at.y == 20) {
            // The stop is the last element: pi r^2 / (r^2 + z^2).
            const double r2 = 6e-3 * 6e-3;
            CHECK(mean == Approx(pi_d * r2 / (r2 + lens->rear_z() * lens->rear_z())).epsilon(2e-3));
        }
    }
}

TEST_CASE("a realistic camera renders a white sky with its lens's irradiance, upright, and supports only path",
          "[camera][render]") {
    const TextFile file(biconvex);
    const std::string scene = R"(
Film "rgb" "integer xresolution" 12 "integer yresolution" 12 "float diagonal" 10
Sampler "sobol" "integer pixelsamples" 256
Camera "realistic" "float aperturediameter" 12 "float focusdistance" 2 "string lensfile" ")" +
                              file.path() + "\"\nWorldBegin\n";
    std::vector<Error> warnings;
    auto lens = LensSystem::read(file.path(), 12e-3, {}, {"test.pbrt", 1, 1}, warnings);
    REQUIRE(lens->focus(2, {"test.pbrt", 1, 1}).ok());
    const double r2 = 6e-3 * 6e-3, middle = pi_d * r2 / (r2 + lens->rear_z() * lens->rear_z());
    const auto sky =
        render_test::render_of(render_test::scene_of(scene + "LightSource \"infinite\" \"rgb L\" [2 2 2]"));
    const std::vector<double> image = sky.frame_buffer.resolve(sky.beauty);
    // 256 Sobol' points of a disk in its square have an error of about sqrt(4 / pi - 1) / 256^(3/4) = 0.8 %; four times
    // that.
    CHECK(image[3 * (6 * 12 + 6)] == Approx(2 * middle).epsilon(0.035));
    // The left half of the world is white: at +z the camera's left is -x.
    const auto left = render_test::render_of(
        render_test::scene_of(scene + "AreaLightSource \"diffuse\" \"rgb L\" [2 2 2] \"bool twosided\" true\n"
                                      "Shape \"bilinearmesh\" \"point3 P\" [-9 0 2 0 0 2 -9 9 2 0 9 2]"));
    const std::vector<double> half = left.frame_buffer.resolve(left.beauty);
    CHECK(half[3 * (3 * 12 + 3)] == Approx(2 * middle).epsilon(0.05));  // up and left; cos^4 within 2 mm of 50
    for (const std::size_t dark : {3 * 12 + 9, 9 * 12 + 3, 9 * 12 + 9}) CHECK(half[3 * dark] == 0);
    for (const char* integrator : {"bdpt", "lighttracer", "pssmlt"}) {
        RenderSettings settings;
        settings.paths.integrator = render_test::integrator_named(integrator);
        const auto refused =
            transport::render(render_test::scene_of(scene + "LightSource \"infinite\" \"rgb L\" [2 2 2]"), settings);
        REQUIRE_FALSE(refused.ok());
        CHECK(refused.error().message.find("camera 'realistic' cannot be used with") != std::string::npos);
        CHECK(refused.error().line == 4);
    }
}

TEST_CASE("errors of cameras and lens files name the cause", "[camera][law7]") {
    struct Case {
        std::string lens, message;
    };
    for (const Case& each :
         {Case{"", "no lens element"}, Case{"50 6 1.5\n", "3 numbers in a row"}, Case{"50 6 x 30\n", "found 'x'"},
          Case{"50 6 1.5 -30\n", "diameter"}, Case{"50 -6 1.5 30\n", "negative thickness"},
          Case{"50 6 0.5 30\n", "index below 1"}, Case{"50 6 1e999 30\n", "found '1e999'"},
          Case{"50 6 1e64 30\n", "index above 100"}, Case{"-1e200 6 1.5 30\n", "length above 1e12 mm"}}) {
        const TextFile file("# lens\n" + each.lens);
        std::vector<Error> warnings;
        const auto camera =
            make_camera(camera_of("realistic", {typed::text("lensfile", file.path())}), {{}, 4, 4}, warnings);
        REQUIRE_FALSE(camera.ok());
        CAPTURE(camera.error().to_string());
        CHECK(camera.error().message.find(each.message) != std::string::npos);
        CHECK(camera.error().file == file.path());
        CHECK(camera.error().line == (each.lens.empty() ? 0 : 2));
    }
    std::vector<Error> warnings;
    for (const SceneEntity& entity :
         {camera_of("realistic", {}), camera_of("spherical", {typed::text("mapping", "fisheye")}),
          camera_of("orthographic", {typed::numbers("screenwindow", ParameterType::real, {1, 1, 0, 1})}),
          camera_of("orthographic", {typed::real("frameaspectratio", -1)})}) {
        const auto camera = make_camera(entity, {{}, 4, 4}, warnings);
        REQUIRE_FALSE(camera.ok());
        CHECK(camera.error().file == "test.pbrt");
    }
}

}  // namespace cameras
