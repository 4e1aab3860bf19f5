// The shell commands of an experiment's config, and unknown names.
#include <catch2/catch.hpp>

#include <cmath>
#include <regex>
#include <sstream>

#include "experiments/job/text/json.h"
#include "experiments/study/analysis/convergence.h"
#include "experiments/study/run/processes/external.h"
#include "tests/experiments/support.h"
#include "tests/support/paths.h"

using namespace raylex::experiments;
using raylex::test::Folder;
using raylex::test::Outcome;
using raylex::test::run_raylex;
using raylex::test::small_scene;

TEST_CASE("a shell never interprets an inserted value, whatever the quotes around its placeholder", "[law7][gate]") {
    const std::vector<std::string> nasty{"a b.pbrt",
                                         "$(touch pwned).pbrt",
                                         "`touch pwned`.pbrt",
                                         "x'; touch pwned; '",
                                         "x\"; touch pwned; \"",
                                         "x\\",
                                         "$HOME ~ * ?",
                                         "x\n touch pwned\n",
                                         "-n && touch pwned",
                                         "",
                                         "plain/name-1.pbrt",
                                         "'$(touch pwned)'",
                                         "\"$(touch pwned)\"",
                                         "x) ; touch pwned #",
                                         "${IFS}touch${IFS}pwned"};
    // Each command prints its first argument, the value after the shell's interpretation, and a full stop.
    const std::vector<std::pair<std::string, std::string>> contexts{
        {"printf '%s.' {scene}", "@"},
        {"printf '%s.' '{scene}'", "@"},
        {"printf '%s.' \"{scene}\"", "@"},
        {"printf '%s.' 'in={scene} it'", "in=@ it"},
        {"printf '%s.' \"in={scene} it\"", "in=@ it"},
        {"printf '%s.' in={scene}", "in=@"},
        {"printf '%s.' \"it's {scene}\"", "it's @"},
        {"printf '%s.' \"\\\"{scene}\\\"\"", "\"@\""},
        {"printf '%s.' \"$(printf '%sX' {scene})\"", "@X"},
        {"printf '%s.' \"$(printf '%sX' \"{scene}\")\"", "@X"},
        {"printf '%s.' \"$(printf '%sX' '{scene}')\"", "@X"},
        {"printf '%s.' \"`printf '%sX' {scene}`\"", "@X"},
        {"# it's a comment with {scene}\nprintf '%s.' {scene}", "@"},
        {"( printf '%s.' {scene} )", "@"},
        {"printf '%s.' \"$RAYLEX_SCENE\"", "@"},
        {"sh -c 'printf \"%s.\" \"$RAYLEX_SCENE\"'", "@"}};
    for (const auto& [command, wanted] : contexts)
        for (const std::string& value : nasty) {
            const Folder folder;
            CAPTURE(command, value);
            auto filled = fill_command(command, {{"scene", value}}, {});
            REQUIRE(filled);
            auto process = run_process(*filled, folder.path(""), folder.path("log.txt"), 20, nullptr, {});
            REQUIRE(process);
            CHECK(process->exit_code == 0);
            std::string expected = wanted;
            expected.replace(expected.find('@'), 1, value);
            CHECK(folder.read("log.txt") == expected + ".");
            CHECK_FALSE(folder.has("pwned"));
        }
    // Another shell would interpret inserted values, so the command is refused unless the value is inert.
    for (const char* command : {"eval \"echo {scene}\"", "sh -c 'echo {scene}'", "bash -lc \"echo {scene}\"",
                                "ssh farm render {scene}", "python3 -c 'print(\"{scene}\")'", "/bin/sh -ec 'x {scene}'",
                                "cat <<END\n{scene}\nEND", "\"eval\" {scene}", "e\\val {scene}"}) {
        CAPTURE(command);
        auto refused = fill_command(command, {{"scene", "$(touch pwned)"}}, {"c.toml", 7, 1});
        REQUIRE_FALSE(refused);
        CHECK(refused.error().line == 7);
        CHECK(refused.error().hint.find("$RAYLEX_SCENE") != std::string::npos);
        CHECK(fill_command(command, {{"scene", "room.pbrt"}}, {}));
    }
    auto arithmetic = fill_command("echo $(({spp} * 2)) ${scene}", {{"spp", "16"}, {"scene", "s"}}, {});
    REQUIRE(arithmetic);
    CHECK(arithmetic->text == "echo $((16 * 2)) ${scene}");
    CHECK(place_variable("integrator.strategy") == "RAYLEX_INTEGRATOR_STRATEGY");
    CHECK(has_place("x $RAYLEX_SPP", "spp"));
    CHECK_FALSE(has_place("x $RAYLEX_SPPX", "spp"));
}

TEST_CASE("a scene's file name stays one word in the quotes of a study's command", "[law7]") {
    const Folder folder;
    const std::string name = "$(touch pwned) 'it' `touch pwned`";
    folder.write(name + ".pbrt", small_scene());
    folder.write("c.toml", "[[scene]]\nname = \"room\"\nfile = \"" + name + R"(.pbrt"
[[method]]
name = "other"
command = "echo '{scene}' \"{scene}\" > seen.txt; : {out} {spp}"
[budget]
samples = 1
)");
    CHECK(run_raylex(folder, "experiment run c.toml -o out").code == 2);  // the command writes no image
    CHECK(folder.read("seen.txt").find(name + ".pbrt") != std::string::npos);
    CHECK_FALSE(folder.has("pwned"));
}

TEST_CASE("unknown names in a config, a job or a flag are errors with the closest match", "[law7]") {
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    const auto study = [&](const std::string& key) {
        folder.write("c.toml", "[[scene]]\nname = \"room\"\nfile = \"room.pbrt\"\n[[method]]\nname = \"mine\"\n" + key +
                                   "\n[budget]\nsamples = 1\n");
        return run_raylex(folder, "experiment run c.toml -o out");
    };
    // Also names of pbrt, because another method than the requested one would be measured.
    for (const char* name : {"ambientocclusion", "mlt", "sppm", "simplepath", "paht"}) {
        CAPTURE(name);
        const Outcome refused = study(std::string("integrator = \"") + name + "\"");
        CHECK(refused.code == 2);
        CHECK(refused.err.find("c.toml:6:") != std::string::npos);
        CHECK(refused.err.find(std::string("unknown integrator '") + name + "'; expected one of: path") !=
              std::string::npos);
        CHECK_FALSE(folder.has("out"));
        const Outcome flag = run_raylex(folder, std::string("render room.pbrt -o x.exr --integrator ") + name);
        CHECK(flag.code == 2);
        CHECK(flag.err.find(std::string("unknown integrator '") + name + "'") != std::string::npos);
        folder.write("job.toml", std::string("[scene]\nfile = \"room.pbrt\"\n[integrator]\ntype = \"") + name + "\"\n");
        const Outcome job = run_raylex(folder, "render job.toml -o x.exr");
        CHECK(job.code == 2);
        CHECK(job.err.find("job.toml:4:") != std::string::npos);
    }
    CHECK(study("integrator = \"paht\"").err.find("did you mean 'path'?") != std::string::npos);
    CHECK(study("sampler = \"pmj02bn\"").err.find("c.toml:6:") != std::string::npos);
    CHECK(study("sampler = \"halton\"").err.find("there is no sampler 'halton'") != std::string::npos);
    CHECK(study("filter = \"gausian\"").err.find("did you mean 'gaussian'?") != std::string::npos);
    CHECK(run_raylex(folder, "render room.pbrt -o x.exr --sampler sobl").err.find("did you mean 'sobol'?") !=
          std::string::npos);
    CHECK(run_raylex(folder, "render room.pbrt -o x.exr --filter boxx").err.find("did you mean 'box'?") !=
          std::string::npos);
    // Names in a scene file may be replaced, with a warning.
    folder.write("odd.pbrt", "Accelerator \"octree\"\n" + small_scene());
    CHECK(run_raylex(folder, "render odd.pbrt --spp 1 -o x.exr")
              .err.find("accelerator 'octree' is unknown; expected bvh or kdtree") != std::string::npos);
}

TEST_CASE("a reference by a method without variances does not count as exact", "[gate]") {
    // The reference is much noisier than the mean of the images: if it counted as exact, every method would be reported
    // as biased. Its noise is that of its method's replicates.
    const Folder folder;
    folder.write("room.pbrt", small_scene());
    folder.write("c.toml", R"(replicates = 12
[[scene]]
name = "room"
file = "room.pbrt"
[[method]]
name = "path"
[[method]]
name = "both"
integrator = "bdpt"
[budget]
samples = 64
[reference]
method = "both"
spp = 4
)");
    const Outcome run = run_raylex(folder, "experiment run c.toml -o out --report");
    INFO(run.out << run.err);
    REQUIRE(run.code == 0);
    CHECK(run.out.find("BIASED") == std::string::npos);
    // Such a noisy reference can hide a bias of more than a tenth; its own method is judged by the other method's
    // images.
    CHECK(std::regex_search(run.out, std::regex("\npath on room: (no bias found|cannot tell)")));
    CHECK(run.out.find("both on room: no bias found; a bias of ") != std::string::npos);
    CHECK(run.out.find("(compared with path)") != std::string::npos);
}

TEST_CASE("declared omissions and slopes through two budgets are not reported as bias", "[gate]") {
    const Folder folder;
    folder.write("c.toml", "replicates = 3\n[[scene]]\nname = \"glass\"\nfile = \"" + raylex::test::source_dir() +
                               R"(/experiments/scenes/still-life/scene.pbrt"
resolution = [24, 16]
[[method]]
name = "path"
[[method]]
name = "light"
integrator = "lighttracer"
[budget]
samples = [4, 16]
[reference]
method = "path"
spp = 64
[[channel]]
name = "direct"
lpe = "C<RD>L"
[[channel]]
name = "mirrored"
lpe = "C<RS>.*L"
)");
    const Outcome run = run_raylex(folder, "experiment run c.toml -o out --report");
    INFO(run.out << run.err);
    REQUIRE(run.code == 0);
    CHECK(run.out.find("BIASED") == std::string::npos);
    CHECK(run.out.find("not judged: the method declares that it does not find C<.S>.* (beauty, mirrored, rest)") !=
          std::string::npos);
    CHECK(run.out.find("warning: ") != std::string::npos);  // of the cell, in the terminal
    std::istringstream lines(folder.read("out/results.jsonl"));
    int checked = 0, left_out = 0;
    for (std::string line; std::getline(lines, line);) {
        const auto json = raylex::experiments::parse_json(line);
        if (json.at("kind") != "bias" || json.at("variant") != "light") continue;
        const bool omitted = json.at("omitted") == "C<.S>.*";
        CHECK(omitted == (json.at("channel") != "direct"));
        ++(omitted ? left_out : checked);
    }
    CHECK(checked == 1);
    CHECK(left_out >= 2);

    std::vector<BudgetGroup> groups;
    for (const double budget : {64.0, 256.0, 1024.0, 4096.0}) {
        BudgetGroup group;
        group.budget = budget;
        for (int i = 0; i < 6; ++i) {
            group.errors.push_back(std::pow(budget, -0.5) * (1 + 0.001 * i));  // far too shallow
            group.samples.push_back(budget);
            group.seconds.push_back(budget);
        }
        groups.push_back(group);
        const SlopeTest result = test_slope(groups, true);
        CHECK(result.too_shallow == (groups.size() == 4));
        if (groups.size() == 2) CHECK(result.text.find("three are needed") != std::string::npos);
    }
}
