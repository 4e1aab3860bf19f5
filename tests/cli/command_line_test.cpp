// The command line independent of the command: unknown words, help, and the destination of text.
#include <catch2/catch.hpp>

#include <algorithm>

#include "experiments/job/text/json.h"
#include "support.h"

namespace {

using raylex::experiments::parse_json;
using raylex::test::all_matches;
using raylex::test::check_refused;
using raylex::test::contains;
using raylex::test::Folder;
using raylex::test::Outcome;
using raylex::test::run_raylex;
using raylex::test::run_shell;
using raylex::test::SceneFolder;

}  // namespace

TEST_CASE("an unknown subcommand is named, with the known ones") {
    const Folder folder;
    check_refused(folder, "rendr room.pbrt", {"'rendr'", "did you mean 'render'", "raylex --help"});
    check_refused(folder, "lpe chek", {"'chek'", "did you mean 'check'", "raylex lpe --help"});
    for (const char* with_options : {"rendr room.pbrt --spp 4", "rendr room.pbrt -o out.exr"})
        check_refused(folder, with_options, {"unknown subcommand 'rendr'", "did you mean 'render'"});
}

TEST_CASE("a failed write to standard output is an error; a reader that closes the pipe is not") {
    const Folder folder;
    // Short texts and texts longer than a buffer fail in different calls.
    for (const char* command : {"lpe explain CL", "help render", "render --help", "plugins"}) {
        CAPTURE(command);
        const Outcome full = run_shell(folder, "\"$RAYLEX\" " + std::string(command) + " > /dev/full");
        CHECK(full.code == 2);
        CHECK(contains(full.err, "cannot write to standard output"));
        // The reader ends before anything is written.
        const Outcome left =
            run_shell(folder, "set -o pipefail; { sleep 0.3; \"$RAYLEX\" " + std::string(command) + "; } | true");
        CAPTURE(left.err);
        CHECK(left.code == 0);
        CHECK(left.err.empty());
    }
}

TEST_CASE("words after '--' are not options") {
    const Folder folder;
    CHECK(run_raylex(folder, "lpe explain -- CL").code == 0);
    check_refused(folder, "scene write -- -r.pbrt -o a.pbrt", {"'-o' stands after '--'"});
}

TEST_CASE("an unknown option is named, with the closest match") {
    const Folder folder;
    check_refused(folder, "render x.toml --threds 2", {"unknown option '--threds'; did you mean '--threads'?"});
    check_refused(folder, "render x.toml --threds=2", {"unknown option '--threds'; did you mean '--threads'?"});
    check_refused(folder, "scene info x.pbrt -jsn", {"'-jsn'; did you mean '--json'?", "raylex scene info --help"});
    check_refused(folder, "--colr never lpe check", {"'--colr'; did you mean '--color'?"});
    // The option that seems to be missing is misspelt.
    check_refused(folder, "experiment run c.toml --outptu o", {"'--outptu'; did you mean '--output'?"});
    // These commands accept any number of words after the first expression.
    check_refused(folder, "lpe explain CL --dialct osl", {"'--dialct'; did you mean '--dialect'?", "explain --help"});
    check_refused(folder, "lpe union CL CDL --sampels 2", {"'--sampels'; did you mean '--samples'?", "union --help"});
    check_refused(folder, "--threads 2 render x.pbrt", {"'--threads' of 'raylex'; expected it after 'raylex render'"});
    for (const char* nothing_near : {"render x.pbrt -z", "lpe check --nothing-like-it"}) {
        const Outcome outcome = run_raylex(folder, nothing_near);
        CHECK(contains(outcome.err, "unknown option '-"));
        CHECK_FALSE(contains(outcome.err, "did you mean"));
    }
}

TEST_CASE("man pages have every option of --help, and shells complete them") {
    const Folder folder;
    REQUIRE(run_raylex(folder, "help --write share").code == 0);
    for (const std::string command : {"render", "lpe check", "stability"}) {
        CAPTURE(command);
        const std::string help = run_raylex(folder, command + (command == "render" ? " --help-all" : " --help")).out;
        const auto options = all_matches(help, "\n  (-[a-z],)?(--[a-z-]+)");
        REQUIRE(options.size() > 5);
        std::string page = command;
        std::replace(page.begin(), page.end(), ' ', '-');
        // troff writes a hyphen as \-.
        const std::string manual = run_shell(folder, "tr -d '\\\\' <share/man/man1/raylex-" + page + ".1").out;
        for (const auto& option : options) {
            CAPTURE(option.back());
            CHECK(contains(manual, option.back()));
            CHECK(contains(folder.read("share/zsh/vendor-completions/_raylex"), "'" + option.back() + ":"));
        }
    }
    for (const std::string shell : {"bash", "zsh", "fish"}) {
        CAPTURE(shell);
        if (run_shell(folder, "command -v " + shell).code != 0) continue;
        CHECK(run_shell(folder,
                        "for file in $(find share/" + shell + "* -type f); do " + shell + " -n $file || exit 1; done")
                  .code == 0);
    }
    const std::string complete =
        ". share/bash-completion/completions/raylex; COMP_WORDS=(raylex lpe check --wr) "
        "COMP_CWORD=3; _raylex raylex --wr check; echo \"${COMPREPLY[@]}\"; "
        "COMP_WORDS=(raylex lpe co) COMP_CWORD=2; _raylex raylex co lpe; echo \"${COMPREPLY[@]}\"";
    CHECK(run_shell(folder, complete).out == "--write-as\ncontains complement\n");
}

TEST_CASE("a program that was moved alone names what is missing") {
    const raylex::test::SceneFolder folder;
    REQUIRE(run_shell(folder, "mkdir bin && cp \"$RAYLEX\" bin").code == 0);
    for (const std::string line : {"stability --list", "render room.pbrt --spp 32 --commands=make --shards 2"}) {
        const Outcome alone = run_shell(folder, "bin/raylex " + line);
        CHECK(alone.code == 2);
        CHECK(contains(alone.err, "this part of raylex is missing"));
        CHECK(contains(alone.err, "move it too"));
    }
}

TEST_CASE("raylex help prints the same text as --help") {
    const Folder folder;
    for (const std::string command : {"", "render", "lpe", "lpe explain"}) {
        CAPTURE(command);
        const Outcome requested = run_raylex(folder, "help " + command),
                      option = run_raylex(folder, command + " --help");
        CHECK(requested.code == 0);
        CHECK(contains(requested.out, "Usage: raylex " + command));
        CHECK(requested.out == option.out);
    }
    check_refused(folder, "help rendr", {"'rendr'", "did you mean 'render'"});
    check_refused(folder, "help lpe chek", {"'chek'", "did you mean 'check'"});
    check_refused(folder, "help render scene", {"'raylex render' has no subcommands"});
}

TEST_CASE("'-' is standard output for every command that writes text, and nothing else is printed there") {
    const SceneFolder folder;
    const auto run_well = [&](const std::string& arguments) {
        Outcome outcome = run_raylex(folder, arguments);
        INFO(arguments << "\n" << outcome.err);
        REQUIRE(outcome.code == 0);
        REQUIRE_FALSE(folder.has("-"));
        return outcome;
    };
    run_well("scene write room.pbrt -o again.pbrt");
    CHECK(run_well("scene write room.pbrt -o -").out == folder.read("again.pbrt"));

    const Outcome info = run_well("scene info room.pbrt --json -");
    CHECK(parse_json(info.out).is_object());
    CHECK(contains(info.err, "film rgb 16x16"));

    const Outcome render = run_well("render room.pbrt --spp 1 --light-groups --stats -");
    CHECK(parse_json(render.out)["complete"] == true);
    CHECK(contains(render.err, "room.exr: 16x16"));
    CHECK(contains(render.err, "sums to beauty"));
    folder.write("jobs/job.toml", "[scene]\nfile = '../room.pbrt'\n[output]\nfile = 'job.exr'\nstats = '-'\n");
    CHECK(parse_json(run_well("render jobs/job.toml --spp 1").out)["complete"] == true);
    CHECK_FALSE(folder.has("jobs/-"));

    CHECK(contains(run_well("report room.exr -o -").out.substr(0, 20), "<!DOCTYPE html>"));
    for (const std::string command : {"lpe split --by lobe", "lpe graph CDL"})
        CHECK(run_well(command + " -o -").out == run_well(command).out);
    const Outcome check = run_well("lpe check a=CL b=CDL --what disjoint -o -");
    CHECK(check.out.starts_with("[[channel]]\nname = \"a\"\n"));
    CHECK(contains(check.err, "no path is counted by two"));
    check_refused(folder, "lpe check a=CL --what disjoint --json -o -", {"--json and -o -", "a file name"});
}

TEST_CASE("binary files cannot be written to standard output") {
    const SceneFolder folder;
    for (const char* output : {"--deep -", "--atlas -", "--driver exr:file=-"})
        check_refused(folder, "render room.pbrt -o a.exr --spp 1 " + std::string(output), {"standard output, '-'"});
    check_refused(folder, "render room.pbrt -o -", {"'-' does not end in .exr"});
    check_refused(folder, "merge x.exr.shard-1-of-1 -o x.exr --atlas -", {"standard output, '-'"});
    // Meshes from files are written to files, because label rules refer to them by file name.
    folder.write("m.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    folder.write("mesh.pbrt", raylex::test::small_scene() + "Shape \"plymesh\" \"string filename\" \"m.ply\"\n");
    check_refused(folder, "scene write mesh.pbrt -o -", {"1 mesh of the scene came from files", "behind -o"});
}
