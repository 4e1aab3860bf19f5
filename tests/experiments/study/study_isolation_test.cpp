// A study with scenes that crash their process or never end: the cells of the other scenes run.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>

#include "experiments/study/results.h"
#include "experiments/study/run/processes/child_process.h"
#include "tests/experiments/support.h"
#include "tests/support/paths.h"

using namespace raylex::experiments;
using raylex::test::Folder;
using raylex::test::Outcome;
using raylex::test::run_raylex;
using raylex::test::run_shell;
using raylex::test::small_scene;

namespace {

const std::string integrator = "Integrator \"path\" \"integer maxdepth\" 3";

std::string deadly_scene(const std::string& way, const std::string& at) {
    std::string scene = small_scene();
    scene.replace(scene.find(integrator), integrator.size(),
                  "Integrator \"deadly\" \"string way\" \"" + way + "\" \"string at\" \"" + at + "\"");
    return scene;
}

struct BadScene {
    std::string way, at, reason;
};

void write_study(const Folder& folder, const std::vector<BadScene>& bad, const std::string& head = {}) {
    std::string config = head + "threads = 1\nplugins = [\"" + raylex::test::binary_dir() +
                         "/tests/libdeadly.so\"]\n[[method]]\nname = \"asis\"\n[budget]\nsamples = 1\n";
    const auto add = [&](const std::string& name, const std::string& scene) {
        folder.write(name + ".pbrt", scene);
        config += "[[scene]]\nname = \"" + name + "\"\nfile = \"" + name + ".pbrt\"\nresolution = [4, 4]\n";
    };
    for (const BadScene& each : bad) add(each.way + "-" + each.at, deadly_scene(each.way, each.at));
    add("good", small_scene());
    folder.write("c.toml", config);
}

Experiment results_of(const Folder& folder) {
    auto read = read_experiment(folder.path("out"));
    INFO((read ? std::string() : read.error().to_string()));
    REQUIRE(read);
    return *std::move(read);
}

const StudyRun& run_of(const Experiment& results, std::string_view scene) {
    const auto found = std::find_if(results.runs.begin(), results.runs.end(),
                                    [&](const StudyRun& each) { return each.scene == scene; });
    REQUIRE(found != results.runs.end());
    return *found;
}

}  // namespace

TEST_CASE("a scene that crashes its process fails alone: the other cells run, and resume continues",
          "[law7][gate][gate]") {
    const Folder folder;
    // The address sanitizer would turn a segmentation fault into an exit code.
    const char* const options = std::getenv("ASAN_OPTIONS");
    setenv("ASAN_OPTIONS", (std::string(options == nullptr ? "" : options) + ":handle_segv=0").c_str(), 1);
    const std::vector<BadScene> bad{
        {"abort", "loading", "SIGABRT"},      {"segmentation", "loading", "SIGSEGV"},
        {"abort", "rendering", "SIGABRT"},    {"kill", "rendering", "SIGKILL"},
        {"exit", "rendering", "exit code 7"}, {"exception", "loading", "thrown by the scene"}};
    write_study(folder, bad);
    const Outcome plan = run_raylex(folder, "experiment plan c.toml");
    CHECK(plan.code == 2);
    CHECK(plan.out.find("abort-loading.asis.1spp.r0  FAILS") != std::string::npos);
    CHECK(plan.out.find("good.asis.1spp.r0  seed ") != std::string::npos);
    const Outcome run = run_raylex(folder, "experiment run c.toml -o out");
    INFO(run.out << run.err);
    CHECK(run.code == 2);
    CHECK(run.out.find("1 of 7 cells done, 6 FAILED") != std::string::npos);
    const Experiment results = results_of(folder);
    REQUIRE(results.runs.size() == 7);
    CHECK_FALSE(run_of(results, "good").failed);
    for (const BadScene& each : bad) {
        const StudyRun& cell = run_of(results, each.way + "-" + each.at);
        CAPTURE(cell.id, cell.failure);
        CHECK(cell.failed);
        CHECK(cell.failure.find(each.reason) != std::string::npos);
        if (each.way == "abort") CHECK(cell.failure.find("last words of the scene") != std::string::npos);
        CHECK_FALSE(folder.has("out/cells/" + cell.id + ".partial"));
    }
    // A failed cell stays failed and crashes nothing again; on request it is run again.
    const Outcome resumed = run_raylex(folder, "experiment resume c.toml -o out");
    CHECK(resumed.code == 2);
    CHECK(resumed.out.find("] abort-rendering") == std::string::npos);
    folder.write("abort-rendering.pbrt", deadly_scene("nothing", "rendering"));
    const Outcome changed = run_raylex(folder, "experiment resume c.toml -o out --retry");
    CHECK(changed.code == 2);
    CHECK(changed.err.find("has changed since") != std::string::npos);
    folder.write("abort-rendering.pbrt", deadly_scene("abort", "rendering"));
    folder.write("abort-loading.pbrt", small_scene());  // a scene that never crashed
    const Outcome retried = run_raylex(folder, "experiment resume c.toml -o out --retry");
    INFO(retried.out << retried.err);
    CHECK(retried.code == 2);
    CHECK(retried.out.find("2 of 7 cells done, 5 FAILED") != std::string::npos);
    CHECK_FALSE(run_of(results_of(folder), "abort-loading").failed);
}

TEST_CASE("a study whose only scene crashes lists its cells as failed; an error in all scenes is reported at once",
          "[gate]") {
    const Folder folder;
    write_study(folder, {});
    folder.write("good.pbrt", deadly_scene("abort", "loading"));
    CHECK(run_raylex(folder, "experiment run c.toml -o out").code == 2);
    CHECK(run_of(results_of(folder), "good").failure.find("SIGABRT") != std::string::npos);
    folder.write("good.pbrt", "nonsense");
    const Outcome refused = run_raylex(folder, "experiment run c.toml -o other");
    CHECK(refused.code == 2);
    CHECK(refused.err.find("good.pbrt:1:1") != std::string::npos);
    CHECK_FALSE(folder.has("other/experiment.json"));
}

TEST_CASE("a cell that never ends is ended by its timeout or an interrupt; no process is left",
          "[release-only][law7][gate][gate]") {
    const Folder folder;
    write_study(folder, {{"endless", "rendering", "timeout"}}, "timeout = \"2s\"\n");
    const Outcome run = run_raylex(folder, "experiment run c.toml -o out");
    INFO(run.out << run.err);
    CHECK(run.code == 2);
    const Experiment results = results_of(folder);
    CHECK(run_of(results, "endless-rendering").failure.find("timeout of 2.00 s") != std::string::npos);
    CHECK_FALSE(run_of(results, "good").failed);
    // SIGTERM only to the program, as a batch system sends it.
    write_study(folder, {{"endless", "rendering", ""}});
    const Outcome stopped = run_shell(folder, R"("$RAYLEX" experiment run c.toml -o stopped & program=$!
for i in $(seq 200); do worker=$(pgrep -P $program); [ -n "$worker" ] && break; sleep 0.05; done
sleep 0.5; kill -TERM $program; wait $program; echo "code $?"
for i in $(seq 100); do kill -0 $worker 2>/dev/null || break; sleep 0.05; done
kill -0 $worker 2>/dev/null && echo "left behind")");
    CHECK(stopped.out.find("code 130") != std::string::npos);
    CHECK(stopped.out.find("left behind") == std::string::npos);
    // No process is left if the program itself is killed.
    const Outcome killed = run_shell(folder, R"("$RAYLEX" experiment run c.toml -o killed & program=$!
for i in $(seq 200); do worker=$(pgrep -P $program); [ -n "$worker" ] && break; sleep 0.05; done
sleep 0.2; kill -KILL $program; wait $program
for i in $(seq 100); do kill -0 $worker 2>/dev/null || break; sleep 0.05; done
kill -0 $worker 2>/dev/null && echo "left behind")");
    CHECK(killed.out.find("left behind") == std::string::npos);
}

TEST_CASE("a child process answers, sends messages, crashes with a reason and is restarted", "[gate]") {
    ChildProcess process([] {
        return [count = 0](const std::string& request, const Tell& tell) mutable {
            if (request == "die") _exit(3);
            tell("told " + request);
            return request + " " + std::to_string(++count);
        };
    });
    std::string told;
    const auto ask = [&](const std::string& text) {
        auto answer = process.ask({text, 20, nullptr, 1, [&](const std::string& each) { told = each; }});
        REQUIRE(answer);
        return *answer;
    };
    const std::string large(3'000'000, 'x');
    CHECK(ask(large).content == large + " 1");
    CHECK(told == "told " + large);
    CHECK(ask("b").content == "b 2");
    const ChildProcess::Answer death = ask("die");
    CHECK(death.content.empty());
    CHECK(death.death.find("exit code 3") != std::string::npos);
    CHECK(ask("c").content == "c 1");
}
