// Passes: each class of paths by a method of its own. Their sum is compared with closed forms and with single methods;
// classes that miss paths, count paths twice, or hold paths that their method does not sample are refused.
#include <catch2/catch.hpp>

#include <numeric>
#include <random>

#include "passes_support.h"
#include "tests/transport/enclosure.h"

using namespace passes_test;

namespace {

constexpr double reflected = 0.45, mirrored = 0.35;

std::string events_of(const std::string& reflections) {
    std::string text;
    for (const char letter : reflections) text += letter == 'D' ? "<RD>" : "<RS>";
    return text;
}

/// A room of coated, rough and mixed materials with a textured floor, two lights of different groups, and a cutout.
const std::string mixed_scene = plain_film + R"(
LookAt 0 2 5  0 0.5 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
Attribute "light" "string group" "key"
)" + area_light + R"(
AttributeBegin AreaLightSource "diffuse" "rgb L" [2 4 8] Translate -2 2 1 Rotate 90 0 1 0
Shape "disk" "float radius" 0.4 AttributeEnd
Texture "checks" "spectrum" "checkerboard" "float uscale" 6 "float vscale" 6
  "rgb tex1" [0.9 0.3 0.1] "rgb tex2" [0.05 0.5 0.9]
Material "coateddiffuse" "texture reflectance" "checks" "float roughness" 0.3
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 4 4 0 4 4 0 -4 -4 0 -4]
  "point2 uv" [0 0 1 0 1 1 0 1]
AttributeBegin Material "coatedconductor" "float interface.roughness" 0.2 "float conductor.roughness" 0.3
Translate -0.8 0.6 0 Shape "sphere" "float radius" 0.5 AttributeEnd
AttributeBegin Material "diffusetransmission" "rgb reflectance" [0.3 0.5 0.2] "rgb transmittance" [0.5 0.2 0.4]
Translate 0.2 1.4 -0.4 Shape "sphere" "float radius" 0.4 "float alpha" 0.6 AttributeEnd
AttributeBegin Material "dielectric" Translate 0.9 0.6 0.4 Shape "sphere" "float radius" 0.4 AttributeEnd
)";

std::string many_layers() {
    std::string text = "[channels]\nshipped_partition = true\naovs = ['Nn', 'z']\nlight_groups = true\n";
    int count = 0;
    const auto add = [&](const std::string& expression) { text += channel("c" + std::to_string(count++), expression); };
    for (int length = 1; length <= 6; ++length) add("C.{" + std::to_string(length) + "}[LOB]");
    for (const char* lobe : {"<RD>", "<RG>", "<RS>", "<TD>", "<TG>", "<TS>"}) {
        add(std::string("C") + lobe + ".*L");
        add(std::string("C.*") + lobe + "L");
        add(std::string("C.+") + lobe + ".+L");
    }
    add("unoccluded;C<RD>L");
    add("C<RD><RD>*<RG>.*");
    return text;
}

}  // namespace

TEST_CASE("Passes: random partitions of path strings, by path, bdpt and light tracer, sum to closed forms",
          "[passes][statistical][gate]") {
    constexpr std::size_t longest = 8, split_at = 3;
    constexpr int seeds = 10;
    const std::vector<EnclosurePathString> all = enclosure_path_strings(reflected, mirrored, longest);
    double beauty = 0;
    for (const EnclosurePathString& each : all) beauty += each.value;
    std::vector<EnclosurePathString> shown = enclosure_path_strings(reflected, mirrored, split_at + 1);
    std::mt19937 random(46);
    const int methods = GENERATE(2, 3);
    for (int partition = 0; partition < 3; ++partition) {
        // Path strings that agree in their first `split_at` reflections go to one pass, shorter ones anywhere.
        std::string of_bdpt, of_light_tracer;
        for (const EnclosurePathString& each : enclosure_path_strings(reflected, mirrored, split_at)) {
            const bool is_prefix = each.reflections.size() == split_at;
            const std::string item = "(C" + events_of(each.reflections) + (is_prefix ? ".*" : "L") + ")";
            const auto choice = static_cast<int>(random() % 100) % methods;
            if (choice == 1) of_bdpt += (of_bdpt.empty() ? "" : "|") + item;
            if (choice == 2 && each.reflections.starts_with('D'))
                of_light_tracer += (of_light_tracer.empty() ? "" : "|") + item;
        }
        std::string text = "[render]\nmax_depth = 8\nlayer_passes = true\n";
        text += pass("path", "rest", "roulette = false\nspp = 192\n");
        if (!of_bdpt.empty()) text += pass("bdpt", of_bdpt, "roulette = false\nspp = 64\n");
        if (!of_light_tracer.empty()) text += pass("lighttracer", of_light_tracer, "roulette = false\nspp = 192\n");
        std::vector<ClosedForm> forms{{"beauty", beauty}};
        for (const EnclosurePathString& each : shown) {
            const std::string name = "w" + each.reflections;
            text += channel(name, "C" + events_of(each.reflections) + "L");
            forms.push_back({name, each.value});
        }
        PlannedJob plan = plan_of(enclosure(reflected, mirrored, 100), text);
        Replicates found;
        for (int seed = 0; seed < seeds; ++seed) {
            plan.job.settings.samples.seed = static_cast<std::uint64_t>(100 * partition + seed);
            plan.job.settings.machine.threads = 2;
            const JobOutput rendered = plan.rendered();
            std::vector<double>& means = found.of_seed.emplace_back();
            for (const ClosedForm& form : forms) {
                const std::vector<double> image = values_of(rendered, form.expression);
                double sum = 0;
                for (const double value : image) sum += value;
                means.insert(means.end(), blocks_across * blocks_across, sum / static_cast<double>(image.size()));
            }
            // Law 1, of the layers of passes and of the path strings with the rest
            std::vector<double> layers(values_of(rendered, "beauty").size());
            for (const PlannedPass& each : plan.passes.passes) {
                const std::vector<double> layer = values_of(rendered, "pass_" + each.name);
                for (std::size_t i = 0; i < layers.size(); ++i) layers[i] += layer[i];
            }
            std::vector<double> words = values_of(rendered, "rest");
            for (const EnclosurePathString& each : shown) {
                const std::vector<double> layer = values_of(rendered, "w" + each.reflections);
                for (std::size_t i = 0; i < words.size(); ++i) words[i] += layer[i];
            }
            const std::vector<double> whole = values_of(rendered, "beauty");
            double worst = 0;
            for (std::size_t i = 0; i < whole.size(); ++i)
                worst = std::max({worst, std::abs(layers[i] - whole[i]), std::abs(words[i] - whole[i])});
            CHECK(worst < 1e-11);
        }
        check_closed_forms(found, forms, 6 * forms.size(), 0.2);
    }
}

TEST_CASE("Passes: one pass that takes all paths gives the bits of a render without passes", "[passes]") {
    const std::string settings = "[render]\nspp = 4\n" + channel("a", "CD.*"), scene = ball_scene(area_light);
    const JobOutput plain = plan_of(scene, settings + "[integrator]\ntype = 'bdpt'\n").rendered();
    for (const char* takes : {".*", "rest", "C.*"}) {
        const JobOutput one = plan_of(scene, settings + pass("bdpt", takes)).rendered();
        for (const char* name : {"beauty", "a", "rest"}) check_same_bits(values_of(one, name), values_of(plain, name));
    }
    // neighbours of one method are one pass
    const JobOutput joined = plan_of(scene, settings + pass("bdpt", "C<RD>.*") + pass("bdpt", "rest")).rendered();
    CHECK(joined.passes.empty());
    check_same_bits(values_of(joined, "beauty"), values_of(plain, "beauty"));
}

TEST_CASE("Passes: the bits do not depend on threads", "[passes]") {
    const std::string passes =
        "[render]\nspp = 8\n" + pass("path", "rest") + pass("lighttracer", "C<RD>S+[<L.>O]", "spp = 16\n");
    const std::string scene = ball_scene(area_light);
    PlannedJob plan = plan_of(scene, passes);
    plan.job.settings.machine.threads = 1;
    const JobOutput one = plan.rendered();
    plan.job.settings.machine.threads = 3;
    const JobOutput three = plan.rendered();
    check_same_bits(values_of(one, "beauty"), values_of(three, "beauty"));
    CHECK(one.output.statistics.camera_samples == 18 * 18 * 24);
}

TEST_CASE("Passes: layers change no bit of the beauty", "[passes][law2]") {
    const std::string direct = pass("path", "C.?[LB]");
    const std::vector<std::string> jobs{
        pass("path", "rest") + pass("lighttracer", "C<RD>[DSG]+[<L.>O]", "spp = 16\n"),
        pass("path", "C<RD>.*", "spp = 12\n") + pass("bdpt", "rest"),
        direct + pass("bdpt", "C.*<RG>.+L&C.{2,}L") + pass("path", "rest", "spp = 12\n"),
        direct + pass("bdpt", "rest") + pass("lighttracer", "C<RD>.*<RD>L-C<RD>L"),
        pass("path", "C(<RD>|<RG>.*<RD>).*<RG>L") + pass("path", "rest", "spp = 12\n")};
    for (const std::string& passes : jobs) {
        INFO(passes);
        const std::string settings = "[render]\nspp = 8\nmax_depth = 6\n";
        const JobOutput bare = plan_of(mixed_scene, settings + passes).rendered();
        const std::vector<double> beauty = values_of(bare, "beauty");
        CHECK(std::accumulate(beauty.begin(), beauty.end(), 0.0) > 10);
        for (const std::string& layers : {channel("a", "C<RD>.*"), many_layers()}) {
            const JobOutput rendered = plan_of(mixed_scene, settings + passes + layers).rendered();
            check_same_bits(values_of(rendered, "beauty"), beauty);
            if (layers.find("aovs") == std::string::npos) continue;
            // Law 1
            std::vector<double> sum(beauty.size());
            const auto lpe_layers = plan_of(mixed_scene, settings + passes + layers).channels.partitions.front().layers;
            for (const std::string& name : lpe_layers) {
                const std::vector<double> layer = values_of(rendered, name);
                for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += layer[i];
            }
            double worst = 0;
            for (std::size_t i = 0; i < sum.size(); ++i)
                worst = std::max(worst, std::abs(sum[i] - beauty[i]) / std::max(beauty[i], 1e-3));
            CHECK(worst < 1e-12);
            // geometry comes from the camera-based pass alone
            const bool more = passes.find("spp = 12") < passes.find("[[pass]]", 1);
            const std::string geometry = "[channels]\naovs = ['Nn', 'z']\n[render]\nspp = ";
            const JobOutput plain = plan_of(mixed_scene, geometry + (more ? "12\n" : "8\n")).rendered();
            for (const char* name : {"Nn", "z"}) check_same_bits(values_of(rendered, name), values_of(plain, name));
        }
    }
}

TEST_CASE("Passes: layers of more light groups than have bits change no bit of the beauty", "[passes][law2]") {
    std::string scene = plain_film + R"(
LookAt 0 2 5  0 0.5 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
Material "coateddiffuse" "rgb reflectance" [0.7 0.5 0.3] "float roughness" 0.4
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 4 4 0 4 4 0 -4 -4 0 -4]
)",
                groups, classes;
    for (int i = 0; i < 70; ++i) {
        const std::string n = std::to_string(i), at = std::to_string(0.25 * (i % 10) - 1) + " " +
                                                      std::to_string(0.6 + 0.1 * (i / 10)) + " " +
                                                      std::to_string(0.2 * (i / 10) - 1);
        scene += "MakeNamedMaterial \"m" + n + "\" \"string type\" \"diffuse\"\n" + "AttributeBegin NamedMaterial \"m" +
                 n + "\" AreaLightSource \"diffuse\" \"rgb L\" [3 2 " + n + "] Translate " + at +
                 " Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 0.05 AttributeEnd\n";
        groups += "[[light_group]]\narea_light_material = 'm" + n + "'\ngroup = 'g" + n + "'\n";
        if (i % 2 == 0)
            classes += (i == 0 ? "" : "|") + std::string("(C<RD>{") + (i % 4 == 0 ? "1" : "2") + "}<L.'g" + n + "'>)";
    }
    const std::string job =
        "[render]\nspp = 4\nmax_depth = 3\n" + groups + pass("path", classes) + pass("bdpt", "rest");
    const JobOutput bare = plan_of(scene, job).rendered();
    const JobOutput split = plan_of(scene, job + "[channels]\nlight_groups = true\n").rendered();
    check_same_bits(values_of(split, "beauty"), values_of(bare, "beauty"));
    CHECK(values_of(split, "light_g69").size() == values_of(bare, "beauty").size());
}

TEST_CASE("Passes: the sum agrees with one method, layer by layer", "[passes][statistical][gate]") {
    constexpr int seeds = 12;
    std::vector<std::string> names;
    std::string layers;
    for (const char* each : {"C<RD>[LB]", "C<RD>.+[LB]", "C<RS>.*", "C<T.>.*", "C.+B", "C.+L-C.+B"}) {
        names.push_back("c" + std::to_string(names.size()));
        layers += channel(names.back(), each);
    }
    const auto means = [&](PlannedJob plan, std::uint64_t first) {
        Replicates result;
        for (int seed = 0; seed < seeds; ++seed) {
            plan.job.settings.samples.seed = first + static_cast<std::uint64_t>(seed);
            plan.job.settings.machine.threads = 2;
            const JobOutput rendered = plan.rendered();
            std::vector<double>& of_seed = result.of_seed.emplace_back();
            for (const std::string& name : names) {
                const std::vector<double> image = values_of(rendered, name);
                std::vector<double> sums(blocks_across * blocks_across);
                for (std::size_t i = 0; i < image.size(); i += 3) {
                    const std::size_t x = i / 3 % 18, y = i / 3 / 18;
                    sums[y / 6 * blocks_across + x / 6] += image[i + 1] / 36;
                }
                of_seed.insert(of_seed.end(), sums.begin(), sums.end());
            }
        }
        return result;
    };
    const Replicates plain =
        means(plan_of(many_lights(), "[render]\nspp = 64\nmax_depth = 4\n[integrator]\ntype = 'bdpt'\n" + layers), 1);
    const std::string passes =
        GENERATE_COPY(pass("path", "C<RD>?[LB]", "spp = 64\n") + pass("bdpt", "rest", "spp = 64\n"),
                      pass("bdpt", "rest", "spp = 64\n") + pass("lighttracer", "C<RD><RS>.*[LB]", "spp = 256\n"),
                      pass("path", "(CB)|(C<RD><RD>B)", "spp = 64\n") + pass("bdpt", "rest", "spp = 64\n") +
                          pass("lighttracer", "C<RD>(.*<RD>)?(L-B)", "spp = 256\n"));
    const std::string prune = GENERATE("", "prune = false\n");
    const Replicates summed = means(plan_of(many_lights(), "[render]\nmax_depth = 4\n" + prune + passes + layers), 500);
    check_agreement(plain, summed, names);
}

TEST_CASE("Passes: variances add", "[passes]") {
    const std::string scene = ball_scene(area_light);
    const PlannedJob plan = plan_of(scene,
                                    "[render]\nspp = 16\nlayer_passes = true\n[channels.statistics]\nbeauty = ['mse']\n"
                                    "pass_path = ['mse']\npass_path_2 = ['mse']\n" +
                                        pass("path", "C<RD>.*") + pass("path", "rest", "spp = 32\n"));
    const JobOutput rendered = plan.rendered();
    const std::vector<double> sum = values_of(rendered, "beauty_mse"), a = values_of(rendered, "pass_path_mse"),
                              b = values_of(rendered, "pass_path_2_mse");
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
        worst = std::max(worst, std::abs(sum[i] - a[i] - b[i]));
        largest = std::max({largest, a[i], b[i]});
    }
    CHECK(largest > 0);
    CHECK(worst <= 1e-12 * largest);
}

TEST_CASE("Passes: holes, overlaps and paths that a method misses are refused with the shortest path", "[passes]") {
    const auto refuted = [](const std::string& light, const std::string& passes) {
        auto plan = planned(ball_scene(light), passes);
        INFO((plan ? std::string() : plan.error().to_string()));
        REQUIRE(plan.ok());
        return plan->passes.refuted;
    };
    const auto has = [](const std::string& text, const std::string& part) {
        INFO(text << " has: " << part);
        CHECK(text.find(part) != std::string::npos);
    };
    has(refuted(area_light, pass("path", "C<RD>.*") + pass("bdpt", "C<T.>.*")), "no pass takes camera, light");
    has(refuted(area_light, pass("path", "CL") + pass("bdpt", "C<RD>.*") + pass("bdpt", "C<RS>.*", "spp = 2\n")),
        "no pass takes camera, specular transmission");
    has(refuted(area_light, pass("path", "C<RD>.*") + pass("bdpt", "C.L") + pass("path", "rest", "spp = 2\n")),
        "'path' and 'bdpt' both count camera, diffuse reflection");
    // the light tracer sees nothing through glass
    const std::string tracer = refuted(area_light, pass("path", "C<RD>.*") + pass("lighttracer", "rest"));
    has(tracer, "lighttracer does not sample camera, specular");
    has(tracer, "path or bdpt");
    // no ray of a path tracer hits a point light, but light paths from it pass through glass
    const std::string caustic = refuted(point_light, pass("lighttracer", "C<RD>L") + pass("path", "rest"));
    has(caustic, "path does not sample camera, diffuse reflection");
    has(caustic, "lighttracer or bdpt");
    // neither do subpaths from both sides meet in a path that has no two neighbours with densities: no method samples
    // it
    CHECK(refuted(point_light, pass("path", "C<RD>L") + pass("bdpt", "rest")).empty());
    CHECK(refuted(area_light, pass("lighttracer", "C<RD>S+L") + pass("path", "rest")).empty());
}

TEST_CASE("Passes: what they do not support is refused by name", "[passes]") {
    const std::string two = pass("path", "rest") + pass("bdpt", "C<RD>.*");
    const auto refused = [&](const std::string& more, const std::string& part) {
        auto plan = planned(ball_scene(area_light), more);
        REQUIRE_FALSE(plan.ok());
        const std::string text = plan.error().to_string();
        INFO(text << " has: " << part);
        CHECK(text.find(part) != std::string::npos);
    };
    refused(two + channel("a", "C<RD>L") + "[adaptive]\nerror = '1%'\nchannels = ['a']\n",
            "passes do not support adaptive sampling by channels");
    const std::string light = pass("lighttracer", "C<RD>L");
    refused(pass("path", "rest") + light + "[render]\nspp = 16\n[channels.statistics]\nbeauty = ['mse']\n",
            "has 16 samples per pixel; expected at least 32");
    refused(two + "[atlas]\nfile = 'a.exr'\n", "passes do not support a path atlas");
    refused(two + "[render]\nbeauty = false\n", "passes do not support no beauty");
    refused(two + "[integrator]\ntype = 'path'\n", "passes do not support an integrator for all paths");
    refused(two + channel("albedo", "nothruput;overwrite;C<.S>*((U2L)|O)"), "channel 'albedo' has");
    refused(two + pass("path", "rest"), "two passes take the rest");
    refused(two + pass("path", "noclamp;CL"), "prefix noclamp");
    refused(two + pass("path", "C<RD"), "job.toml");
    refused(pass("path", "rest", "maxdepth = 3\n") + pass("bdpt", "C<RD>.*"), "paths of different lengths");
    refused(pass("path", "rest", "strateg = 'mis'\n") + pass("bdpt", "C<RD>.*"), "strateg");
    refused(pass("pth", "rest"), "pth");
    refused("[render]\nlayer_passes = true\n", "--layer-passes without passes");
    refused(pass("path", "rest", "spp = 0\n"), "spp");
    refused("pass = []\n", "job.toml:2:8: 'pass' has no pass");
    refused("pass = 'path:rest'\n", "'pass'");
    refused("[pass]\nmethod = 'path'\n", "'pass'");
    refused("[[pass]]\n", "method");
    refused("[[pass]]\ntakes = 'rest'\n", "method");
    refused("[[pass]]\nmethod = 'path'\n", "takes");
    refused(pass("path", "rest", "share = -1\n"), "share");
}

TEST_CASE("Passes: flags have the keys of tables", "[passes]") {
    auto parsed = parse_pass("bdpt:C<RD>S+[<L.>O]:spp=256:share=0.5:name=caustics:aovs=true:roulette=false", {});
    REQUIRE(parsed.ok());
    CHECK(parsed->method.type == "bdpt");
    CHECK(parsed->takes == "C<RD>S+[<L.>O]");
    CHECK(parsed->samples_per_pixel == std::uint64_t{256});
    CHECK(parsed->time_share == 0.5);
    CHECK(parsed->name == "caustics");
    CHECK(parsed->has_aovs);
    REQUIRE(parsed->method.parameters.parameters.size() == 1);
    CHECK(parsed->method.parameters.parameters[0].type == raylex::ParameterType::boolean);
    CHECK(parse_pass("path:C<.'a:b=c'>L", {})->takes == "C<.'a:b=c'>L");
    CHECK_FALSE(parse_pass("path:rest:spp=4:spp=8", {}).ok());
    for (const char* wrong : {"path", ":C.*", "path:", "path:rest:spp=0", "path:rest:spp=x", "path:rest:aovs=yes"})
        CHECK_FALSE(parse_pass(wrong, {}).ok());
}
