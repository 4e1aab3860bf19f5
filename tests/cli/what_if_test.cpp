// raylex ask --what-if, --light and --mix: other lights and colours without a render.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/experiments/support.h"

using namespace raylex;
using namespace raylex::test;

namespace {

using Color = std::array<double, 3>;

/// The colours of the scene below, which tests change.
struct Colors {
    Color floor{.6, .5, .4}, wall{.3, .4, .6}, leaf{.3, .4, .2}, through{.2, .4, .3}, lamp{5, 5, 4}, bulb{2, 2, 3};
};

std::string text(const Color& color) {
    std::ostringstream out;
    out.precision(17);
    out << '[' << color[0] << ' ' << color[1] << ' ' << color[2] << ']';
    return out.str();
}

/// A floor, a wall and a leaf that transmits light, with a lamp of group key and a point light without a group.
std::string scene(const Colors& colors) {
    const auto material = [](const std::string& name, const std::string& type) {
        return "MakeNamedMaterial \"" + name + "\" \"string type\" \"" + type + "\" \"rgb reflectance\" ";
    };
    const std::string quad = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" ";
    return R"(Film "rgb" "integer xresolution" 14 "integer yresolution" 10
Sampler "independent" "integer pixelsamples" 64
PixelFilter "box"
Integrator "path" "integer maxdepth" 4
LookAt 0 1.2 4  0 0.8 0  0 1 0
Camera "perspective" "float fov" 55
WorldBegin
LightSource "point" "rgb I" )" +
           text(colors.bulb) + " \"point3 from\" [0 3 1]\n" + material("floor", "diffuse") + text(colors.floor) + "\n" +
           material("wall", "diffuse") + text(colors.wall) + "\n" + material("leaf", "diffusetransmission") +
           text(colors.leaf) + " \"rgb transmittance\" " + text(colors.through) +
           "\nMakeNamedMaterial \"ball\" \"string type\" \"coateddiffuse\" \"rgb reflectance\" [.5 .4 .3]\n" +
           "NamedMaterial \"floor\"\n" + quad + "[-2 0 2 2 0 2 2 0 -2 -2 0 -2]\nNamedMaterial \"wall\"\n" + quad +
           "[-2 0 -2 2 0 -2 2 2 -2 -2 2 -2]\nNamedMaterial \"leaf\"\n" + quad +
           "[-1 .7 1 0 .7 1 0 .9 0 -1 .9 0]\nNamedMaterial \"ball\"\nAttributeBegin\nTranslate 1 .3 .5\n"
           "Shape \"sphere\" \"float radius\" .3\nAttributeEnd\nAreaLightSource \"diffuse\" \"rgb L\" " +
           text(colors.lamp) + "\n" + quad + "[.3 2 -1 1.3 2 -1 1.3 1.2 -1 .3 1.2 -1]\n";
}

struct WhatIfFolder : Folder {
    /// Renders `name`.exr and `name`.atlas.exr.
    void render(const std::string& name, const Colors& colors, int seed, const std::string& more = {}) const {
        write(name + ".pbrt", scene(colors));
        write(name + ".toml",
              "[scene]\nfile = \"" + name + ".pbrt\"\n[[light_group]]\nlight = \"area:0\"\ngroup = \"key\"\n");
        run("render " + name + ".toml --seed " + std::to_string(seed) + " -o " + name + ".exr --atlas " + name +
            ".atlas.exr " + more);
    }
    Outcome run(const std::string& arguments) const {
        Outcome outcome = run_raylex(*this, arguments);
        INFO(arguments << "\n" << outcome.out << outcome.err);
        REQUIRE(outcome.code == 0);
        return outcome;
    }
    [[nodiscard]] display::ExrImage image(const std::string& name) const {
        auto read = display::read_exr(path(name));
        REQUIRE(read);
        return *std::move(read);
    }
};

/// The mean of a layer over the image and (R, G, B), and the standard error of it: pixels are independent.
struct Measured {
    double mean = 0, error = 0;
};
Measured measured(const display::ExrImage& image, const std::string& layer) {
    Measured result;
    const std::string error_name = (layer.empty() ? "beauty" : layer) + "_error";
    const std::vector<float> errors = test::plane(image, error_name, error_name);
    const auto pixels = static_cast<double>(errors.size());
    for (const char* component : {"R", "G", "B"})
        for (const float value : test::plane(image, layer, component))
            result.mean += static_cast<double>(value) / (3 * pixels);
    double variance = 0;
    for (const float error : errors) variance += static_cast<double>(error) * static_cast<double>(error);
    result.error = std::sqrt(variance) / pixels;
    return result;
}

}  // namespace

TEST_CASE("factors of 1 give the bits of an ask without them", "[atlas][gate]") {
    const WhatIfFolder folder;
    folder.render("a", {}, 1);
    for (const std::string layers : {"--partition shipped --light-groups --errors", "--lpe d=CDL"}) {
        folder.run("ask a.atlas.exr " + layers + " -o plain.exr");
        folder.run("ask a.atlas.exr " + layers + " --what-if floor.D=1 --what-if leaf=1,1,1 --light key=1 -o ones.exr");
        CHECK(image_bits(folder.path("ones.exr")) == image_bits(folder.path("plain.exr")));
    }
    folder.run("ask a.atlas.exr --light key=1 -o beauty.exr");
    for (const char* component : {"R", "G", "B", "A"})
        CHECK(plane(folder.image("beauty.exr"), "", component) == plane(folder.image("a.exr"), "", component));
}

TEST_CASE("ask mixes lights as mix does, and every partition sums", "[atlas][law1][gate]") {
    const WhatIfFolder folder;
    folder.render("a", {}, 1, "--light-groups");
    folder.write("m.toml", "[light]\nkey = [2, 0.5, 0]\ndefault = \"+1 stop\"\n");
    folder.run("mix a.exr --mix m.toml -o mixed.exr");
    folder.run("ask a.atlas.exr --mix m.toml --light-groups --partition shipped -o asked.exr");
    const auto mixed = folder.image("mixed.exr"), asked = folder.image("asked.exr");
    for (const std::string layer : {"", "light_key", "light_default"})
        for (const char* component : {"R", "G", "B"}) {
            const auto a = plane(mixed, layer, component), b = plane(asked, layer, component);
            for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == Approx(b[i]).epsilon(1e-6).margin(1e-9));
        }
    CHECK(folder.run("verify asked.exr").code == 0);
    CHECK(asked.attributes.at("raylex/mix") == "default=2,2,2 key=2,0.5,0");
    // Without the floor's reflection, light that met it is gone, and all other light is as it was.
    folder.run(
        "ask a.atlas.exr --what-if floor=0 --lpe 'floor=C.*<.D'\"'floor'\"'>.*L' "
        "--lpe 'direct=C<RD'\"'wall'\"'>L' -o dark.exr");
    folder.run("ask a.atlas.exr --lpe 'floor=C.*<.D'\"'floor'\"'>.*L' --lpe 'direct=C<RD'\"'wall'\"'>L' -o light.exr");
    const auto dark = folder.image("dark.exr"), light = folder.image("light.exr");
    for (const char* component : {"R", "G", "B"}) {
        CHECK(plane(dark, "direct", component) == plane(light, "direct", component));
        const auto without = plane(dark, "", component), floor = plane(light, "floor", component),
                   all = plane(light, "", component);
        double sum = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            CHECK(without[i] == Approx(all[i] - floor[i]).margin(1e-6));
            sum += static_cast<double>(floor[i]);
        }
        CHECK(sum > 0);
        for (const float value : plane(dark, "floor", component)) CHECK(value == 0);
    }
}

TEST_CASE("the gradient of the beauty by a factor is the sum of k times the light of k hits", "[atlas][gate]") {
    const WhatIfFolder folder;
    folder.render("a", {}, 1);
    // h is a power of two, so the factors are exact.
    constexpr double h = 1.0 / 16;
    constexpr int most_hits = 5;
    std::string at_least, hits = "C";
    for (int k = 1; k <= most_hits; ++k) {
        hits += ".*<.D'\"'floor'\"'>";
        at_least += " --lpe 'hits" + std::to_string(k) + "=" + hits + ".*L'";
    }
    folder.run("ask a.atlas.exr" + at_least + " -o layers.exr");
    folder.run("ask a.atlas.exr --what-if floor.D=1.0625 -o more.exr");
    folder.run("ask a.atlas.exr --what-if floor.D=0.9375 -o less.exr");
    const auto layers = folder.image("layers.exr"), more = folder.image("more.exr"), less = folder.image("less.exr");
    double largest = 0, twice = 0;
    for (const char* component : {"R", "G", "B"}) {
        const auto up = plane(more, "", component), down = plane(less, "", component);
        std::vector<std::vector<float>> of_hits;
        for (int k = 1; k <= most_hits; ++k) of_hits.push_back(plane(layers, "hits" + std::to_string(k), component));
        for (std::size_t i = 0; i < up.size(); ++i) {
            double gradient = 0, remainder = 0, value = static_cast<double>(up[i]) + static_cast<double>(down[i]);
            for (int k = 1; k <= most_hits; ++k) {
                const auto light = [&](int least) {
                    return least > most_hits ? 0.0
                                             : static_cast<double>(of_hits[static_cast<std::size_t>(least - 1)][i]);
                };
                const double exact = light(k) - light(k + 1);
                gradient += k * exact;
                remainder += ((std::pow(1 + h, k) - std::pow(1 - h, k)) / (2 * h) - k) * exact;
                value += k * std::abs(exact);
            }
            const double difference = (static_cast<double>(up[i]) - static_cast<double>(down[i])) / (2 * h);
            // Each of the values is rounded to float, by at most 2^-24 of it, and the difference divides this by 2 h.
            CHECK(std::abs(difference - gradient - remainder) <= std::ldexp(value, -24) / (2 * h));
            largest = std::max(largest, gradient);
            twice = std::max(twice, static_cast<double>(of_hits[1][i]));
        }
    }
    CHECK(largest > 0.01);
    CHECK(twice > 1e-4);  // k is not 1 everywhere: some light met the floor twice
}

TEST_CASE("20 edits of an atlas agree with renders of the edited scenes, within their intervals",
          "[atlas][statistical][release-only][gate]") {
    const WhatIfFolder folder;
    std::mt19937 random(7);
    const auto factor = [&] {
        Color color{};
        for (double& each : color) each = std::uniform_real_distribution<double>(0, 1.4)(random);
        return color;
    };
    const auto times = [](Color& color, const Color& by) {
        for (std::size_t c = 0; c < 3; ++c) color[c] *= by[c];
    };
    const auto option = [](const Color& by) {
        std::ostringstream out;
        out.precision(17);
        out << by[0] << ',' << by[1] << ',' << by[2];
        return out.str();
    };
    constexpr int edits = 20;
    int agree = 0, compared = 0, pixels_agree = 0, pixels = 0;
    for (int edit = 0; edit < edits; ++edit) {
        const Color floor = factor(), wall = factor(), leaf = factor(), through = factor(), key = factor(),
                    bulb = factor();
        Colors colors;
        folder.render("before", colors, 100 + edit, "--spp 1024");
        times(colors.floor, floor);
        times(colors.wall, wall);
        times(colors.leaf, leaf);
        times(colors.through, through);
        times(colors.lamp, key);
        times(colors.bulb, bulb);
        folder.render("after", colors, 200 + edit, "--spp 1024");
        const std::string layers = " --errors --light-groups --lpe indirect='C[DSV][DSV]+L' ";
        folder.run("ask before.atlas.exr --what-if floor.D=" + option(floor) + " --what-if wall.diffuse=" +
                   option(wall) + " --what-if leaf.RD=" + option(leaf) + " --what-if leaf.TD=" + option(through) +
                   " --light key=" + option(key) + " --light default=" + option(bulb) + layers + "-o asked.exr");
        folder.run("ask after.atlas.exr" + layers + "-o rendered.exr");
        const auto asked = folder.image("asked.exr"), rendered = folder.image("rendered.exr");
        for (const std::string layer : {"", "light_key", "indirect"}) {
            const Measured a = measured(asked, layer), b = measured(rendered, layer);
            CAPTURE(edit, layer, a.mean, a.error, b.mean, b.error);
            const double error = std::hypot(a.error, b.error);
            REQUIRE(error > 0);
            CHECK(std::abs(a.mean - b.mean) < 5 * error);
            CHECK(error < 0.05 * b.mean);
            agree += std::abs(a.mean - b.mean) <= 1.96 * error ? 1 : 0;
            ++compared;
            const std::string name = (layer.empty() ? "beauty" : layer) + "_error";
            const std::vector<float> ea = test::plane(asked, name, name), eb = test::plane(rendered, name, name);
            for (std::size_t i = 0; i < ea.size(); ++i) {
                double difference = 0;
                for (const char* component : {"R", "G", "B"})
                    difference += static_cast<double>(test::plane(asked, layer, component)[i] -
                                                      test::plane(rendered, layer, component)[i]) /
                                  3;
                const double deviation = std::hypot(static_cast<double>(ea[i]), static_cast<double>(eb[i]));
                pixels_agree += std::abs(difference) <= 2.145 * deviation ? 1 : 0;
                ++pixels;
            }
        }
    }
    // 95 % of 60 are 57. The layers of an edit are correlated, so the count scatters like that of about 30 comparisons.
    WARN(agree << " of " << compared << " comparisons are within the interval of 95 %");
    CHECK(agree >= 50);
    // Student's t with 14 degrees of freedom, for two errors from eight parts each, exceeds 2.145 in 5 % of cases. It
    // exceeds it less often where rare bright samples make light heavy-tailed. 8400 pixels, of which each serves three
    // correlated layers, scatter by 0.4 %.
    WARN(pixels_agree << " of " << pixels << " pixels are within theirs");
    CHECK(pixels_agree >= 0.94 * pixels);
    CHECK(pixels_agree <= 0.985 * pixels);
}

TEST_CASE("what an atlas cannot answer is refused by name", "[atlas][gate]") {
    const WhatIfFolder folder;
    folder.render("a", {}, 1);
    folder.render("short", {}, 1, "--atlas-length 1");
    folder.render("types", {}, 1, "--atlas-by group");
    for (const auto& [arguments, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
             {"a.atlas.exr --what-if wlal.D=0.5", {"unknown object 'wlal.D'", "floor, leaf, wall"}},
             {"a.atlas.exr --what-if wall.S=0.5", {"object 'wall' has no lobe 'S'", "diffuse"}},
             {"a.atlas.exr --what-if wall.roughness=0.5", {"roughness changes the directions of light"}},
             {"a.atlas.exr --what-if wall.ior=0.5", {"ior changes the directions of light"}},
             {"a.atlas.exr --what-if ball.D=0.5", {"object 'ball' is coated", "share energy"}},
             {"a.atlas.exr --what-if wall.D=-1", {"'-1' is not a factor of 'wall.D'"}},
             {"a.atlas.exr --what-if wall.D=2 --what-if wall.D=3", {"'wall.D' has two factors"}},
             {"a.atlas.exr --light kye=2", {"unknown light group 'kye'", "did you mean 'key'?", "default"}},
             {"short.atlas.exr --what-if wall.D=0.5", {"merges path strings", "...", "--atlas-length above 1"}},
             {"types.atlas.exr --what-if wall.D=0.5", {"merges path strings", "--atlas-by label,lobe,group"}}})
        check_refused(folder, "ask " + arguments + " -o o.exr", words);
    check_refused(folder, "ask a.atlas.exr --light key=2", {"layers need a file"});
    check_refused(folder, "ask a.atlas.exr --light key=2 --top 3 -o o.exr", {"exclude one another"});
    check_refused(folder, "mix a.atlas.exr key=2 -o o.exr", {"path atlas", "raylex ask --light"});
    // Merged scatterings keep their light's group.
    folder.run("ask short.atlas.exr --light key=2 -o o.exr");
    CHECK(contains(folder.run("ask a.atlas.exr --what-if wall.D=1.5 -o o.exr").err, "factor above 1"));
}

TEST_CASE("an atlas that merges path strings gives bounds of the light with other colours", "[atlas][gate]") {
    const WhatIfFolder folder;
    folder.render("a", {}, 1);
    folder.render("short", {}, 1, "--atlas-length 1");
    folder.render("types", {}, 1, "--atlas-by group");
    const std::string edit = " --what-if wall.D=0.5,0.2,1 --what-if leaf.TD=1.25 --lpe direct='C<RD>L' --errors ";
    folder.run("ask a.atlas.exr" + edit + "-o exact.exr");
    const auto exact = folder.image("exact.exr");
    for (const std::string atlas : {"short", "types"}) {
        CAPTURE(atlas);
        check_refused(folder, "ask " + atlas + ".atlas.exr" + edit + "-o o.exr", {"--intervals gives bounds"});
        const Outcome asked = folder.run("ask " + atlas + ".atlas.exr --intervals" + edit + "-o bounds.exr");
        CHECK(contains(asked.err, "the beauty is the middle of its bounds"));
        const auto bounds = folder.image("bounds.exr");
        CHECK(bounds.layer("beauty_error") == nullptr);
        CHECK(bounds.partitions.empty());
        double width = 0;
        for (const char* component : {"R", "G", "B"}) {
            const auto value = plane(exact, "", component), least = plane(bounds, "beauty_least", component),
                       most = plane(bounds, "beauty_most", component), middle = plane(bounds, "", component);
            for (std::size_t i = 0; i < value.size(); ++i) {
                // Values of path strings and of their sums are rounded to float, by 2^-24 each.
                const float slack = 4e-7f * most[i];
                CHECK(least[i] <= value[i] + slack);
                CHECK(value[i] <= most[i] + slack);
                CHECK(middle[i] == Approx((least[i] + most[i]) / 2));
                width += static_cast<double>(most[i] - least[i]);
            }
        }
        CHECK(width > 0);
    }
    // Light that met no other scattering than its own is exact in the short atlas.
    CHECK(folder.image("exact.exr").layer("direct_error") != nullptr);
    folder.run("ask short.atlas.exr --intervals" + edit + "-o bounds.exr");
    CHECK(plane(folder.image("bounds.exr"), "direct", "R") == plane(exact, "direct", "R"));
}
