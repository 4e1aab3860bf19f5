// An experiment's config, its plan and its arrays, without rendering.
#include <catch2/catch.hpp>

#include <cstring>
#include <set>

#include "experiments/study/plan/plan.h"
#include "experiments/study/results.h"
#include "experiments/study/run/cells/method_settings.h"
#include "tests/experiments/support.h"

using namespace raylex::experiments;
using raylex::test::Folder;

namespace {

const std::string base = R"(name = "small"
replicates = 2
[[scene]]
name = "room"
file = "room.pbrt"
[[method]]
name = "path"
integrator = "path"
[[method]]
name = "shallow"
max_depth = 2
[budget]
samples = [4, 8]
)";

struct Made {
    Folder folder;
    Made() { folder.write("room.pbrt", raylex::test::small_scene()); }
    [[nodiscard]] raylex::Result<ExperimentConfig> read(const std::string& text,
                                                        const std::vector<std::string>& overrides = {}) const {
        return read_experiment_config(folder.write("c.toml", text), overrides);
    }
};

ExperimentConfig config_of(const Made& made, const std::string& text, const std::vector<std::string>& overrides = {}) {
    auto config = made.read(text, overrides);
    INFO((config ? std::string() : config.error().to_string()));
    REQUIRE(config);
    return *std::move(config);
}

std::vector<std::string> texts(const std::string& toml) {
    const std::string text = "v = " + toml;
    TomlSource source("a.toml", text);
    const toml::table table = toml::parse(text);
    auto values = read_axis(source, *table.get("v"), "v");
    if (!values) return {"error: " + values.error().message};
    std::vector<std::string> result;
    for (const AxisValue& each : *values) result.push_back(each.text());
    return result;
}

}  // namespace

TEST_CASE("axes are values, lists, ranges and powers of two") {
    using List = std::vector<std::string>;
    CHECK(texts("[1, 2.5, 'a', true]") == List{"1", "2.5", "a", "true"});
    CHECK(texts("'1..4'") == List{"1", "2", "3", "4"});
    CHECK(texts("'1..8 step 3'") == List{"1", "4", "7"});
    CHECK(texts("'-2 .. 0'") == List{"-2", "-1", "0"});
    CHECK(texts("'pow2(0..4)'") == List{"1", "2", "4", "8", "16"});
    CHECK(texts("'sobol'") == List{"sobol"});
    CHECK(texts("'9223372036854775806..9223372036854775807'").size() == 2);
    for (const char* bad :
         {"[]", "'4..1'", "'1..4 step 0'", "'pow2(0..63)'", "'pow2(2)'", "[1, 1]", "[[1]]", "'1..x'", "'1..100000'"}) {
        CAPTURE(bad);
        CHECK(texts(bad).front().starts_with("error: "));
    }
}

TEST_CASE("sweeps and --set can set every value, and the variants follow") {
    const Made made;
    const std::string text = base + "[sweep]\nmax_depth = [3, 5]\n\"sampler.type\" = ['independent', 'sobol']\n";
    const ExperimentConfig config = config_of(made, text);
    REQUIRE(config.variants.size() == 8);
    CHECK(config.variants[1].settings == NamedValues{{"max_depth", "3"}, {"sampler.type", "sobol"}});
    CHECK(config.variants[1].render.paths.max_depth == 3);
    REQUIRE(config.variants[1].render.samples.sampler);
    CHECK(config.variants[1].render.samples.sampler->type == "sobol");
    CHECK(config.variants[1].render.paths.integrator->type == "path");
    CHECK(config.variants[4].method == 1);

    const ExperimentConfig changed =
        config_of(made, base,
                  {"replicates=3", "method.path.integrator.type=path", "scene.*.resolution=8x6",
                   "budget.samples='pow2(0..2)'", "reference.method=path", "reference.spp=64"});
    CHECK(changed.replicates == 3);
    CHECK(changed.budgets.size() == 3);
    CHECK(changed.reference.samples == 64);
    CHECK((changed.scenes[0].job.settings.film.resolution == std::array<int, 2>{8, 6}));
    CHECK(changed.hash != config.hash);
    CHECK(config_of(made, "# a remark\n" + text).hash == config.hash);  // only the values count, not the layout
}

TEST_CASE("a method's only sample filter can be swept, and its settings have the keys of a sweep") {
    const Made made;
    const std::string clamped = base +
                                "[[method]]\nname = \"clamp\"\nunbiased = false\n"
                                "integrator = {type = \"path\", lightsampler = \"uniform\"}\n"
                                "[[method.sample_filter]]\ntype = \"clamp\"\n"
                                "[method.sweep]\n\"sample_filter.luminance\" = [1, 10]\n";
    const ExperimentConfig config = config_of(made, clamped);
    REQUIRE(config.variants.size() == 4);
    CHECK_FALSE(config.methods[2].unbiased);
    CHECK(config.variants[3].settings == NamedValues{{"sample_filter.luminance", "10"}});
    CHECK(settings_text(config.variants[3].render) == NamedValues{{"integrator.type", "path"},
                                                                  {"integrator.lightsampler", "uniform"},
                                                                  {"filter_mode", "importance"},
                                                                  {"lobes", "exact"},
                                                                  {"sample_filter.type", "clamp"},
                                                                  {"sample_filter.luminance", "10"}});
    const ExperimentConfig set =
        config_of(made, clamped.substr(0, clamped.find("[method.sweep]")), {"method.clamp.sample_filter.luminance=3"});
    CHECK(settings_text(set.variants[2].render).back() ==
          std::pair<std::string, std::string>("sample_filter.luminance", "3"));
}

TEST_CASE("errors in a config have their place", "[law7]") {
    const Made made;
    made.folder.write("c.toml", "");
    struct Case {
        std::string text, message;
        int line;
    };
    const auto with = [](const std::string& from, const std::string& to) {
        std::string text = base;
        text.replace(text.find(from), from.size(), to);
        return text;
    };
    const std::vector<Case> cases{
        {with("replicates", "replicatez"), "unknown key 'replicatez'", 2},
        {with("max_depth", "max_dept"), "unknown key 'max_dept' in a [[method]] table", 11},
        {with("samples = [4, 8]", "samples = []"), "'samples' is empty", 13},
        {with("samples = [4, 8]", "samples = [0]"), "'0' is not a budget of samples", 13},
        {with("samples = [4, 8]", "seconds = -1"), "'-1' is not a budget of seconds", 13},
        {with("samples = [4, 8]", "error = '0%'"), "'0%' is not a budget of error", 13},
        {with("[budget]\nsamples = [4, 8]", ""), "the config has no [budget]", 1},
        {with("room.pbrt", "rom.pbrt"), "cannot find the scene", 5},
        {with("integrator = \"path\"", "integrator = { type = 'path', strateg = 1 }"),
         "integrator 'path' has no parameter 'strateg'", 8},
        {with("name = \"shallow\"", "name = \"path\""), "the method name 'path' is used twice", 10},
        {with("name = \"shallow\"", "name = \"a/b\""), "cannot be a part of file names", 10},
        {base + "[sweep]\nmax_dept = [1, 2]\n", "unknown key 'max_dept'", 15},
        {base + "[sweep]\n", "the sweep is empty", 14},
        {base + "[sweep]\n'filter.xradius' = [1, 2]\n", "[filter] has no 'type'", 15},
        {base + "[[exclude]]\nmethod = 'pth'\n", "unknown method 'pth'", 15},
        {base + "[reference]\nmethod = 'path'\n", "has neither error nor spp", 14},
        {base + "[[region]]\nname = 'a'\ncrop = [4, 0, 4, 4]\n", "'crop' is not a rectangle", 16},
        {base + "[[region]]\nname = 'a'\nmask = 'no.exr'\n", "cannot find the mask", 16},
        {with("max_depth = 2", "command = 'x {scene} {out} {sed}'"), "unknown placeholder 'sed'", 9},
        {with("max_depth = 2", "command = 'x {scene} {out} {spp}'"), "lacks {seed}", 9},
    };
    for (const Case& each : cases) {
        auto config = made.read(each.text);
        CAPTURE(each.text);
        REQUIRE_FALSE(config);
        CAPTURE(config.error().to_string());
        CHECK(config.error().message.find(each.message) != std::string::npos);
        CHECK(config.error().line == each.line);
        CHECK(config.error().file == made.folder.path("c.toml"));
    }
    const std::vector<std::pair<std::string, std::string>> overrides{
        {"replicates=0", "expected an integer from 1"},
        {"replicates", "this sets nothing"},
        {"method.pth.max_depth=1", "did you mean 'path'?"},
        {"method.path.max_dept=1", "did you mean 'max_depth'?"},
        {"replicate=4", "did you mean 'replicates'?"}};
    for (const auto& [override, message] : overrides) {
        auto config = made.read(base, {override});
        CAPTURE(override);
        REQUIRE_FALSE(config);
        CHECK(config.error().to_string().starts_with("--set " + override));
        CHECK(config.error().to_string().find(message) != std::string::npos);
    }
}

TEST_CASE("a plan interleaves methods, honours exclusions, and never repeats a seed") {
    const Made made;
    const ExperimentConfig config = config_of(made, base + "[[exclude]]\nmethod = 'shallow'\nsamples = 8\n",
                                              {"replicates=500", "reference.method=path", "reference.spp=1"});
    auto plan = make_plan(config);
    REQUIRE(plan);
    REQUIRE(plan->runs.size() == 500 * 3);
    CHECK(plan->runs[0].run.id == "room.path.4spp.r0");
    CHECK(plan->runs[1].run.id == "room.shallow.4spp.r0");
    CHECK(plan->runs[2].run.id == "room.path.8spp.r0");
    CHECK(plan->runs[3].run.id == "room.path.4spp.r1");
    std::set<std::uint32_t> seeds;
    for (const std::uint64_t seed : plan->reference_seeds) CHECK(seeds.insert(short_seed(seed)).second);
    for (const PlannedRun& each : plan->runs) CHECK(seeds.insert(short_seed(each.run.seed)).second);
    // More replicates keep the seeds of the first ones.
    auto more = make_plan(config_of(made, base, {"replicates=2", "reference.method=path", "reference.spp=1"}));
    REQUIRE(more);
    CHECK(more->runs[0].run.seed == plan->runs[0].run.seed);
    // Another seed of the config shares no seed with it.
    auto other = make_plan(config_of(made, base, {"seed=1"}));
    REQUIRE(other);
    for (const PlannedRun& each : other->runs) CHECK_FALSE(seeds.contains(short_seed(each.run.seed)));
    auto nothing = make_plan(config_of(made, base + "[[exclude]]\nsamples = 5\n"));
    REQUIRE_FALSE(nothing);
    CHECK(nothing.error().message.find("matches no cell") != std::string::npos);
}

TEST_CASE("arrays have NumPy's format, and are read back bit by bit") {
    const Folder folder;
    const PixelArray array{2, 3, 2, {0.1, -2, 3e300, 5e-324, 0, 1, 2, 3, 4, 5, 6, 7}};
    REQUIRE(write_npy(folder.path("a.npy"), array));
    auto read = read_npy(folder.path("a.npy"));
    REQUIRE(read);
    CHECK(read->height == 2);
    CHECK(read->width == 3);
    CHECK(read->components == 2);
    CHECK((std::memcmp(read->values.data(), array.values.data(), 12 * sizeof(double)) == 0));
    const std::string bytes = folder.read("a.npy");
    CHECK(bytes.size() % 64 == (12 * sizeof(double)) % 64);  // the data are aligned, as the format recommends
    CHECK(bytes.substr(10, 62) == "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3, 2), }");
    REQUIRE(write_npy_counts(folder.path("n.npy"), 1, 2, {7, 1ULL << 40}));
    auto counts = read_npy(folder.path("n.npy"));
    REQUIRE(counts);
    CHECK(counts->components == 1);
    CHECK(counts->values == std::vector<double>{7, 1099511627776.0});
    folder.write("short.npy", bytes.substr(0, bytes.size() - 1));
    folder.write("other.npy", "P6 hello");
    std::string fortran = bytes;
    fortran.replace(fortran.find("False"), 5, "True ");
    folder.write("fortran.npy", fortran);
    for (const char* name : {"short.npy", "other.npy", "fortran.npy", "none.npy"}) {
        auto refused = read_npy(folder.path(name));
        REQUIRE_FALSE(refused);
        CHECK(refused.error().file == folder.path(name));
    }
}
