// raylex mix: the light groups of images of raylex and of other renderers.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/display/files.h"
#include "tests/experiments/support.h"
#include "tests/support/paths.h"

using namespace raylex;
using namespace raylex::test;

namespace {

/// The room with its lamp in the group `lamp`, rendered with two partitions, statistics and a depth.
struct MixFolder : SceneFolder {
    MixFolder() {
        write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[[light_group]]\nlight = \"area:0\"\ngroup = \"lamp\"\n");
        const Outcome rendered = run_raylex(*this,
                                            "render job.toml --light-groups --partition shipped --aov z "
                                            "--statistics light_lamp=mse,even --statistics beauty=mse,even -o in.exr");
        INFO(rendered.err);
        REQUIRE(rendered.code == 0);
    }
    [[nodiscard]] display::ExrImage image(const std::string& name) const {
        auto read = display::read_exr(path(name));
        INFO((read ? std::string() : read.error().to_string()));
        REQUIRE(read);
        return *std::move(read);
    }
    Outcome mix(const std::string& arguments, int code = 0) const {
        Outcome mixed = run_raylex(*this, "mix in.exr " + arguments);
        INFO(mixed.out << mixed.err);
        REQUIRE(mixed.code == code);
        return mixed;
    }
};

constexpr std::array components{"R", "G", "B"};

std::vector<float> scaled(std::vector<float> values, double factor) {
    for (float& value : values) value = static_cast<float>(factor * static_cast<double>(value));
    return values;
}

}  // namespace

TEST_CASE("mix scales light groups and all that follows them, and the beauty stays their sum", "[law1][gate]") {
    const MixFolder folder;
    const Outcome mixed = folder.mix("light_lamp=2,0.5,0 default=+1stop -o out.exr");
    const auto before = folder.image("in.exr"), after = folder.image("out.exr");
    constexpr std::array<double, 3> factors{2, 0.5, 0};
    for (std::size_t c = 0; c < 3; ++c) {
        const char* const name = components[c];
        const auto lamp = scaled(plane(before, "light_lamp", name), factors[c]),
                   rest = scaled(plane(before, "light_default", name), 2);
        CHECK(plane(after, "light_lamp", name) == lamp);
        CHECK(plane(after, "light_default", name) == rest);
        CHECK(plane(after, "light_lamp_mse", name) ==
              scaled(plane(before, "light_lamp_mse", name), factors[c] * factors[c]));
        CHECK(plane(after, "light_lamp_even", name) == scaled(plane(before, "light_lamp_even", name), factors[c]));
        const auto beauty = plane(after, "", name);
        for (std::size_t i = 0; i < beauty.size(); ++i) CHECK(beauty[i] == Approx(lamp[i] + rest[i]).epsilon(2e-7));
    }
    CHECK(plane(after, "", "A") == plane(before, "", "A"));
    CHECK(plane(after, "z", "Z") == plane(before, "z", "Z"));
    for (const char* layer : {"directDiffuse", "indirectDiffuse", "beauty_mse", "beauty_even"}) {
        CAPTURE(layer);
        CHECK(before.layer(layer) != nullptr);
        CHECK(after.layer(layer) == nullptr);
        CHECK(after.attributes.count("lpe/" + std::string(layer)) == 0);
        CHECK(contains(mixed.err, "layer '" + std::string(layer) + "' is left out"));
    }
    CHECK(contains(mixed.err, "partition 'shipped' is left out"));
    CHECK(contains(mixed.out, "partition 'light_groups': 2 layers sum to beauty"));
    CHECK(after.attributes.at("raylex/mix") == "light_lamp=2,0.5,0 default=2,2,2");
    CHECK(run_raylex(folder, "verify out.exr").code == 0);
}

TEST_CASE("a partition of a scaled layer follows it", "[law1][gate]") {
    const MixFolder folder;
    folder.write("nested.toml", folder.read("job.toml") + R"([[channel]]
name = "lamp"
lpe = "C.*<L.'lamp'>"
[[channel]]
name = "lamp_seen"
lpe = "C<L.'lamp'>"
[[channel]]
name = "lamp_scattered"
lpe = "C.+<L.'lamp'>"
[[partition]]
name = "groups"
channels = ["lamp"]
rest = "others"
[[partition]]
name = "of_lamp"
of = "lamp"
channels = ["lamp_seen", "lamp_scattered"]
)");
    REQUIRE(run_raylex(folder, "render nested.toml -o in.exr").code == 0);
    const Outcome mixed = folder.mix("lamp=0.25 -o out.exr");
    CHECK(contains(mixed.out, "partition 'of_lamp': 2 layers sum to lamp"));
    CHECK(contains(mixed.out, "kept others"));
    const auto before = folder.image("in.exr"), after = folder.image("out.exr");
    for (const std::string layer : {"lamp", "lamp_seen", "lamp_scattered"})
        CHECK(plane(after, layer, "G") == scaled(plane(before, layer, "G"), 0.25));
    CHECK(plane(after, "others", "G") == plane(before, "others", "G"));
    check_refused(folder, "mix in.exr lamp_seen=2 -o o.exr", {"no terms of one sum", "groups (lamp, others)"});
}

TEST_CASE("factors of 1 keep every bit, factors of 0 leave one light alone", "[law1][gate]") {
    const MixFolder folder;
    folder.mix("lamp=1 light_default=1,1,1 -o same.exr");
    CHECK(image_bits(folder.path("same.exr")) == image_bits(folder.path("in.exr")));
    const Outcome solo = folder.mix("default=0 -o solo.exr");
    CHECK(contains(solo.out, "kept light_lamp"));
    const auto image = folder.image("solo.exr");
    for (const char* name : components) {
        CHECK(plane(image, "", name) == plane(image, "light_lamp", name));
        CHECK(plane(image, "light_lamp", name) == plane(folder.image("in.exr"), "light_lamp", name));
    }
    // A mix of a mix, back to the first: powers of two are exact.
    folder.mix("lamp=4 -o four.exr");
    REQUIRE(run_raylex(folder, "mix four.exr lamp=0.25 -o back.exr").code == 0);
    const auto back = folder.image("back.exr");
    CHECK(plane(back, "light_lamp", "R") == plane(folder.image("in.exr"), "light_lamp", "R"));
    CHECK(back.attributes.at("raylex/mix") == "lamp=4,4,4; lamp=0.25,0.25,0.25");
}

TEST_CASE("a mix comes from a file, and mistakes are named", "[gate]") {
    const MixFolder folder;
    folder.write("warm.toml", "[light]\nlamp = [1, 0.8, 0.6]\ndefault = \"-1 stop\"\n");
    folder.mix("--mix warm.toml -o file.exr");
    folder.mix("lamp=1,0.8,0.6 default=0.5 -o words.exr");
    CHECK(image_bits(folder.path("file.exr")) == image_bits(folder.path("words.exr")));
    folder.write("color.toml", "[what_if]\n\"ground.D\" = 0.5\n");
    folder.write("table.toml", "[lights]\nlamp = 2\n");
    folder.write("value.toml", "[light]\nlamp = [1, 2]\n");
    for (const auto& [arguments, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
             {"lamp=+-1stop -o o.exr", {"'+-1stop' is not a factor of 'lamp'"}},
             {"light_lmap=2 -o o.exr", {"'light_lmap'", "did you mean 'light_lamp'?", "light_default"}},
             {"lamp=2 light_lamp=3 -o o.exr", {"'light_lamp' has two factors"}},
             {"lamp=2 directDiffuse=3 -o o.exr", {"could count twice", "light_groups (light_lamp, light_default)"}},
             {"z=2 -o o.exr", {"no terms of one sum"}},
             {"beauty=2 -o o.exr", {"no terms of one sum"}},
             {"lamp=-1 -o o.exr", {"'-1' is not a factor of 'lamp'", "+1stop"}},
             {"lamp=1,2 -o o.exr", {"'1,2' is not a factor"}},
             {"lamp -o o.exr", {"expected NAME=FACTOR"}},
             {"-o o.exr", {"no factors"}},
             {"--mix color.toml -o o.exr", {"'ground.D' is a colour of an object", "raylex ask"}},
             {"--mix table.toml -o o.exr", {"table.toml:1", "light"}},
             {"--mix value.toml -o o.exr", {"value.toml:2", "not a factor of 'lamp'"}},
             {"lamp=2 -o in.exr", {"would be overwritten"}}})
        check_refused(folder, "mix in.exr " + arguments, words);
}

TEST_CASE("a group is scaled whose name differs from another one only in characters that layers lack") {
    const SceneFolder folder;
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[[light_group]]\nlight = \"area:0\"\ngroup = \"a b\"\n"
                 "[[light_group]]\nlight = \"point:0\"\ngroup = \"a_b\"\n");
    REQUIRE(run_raylex(folder, "render job.toml --light-groups -o in.exr").code == 0);
    REQUIRE(run_raylex(folder, "mix in.exr a_b=0 'a b=2' -o out.exr").code == 0);
    const auto before = display::read_exr(folder.path("in.exr")), after = display::read_exr(folder.path("out.exr"));
    REQUIRE(before);
    REQUIRE(after);
    for (const display::ImageLayer& layer : after->layers) {
        const auto lpe = after->attributes.find("lpe/" + layer.name);
        if (lpe == after->attributes.end() || !layer.name.starts_with("light_a")) continue;
        const double factor = lpe->second.find("a_b") == std::string::npos ? 2 : 0;
        CAPTURE(layer.name, lpe->second);
        CHECK(plane(*after, layer.name, "G") == scaled(plane(*before, layer.name, "G"), factor));
    }
}

TEST_CASE("mix follows the light groups of Blender's image and keeps unassigned light", "[gate]") {
    const Folder folder;
    folder.write("cycles.exr", read_bytes(source_dir() + "/tests/experiments/data/cycles.exr"));
    const Outcome mixed = run_raylex(folder, "mix cycles.exr key=3 Combined_sky=0,0,1 -o out.exr");
    INFO(mixed.out << mixed.err);
    REQUIRE(mixed.code == 0);
    CHECK(contains(mixed.err, "the header declares no partition"));
    CHECK(contains(mixed.err, "layer 'ViewLayer.DiffDir' is left out"));
    const auto before = display::read_exr(folder.path("cycles.exr")), after = display::read_exr(folder.path("out.exr"));
    REQUIRE(before);
    REQUIRE(after);
    const auto of = [](const display::ExrImage& image, const std::string& layer) {
        return plane(image, "ViewLayer." + layer, "R");
    };
    const auto beauty = of(*before, "Combined"), key = of(*before, "Combined_key"), sky = of(*before, "Combined_sky"),
               mix = of(*after, "Combined");
    for (std::size_t i = 0; i < beauty.size(); ++i) {
        const double exact =
            static_cast<double>(beauty[i]) + 2 * static_cast<double>(key[i]) - static_cast<double>(sky[i]);
        const double size = static_cast<double>(beauty[i]) + 2 * static_cast<double>(key[i]);
        CHECK(std::abs(static_cast<double>(mix[i]) - exact) <= 4e-6 * size + 1e-9);
    }
    CHECK(of(*after, "Combined_bulb") == of(*before, "Combined_bulb"));
    CHECK(plane(*after, "ViewLayer.Combined", "A") == plane(*before, "ViewLayer.Combined", "A"));
    CHECK(after->layer("ViewLayer.DiffDir") == nullptr);
}

TEST_CASE("mix keeps types, tiles and foreign parts, and clamps halves") {
    const Folder folder;
    constexpr int width = 8, height = 5;
    const std::vector<float> one(width * height, 1.0f), large(width * height, 60000.0f), ids(width * height, 7.0f);
    std::vector<ForeignChannel> channels{{"id", Imf::UINT, ids}};
    for (const std::string c : {"R", "G", "B"}) {
        channels.push_back({c, Imf::HALF, large});
        channels.push_back({"sun." + c, Imf::HALF, one});
        channels.push_back({"other." + c, Imf::HALF, large});
    }
    for (const int tile : {0, 4}) {
        write_foreign(folder.path("in.exr"), channels, box(width, height), box(width, height), tile);
        const Outcome mixed = run_raylex(folder, "mix in.exr sun=5 -o out.exr");
        INFO(mixed.err);
        REQUIRE(mixed.code == 0);
        const Outcome bright = run_raylex(folder, "mix in.exr other=2 -o bright.exr");
        REQUIRE(bright.code == 0);
        const auto image = display::read_exr(folder.path("out.exr")),
                   over = display::read_exr(folder.path("bright.exr"));
        REQUIRE(image);
        REQUIRE(over);
        CHECK(plane(*image, "sun", "G").front() == 5);
        CHECK(plane(*image, "", "G").back() == 60000);  // 60004 as a half
        CHECK(plane(*image, "id", "id") == ids);
        CHECK(image->layer("sun")->planes.front().stored == display::StoredType::half_float);
        CHECK(image->layer("id")->planes.front().stored == display::StoredType::unsigned_int);
        CHECK(plane(*over, "other", "R").front() == 65504);
        CHECK(plane(*over, "", "R").front() == 65504);
        CHECK(plane(*over, "sun", "R") == one);
    }
    write_foreign_parts(folder.path("parts.exr"),
                        {{"rgba", {{"R", Imf::FLOAT, one}, {"G", Imf::FLOAT, one}, {"B", Imf::FLOAT, one}}},
                         {"sun", {{"sun.R", Imf::FLOAT, one}, {"sun.G", Imf::FLOAT, one}, {"sun.B", Imf::FLOAT, one}}},
                         {"id", {{"id", Imf::UINT, ids}}}},
                        width, height);
    REQUIRE(run_raylex(folder, "mix parts.exr sun=0.5 -o half.exr").code == 0);
    const auto parts = display::read_exr(folder.path("half.exr"));
    REQUIRE(parts);
    CHECK(plane(*parts, "", "R").front() == 0.5f);
    CHECK(plane(*parts, "id", "id") == ids);
    CHECK(parts->layer("sun")->part == "sun");
}
