// Geometric AOVs of rendered analytic scenes. The box filter is so narrow that every sample passes through its pixel's
// centre, so that a pixel contains the function's value there, without averaging.
#include "transport/render_support.h"

#include <array>
#include <map>
#include <numbers>

#include "geoaovs/geoaovs.h"

using namespace render_test;

namespace {

using Values = std::vector<double>;

/// Points are floats of size at most 10 that pass two or three transforms.
constexpr double tolerance = 5e-6;

display::ChannelDefinition named(const std::string& name) {
    display::ChannelDefinition channel;
    channel.name = name;
    return channel;
}

std::vector<display::ChannelDefinition> all_aovs() {
    std::vector<display::ChannelDefinition> channels;
    for (const std::string& name : raylex::geoaovs::channel_names()) channels.push_back(named(name));
    return channels;
}

std::string header(int size, const std::string& camera = "") {
    const std::string side = std::to_string(size);
    return "Film \"rgb\" \"integer xresolution\" " + side + " \"integer yresolution\" " + side +
           "\nPixelFilter \"box\" \"float xradius\" 1e-6 \"float yradius\" 1e-6\n"
           "Sampler \"independent\" \"integer pixelsamples\" 2\n" +
           camera + "Camera \"perspective\" \"float fov\" 40\nWorldBegin\n";
}

/// All AOVs: [name] -> pixels.
std::map<std::string, Values> aovs_of(const std::string& text) {
    transport::RenderSettings settings;
    settings.channels.list = all_aovs();
    const auto output = render_of(scene_of(text), settings);
    CHECK(output.statistics.refused_services_calls == 0);
    std::map<std::string, Values> result;
    for (std::size_t i = 0; i < settings.channels.list.size(); ++i)
        result[settings.channels.list[i].name] = output.frame_buffer.resolve(static_cast<display::ChannelId>(i + 1));
    return result;
}

void check_values(const Values& found, const Values& expected, double margin = tolerance) {
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) CHECK(found[i] == Approx(expected[i]).margin(margin));
}

using Point = std::array<double, 3>;
double dot(const Point& a, const Point& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace

TEST_CASE("a sphere's AOVs match its equation in every pixel", "[geoaovs][render]") {
    // The default camera looks along +z from the origin, x to the right and y up: camera space is world space.
    const int size = 16;
    const double r = 2, pi = std::numbers::pi;
    const Point centre{0.5, -0.25, 7};
    const auto aovs = aovs_of(header(size) + "Translate 0.5 -0.25 7\nShape \"sphere\" \"float radius\" 2\n");
    int hits = 0;
    for (int pixel = 0; pixel < size * size; ++pixel) {
        const double t = std::tan(20 * pi / 180);
        const double x = (-1 + (2 * (pixel % size) + 1) / double(size)) * t;
        const double y = (1 - (2 * (pixel / size) + 1) / double(size)) * t, l = std::sqrt(x * x + y * y + 1);
        const Point d{x / l, y / l, 1 / l};
        const double b = dot(d, centre), discriminant = b * b - dot(centre, centre) + r * r;
        const auto value = [&](const std::string& name) {
            const Values& all = aovs.at(name);
            const std::size_t n = all.size() / static_cast<std::size_t>(size * size);
            const auto at = all.begin() + static_cast<std::ptrdiff_t>(n) * pixel;
            return Values(at, at + static_cast<std::ptrdiff_t>(n));
        };
        CAPTURE(pixel);
        if (discriminant < 0) {
            CHECK(std::isinf(value("z")[0]));
            CHECK(value("id")[0] == 0);
            CHECK(value("a")[0] == 0);
            CHECK(value("P") == Values{0, 0, 0});
            continue;
        }
        ++hits;
        const double distance = b - std::sqrt(discriminant);
        Point p, o, n;
        for (std::size_t i = 0; i < 3; ++i) {
            p[i] = distance * d[i];
            o[i] = p[i] - centre[i];
            n[i] = o[i] / r;
        }
        const Values normal(n.begin(), n.end()), position(p.begin(), p.end()), view{-d[0], -d[1], -d[2]};
        const double phi = std::atan2(o[1], o[0]) + (o[1] < 0 ? 2 * pi : 0), theta = std::acos(o[2] / r);
        // pbrt-v4: u = phi / (2 pi), v from -z to +z.
        const Values st{phi / (2 * pi), 1 - theta / pi, 0};
        const double rho = std::hypot(o[0], o[1]);
        for (const char* name : {"P", "Pw", "__Pworld"}) check_values(value(name), position);
        check_values(value("Po"), Values(o.begin(), o.end()));
        for (const char* name : {"Nn", "Ngn", "Non", "__Nworld"}) check_values(value(name), normal);
        for (const char* name : {"Vn", "__Vworld"}) check_values(value(name), view);
        check_values(value("VLen"), {distance});
        for (const char* name : {"z", "zback", "zfiltered"}) check_values(value(name), {p[2]});
        check_values(value("u"), {st[0]});
        check_values(value("v"), {st[1]});
        for (const char* name : {"st", "__st"}) check_values(value(name), st);
        check_values(value("Tn"), {-o[1] / rho, o[0] / rho, 0}, 1e-5);  // points are rounded, and rho can be small
        check_values(value("dPdu"), {-2 * pi * o[1], 2 * pi * o[0], 0}, 3e-5);
        check_values(value("dPdv"), {-pi * o[2] * o[0] / rho, -pi * o[2] * o[1] / rho, pi * rho}, 1e-4);
        check_values(value("curvature"), {1 / r});
        check_values(value("incidenceAngle"), {std::acos(-dot(n, d))}, 1e-4);  // acos loses half the digits at 0
        check_values(value("__depth"), {p[2], p[1], -dot(n, d)});
        check_values(value("outsideIOR"), {1});
        CHECK(value("id") == Values{1});
        CHECK(value("id2") == Values{0});
        CHECK(value("rawId") == Values{1});
        CHECK(value("a") == Values{1});
        CHECK(value("Oi") == Values{1, 1, 1});
        CHECK(value("wireframe") == Values{0});
        CHECK(value("time") == Values{0});
        CHECK(value("sampleCount") == Values{2});
        check_values(value("albedo"), {0.5, 0.5, 0.5});
    }
    CHECK(hits > 60);
}

TEST_CASE("curvature is half the sum of the principal curvatures, towards the viewer positive", "[geoaovs][render]") {
    const auto curvature = [](const std::string& shape, const std::string& camera = "") {
        return aovs_of(header(1, camera) + shape).at("curvature")[0];
    };
    const std::string sphere = "Shape \"sphere\" \"float radius\" 2\n";
    CHECK(curvature("Translate 0 0 9\n" + sphere) == Approx(0.5));
    CHECK(curvature(sphere) == Approx(-0.5));  // from inside
    CHECK(curvature("Translate 0 0 9\nReverseOrientation\n" + sphere) == Approx(0.5));
    // An ellipsoid with half axes 2, 2, 6 seen along its long axis: both curvatures are c / a^2.
    CHECK(curvature("Translate 0 0 20\nScale 1 1 3\n" + sphere) == Approx(6.0 / 4));
    // Seen across it: 1 / a around and a / c^2 along.
    CHECK(curvature("Translate 0 0 20\nRotate 90 1 0 0\nScale 1 1 3\n" + sphere) == Approx((0.5 + 2.0 / 36) / 2));
    // With an instance.
    CHECK(curvature("ObjectBegin \"o\"\n" + sphere +
                    "ObjectEnd\nTranslate 0 0 20\nRotate 90 1 0 0\nScale 1 1 3\n"
                    "ObjectInstance \"o\"\n") == Approx((0.5 + 2.0 / 36) / 2));
    const std::string cylinder = "Shape \"cylinder\" \"float radius\" 4 \"float zmin\" -3 \"float zmax\" 3\n";
    CHECK(curvature("Translate 0 0 20\nRotate 90 1 0 0\n" + cylinder) == Approx(1.0 / 8));
    CHECK(curvature("Translate 0 0 20\nShape \"disk\" \"float radius\" 3\n") == 0);
    // z = x y over [-1, 1]^2: 2 H = -2 x y / (1 + x^2 + y^2)^(3/2) about the upward normal, so it bulges upwards where
    // x y > 0. Seen straight down on (0.5, 0.25).
    const std::string saddle = "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 1 1 -1 -1 -1 1 -1 1 1 1]\n";
    const double expected = 0.125 / std::pow(1 + 0.25 + 0.0625, 1.5);
    CHECK(curvature(saddle, "LookAt 0.5 0.25 9  0.5 0.25 0  0 1 0\n") == Approx(expected));
    CHECK(curvature(saddle, "LookAt 0.5 0.25 -9  0.5 0.25 0  0 1 0\n") == Approx(-expected));
    // A triangle whose vertices and normals lie on a sphere of radius 3. The normal N = p / 3 of a point turns with its
    // direction, so the curvature is 1 / (3 |N|); at the middle |N|^2 is 1/3 of (1, 1, 1) / sqrt(3) squared.
    const double n = std::sqrt(1.0 / 3);
    CHECK(curvature("Shape \"trianglemesh\" \"point3 P\" [3 0 0 0 3 0 0 0 3] \"normal N\" [1 0 0 0 1 0 0 0 1]\n",
                    "LookAt 9 9 9  0 0 0  0 1 0\n") == Approx(1 / (3 * n)));
    CHECK(curvature("Shape \"trianglemesh\" \"point3 P\" [3 0 0 0 3 0 0 0 3]\n", "LookAt 9 9 9  0 0 0  0 1 0\n") == 0);
}

TEST_CASE("derivatives, object space and parameters of meshes, patches and disks", "[geoaovs][render]") {
    // A rectangle of 4 x 2, placed by a transform; texture coordinates are twice x and y.
    const std::string place = "Translate 1 0 8\nScale 2 1 1\n";
    const std::string points = "\"point3 P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"point2 uv\" [0 0 8 0 8 4 0 4]";
    const auto mesh =
        aovs_of(header(1) + place + "Shape \"trianglemesh\" " + points + " \"integer indices\" [0 1 2 0 2 3]\n");
    check_values(mesh.at("P"), {0, 0, 8});
    check_values(mesh.at("Po"), {-0.5, 0, 0});
    check_values(mesh.at("st"), {2, 2, 0});
    check_values(mesh.at("dPdu"), {0.5, 0, 0});
    check_values(mesh.at("dPdv"), {0, 0.5, 0});
    check_values(mesh.at("Tn"), {1, 0, 0});
    // (-0.5, 0) is 0.5 of vertex 0, 0.25 of 2 and 0.25 of 3 (the second triangle): u and v are the weights of the
    // latter two.
    check_values(mesh.at("u"), {0.25});
    check_values(mesh.at("v"), {0.25});
    const auto patch = aovs_of(header(1) + place +
                               "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0] "
                               "\"point2 uv\" [0 0 8 0 0 4 8 4]\n");
    for (const char* name : {"P", "Po", "st", "dPdu", "dPdv", "Tn"}) check_values(patch.at(name), mesh.at(name));
    check_values(patch.at("u"), {0.25});
    check_values(patch.at("v"), {0.5});
    // Without coordinates a triangle has (0,0), (1,0), (1,1): s increases from the first vertex to the second.
    const auto bare = aovs_of(header(1) + "Shape \"trianglemesh\" \"point3 P\" [-4 -3 8 4 -3 8 4 5 8]\n");
    check_values(bare.at("dPdu"), {8, 0, 0});
    check_values(bare.at("dPdv"), {0, 8, 0});
    check_values(bare.at("st"), {0.5, 0.375, 0});
    // A disk of radius 5 with a hole of 1, hit 2 to the left of its centre: v increases inwards over 4.
    const auto disk =
        aovs_of(header(1) + "Translate 2 0 8\nShape \"disk\" \"float radius\" 5 \"float innerradius\" 1\n");
    check_values(disk.at("Po"), {-2, 0, 0});
    check_values(disk.at("dPdv"), {4, 0, 0});
    check_values(disk.at("st"), {0.5, 0.75, 0});
    const auto cylinder = aovs_of(
        header(1) + "Translate 0 1 8\nRotate 90 1 0 0\nShape \"cylinder\" \"float zmin\" -3 \"float zmax\" 3\n");
    CHECK(std::abs(cylinder.at("dPdv")[1]) == Approx(6));
    check_values(cylinder.at("P"), {0, 0, 7});
}

TEST_CASE("ids distinguish instances, their parts and their surfaces", "[geoaovs][render]") {
    const std::string scene = header(1) +
                              "AttributeBegin\nTranslate 0 0 -50\nShape \"sphere\"\nAttributeEnd\n"
                              "ObjectBegin \"pair\"\nTranslate 100 0 0\nShape \"sphere\"\nTranslate -100 0 0\n"
                              "Shape \"sphere\" \"float radius\" 0.5\nObjectEnd\n"
                              "AttributeBegin\nTranslate 0 0 -80\nObjectInstance \"pair\"\nAttributeEnd\n"
                              "Translate 0 0 10\nScale 3 3 3\nObjectInstance \"pair\"\n";
    const auto aovs = aovs_of(scene);
    CHECK(aovs.at("id") == Values{3});     // one shape, then two instances
    CHECK(aovs.at("id2") == Values{2});    // the object's second shape
    CHECK(aovs.at("rawId") == Values{5});  // 1 + 2 + 2
    check_values(aovs.at("P"), {0, 0, 8.5});
    check_values(aovs.at("Po"), {0, 0, -0.5});
    check_values(aovs.at("curvature"), {1 / 1.5});
}

TEST_CASE("inside glass the index on the camera's side is the glass's", "[geoaovs][render]") {
    const std::string glass = "Material \"dielectric\" \"float eta\" 1.4\nShape \"sphere\" \"float radius\" 2\n";
    check_values(aovs_of(header(1) + glass).at("outsideIOR"), {1.4});
    check_values(aovs_of(header(1) + "Translate 0 0 9\n" + glass).at("outsideIOR"), {1});
}

TEST_CASE("the wireframe is a line of one pixel", "[geoaovs][render]") {
    // A triangle whose sides are 0.6, 0.6 and 0.6 sqrt(2) of the image's width, 40 degrees over 64 pixels, seen at an
    // angle: only screen positions matter. Its lines cover about their length in pixels; corners are counted twice.
    const double t = std::tan(20 * std::numbers::pi / 180);
    const auto corner = [&](double x, double y, double z) {
        return std::to_string(x * t * z) + " " + std::to_string(y * t * z) + " " + std::to_string(z) + " ";
    };
    const std::string film =
        "Film \"rgb\" \"integer xresolution\" 64 \"integer yresolution\" 64\n"
        "PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5\n"
        "Sampler \"independent\" \"integer pixelsamples\" 16\n"
        "Camera \"perspective\" \"float fov\" 40\nWorldBegin\n";
    const auto aovs = aovs_of(film + "Shape \"trianglemesh\" \"point3 P\" [" + corner(-0.6, -0.6, 5) +
                              corner(0.6, -0.6, 9) + corner(-0.6, 0.6, 12) + "]\n");
    double sum = 0, area = 0;
    for (const double v : aovs.at("wireframe")) sum += v;
    for (const double v : aovs.at("a")) area += v;
    const double side = 0.6 * 64, length = side * (2 + std::sqrt(2.0));
    // Half of every line's width lies outside the triangle. 16 x 65 independent samples decide at the line: 3 per cent;
    // the error at corners is about one pixel each.
    CHECK(sum == Approx(length / 2).epsilon(0.05));
    CHECK(area == Approx(side * side / 2).epsilon(0.01));
}

TEST_CASE("requesting every AOV keeps the beauty's bits, and threads affect only cpuTime", "[geoaovs][law2][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    raylex::transport::SceneEntity clamp;
    clamp.type = "clamp";
    settings.channels.sample_filters = {clamp};
    const auto alone = render_of(scene, settings);
    settings.channels.list = all_aovs();
    settings.machine.threads = 1;
    const auto one = render_of(scene, settings);
    settings.machine.threads = 3;
    const auto three = render_of(scene, settings);
    CHECK(one.frame_buffer.resolve(one.beauty) == alone.frame_buffer.resolve(alone.beauty));
    double seconds = 0;
    for (std::size_t i = 0; i < settings.channels.list.size(); ++i) {
        const auto id = static_cast<display::ChannelId>(i + 1);
        CAPTURE(settings.channels.list[i].name);
        const Values values = one.frame_buffer.resolve(id);
        if (settings.channels.list[i].name == "cpuTime") {
            for (const double v : values) seconds += v;
            CHECK(*std::min_element(values.begin(), values.end()) > 0);
            continue;
        }
        CHECK(values == three.frame_buffer.resolve(id));
        if (settings.channels.list[i].name == "Ci") CHECK(values == one.frame_buffer.resolve(one.beauty));
        if (settings.channels.list[i].name == "a") CHECK(values == one.frame_buffer.resolve_alpha());
    }
    CHECK(seconds > 0);
    CHECK(seconds <= one.statistics.render_cpu_seconds);
}

TEST_CASE("without channels of light, materials are evaluated only for AOVs that need more than geometry",
          "[geoaovs][render][law4]") {
    const auto scene = scene_of(room);
    const auto rendered = [&](std::vector<display::ChannelDefinition> channels, bool beauty) {
        transport::RenderSettings settings;
        settings.samples.per_pixel = 16;
        settings.channels.list = std::move(channels);
        settings.channels.beauty = beauty;
        return render_of(scene, settings);
    };
    const auto closures = [](const transport::RenderOutput& output) {
        return output.statistics.pruned[static_cast<std::size_t>(transport::Pruned::closures)];
    };
    std::vector<display::ChannelDefinition> of_geometry;
    for (const display::ChannelDefinition& channel : all_aovs())
        if (channel.name != "albedo" && channel.name != "outsideIOR" && channel.name != "cpuTime" &&
            channel.name != "Ci")
            of_geometry.push_back(channel);
    const auto check_same = [&](const transport::RenderOutput& with, const transport::RenderOutput& without,
                                std::size_t channels) {
        for (std::size_t i = 0; i < channels; ++i) {
            CAPTURE(of_geometry[i].name);
            CHECK(without.frame_buffer.resolve(static_cast<display::ChannelId>(i)) ==
                  with.frame_buffer.resolve(static_cast<display::ChannelId>(i + 1)));
        }
    };
    const auto full = rendered(of_geometry, true), alone = rendered(of_geometry, false);
    CHECK(closures(full) == 0);
    check_same(full, alone, of_geometry.size());
    double hits = 0;
    for (const double alpha : alone.frame_buffer.resolve_alpha()) hits += alpha;
    const double samples = static_cast<double>(alone.statistics.camera_samples);
    const double pixels = samples / 16;
    // All hits of camera rays; alpha is their mean, with 16 samples a pixel.
    CHECK(static_cast<double>(closures(alone)) == Approx(hits / pixels * samples));
    for (const char* name : {"albedo", "outsideIOR"}) {
        std::vector<display::ChannelDefinition> more = of_geometry;
        more.push_back(named(name));
        const auto with_more = rendered(more, false);
        CHECK(closures(with_more) == 0);
        CHECK(with_more.frame_buffer.resolve(static_cast<display::ChannelId>(more.size() - 1)) ==
              rendered(more, true).frame_buffer.resolve(static_cast<display::ChannelId>(more.size())));
        check_same(full, with_more, of_geometry.size());
    }
    // Light that the camera sees directly needs no material; light seen through mirrors needs mirrors only.
    for (const char* expression : {"CL", "CS+L", "CD[DS]*L"}) {
        CAPTURE(expression);
        std::vector<display::ChannelDefinition> with_light = of_geometry;
        with_light.push_back(lpe_channel("light", expression));
        const auto lit = rendered(with_light, false);
        check_same(full, lit, of_geometry.size());
        // Walls are not mirrors, and the metal wall is not diffuse.
        CHECK(closures(lit) > 0);
        CHECK((closures(lit) == closures(alone)) == (std::string(expression) == "CL"));
        CHECK(closures(lit) <= closures(alone));
    }
}
