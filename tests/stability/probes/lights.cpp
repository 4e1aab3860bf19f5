// Lights: integrals of their samples, agreement of densities with samples, image environments with black parts.
#include "transport/lights/light_table.h"

#include "tests/stability/probes/draws.h"
#include "tests/stability/probes/probes.h"
#include "transport/cameras/camera.h"
#include "transport/import/pbrt/pbrt_importer.h"

namespace raylex::experiments {
namespace {

using namespace transport;

struct LitScene {
    EmbreeScene geometry;
    LightTable lights;
};

Result<LitScene> lit_scene(const std::string& text, const ProbeInput& input) {
    auto scene = import_pbrt_text("WorldBegin\n" + text, input.where().file);
    if (!scene) return scene.error();
    TextureTable textures;
    auto geometry = EmbreeScene::build(*scene, textures, {});
    if (!geometry) return geometry.error();
    std::vector<Error> warnings;
    auto lights = LightTable::build(*scene, *geometry, warnings);
    if (!lights) return lights.error();
    return LitScene{*std::move(geometry), *std::move(lights)};
}

std::string decimal(double v) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", v);
    return text;
}

/// Returns a light for the word "light": a shape above the origin in the plane z = distance, facing down, or another
/// light. Numbers: distance (2), size (1).
Result<std::string> light_text(const ProbeInput& input) {
    const std::string light = input.word("light");
    if (Status given = input.status(); !given) return given.error();
    const std::string d = decimal(input.number("distance", 2)), r = decimal(input.number("size", 1)), m = "-" + r;
    const std::string area = "AttributeBegin\nTranslate 0 0 " + d + "\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n";
    const std::string corners =
        "\"point3 P\" [" + m + " " + m + " 0  " + r + " " + m + " 0  " + m + " " + r + " 0  " + r + " " + r + " 0]";
    const std::string slanted =
        "\"point3 P\" [" + m + " " + m + " 0  " + r + " " + m + " 0  " + m + " " + r + " 0  0 0 " + r + "]";
    if (light == "sphere") return area + "Shape \"sphere\" \"float radius\" " + r + "\nAttributeEnd";
    if (light == "part-sphere")
        return area + "Shape \"sphere\" \"float radius\" " + r + " \"float phimax\" 250\nAttributeEnd";
    if (light == "inner-sphere")
        return area + "ReverseOrientation Shape \"sphere\" \"float radius\" " + r + "\nAttributeEnd";
    if (light == "ellipsoid") return area + "Scale 1 0.6 0.3 Shape \"sphere\" \"float radius\" " + r + "\nAttributeEnd";
    if (light == "disk") return area + "Rotate 180 1 0 0 Shape \"disk\" \"float radius\" " + r + "\nAttributeEnd";
    if (light == "cylinder")
        return area + "Rotate 90 1 0 0 Shape \"cylinder\" \"float radius\" " + r + " \"float zmin\" " + m +
               " \"float zmax\" " + r + "\nAttributeEnd";
    if (light == "triangle")
        return area + "Shape \"trianglemesh\" \"integer indices\" [0 2 1] " + corners + "\nAttributeEnd";
    if (light == "triangle-normals")
        return area +
               "Shape \"trianglemesh\" \"integer indices\" [0 2 1] \"normal N\" [1 0 -1  -1 0.5 -1  0 -1 -1  0 0 -1] " +
               corners + "\nAttributeEnd";
    if (light == "rectangle")
        return area + "Shape \"trianglemesh\" \"integer indices\" [0 2 1 1 2 3] " + corners + "\nAttributeEnd";
    if (light == "patch")
        return area + "Shape \"bilinearmesh\" \"integer indices\" [0 2 1 3] " + corners + "\nAttributeEnd";
    if (light == "slanted-patch")
        return area + "Shape \"bilinearmesh\" \"integer indices\" [0 2 1 3] " + slanted + "\nAttributeEnd";
    if (light == "point") return "LightSource \"point\" \"rgb I\" [1 1 1] \"point3 from\" [0 0 " + d + "]";
    if (light == "spot")
        return "LightSource \"spot\" \"rgb I\" [1 1 1] \"point3 from\" [0 0 " + d + "] \"point3 to\" [0 0 0]";
    if (light == "distant")
        return std::string("LightSource \"distant\" \"rgb L\" [1 1 1] \"point3 from\" [0 0 1] \"point3 to\" [0 0 0]");
    if (light == "sky") return std::string("LightSource \"infinite\" \"rgb L\" [1 1 1]");
    return error_at(input.where(), "unknown light '" + light + "'");
}

Vec3 probed_point(const ProbeInput& input) {
    return {static_cast<Real>(input.number("x", 0)), static_cast<Real>(input.number("y", 0)),
            static_cast<Real>(input.number("z", 0))};
}

struct Corner {
    double x, y;
};
/// Lambert's formula for a polygon in the plane z = d above `p`, seen from below: E = L/2 times the sum of edge angles
/// times the cosines of their planes.
double polygon_irradiance(const std::vector<Corner>& corners, double d, const DVec3& p) {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Corner &a = corners[i], &b = corners[(i + 1) % corners.size()];
        const DVec3 va = normalize(DVec3{a.x, a.y, d} - p), vb = normalize(DVec3{b.x, b.y, d} - p);
        const DVec3 n = cross(va, vb);
        const double sine = length(n);
        sum += sine > 0 ? std::atan2(sine, dot(va, vb)) * n.z / sine : 0;
    }
    return std::abs(sum) / 2;
}

/// Returns the unoccluded irradiance of the plane z = 0 at the point below the light, or nothing without a formula.
std::optional<double> irradiance_formula(const std::string& light, double d, double r, const DVec3& p) {
    const double h = d - p.z, aside = std::hypot(p.x, p.y);
    if (light == "sphere" && h > r) return exact_pi * r * r / (h * h + aside * aside) * h / std::hypot(h, aside);
    if (light == "inner-sphere") return exact_pi;
    if (light == "disk" && aside == 0) return exact_pi * r * r / (r * r + h * h);
    if (light.starts_with("triangle")) return polygon_irradiance({{-r, -r}, {r, -r}, {-r, r}}, d, p);
    if (light == "rectangle" || light == "patch") return polygon_irradiance({{-r, -r}, {r, -r}, {r, r}, {-r, r}}, d, p);
    if (light == "point") return h / std::pow(h * h + aside * aside, 1.5);
    if (light == "spot" && aside == 0) return 1 / (h * h);
    if (light == "distant") return 1;
    if (light == "sky") return exact_pi;
    return std::nullopt;
}

/// Samples a light with evenly distributed points in 8 shifts (Roberts' R2 lattice).
template <class Use>
ProbeResult mean_of_light_samples(const LitScene& scene, const Vec3& from, int samples, const Use& use) {
    Draws draws(7);
    RunningMean mean;
    for (int shift = 0; shift < 8; ++shift) {
        double a = draws.fine(), b = draws.fine(), sum = 0;
        for (int i = 0; i < samples / 8; ++i) {
            LightSample s;
            const Vec2 u{std::min(static_cast<Real>(a), one_minus_epsilon),
                         std::min(static_cast<Real>(b), one_minus_epsilon)};
            if (scene.lights.sample(scene.lights.chooser(LightChoice::light_sampling), scene.geometry, from,
                                    draws.one(), u, s))
                sum += use(s);
            a += 0.7548776662466927;
            b += 0.5698402909980532;
            a -= a >= 1 ? 1 : 0;
            b -= b >= 1 ? 1 : 0;
        }
        mean.add(sum / (samples / 8));
    }
    ProbeResult result;
    result.measured = mean.mean();
    result.standard_error = mean.standard_error();
    result.degrees = 7;
    return result;
}

Result<ProbeResult> light_irradiance(const ProbeInput& input) {
    auto text = light_text(input);
    if (!text) return text.error();
    auto scene = lit_scene(*text, input);
    if (!scene) return scene.error();
    const Vec3 from = probed_point(input);
    ProbeResult result = mean_of_light_samples(
        *scene, from, static_cast<int>(input.number("samples", 32768)),
        [](const LightSample& s) { return s.wi.z > 0 ? double(s.radiance.g) * double(s.wi.z) / double(s.pdf) : 0; });
    result.expected =
        irradiance_formula(input.word("light"), input.number("distance", 2), input.number("size", 1), DVec3(from));
    return result;
}

/// Returns the solid angle of a triangle (Van Oosterom and Strackee 1983).
double triangle_solid_angle(const DVec3& a, const DVec3& b, const DVec3& c) {
    const double la = length(a), lb = length(b), lc = length(c);
    return 2 *
           std::atan2(std::abs(dot(a, cross(b, c))), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

/// The mean of 1 / pdf is the solid angle of the samples.
Result<ProbeResult> light_solid_angle(const ProbeInput& input) {
    auto text = light_text(input);
    if (!text) return text.error();
    auto scene = lit_scene(*text, input);
    if (!scene) return scene.error();
    const Vec3 from = probed_point(input);
    ProbeResult result = mean_of_light_samples(*scene, from, static_cast<int>(input.number("samples", 32768)),
                                               [](const LightSample& s) { return 1 / double(s.pdf); });
    const std::string light = input.word("light");
    const double d = input.number("distance", 2), r = input.number("size", 1), h = d - double(from.z);
    const auto corner = [&](double x, double y) { return DVec3{x, y, d} - DVec3(from); };
    const DVec3 a = corner(-r, -r), b = corner(r, -r), c = corner(-r, r), e = corner(r, r);
    if (light == "sphere") {
        const double s2 = r * r / dot(DVec3{0, 0, d} - DVec3(from), DVec3{0, 0, d} - DVec3(from));
        result.expected = 2 * exact_pi * s2 / (1 + std::sqrt(1 - s2));
    }
    if (light == "disk") result.expected = 2 * exact_pi * r * r / (std::hypot(h, r) * (std::hypot(h, r) + h));
    if (light.starts_with("triangle")) result.expected = triangle_solid_angle(a, b, c);
    if (light == "rectangle" || light == "patch")
        result.expected = triangle_solid_angle(a, b, c) + triangle_solid_angle(b, c, e);
    return result;
}

struct Identity {
    double largest = 0;
    int compared = 0, elsewhere = 0;  ///< `elsewhere`: the sample's ray hit another primitive, or nothing
};

/// Compares the densities of sampled directions with the density for a scattering ray that hits the light.
Identity compare_densities(const LitScene& scene, const Vec3& from, int samples, double least_cosine) {
    Identity identity;
    Draws draws(9);
    for (int i = 0; i < samples; ++i) {
        LightSample s;
        const Real choice = draws.one();
        if (!scene.lights.sample(scene.lights.chooser(LightChoice::mis), scene.geometry, from, choice, draws.two(), s))
            continue;
        if (s.infinite || s.delta) {
            const double again = scene.lights.density(scene.lights.chooser(LightChoice::mis), scene.geometry, from, s);
            identity.largest = std::max(identity.largest, std::abs(again / double(s.pdf) - 1));
            ++identity.compared;
            continue;
        }
        Ray ray;
        ray.origin = from;
        ray.direction = s.wi;
        Hit hit;
        scene.geometry.intersect({&ray, 1}, {&hit, 1});
        if (!hit.valid() || scene.geometry.shapes()[hit.shape].first_light + hit.primitive != s.light) {
            ++identity.elsewhere;
            continue;
        }
        SurfacePoint point;
        SurfaceSource source;
        scene.geometry.surfaces({&ray, 1}, {&hit, 1}, {&point, 1}, {&source, 1});
        const double far_side = double(length(point.position - s.target)) / double(length(s.target - from));
        const double cosine = double(abs_dot(point.geometric_normal, s.wi));
        if (far_side > 1e-3 || cosine < least_cosine) {
            ++identity.elsewhere;
            continue;
        }
        const double again =
            scene.lights.density(scene.lights.chooser(LightChoice::mis), scene.geometry, s.light, from, point, hit);
        identity.largest = std::max(identity.largest, std::abs(again / double(s.pdf) - 1));
        ++identity.compared;
    }
    return identity;
}

Result<Identity> identity_of(const ProbeInput& input) {
    auto text = light_text(input);
    if (!text) return text.error();
    auto scene = lit_scene(*text, input);
    if (!scene) return scene.error();
    return compare_densities(*scene, probed_point(input), static_cast<int>(input.number("samples", 20000)),
                             input.number("least_cosine", 0.05));
}

Result<ProbeResult> light_pdf_identity(const ProbeInput& input) {
    auto identity = identity_of(input);
    if (!identity) return identity.error();
    ProbeResult result;
    result.measured = identity->compared > 0 ? identity->largest : INFINITY;
    result.expected = 0;
    result.note = std::to_string(identity->compared) + " compared, " + std::to_string(identity->elsewhere) +
                  " hit another primitive, nothing, or the light at a grazing angle";
    return result;
}

Result<ProbeResult> light_pdf_elsewhere(const ProbeInput& input) {
    auto identity = identity_of(input);
    if (!identity) return identity.error();
    ProbeResult result;
    result.measured = identity->elsewhere / double(std::max(1, identity->compared + identity->elsewhere));
    result.expected = 0;
    return result;
}

/// Compares directions of light samples with density() of the rays' hits, in cells around the direction of the light's
/// middle.
Result<ProbeResult> light_chi_squared(const ProbeInput& input) {
    auto text = light_text(input);
    if (!text) return text.error();
    auto scene = lit_scene(*text, input);
    if (!scene) return scene.error();
    const Vec3 from = probed_point(input);
    const double d = input.number("distance", 2), r = input.number("size", 1);
    // Beside the middle, because a silhouette along a ring of cells would contain all or none of a cell's points.
    const Vec3 aside{static_cast<Real>(0.4 * r), static_cast<Real>(0.3 * r), static_cast<Real>(d)};
    const Vec3 middle = normalize(aside - from);
    const LobeCells cells(middle, std::min(1.0, r / d), 10, 12);
    std::vector<double> expected = cells.integrate(
        [&](const Vec3& w) -> double {
            Ray ray;
            ray.origin = from;
            ray.direction = w;
            Hit hit;
            scene->geometry.intersect({&ray, 1}, {&hit, 1});
            if (!hit.valid()) return 0;
            SurfacePoint point;
            SurfaceSource source;
            scene->geometry.surfaces({&ray, 1}, {&hit, 1}, {&point, 1}, {&source, 1});
            const std::uint32_t light = scene->geometry.shapes()[hit.shape].first_light + hit.primitive;
            if (scene->lights.emitted(light, point, -w).is_black()) return 0;
            return scene->lights.density(scene->lights.chooser(LightChoice::mis), scene->geometry, light, from, point,
                                         hit);
        },
        static_cast<int>(input.number("grid", 60)));
    const auto samples = static_cast<int>(input.number("samples", 20000));
    std::vector<double> observed(expected.size() + 1);
    Draws draws(static_cast<std::uint64_t>(input.number("seed", 1)));
    for (int i = 0; i < samples; ++i) {
        LightSample s;
        const Real choice = draws.one();
        const bool any = scene->lights.sample(scene->lights.chooser(LightChoice::mis), scene->geometry, from, choice,
                                              draws.two(), s);
        observed[any ? cells.cell(s.wi) : observed.size() - 1] += 1;
    }
    const double integral = std::accumulate(expected.begin(), expected.end(), 0.0);
    expected.push_back(std::max(0.0, 1 - integral));
    for (double& e : expected) e *= samples;
    ProbeResult result;
    result.measured = chi_squared_deviation(observed, expected);
    result.expected = 0;
    result.note = "the density's integral is " + std::to_string(integral);
    return result;
}

/// Returns an environment for the word "image": flat, rows (every second one black), black-half, pixel (one lit), none.
/// Number: "resolution".
Result<EnvironmentImage> environment_of(const ProbeInput& input) {
    const std::string image = input.word("image");
    const auto n = static_cast<int>(input.number("resolution", 8));
    if (Status given = input.status(); !given) return given.error();
    std::vector<transport::Rgb> pixels(static_cast<std::size_t>(n * n));
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            Real value = static_cast<Real>(1 + (x * 7 + y * 3) % 5);
            if (image == "flat") value = 1;
            if (image == "rows" && y % 2 == 0) value = 0;
            if (image == "black-half" && y >= n / 2) value = 0;
            if (image == "pixel" && (x != n / 3 || y != n - 1)) value = 0;
            if (image == "none") value = 0;
            pixels[static_cast<std::size_t>(y * n + x)] = transport::Rgb(value);
        }
    return EnvironmentImage(n, std::move(pixels), Placement(Transform::rotate(40, 1, 1, 0)));
}

/// Compares counts of samples per pixel with the pixels' fractions of the light.
Result<ProbeResult> environment_chi_squared(const ProbeInput& input) {
    auto image = environment_of(input);
    if (!image) return image.error();
    const auto n = static_cast<std::size_t>(input.number("resolution", 8));
    const auto samples = static_cast<int>(input.number("samples", 100000));
    const Placement placement(Transform::rotate(40, 1, 1, 0));
    const auto pixel_of = [&](const Vec3& w) {
        const Vec2 uv = octahedral_from_direction(normalize(placement.to_object.vector(DVec3(w))).to_real());
        const auto cell = [&](Real v) { return std::min(static_cast<std::size_t>(v * static_cast<Real>(n)), n - 1); };
        return cell(uv.y) * n + cell(uv.x);
    };
    std::vector<double> expected(n * n), observed(n * n);
    for (std::size_t y = 0; y < n; ++y)
        for (std::size_t x = 0; x < n; ++x) {
            const Vec2 middle{(static_cast<Real>(x) + Real(0.5)) / static_cast<Real>(n),
                              (static_cast<Real>(y) + Real(0.5)) / static_cast<Real>(n)};
            const Vec3 w = normalize(placement.to_world.vector(DVec3(direction_from_octahedral(middle)))).to_real();
            expected[y * n + x] = double(image->pdf(w)) * 4 * exact_pi / double(n * n) * samples;
        }
    Draws draws(static_cast<std::uint64_t>(input.number("seed", 1)));
    int wrong = 0, none = 0, across = 0;
    for (int i = 0; i < samples; ++i) {
        Vec3 w;
        transport::Rgb radiance;
        Real pdf = 0;
        if (!image->sample(draws.two(), w, radiance, pdf)) {
            ++none;
            continue;
        }
        wrong += !(is_finite(w) && std::isfinite(pdf) && pdf > 0 && radiance.g > 0);
        across += image->pdf(w) != pdf;
        observed[pixel_of(w)] += 1;
    }
    ProbeResult result;
    result.measured = wrong > 0 ? INFINITY : chi_squared_deviation(observed, expected);
    if (none == samples) result.measured = image->mean_luminance() == 0 ? 0 : INFINITY;
    result.expected = 0;
    result.note =
        std::to_string(across) + " of " + std::to_string(samples) + " samples were rounded into another pixel";
    return result;
}

/// Returns the fraction of samples whose pdf differs from pdf() of their direction, which rounding moved to the next
/// pixel.
Result<ProbeResult> environment_identity(const ProbeInput& input) {
    auto image = environment_of(input);
    if (!image) return image.error();
    const auto samples = static_cast<int>(input.number("samples", 100000));
    Draws draws(2);
    double differ = 0;
    for (int i = 0; i < samples; ++i) {
        Vec3 w;
        transport::Rgb radiance;
        Real pdf = 0;
        if (image->sample(draws.two(), w, radiance, pdf)) differ += image->pdf(w) != pdf;
    }
    ProbeResult result;
    result.measured = differ / samples;
    result.expected = 0;
    return result;
}

/// Returns the mean irradiance by samples of an image, relative to that of its pixels.
Result<ProbeResult> environment_flux(const ProbeInput& input) {
    auto image = environment_of(input);
    if (!image) return image.error();
    const auto samples = static_cast<int>(input.number("samples", 100000));
    Draws draws(5);
    RunningMean mean;
    for (int i = 0; i < samples; ++i) {
        Vec3 w;
        transport::Rgb radiance;
        Real pdf = 0;
        mean.add(image->sample(draws.two(), w, radiance, pdf) ? double(radiance.g) / double(pdf) : 0);
    }
    ProbeResult result;
    result.measured = mean.mean();
    result.standard_error = mean.standard_error();
    result.expected = 4 * exact_pi * image->mean_luminance();
    return result;
}

/// Tests points of a lens in cells of its disk: 8 rings of equal area, 12 sectors.
Result<ProbeResult> lens_chi_squared(const ProbeInput& input) {
    SceneEntity entity;
    entity.type = "perspective";
    const double radius = input.number("radius", 0.5);
    for (const auto& [name, value] : {std::pair("lensradius", radius), std::pair("focaldistance", 3.0)}) {
        Parameter p;
        p.name = name;
        p.type = ParameterType::real;
        p.numbers = {value};
        entity.parameters.parameters.push_back(p);
    }
    std::vector<Error> warnings;
    auto camera = make_camera(entity, {Transform(), 64, 64}, warnings);
    if (!camera) return camera.error();
    constexpr int rings = 8, sectors = 12, samples = 100'000;
    std::vector<double> observed(rings * sectors), expected(rings * sectors, double(samples) / (rings * sectors));
    Draws draws(static_cast<std::uint64_t>(input.number("seed", 1)));
    int wrong = 0;
    for (int i = 0; i < samples; ++i) {
        const Real x = 64 * draws.one(), y = 64 * draws.one();
        const Ray ray = (*camera)->generate({x, y, draws.two()});
        const double px = double(ray.origin.x) / radius, py = double(ray.origin.y) / radius;
        const double angle = std::atan2(py, px) / (2 * exact_pi) + 0.5, r2 = px * px + py * py;
        wrong += !(is_finite(ray.direction) && r2 <= 1 + 1e-6);
        observed[static_cast<std::size_t>(std::min(static_cast<int>(r2 * rings), rings - 1) * sectors +
                                          std::min(static_cast<int>(angle * sectors), sectors - 1))] += 1;
    }
    ProbeResult result;
    result.measured = wrong > 0 ? INFINITY : chi_squared_deviation(observed, expected);
    result.expected = 0;
    return result;
}

}  // namespace

std::span<const NamedProbe> light_probes() {
    static constexpr NamedProbe table[] = {
        {"light_irradiance",
         "irradiance on z = 0 by light samples, unoccluded; light, distance, size, x, y, z, samples", light_irradiance},
        {"light_solid_angle", "mean of 1 / pdf over light samples; light, distance, size, x, y, z, samples",
         light_solid_angle},
        {"light_pdf_identity",
         "largest relative difference between a light sample's pdf and the density of its ray's hit; light, "
         "distance, "
         "size, x, y, z, samples, least_cosine",
         light_pdf_identity},
        {"light_pdf_elsewhere",
         "fraction of light samples whose ray does not hit their point; parameters as for light_pdf_identity",
         light_pdf_elsewhere},
        {"light_chi_squared",
         "excess of Pearson's chi-squared of directions against densities, in standard deviations; light, distance, "
         "size, "
         "x, y, z, samples, grid, seed",
         light_chi_squared},
        {"environment_chi_squared",
         "excess of chi-squared of an image environment, by pixels; image, resolution, samples, seed",
         environment_chi_squared},
        {"environment_pdf_identity",
         "fraction of samples that rounding moves to the next pixel; image, resolution, samples", environment_identity},
        {"environment_flux", "mean of radiance / pdf over samples of an image environment; image, resolution, samples",
         environment_flux},
        {"lens_chi_squared", "excess of chi-squared of points on the perspective camera's lens; radius, seed",
         lens_chi_squared}};
    return table;
}

}  // namespace raylex::experiments
