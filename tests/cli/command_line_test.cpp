// What the command line itself says, whatever the command: words that are not known, help, and where
// text goes.
#include <catch2/catch.hpp>

#include "support.h"

namespace {

using raylex::test::check_refused;
using raylex::test::contains;
using raylex::test::Folder;
using raylex::test::Outcome;
using raylex::test::run_raylex;

}  // namespace

TEST_CASE("an unknown subcommand is named, with what there is") {
    const Folder folder;
    check_refused(folder, "rendr room.pbrt", {"'rendr'", "did you mean 'render'", "raylex --help"});
    check_refused(folder, "lpe chek", {"'chek'", "did you mean 'check'", "raylex lpe --help"});
}

TEST_CASE("an unknown option is named, with the one that may be meant") {
    const Folder folder;
    check_refused(folder, "render x.toml --threds 2", {"unknown option '--threds'; did you mean '--threads'?"});
    check_refused(folder, "render x.toml --threds=2", {"unknown option '--threds'; did you mean '--threads'?"});
    check_refused(folder, "scene info x.pbrt -jsn", {"'-jsn'; did you mean '--json'?", "raylex scene info --help"});
    check_refused(folder, "--colr never lpe check", {"'--colr'; did you mean '--color'?"});
    // The option that seems to be missing is the one that is misspelt.
    check_refused(folder, "experiment run c.toml --outptu o", {"'--outptu'; did you mean '--output'?"});
    // These take whatever stands behind the first expression.
    check_refused(folder, "lpe explain CL --dialct osl", {"'--dialct'; did you mean '--dialect'?", "explain --help"});
    check_refused(folder, "lpe union CL CDL --sampels 2", {"'--sampels'; did you mean '--samples'?", "union --help"});
    check_refused(folder, "--threads 2 render x.pbrt", {"'--threads' of 'raylex'; expected it behind 'raylex render'"});
    for (const char* nothing_near : {"render x.pbrt -z", "lpe check --nothing-like-it"}) {
        const Outcome outcome = run_raylex(folder, nothing_near);
        CHECK(contains(outcome.err, "unknown option '-"));
        CHECK_FALSE(contains(outcome.err, "did you mean"));
    }
}

TEST_CASE("help by a word is help by an option") {
    const Folder folder;
    for (const std::string command : {"", "render", "lpe", "lpe explain"}) {
        CAPTURE(command);
        const Outcome asked = run_raylex(folder, "help " + command), option = run_raylex(folder, command + " --help");
        CHECK(asked.code == 0);
        CHECK(contains(asked.out, "Usage: raylex " + command));
        CHECK(asked.out == option.out);
    }
    check_refused(folder, "help rendr", {"'rendr'", "did you mean 'render'"});
    check_refused(folder, "help lpe chek", {"'chek'", "did you mean 'check'"});
    check_refused(folder, "help render scene", {"'raylex render' has no subcommands"});
}
