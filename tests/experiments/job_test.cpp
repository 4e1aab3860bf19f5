// The settings of a TOML job, and its errors with their place.
#include <catch2/catch.hpp>

#include "experiments/job/job_file.h"

using raylex::Error;
using raylex::Result;
using raylex::experiments::Job;
using raylex::experiments::parse_job;

namespace {

constexpr const char* scene = "[scene]\nfile = 'scenes/a.pbrt'\n";

Error error_of(const std::string& text) {
    auto job = parse_job(text, "dir/job.toml");
    REQUIRE_FALSE(job);
    return job.error();
}

void check_place(const Error& error, int line, int column) {
    CHECK(error.file == "dir/job.toml");
    CHECK(error.line == line);
    CHECK(error.column == column);
}

}  // namespace

TEST_CASE("a job supports all settings of the flags") {
    auto job = parse_job(R"([scene]
file = "scenes/a.pbrt"
[output]
file = "out.exr"
preview = "/abs/out.png"
stats = "out.json"
[color]
ocio = "my.ocio"
rendering_space = "ACEScg"
[render]
spp = 64
seed = 7
threads = 2
resolution = [320, 200]
max_depth = 5
beauty = true
isa = "avx2"
lobes = "picked"
[integrator]
type = "path"
regularize = true
weights = [1, 2.5]
[sampler]
type = "independent"
[filter]
type = "gaussian"
xradius = 2
[channels]
aovs = ["Nn", "z"]
shipped_partition = true
light_groups = true
dialect = "osl"
[[channel]]
name = "caustics"
lpe = 'CDS+L'
[[channel]]
name = "direct"
lpe = "CDL"
dialect = "renderman"
[[partition]]
name = "mine"
channels = ["caustics", "direct"]
rest = "other"
[[label]]
material = "floor*"
label = "floor"
[[light_group]]
light = "spot:0"
group = "key"
)",
                         "dir/job.toml");
    REQUIRE(job);
    CHECK(job->scene_file == "dir/scenes/a.pbrt");
    CHECK(job->output == "dir/out.exr");
    CHECK(job->preview == "/abs/out.png");
    CHECK(job->statistics == "dir/out.json");
    CHECK(job->ocio_config == "dir/my.ocio");
    CHECK(job->rendering_space == "ACEScg");
    CHECK(job->settings.samples.per_pixel == 64u);
    CHECK(job->settings.samples.seed == 7u);
    CHECK(job->settings.machine.threads == 2);
    CHECK((*job->settings.film.resolution)[0] == 320);
    CHECK((*job->settings.film.resolution)[1] == 200);
    CHECK(job->settings.paths.max_depth == 5);
    CHECK(job->settings.machine.isa == "avx2");
    CHECK(job->settings.labels.picked_lobes);
    REQUIRE(job->settings.paths.integrator);
    CHECK(job->settings.paths.integrator->type == "path");
    CHECK(*job->settings.paths.integrator->parameters.boolean_or("regularize", false));
    const raylex::Parameter* weights = job->settings.paths.integrator->parameters.find("weights");
    REQUIRE(weights != nullptr);
    CHECK(weights->numbers == std::vector<double>{1, 2.5});
    CHECK(weights->type == raylex::ParameterType::real);
    CHECK(*job->settings.film.filter->parameters.real_or("xradius", 0) == 2);
    REQUIRE(job->aovs.size() == 2);
    CHECK(job->aovs[1].name == "z");
    CHECK(job->shipped_partition);
    CHECK(job->light_groups);
    REQUIRE(job->expressions.size() == 2);
    CHECK(job->expressions[0].dialect == raylex::lpe::Dialect::osl);
    CHECK(job->expressions[1].dialect == raylex::lpe::Dialect::renderman);
    // The expression's first character is after the quote.
    CHECK(job->expressions[0].location.line == 35);
    CHECK(job->expressions[0].location.column == 8);
    REQUIRE(job->partitions.size() == 1);
    CHECK(job->partitions[0].rest == "other");
    REQUIRE(job->label_rules.size() == 2);
    CHECK(job->label_rules[0].selector == raylex::transport::LabelRule::Selector::material);
    CHECK(job->label_rules[1].label == "key");
}

TEST_CASE("an unknown key is refused with its place and the closest match", "[law7]") {
    const Error error = error_of(std::string(scene) + "[render]\nssp = 4\n");
    check_place(error, 4, 1);
    CHECK(error.message.find("'ssp'") != std::string::npos);
    CHECK(error.hint == "did you mean 'spp'?");
    CHECK(error.excerpt == "ssp = 4");
    check_place(error_of(std::string(scene) + "[rendr]\nspp = 4\n"), 3, 2);
    check_place(error_of(std::string(scene) + "[[label]]\nmaterial = 'a'\nlabel = 'b'\nmash = 'c'\n"), 6, 1);
}

TEST_CASE("a wrong type is refused with what was found and expected", "[law7]") {
    const Error error = error_of(std::string(scene) + "[render]\nspp = \"many\"\n");
    check_place(error, 4, 7);
    CHECK(error.message.find("a string") != std::string::npos);
    CHECK(error.message.find("an integer") != std::string::npos);
    check_place(error_of(std::string(scene) + "[channels]\naovs = ['Nn', 3]\n"), 4, 15);
    check_place(error_of("scene = 3\n"), 1, 9);
    check_place(error_of(std::string(scene) + "[label]\nmaterial = 'a'\n"), 3, 1);
}

TEST_CASE("values out of range are refused", "[law7]") {
    for (const char* line : {"spp = 0", "seed = -1", "threads = -2", "resolution = [0, 4]", "resolution = [4]",
                             "resolution = '10y20'", "resolution = [4, 100000]", "max_depth = -1", "lobes = 'some'"}) {
        CAPTURE(line);
        CHECK(error_of(std::string(scene) + "[render]\n" + line + "\n").line == 4);
    }
}

TEST_CASE("columns count bytes, as in all errors") {
    // The two-byte letter comes before the wrong key.
    check_place(error_of("[scene]\n\"file\" = 'x'\n[[channel]]\nname = 'a' \nlpe = 'C'\n[output]\nfile = 'ä.exr' x\n"),
                7, 17);
}

TEST_CASE("invalid TOML in a job is an error with its line") {
    check_place(error_of("[scene\nfile = 'x'\n"), 1, 7);
    check_place(error_of(std::string(scene) + "[scene]\nfile = 'b'\n"), 3, 1);
}

TEST_CASE("the earliest error in the text is the one shown") {
    CHECK(error_of("[scene]\nfile = 3\n[render]\nspp = 'x'\n[zzz]\n").line == 2);
    CHECK(error_of("[zzz]\n[scene]\nfile = 3\n").line == 1);
}

TEST_CASE("missing required keys of a job are errors") {
    CHECK(error_of("").message.find("[scene]") != std::string::npos);
    CHECK(error_of("[scene]\n").message.find("'file'") != std::string::npos);
    CHECK(error_of(std::string(scene) + "[[channel]]\nname = 'a'\n").message.find("'lpe'") != std::string::npos);
    CHECK(error_of(std::string(scene) + "[[partition]]\nname = 'a'\n").message.find("channels") != std::string::npos);
    CHECK(error_of(std::string(scene) + "[[label]]\nlabel = 'a'\n").message.find("selectors") != std::string::npos);
    CHECK(error_of(std::string(scene) + "[[label]]\nlabel = 'a'\nmaterial = 'x'\nmesh = 'y'\n")
              .message.find("2 selectors") != std::string::npos);
}

TEST_CASE("invalid layer names are refused") {
    for (const char* name : {"", "a b", "a,b", "a*", "3d", "beauty", "R", "a.", "x/y"}) {
        CAPTURE(name);
        CHECK_FALSE(raylex::experiments::check_layer_name(name, {}));
    }
    for (const char* name : {"a", "light.key", "_x", "direct-1", "z", "a:b"}) {
        CAPTURE(name);
        CHECK(raylex::experiments::check_layer_name(name, {}));
    }
}
