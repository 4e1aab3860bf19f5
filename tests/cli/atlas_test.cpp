// raylex render --atlas and raylex ask: layers made after the render.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "tests/experiments/support.h"
#include "tests/support/paths.h"

using namespace raylex;
using namespace raylex::test;
using raylex::display::ExrImage;

namespace {

/// A glass ball and a glossy wall over a labelled floor, with a lamp of group key, a point light without a group and a
/// sky.
const char* const glass_over_floor = R"(Film "rgb" "integer xresolution" 14 "integer yresolution" 10
Sampler "independent" "integer pixelsamples" 8
PixelFilter "box"
Integrator "path" "integer maxdepth" 6
LookAt 0 1.2 4  0 0.8 0  0 1 0
Camera "perspective" "float fov" 55
WorldBegin
LightSource "infinite" "rgb L" [.1 .15 .3]
LightSource "point" "rgb I" [3 3 3] "point3 from" [0 3 1]
MakeNamedMaterial "ground" "string type" "coateddiffuse" "rgb reflectance" [.5 .4 .3] "float roughness" .2
MakeNamedMaterial "wall" "string type" "conductor" "float roughness" .3
MakeNamedMaterial "glass" "string type" "dielectric"
MakeNamedMaterial "lamp" "string type" "diffuse" "rgb reflectance" [.1 .1 .1]
NamedMaterial "ground"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 2 2 0 2 2 0 -2 -2 0 -2]
NamedMaterial "wall"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 -2 2 0 -2 2 1 -2 -2 1 -2]
AttributeBegin
NamedMaterial "glass" Translate -0.5 0.6 0.5
Shape "sphere" "float radius" 0.5
AttributeEnd
AttributeBegin
NamedMaterial "lamp"
AreaLightSource "diffuse" "rgb L" [4 4 3]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [.3 2 -1 1.3 2 -1 1.3 1.2 -1 .3 1.2 -1]
AttributeEnd
)";

/// A folder with that scene as scene.pbrt, and a job that names a light group.
struct AtlasFolder : Folder {
    AtlasFolder() {
        write("scene.pbrt", glass_over_floor);
        write("job.toml",
              "[scene]\nfile = \"scene.pbrt\"\n[[light_group]]\narea_light_material = \"lamp\"\ngroup = \"key\"\n");
    }
    /// Renders with an atlas; `more` are further options.
    void render_atlas(const std::string& name, const std::string& more = {}) const {
        const Outcome outcome =
            run_raylex(*this, "render job.toml --atlas " + name + ".atlas.exr -o " + name + ".exr " + more);
        INFO(outcome.out << outcome.err);
        REQUIRE(outcome.code == 0);
    }
};

std::string random_expression(std::mt19937& random) {
    static const char* const events[] = {"D", "S",    "<RD>",         "<RS>",         "<TS>",
                                         ".", "[DS]", "<R.'ground'>", "<.D'ground'>", "<RS'wall'>"};
    static const char* const times[] = {"", "", "*", "+"};
    static const char* const ends[] = {"L", "O", "[LO]", "<L.'key'>", "<L.>", ".*"};
    std::string text = "C";
    for (auto count = random() % 4; count > 0; --count) {
        text += events[random() % std::size(events)];
        text += times[random() % std::size(times)];
    }
    return text + ends[random() % std::size(ends)];
}

std::vector<std::string> layers_of(const ExrImage& image) {
    std::vector<std::string> names;
    for (const auto& layer : image.layers)
        if (layer.is_color()) names.push_back(layer.name);
    return names;
}

/// Compares every layer of `asked` with that of `rendered`, relative to the sum of all layers' magnitudes.
double largest_difference(const ExrImage& requested, const ExrImage& rendered) {
    const std::vector<std::string> names = layers_of(rendered);
    CHECK(layers_of(requested) == names);
    double largest = 0;
    for (const char* component : {"R", "G", "B"}) {
        std::vector<double> sum, difference;
        for (const std::string& name : names) {
            const std::vector<float> a = plane(requested, name, component), b = plane(rendered, name, component);
            sum.resize(a.size());
            difference.resize(a.size());
            for (std::size_t i = 0; i < a.size(); ++i) {
                const auto x = static_cast<double>(a[i]), y = static_cast<double>(b[i]);
                if (!name.empty()) sum[i] += std::abs(y);
                difference[i] = std::max(difference[i], std::abs(x - y));
            }
        }
        for (std::size_t i = 0; i < sum.size(); ++i)
            if (difference[i] > 0) largest = std::max(largest, sum[i] > 0 ? difference[i] / sum[i] : 1);
    }
    return largest;
}

ExrImage image_of(const Folder& folder, const std::string& name) {
    auto image = display::read_exr(folder.path(name));
    REQUIRE(image);
    return *std::move(image);
}

/// Returns the output of `raylex verify` for a file.
void check_verified(const Folder& folder, const std::string& name) {
    const Outcome verified = run_raylex(folder, "verify " + name);
    INFO(verified.out << verified.err);
    CHECK(verified.code == 0);
}

}  // namespace

TEST_CASE("layers from an atlas equal rendered ones: random expressions and partitions", "[atlas][gate]") {
    const AtlasFolder folder;
    std::mt19937 random(17);
    for (const char* method : {"path", "bdpt"}) {
        const std::string how = std::string("--integrator ") + method;
        folder.render_atlas("kept", how + " --atlas-length 6");
        for (int round = 0; round < 2; ++round) {
            std::string wishes = " --partition shipped --light-groups";
            for (int i = 0; i < 25; ++i)
                wishes += " --lpe \"e" + std::to_string(i) + "=" + random_expression(random) + "\"";
            const Outcome rendered = run_raylex(folder, "render job.toml " + how + " -o rendered.exr" + wishes);
            INFO(wishes << rendered.err);
            REQUIRE(rendered.code == 0);
            const Outcome requested = run_raylex(folder, "ask kept.atlas.exr -o asked.exr" + wishes);
            INFO(requested.err);
            REQUIRE(requested.code == 0);
            const ExrImage a = image_of(folder, "asked.exr"), b = image_of(folder, "rendered.exr");
            // Words, their sum and the rendered layer are each rounded to float once, 2^-24 of the layer at most, and
            // every pixel's light is in a layer of two partitions: 3 2^-24 / 2 of the sum of the layers.
            CHECK(largest_difference(a, b) <= 0x1p-23);
            CHECK(a.partitions.size() == b.partitions.size());
            for (const char* component : {"R", "G", "B", "A"})
                CHECK(plane(a, "", component) == plane(b, "", component));
        }
        check_verified(folder, "asked.exr");
        check_verified(folder, "kept.atlas.exr");
    }
}

TEST_CASE("an atlas by technique gives the light of each technique, and its words name the technique",
          "[atlas][gate]") {
    const AtlasFolder folder;
    const std::string wishes =
        " --partition shipped --lpe 'met=s0t3;C<RD>*L' --lpe 'sampled=s1t3;C.*L' --lpe 'splat=s3t1;C.*' "
        "--lpe 'long=beyond4;C.*' --lpe all=C.*";
    const std::string how = "--integrator bdpt --spp 16 --atlas-by label,lobe,group,technique --atlas-length ";
    folder.render_atlas("kept", how + "6");
    const Outcome rendered = run_raylex(folder, "render job.toml --integrator bdpt --spp 16 -o rendered.exr" + wishes);
    INFO(rendered.err);
    REQUIRE(rendered.code == 0);
    const Outcome requested = run_raylex(folder, "ask kept.atlas.exr -o asked.exr" + wishes);
    INFO(requested.err);
    REQUIRE(requested.code == 0);
    const ExrImage a = image_of(folder, "asked.exr"), b = image_of(folder, "rendered.exr");
    CHECK(largest_difference(a, b) <= 0x1p-23);  // the bound of the case above
    for (const char* layer : {"met", "sampled", "splat", "long"}) {
        const std::vector<float> values = plane(b, layer, "G");
        CAPTURE(layer);
        CHECK(std::any_of(values.begin(), values.end(), [](float value) { return value > 0; }));
    }
    check_verified(folder, "kept.atlas.exr");
    CHECK(matches(run_raylex(folder, "ask kept.atlas.exr --top 5 --at 7,5").out, "[^]*\\(s[0-9]+t[0-9]+\\)[^]*"));
    // Merged words keep their technique, and so do merged files.
    folder.render_atlas("short", how + "1 --seed 1");
    CHECK(
        run_raylex(folder, "ask short.atlas.exr -o asked.exr --lpe 'sampled=s1t3;C.*' --lpe 'long=beyond4;C.*'").code ==
        0);
    folder.render_atlas("other", how + "6 --seed 2");
    CHECK(run_raylex(folder, "ask --merge kept.atlas.exr other.atlas.exr -o both.atlas.exr").code == 0);
    CHECK(run_raylex(folder, "ask both.atlas.exr -o asked.exr --lpe 'sampled=s1t3;C.*L'").code == 0);
    folder.render_atlas("plain", "--integrator bdpt");
    check_refused(folder, "ask plain.atlas.exr -o asked.exr --lpe 'sampled=s1t3;C.*L'",
                  {"do not distinguish techniques", "--atlas-by label,lobe,group,technique"});
    const Outcome page = run_raylex(folder, "report kept.atlas.exr -o page.html");
    INFO(page.err);
    CHECK(page.code == 0);
}

TEST_CASE("on whole scenes, layers from an atlas equal rendered ones: a hundred expressions each", "[.full][atlas]") {
    namespace fs = std::filesystem;
    const char* const given = std::getenv("RAYLEX_REFERENCES");
    const fs::path shared = given != nullptr ? fs::path(given) : fs::path(source_dir()) / ".." / "shared/data/scenes";
    const fs::path scenes = fs::exists(shared) ? shared : fs::path(source_dir()) / "experiments/scenes";
    // RenderMan's basic set (experiments/studies/split-check.toml).
    const std::string partitions =
        " --partition shipped --light-groups --lpe v_emissive='C[<L.>O]' --lpe v_directDiffuse='C<RD>[<L.>O]'"
        " --lpe v_indirectDiffuse='C<RD>[DS]+[<L.>O]' --lpe v_subsurface='C<TD>[DS]*[<L.>O]'"
        " --lpe v_directSpecular='C<RS>[<L.>O]' --lpe v_indirectSpecular='C<RS>[DS]+[<L.>O]'"
        " --lpe v_transmissive='C<TS>[DS]*[<L.>O]'";
    std::mt19937 random(100);
    double largest = 0;
    std::size_t asked_scenes = 0;
    for (const fs::directory_entry& scene : fs::directory_iterator(scenes)) {
        const fs::path file = scene.path() / "scene.pbrt";
        if (!fs::exists(file)) continue;
        const Folder folder;
        const std::string render = "render '" + file.string() + "' --resolution 60x40 --spp 4 --max-depth 8 ";
        INFO(file.string());
        REQUIRE(run_raylex(folder, render + "-o kept.exr --atlas kept.atlas.exr").code == 0);
        for (int half = 0; half < 2; ++half) {  // one automaton for a hundred expressions takes longer than two
            std::string wishes = partitions;
            for (int i = 0; i < 50; ++i)
                wishes += " --lpe \"e" + std::to_string(i) + "=" + random_expression(random) + "\"";
            const Outcome rendered = run_raylex(folder, render + "-o rendered.exr" + wishes);
            INFO(wishes << rendered.err);
            REQUIRE(rendered.code == 0);
            const Outcome requested = run_raylex(folder, "ask kept.atlas.exr -o asked.exr" + wishes);
            INFO(requested.err);
            REQUIRE(requested.code == 0);
            const double difference =
                largest_difference(image_of(folder, "asked.exr"), image_of(folder, "rendered.exr"));
            CHECK(difference <= 0x1p-23);  // as above
            largest = std::max(largest, difference);
        }
        check_verified(folder, "asked.exr");
        check_verified(folder, "kept.atlas.exr");
        ++asked_scenes;
    }
    CHECK(asked_scenes >= 10);
    WARN(asked_scenes << " scenes of " << scenes.string() << ": largest difference " << largest
                      << " of the sum of the layers");
}

TEST_CASE("an atlas changes no bit of the image, and threads none of the atlas", "[atlas][law2][law3][gate]") {
    const AtlasFolder folder;
    REQUIRE(run_raylex(folder, "render job.toml -o plain.exr").code == 0);
    // With this budget words are merged; merging also depends only on the samples.
    for (const std::string budget : {"2GiB", "150KiB"}) {
        const ExrImage plain = image_of(folder, "plain.exr");
        std::vector<std::string> words;
        for (const std::string threads : {"1", "2"}) {
            folder.render_atlas("t" + threads, "--atlas-budget " + budget + " --threads " + threads);
            const ExrImage with = image_of(folder, "t" + threads + ".exr");
            for (const char* component : {"R", "G", "B", "A"})
                CHECK(plane(with, "", component) == plane(plain, "", component));
            const Outcome requested =
                run_raylex(folder, "ask t" + threads + ".atlas.exr --errors --partition shipped -o a" + threads +
                                       ".exr --intervals");
            INFO(requested.err);
            REQUIRE(requested.code == 0);
            std::string all;
            for (const char* at : {"2,2", "7,5", "12,9"}) {
                const Outcome top = run_raylex(folder, "ask t" + threads + ".atlas.exr --top 1000 --at " + at);
                REQUIRE(top.code == 0);
                all += top.out;
            }
            words.push_back(all);
        }
        CHECK(words[0] == words[1]);
        const ExrImage one = image_of(folder, "a1.exr"), two = image_of(folder, "a2.exr");
        REQUIRE(layers_of(one) == layers_of(two));
        for (const std::string& layer : layers_of(one))
            for (const char* component : {"R", "G", "B"})
                CHECK(plane(one, layer, component) == plane(two, layer, component));
    }
}

TEST_CASE("a layer that an atlas cannot compute exactly is refused, or lies between its bounds", "[atlas][gate]") {
    const AtlasFolder folder;
    REQUIRE(run_raylex(folder, "render job.toml -o true.exr --lpe c='CDS+L' --lpe d='CDD+L' --lpe s='C<TS>+L'").code ==
            0);
    const ExrImage truth = image_of(folder, "true.exr");
    const Outcome length_two = run_raylex(folder, "render job.toml -o a.exr --atlas a.atlas.exr --atlas-length 2");
    REQUIRE(length_two.code == 0);
    const Outcome merged = run_raylex(folder, "render job.toml -o b.exr --atlas b.atlas.exr --atlas-budget 60KiB");
    INFO(merged.out << merged.err);
    REQUIRE(merged.code == 0);
    for (const std::string name : {"a", "b"}) {
        check_verified(folder, name + ".atlas.exr");
        check_refused(
            folder, "ask " + name + ".atlas.exr --lpe c='CDS+L' -o c.exr",
            {"channel 'c' cannot be computed exactly", "...", "--intervals", "between ", " % of the image's light",
             name == "a" ? "an --atlas-length above 2" : "a greater --atlas-budget"});
        const Outcome requested =
            run_raylex(folder, "ask " + name +
                                   ".atlas.exr --intervals --lpe c='CDS+L' --lpe d='CDD+L' --lpe s='C<TS>+L' -o i.exr");
        INFO(requested.err);
        REQUIRE(requested.code == 0);
        const ExrImage answer = image_of(folder, "i.exr");
        std::size_t intervals = 0, open = 0;
        for (const std::string channel : {"c", "d", "s"}) {
            if (answer.layer(channel) != nullptr) continue;
            ++intervals;
            const std::vector<float> least = plane(answer, channel + "_least", "G"),
                                     most = plane(answer, channel + "_most", "G"), is = plane(truth, channel, "G");
            for (std::size_t i = 0; i < is.size(); ++i) {
                // Three roundings to float, 2^-24 each, of values up to the upper bound.
                const double slack = 3 * 0x1p-24 * static_cast<double>(most[i]);
                CHECK(static_cast<double>(least[i]) <= static_cast<double>(is[i]) + slack);
                CHECK(static_cast<double>(is[i]) <= static_cast<double>(most[i]) + slack);
                open += least[i] < most[i] ? 1 : 0;
            }
        }
        CHECK(intervals > 0);
        CHECK(open > 0);
        // The light of all words is exact, whatever was merged.
        const Outcome whole = run_raylex(folder, "ask " + name + ".atlas.exr --lpe all='C.*' -o w.exr");
        CHECK(whole.code == 0);
    }
    // With a small but usable budget, the first scattering event and direct light stay distinct.
    folder.render_atlas("c", "--spp 128 --atlas-budget 165KiB");
    check_refused(folder, "ask c.atlas.exr --lpe c='CDS+L' -o c.exr", {"cannot be computed exactly"});
    REQUIRE(run_raylex(folder, "ask c.atlas.exr --partition shipped -o s.exr").code == 0);
    check_verified(folder, "s.exr");
    check_refused(folder, "render job.toml -o n.exr --atlas n.atlas.exr --atlas-budget lots", {"--atlas-budget"});
}

TEST_CASE("an atlas stores complete words of a deep scene", "[atlas]") {
    const AtlasFolder folder;
    folder.render_atlas("deep", "--spp 4 --max-depth 65");
    CHECK(run_raylex(folder, "ask deep.atlas.exr --lpe caustics='CDS+L' -o c.exr").code == 0);  // the example in README
}

TEST_CASE("an atlas refuses expressions with labels, lobes and groups that it does not store", "[atlas]") {
    const AtlasFolder folder;
    folder.render_atlas("plain", "--atlas-by group --atlas-length 6");
    check_refused(folder, "ask plain.atlas.exr --lpe f=\"C<RD'ground'>L\" -o f.exr",
                  {"channel 'f' cannot be computed exactly", "ground", "--atlas-by with more than 'group'"});
    CHECK(run_raylex(folder, "ask plain.atlas.exr --lpe key=\"C.*<L.'key'>\" -o g.exr").code == 0);
    check_refused(folder, "render job.toml -o n.exr --atlas n.atlas.exr --atlas-by labels", {"did you mean 'label'?"});
    check_refused(folder, "render job.toml -o n.exr --atlas-length 4", {"--atlas FILE.exr"});
    check_refused(folder, "render job.toml -o n.exr --atlas n.atlas.exr --no-beauty --lpe d=CDL",
                  {"expected a render with beauty"});
    check_refused(folder, "render job.toml -o n.exr --atlas n.atlas.exr --integrator pssmlt",
                  {"supports no path atlas"});
}

TEST_CASE("ask --top lists a pixel's brightest words, and --suggest the noisiest kinds", "[atlas]") {
    const AtlasFolder folder;
    folder.render_atlas("a", "--atlas-length 6");
    const Outcome top = run_raylex(folder, "ask a.atlas.exr --top 2 --at 4,6");
    INFO(top.out << top.err);
    REQUIRE(top.code == 0);
    CHECK(count_matches(top.out, "pixel \\(4, 6\\): \\(.*\\), mean [0-9.]+ \\+- [0-9.]+, 8 samples") == 1);
    CHECK(count_matches(top.out, "\n  [0-9.]+ % +[0-9.e-]+ \\+- [0-9.e-]+ +C [RTLBO]") == 2);
    const Outcome suggested = run_raylex(folder, "ask a.atlas.exr --suggest 3");
    INFO(suggested.out << suggested.err);
    REQUIRE(suggested.code == 0);
    // The last line is a valid command.
    const std::size_t line = suggested.out.rfind("raylex ask ");
    REQUIRE(line != std::string::npos);
    const Outcome requested = run_shell(folder, "\"$RAYLEX\" " + suggested.out.substr(line + 7));
    INFO(requested.err);
    REQUIRE(requested.code == 0);
    CHECK(image_of(folder, "layers.exr").partitions.size() == 1);
    check_verified(folder, "layers.exr");
    check_refused(folder, "ask a.atlas.exr --top 2 --at 14,0", {"outside the image of 14 x 10"});
    check_refused(folder, "ask a.atlas.exr --top 2 --at 4", {"expected X,Y"});
}

TEST_CASE("atlases of several seeds merge in any order", "[atlas][gate]") {
    const AtlasFolder folder;
    folder.render_atlas("a", "--seed 1");
    folder.render_atlas("b", "--seed 2 --spp 4");
    folder.render_atlas("c", "--seed 3");
    REQUIRE(run_raylex(folder, "ask --merge a.atlas.exr b.atlas.exr c.atlas.exr -o abc.exr").code == 0);
    REQUIRE(run_raylex(folder, "ask --merge c.atlas.exr a.atlas.exr b.atlas.exr -o cab.exr").code == 0);
    check_verified(folder, "abc.exr");
    for (const char* name : {"abc", "cab", "a.atlas", "b.atlas", "c.atlas"})
        REQUIRE(
            run_raylex(folder, std::string("ask ") + name + ".exr --partition shipped -o of_" + name + ".exr").code ==
            0);
    const ExrImage abc = image_of(folder, "of_abc.exr"), cab = image_of(folder, "of_cab.exr");
    const ExrImage a = image_of(folder, "of_a.atlas.exr"), b = image_of(folder, "of_b.atlas.exr"),
                   c = image_of(folder, "of_c.atlas.exr");
    for (const std::string& layer : layers_of(abc)) {
        CHECK(plane(abc, layer, "G") == plane(cab, layer, "G"));
        const std::vector<float> merged = plane(abc, layer, "G"), of_a = plane(a, layer, "G"),
                                 of_b = plane(b, layer, "G"), of_c = plane(c, layer, "G");
        for (std::size_t i = 0; i < merged.size(); ++i) {
            const double mean = (8 * static_cast<double>(of_a[i]) + 4 * static_cast<double>(of_b[i]) +
                                 8 * static_cast<double>(of_c[i])) /
                                20;
            // Words and layers of each file and of the merged one: four roundings to float.
            CHECK(std::abs(static_cast<double>(merged[i]) - mean) <= 4 * 0x1p-24 * mean);
        }
    }
    check_refused(folder, "ask --merge a.atlas.exr a.atlas.exr -o n.exr", {"both have seed 1", "--seed"});
    folder.render_atlas("d", "--seed 4 --atlas-length 2");
    check_refused(folder, "ask --merge a.atlas.exr d.atlas.exr -o n.exr", {"length 6", "length 2"});
    check_refused(folder, "ask --merge a.atlas.exr -o n.exr", {"at least two"});
    // Jobs with different seeds and outputs belong to one image; jobs that render different parts of it do not.
    for (const std::string seed : {"7", "8"}) {
        const std::string job = folder.read("job.toml");
        folder.write("s" + seed + ".toml", job + "[render]\nseed = " + seed + "\nspp = 2\n[output]\nfile = \"s" + seed +
                                               ".exr\"\n[atlas]\nfile = \"s" + seed + ".atlas.exr\"\n");
        folder.write("c" + seed + ".toml", job + "[render]\nseed = " + seed + "\nspp = 2\ncrop = [" +
                                               (seed == "7" ? "0, 0, 7" : "1, 0, 8") + ", 7]\n");
        REQUIRE(run_raylex(folder, "render s" + seed + ".toml").code == 0);
        REQUIRE(run_raylex(folder, "render c" + seed + ".toml -o c.exr --atlas c" + seed + ".atlas.exr").code == 0);
    }
    CHECK(run_raylex(folder, "ask --merge s7.atlas.exr s8.atlas.exr -o s.exr").code == 0);
    check_refused(folder, "ask --merge c7.atlas.exr c8.atlas.exr -o n.exr", {"c8.atlas.exr", "jobs that differ"});
}

TEST_CASE("words with negative light sum exactly, even in layers where they cancel", "[atlas][gate]") {
    const AtlasFolder folder;
    std::string scene = glass_over_floor;
    const std::string glass = "\"string type\" \"dielectric\"";
    scene.replace(scene.find(glass), glass.size(), glass + " \"spectrum eta\" \"glass-F11\"");
    folder.write("scene.pbrt", scene);
    folder.render_atlas("a");
    folder.render_atlas("b", "--seed 2");
    REQUIRE(run_raylex(folder, "ask --merge a.atlas.exr b.atlas.exr -o both.exr").code == 0);
    for (const char* name : {"a.atlas.exr", "both.exr"}) {
        check_verified(folder, name);
        // One layer of all words: with single precision per word, the sum misses the beauty by more than rounding.
        const Outcome requested = run_raylex(folder, std::string("ask ") + name + " --light-groups -o layers.exr");
        INFO(requested.out << requested.err);
        CHECK(requested.code == 0);
        check_verified(folder, "layers.exr");
    }
    // A class with light of both signs has no bounds.
    folder.render_atlas("short", "--atlas-length 2");
    check_refused(folder, "ask short.atlas.exr --lpe three=C...L --intervals -o n.exr",
                  {"disperses light by wavelength", "--atlas-length"});
}

TEST_CASE("atlases of shards merge with their image or alone, and give the layers of a single render's atlas",
          "[atlas][law3][gate]") {
    const std::string integrator = GENERATE("path", "bdpt", "lighttracer");
    CAPTURE(integrator);
    const AtlasFolder folder;
    const std::string more = "--spp 48 --integrator " + integrator;
    folder.render_atlas("whole", more);
    for (const char* part : {"1", "2", "3"}) folder.render_atlas("out", more + " --shard " + part + "/3");
    const std::string first = "out.atlas.exr.shard-1-of-3", second = "out.atlas.exr.shard-2-of-3",
                      third = "out.atlas.exr.shard-3-of-3";
    const Outcome unasked = run_raylex(folder, "merge --shards 3 -o out.exr");
    CHECK(unasked.code == 0);
    CHECK((unasked.out + unasked.err).find("--atlas FILE.atlas.exr") != std::string::npos);
    const Outcome merged = run_raylex(folder, "merge --shards 3 -o out.exr --atlas out.atlas.exr");
    INFO(merged.out << merged.err);
    REQUIRE(merged.code == 0);
    check_verified(folder, "out.atlas.exr");
    REQUIRE(run_raylex(folder, "ask --merge " + third + " " + first + " -o some.exr").code == 0);
    REQUIRE(run_raylex(folder, "ask --merge some.exr " + second + " -o all.exr").code == 0);
    for (const char* name : {"whole.atlas.exr", "out.atlas.exr", "all.exr"})
        REQUIRE(run_raylex(folder, std::string("ask ") + name + " --partition shipped -o of_" + name).code == 0);
    const ExrImage whole = image_of(folder, "of_whole.atlas.exr");
    // Roundings to float: words and layers of the whole; words of shards, merged words (twice if they are merged
    // twice), layers.
    CHECK(largest_difference(image_of(folder, "of_out.atlas.exr"), whole) <= 5 * 0x1p-24);
    CHECK(largest_difference(image_of(folder, "of_all.exr"), whole) <= 6 * 0x1p-24);

    check_refused(folder, "ask --merge " + first + " " + first + " -o n.exr",
                  {"both have seed", "samples 0 to 15", "--shard"});
    check_refused(folder, "ask --merge some.exr " + third + " -o n.exr", {"samples 32 to 47"});
    check_refused(folder, "ask --merge all.exr whole.atlas.exr -o n.exr", {"whole.atlas.exr", "samples 0 to 47"});
    // A shard without its atlas is not done.
    std::filesystem::remove(folder.path(second));
    check_refused(folder, "merge --shards 3 -o out.exr --atlas out.atlas.exr", {second});
    folder.render_atlas("out", more + " --shard 2/3");
    CHECK(folder.has(second));
    // The atlas of another render beside the records.
    folder.render_atlas("other", more + " --seed 9 --shard 2/3");
    std::filesystem::rename(folder.path("other.atlas.exr.shard-2-of-3"), folder.path(second));
    check_refused(folder, "merge --shards 3 -o out.exr --atlas out.atlas.exr",
                  {first, "another render", "raylex/seed"});
}

TEST_CASE("ask reports files that are not atlases", "[atlas][law7][gate]") {
    const AtlasFolder folder;
    folder.render_atlas("a");
    check_refused(folder, "ask a.exr --lpe d=CDL -o d.exr", {"a.exr", "not a path atlas"});
    check_refused(folder, "ask job.toml --lpe d=CDL -o d.exr", {"job.toml"});
    check_refused(folder, "ask absent.exr --lpe d=CDL -o d.exr", {"absent.exr"});
    check_refused(folder, "ask a.atlas.exr --lpe d=CDL -o a.atlas.exr", {"would be overwritten"});
    check_refused(folder, "ask a.atlas.exr --lpe d=CDL", {"-o LAYERS.exr"});
    check_refused(folder, "ask a.atlas.exr -o d.exr", {"--lpe"});
    check_refused(folder, "ask a.atlas.exr --lpe d='C<RX>L' -o d.exr", {"found 'X'"});
    const std::string bytes = folder.read("a.atlas.exr");
    // Truncated anywhere: in the header, the tables, the pixels.
    for (const double part : {0.02, 0.1, 0.3, 0.6, 0.9}) {
        folder.write("cut.exr", bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
        check_refused(folder, "ask cut.exr --errors --lpe d=CDL -o d.exr", {"cut.exr"});
    }
    std::string other = bytes;
    const std::size_t version = other.find("atlas/version");
    REQUIRE(version != std::string::npos);
    other[other.find('2', version)] = '7';
    folder.write("other.exr", other);
    check_refused(folder, "ask other.exr --lpe d=CDL -o d.exr", {"version '7'", "expected version 2"});
}
