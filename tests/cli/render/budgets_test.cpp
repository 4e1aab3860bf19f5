// Hostile input: the program ends with a message and exit code 2, not by a signal, and budgets can be raised.
#include <catch2/catch.hpp>

#include "tests/experiments/support.h"

using raylex::test::contains;
using raylex::test::Folder;
using raylex::test::Outcome;
using raylex::test::run_raylex;
using raylex::test::run_shell;
using raylex::test::small_scene;

namespace {

void refuses(const Folder& folder, const std::string& arguments, const std::string& message) {
    const Outcome outcome = run_shell(folder, "timeout 10 \"$RAYLEX\" " + arguments);
    INFO(arguments << "\n" << outcome.err);
    CHECK(outcome.code == 2);
    CHECK(contains(outcome.err, message));
}

}  // namespace

TEST_CASE("deeply nested TOML tables are refused with line and column", "[law7][budget]") {
    const Folder folder;
    std::string header = "[a", dotted = "a", list = "a = ", inline_table = "a = ";
    for (int i = 0; i < 50'000; ++i) header += ".a", dotted += ".a", list += "[", inline_table += "{a=";
    folder.write("scene.pbrt", small_scene());
    for (const std::string& text : {header + "]\n", dotted + " = 1\n", list, inline_table}) {
        folder.write("a.toml", "# a\n" + text);
        refuses(folder, "render a.toml", "a.toml:2:");
        refuses(folder, "experiment plan a.toml", "the budget toml_depth is 100");
        refuses(folder, "lpe check --channels a.toml", "the budget toml_depth is 100");
    }
    folder.write("text.toml", "[[channel]]\nname = \"a\"\nlpe = \"C<RD'0.1.2.3.4'>.*L\" # a.b.c.d.e [[[[[\n");
    CHECK(run_raylex(folder, "lpe check --channels text.toml --budget toml_depth=2").code != 2);
}

TEST_CASE("pipes and devices on the command line are read up to a budget", "[law7][budget][gate]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    refuses(folder, "lpe vectors /dev/zero", "the budget pipe_bytes is 268435456");
    refuses(folder, "lpe check --channels /dev/zero --budget pipe_bytes=1M", "the budget pipe_bytes is 1048576");
    refuses(folder, "compare /dev/zero /dev/zero", "this is a device");
    refuses(folder, "render /dev/zero", "this is a device");
    refuses(folder, "plugins /dev/zero", "this is a device");
    const Outcome piped = run_shell(folder, "\"$RAYLEX\" lpe vectors <(printf 'CL\\tC,- L,-\\t1\\n')");
    INFO(piped.err);
    CHECK(piped.code == 0);
}

TEST_CASE("a budget is raised by a flag or the environment, and a wrong one is refused", "[budget]") {
    const Folder folder;
    folder.write("b.pbrt", "# nothing\n");
    folder.write("a.pbrt", "Include \"b.pbrt\"\nInclude \"b.pbrt\"\n" + small_scene());
    refuses(folder, "render a.pbrt --spp 1 --budget include_files=1", "the budget include_files is 1");
    const Outcome lowered =
        run_shell(folder, "RAYLEX_BUDGETS=include_files=1,image_pixels=1G \"$RAYLEX\" render a.pbrt --spp 1");
    CHECK(lowered.code == 2);
    CHECK(contains(lowered.err, "--budget include_files=VALUE"));
    const Outcome raised =
        run_shell(folder, "RAYLEX_BUDGETS=include_files=1 \"$RAYLEX\" render a.pbrt --spp 1 --budget include_files=2");
    INFO(raised.err);
    CHECK(raised.code == 0);
    refuses(folder, "render a.pbrt --budget includes=2", "names no budget");
    const Outcome wrong = run_shell(folder, "RAYLEX_BUDGETS=nonsense \"$RAYLEX\" render a.pbrt");
    CHECK(wrong.code == 2);
    CHECK(contains(wrong.err, "RAYLEX_BUDGETS"));
}

TEST_CASE("an empty file name is refused, and its option is named", "[law7]") {
    const Folder folder;
    folder.write("scene.pbrt", small_scene());
    refuses(folder, "render scene.pbrt -o ''", "the name is empty");
    refuses(folder, "lpe check --channels ''", "the name is empty");
    refuses(folder, "render ''", "empty");
}

TEST_CASE("a zero byte in a name does not truncate the message", "[law7]") {
    const Folder folder;
    folder.write("a.pbrt",
                 "WorldBegin NamedMaterial \"flo" + std::string(1, '\0') + "or\x1b[31m\"\nShape \"sphere\"\n");
    refuses(folder, "render a.pbrt", "no material is called 'flo?or?[31m'");
}
