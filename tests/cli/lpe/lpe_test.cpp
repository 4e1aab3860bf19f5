// raylex lpe: its output and exit codes.
#include <catch2/catch.hpp>

#include "support.h"

using namespace raylex::test;

TEST_CASE("lpe match prints the result and ends with 0 or 1") {
    const Folder folder;
    Outcome yes = run_raylex(folder, "lpe match 'CDL' 'C,- R,D,floor L,-,key'");
    CHECK(yes.code == 0);
    CHECK(yes.out == "match\n");
    Outcome no = run_raylex(folder, "lpe match 'CSL' 'C,- R,D L,-'");
    CHECK(no.code == 1);
    CHECK(no.out.find("no match\n") == 0);  // the reason follows
    CHECK(run_raylex(folder, "lpe match --dialect osl 'C[DG]L' 'C,- R,D L,-'").code == 0);
    // Labels with blanks and commas need quotes.
    CHECK(run_raylex(folder, "lpe match \"C<RD'the floor, left'>L\" \"C,- R,D,'the floor, left' L,-\"").code == 0);
    // An expression that CLI11 could read as a list.
    CHECK(run_raylex(folder, "lpe match '[C]' 'C,-'").code == 0);
}

TEST_CASE("an invalid expression is shown with a caret, and the exit code is 2", "[law7]") {
    const Folder folder;
    Outcome outcome = run_raylex(folder, "lpe match 'CD(L' 'C,- R,D L,-'");
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    CHECK(outcome.err.find("CD(L\n") != std::string::npos);
    CHECK(outcome.err.find("^") != std::string::npos);
    Outcome events = run_raylex(folder, "lpe match 'CDL' 'C,- X,D L,-'");
    CHECK(events.code == 2);
    CHECK(events.err.find("^") != std::string::npos);
}

TEST_CASE("lpe vectors prints differing rows and counts") {
    const Folder folder;
    folder.write("v.tsv", "# comment\nCDL\tC,- R,D L,-\t1\nCDL\tC,- R,S L,-\t0\nCD(L\tC,-\tERR\n");
    Outcome good = run_raylex(folder, "lpe vectors v.tsv");
    CHECK(good.code == 0);
    CHECK(good.out == "3 agree, 0 disagree\n");
    folder.write("w.tsv", "CDL\tC,- R,D L,-\t0\nCDL\tC,- R,S L,-\t0\n");
    Outcome bad = run_raylex(folder, "lpe vectors w.tsv --dialect osl");
    CHECK(bad.code == 1);
    CHECK(bad.out.find("w.tsv:1:") != std::string::npos);
    CHECK(bad.out.find("1 agree, 1 disagree\n") != std::string::npos);
    CHECK(run_raylex(folder, "lpe vectors absent.tsv").code == 2);
    folder.write("x.tsv", "CDL\tC,- R,D L,-\n");
    Outcome row = run_raylex(folder, "lpe vectors x.tsv");
    CHECK(row.code == 2);
    CHECK(row.err.find("x.tsv:1") != std::string::npos);
}

TEST_CASE("lpe check proves a partition or prints the shortest counterexample") {
    const Folder folder;
    CHECK(run_raylex(folder, "lpe check 'seen=C[<L.>O]' 'lit=C[DSV]+[<L.>O]'").code == 0);
    Outcome missed = run_raylex(folder, "lpe check 'lit=C[DSV]+[<L.>O]'");
    CHECK(missed.code == 1);
    CHECK(missed.out.find("\nC,- L,-") != std::string::npos);
    Outcome twice = run_raylex(folder, "lpe check 'all=C.*[<L.>O]' 'diffuse=CDL'");
    CHECK(twice.code == 1);
    CHECK(twice.out.find("diffuse") != std::string::npos);
    CHECK(run_raylex(folder, "lpe check --of 'CDL' 'diffuse=CDL'").code == 0);
    CHECK(run_raylex(folder, "lpe check 'a=CDL' 'a=CSL'").code == 2);
    CHECK(run_raylex(folder, "lpe check 'CDL'").code == 2);
    CHECK(run_raylex(folder, "lpe check 'a=C('").code == 2);
}

TEST_CASE("the command line's own errors end with 2, help with 0") {
    const Folder folder;
    CHECK(run_raylex(folder, "").code == 2);
    CHECK(run_raylex(folder, "paint").code == 2);
    CHECK(run_raylex(folder, "lpe").code == 2);
    CHECK(run_raylex(folder, "lpe match").code == 2);
    CHECK(run_raylex(folder, "lpe match --dialect french 'C' 'C,-'").code == 2);
    CHECK(run_raylex(folder, "render --no-such-flag x.pbrt").code == 2);
    CHECK(run_raylex(folder, "compare a.exr b.exr --metric nice").code == 2);
    CHECK(run_raylex(folder, "--version").code == 0);
    for (const char* command :
         {"", "render", "lpe", "lpe match", "lpe vectors", "lpe check", "verify", "compare", "report"}) {
        CAPTURE(command);
        Outcome help = run_raylex(folder, std::string(command) + " --help");
        CHECK(help.code == 0);
        CHECK(help.err.empty());
    }
    const std::string help = run_raylex(folder, "render --help-all").out;
    for (const char* option : {"-o", "--spp", "--seed", "--threads", "--resolution", "--integrator", "--max-depth",
                               "--sampler", "--filter", "--lpe", "--dialect", "--no-beauty", "--aov", "--ocio",
                               "--rendering-space", "--isa", "--preview", "--stats"}) {
        CAPTURE(option);
        CHECK(help.find(option) != std::string::npos);
    }
}

TEST_CASE("the example in lpe match --help works as printed") {
    const Folder folder;
    const std::string help = run_raylex(folder, "lpe match --help").out;
    const std::string mark = "Example: raylex ";
    const std::size_t at = help.find(mark);
    REQUIRE(at != std::string::npos);
    const std::size_t begin = at + mark.size();
    CHECK(run_raylex(folder, help.substr(begin, help.find('\n', begin) - begin)).out == "match\n");
}
