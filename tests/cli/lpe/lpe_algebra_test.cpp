// raylex lpe equal, contains, empty, words, difference, ..., explain, graph, and match with a path that does not match.
#include <catch2/catch.hpp>

#include "support.h"
#include "tests/support/skip.h"

using namespace raylex::test;

TEST_CASE("lpe equal, contains and empty prove a statement, or print a counterexample that match reads") {
    const Folder folder;
    CHECK(run_raylex(folder, "lpe equal 'C.*' 'C.*[LOB]'").code == 0);
    CHECK(run_raylex(folder, "lpe equal '[C]L' '[C]L'").code == 0);  // not a list for CLI11
    const Outcome differ = run_raylex(folder, "lpe equal 'C[DS]*L' 'osl:C.*'");
    CHECK(differ.code == 1);
    const std::string path = differ.out.substr(differ.out.find('\n') + 1);
    CHECK(run_raylex(folder, "lpe match osl:'C.*' '" + path.substr(0, path.size() - 1) + "'").code == 0);
    CHECK(run_raylex(folder, "lpe contains 'C.*' 'CDL'").code == 0);
    CHECK(run_raylex(folder, "lpe contains 'CDL' 'C.*'").code == 1);
    CHECK(run_raylex(folder, "lpe empty 'CLD'").code == 0);
    CHECK(run_raylex(folder, "lpe empty 'CL'").out == "'CL' accepts camera, light (C,- L,-)\nC,- L,-\n");
    const Outcome wrong = run_raylex(folder, "lpe contains 'CL' 'C('");
    CHECK(wrong.code == 2);
    CHECK(wrong.err.find("second expression") != std::string::npos);
    CHECK(run_raylex(folder, "lpe equal 'CL'").code == 2);
}

TEST_CASE("lpe check can prove only disjointness or only coverage") {
    const Folder folder;
    CHECK(run_raylex(folder, "lpe check --what disjoint 'a=CL' 'b=CDL'").code == 0);
    CHECK(run_raylex(folder, "lpe check --what disjoint 'a=CL' 'b=C.*L'").code == 1);
    CHECK(run_raylex(folder, "lpe check --what covers 'a=C.*L' 'b=C.*'").code == 0);
    CHECK(run_raylex(folder, "lpe check --what covers 'a=CL' 'b=CDL'").code == 1);
    CHECK(run_raylex(folder, "lpe check --what covers --of 'C[D]?L' 'a=CL' 'b=CDL'").code == 0);
    CHECK(run_raylex(folder, "lpe check --what disjoint --of 'CL' 'a=CL'").code == 2);
    CHECK(run_raylex(folder, "lpe check --what nothing 'a=CL'").code == 2);
}

TEST_CASE("lpe check compares the parts with the channel that equals the beauty, under any name") {
    const Folder folder;
    folder.write("list.rib",
                 "DisplayChannel \"color Ci\" \"string source\" \"color lpe:C[DS]*[<L.>O]\"\n"
                 "DisplayChannel \"color diffuse\" \"string source\" \"color lpe:CD[DS]*[<L.>O]\"\n"
                 "DisplayChannel \"color specular\" \"string source\" \"color lpe:CS[DS]*[<L.>O]\"\n"
                 "DisplayChannel \"color visible\" \"string source\" \"color lpe:C[<L.>O]\"\n");
    const Outcome holds = run_raylex(folder, "lpe check --channels list.rib");
    CHECK(holds.code == 0);
    CHECK(holds.out.find("not layers (the beauty): 'Ci'") != std::string::npos);
    CHECK(run_raylex(folder, "lpe check --channels list.rib --of 'C.*'").code == 0);
    CHECK(run_raylex(folder, "lpe check --channels list.rib --of 'C.*' --volume").code == 1);
    folder.write("alone.rib", "DisplayChannel \"color Ci\" \"string source\" \"color lpe:C.*\"\n");
    CHECK(run_raylex(folder, "lpe check --channels alone.rib").code == 0);  // a single channel is a partition of itself
    CHECK(run_raylex(folder, "lpe check 'all=C.*' 'a=CL'").out.find("both count") !=
          std::string::npos);  // given one by one
}

TEST_CASE("lpe words, complement, intersection, union and difference print paths, or that there are none") {
    const Folder folder;
    const Outcome words = run_raylex(folder, "lpe words 'C<RD>L'");
    CHECK(words.code == 0);
    CHECK(words.out.find("camera, diffuse reflection, light\n    C,- R,D L,-\n") == 0);
    CHECK(words.out.find("3: 2\n") != std::string::npos);
    CHECK(run_raylex(folder, "lpe complement 'C.*'").out == "no path\n");
    CHECK(run_raylex(folder, "lpe complement 'C.*'").code == 1);
    CHECK(run_raylex(folder, "lpe difference 'C.*' 'CD.*' 'CS.*'").code == 0);
    CHECK(run_raylex(folder, "lpe difference 'C.*' 'osl:C.*'").code == 1);
    CHECK(run_raylex(folder, "lpe intersection 'C.*D.*' 'C.*S.*' 'C.{3}' --samples 1").code == 0);
    CHECK(run_raylex(folder, "lpe union '[C]L' '[CC]'").code == 0);
    CHECK(run_raylex(folder, "lpe union 'CL' --nothing").code == 2);
    CHECK(run_raylex(folder, "lpe words 'CL' 'CL'").code == 2);
    CHECK(run_raylex(folder, "lpe words 'CL' --samples 0").code == 2);
}

TEST_CASE("lpe explain describes an expression and ends with 1 if no path matches") {
    const Folder folder;
    const Outcome direct = run_raylex(folder, "lpe explain 'C<RD>[<L.>O]'");
    CHECK(direct.code == 0);
    CHECK(direct.out.find("From the camera, one diffuse reflection, ending at a light or at emission.") !=
          std::string::npos);
    CHECK(direct.out.find("It is the shipped channel 'directDiffuse'.") != std::string::npos);
    CHECK(direct.out.find("    C,- R,D L,-\n") != std::string::npos);
    CHECK(run_raylex(folder, "lpe explain 'noclamp;C.*'").out.find("noclamp: ") != std::string::npos);
    const Outcome never = run_raylex(folder, "lpe explain 'CLD'");
    CHECK(never.code == 1);
    CHECK(never.out.find("'D' (column 3)") != std::string::npos);
    const Outcome wrong = run_raylex(folder, "lpe explain 'C(D'");
    CHECK(wrong.code == 2);
    CHECK(wrong.err.find("^") != std::string::npos);
}

TEST_CASE("lpe match points at the event where a path fails and prints what was expected") {
    const Folder folder;
    CHECK(run_raylex(folder, "lpe match C.*L C,- R,D,floor L,-").code == 0);  // the path in several arguments
    const Outcome no = run_raylex(folder, "lpe match \"C<RD'floor'>L\" 'C,- R,D,flor L,-'");
    CHECK(no.code == 1);
    CHECK(no.out ==
          "no match\n"
          "the path matches up to event 1: camera\n"
          "  C,- R,D,flor L,-\n"
          "      ^\n"
          "found diffuse reflection off 'flor' at column 5; expected one diffuse reflection off 'floor'\n"
          "the expected piece is '<RD'floor'>' (column 2) of the expression\n"
          "its label 'flor' is not 'floor'; did you mean 'floor'?\n");
    const Outcome early = run_raylex(folder, "lpe match --dialect osl 'CD+L' 'C,- R,D'");
    CHECK(early.code == 1);
    CHECK(early.out.find("no match\nall 2 events match, but the path ends too early") == 0);
    CHECK(early.out.find("expected one diffuse scattering or a light") != std::string::npos);
    CHECK(run_raylex(folder, "lpe match 'CLD - C.*' 'C,-'").out == "no match\nthe expression matches no path at all\n");
}

TEST_CASE("lpe truth computes the values of expressions in a room of emitting walls") {
    const Folder folder;
    const Outcome caustics = run_raylex(folder, "lpe truth 'C<RD><RS>+L' --kd .5 --ks .3");
    CHECK(caustics.code == 0);
    CHECK(caustics.out == "0.214285714\n");  // .5 x .3 / (1 - .3)
    const Outcome several =
        run_raylex(folder, "lpe truth \"C<RD'wall'>+<L.'lamp'>\" CL --kd .75 --le 2 --object wall --group lamp");
    CHECK(several.code == 0);
    CHECK(several.out == "6  C<RD'wall'>+<L.'lamp'>\n2  CL\n");
    const Outcome limited = run_raylex(folder, "lpe truth 'C.*L' --kd 1 --max-depth 3 --by-depth");
    CHECK(limited.out.substr(0, 2) == "4\n");
    CHECK(contains(limited.out, "  3 scattering: 1\n  4 scattering: 0\n"));
    const Outcome unbounded = run_raylex(folder, "lpe truth 'C.*L' --kd .75 --ks .25");
    CHECK(unbounded.code == 2);
    CHECK(contains(unbounded.err, "expected less than 1"));
    const Outcome negative = run_raylex(folder, "lpe truth 'C.*L' --kd -1");
    CHECK(negative.code == 2);
    CHECK(contains(negative.err, "--kd"));
}

TEST_CASE("lpe graph writes DOT") {
    const Folder folder;
    const Outcome dot = run_raylex(folder, "lpe graph 'CDS+L'");
    CHECK(dot.code == 0);
    CHECK(dot.out.find("digraph") == 0);
    CHECK(run_raylex(folder, "lpe graph 'CDS+L' -o g.dot").code == 0);
    CHECK(folder.read("g.dot") == dot.out);
    CHECK(run_raylex(folder, "lpe graph 'CDS+L' -o g.png").code == 2);
    CHECK(run_raylex(folder, "lpe graph 'C('").code == 2);
    CHECK(run_raylex(folder, "lpe graph 'C.*D.{9}L' -o h.svg").code == 2);
    CHECK_FALSE(folder.has("h.svg"));
    CHECK(run_raylex(folder, "lpe graph 'CL' -o missing/g.dot").code == 2);
}

TEST_CASE("lpe graph draws SVG with Graphviz") {
    const Folder folder;
    if (run_shell(folder, "command -v dot").code != 0) RAYLEX_SKIP("needs the package graphviz");
    REQUIRE(run_raylex(folder, "lpe graph 'a=CDS+L' \"C<RD'x=y'>L\" -o g.svg").code == 0);
    const std::string svg = folder.read("g.svg");
    CHECK(contains(svg, "<svg"));
    CHECK(contains(svg, ">a</text>"));
    CHECK(contains(svg, "camera, "));  // what a viewer shows under the pointer
}

TEST_CASE("lpe graph names Graphviz where it is missing or fails") {
    const Folder folder;
    const auto refused = [&](const std::string& path) {
        const Outcome outcome = run_shell(folder, "PATH=" + path + " \"$RAYLEX\" lpe graph CDL -o g.svg");
        CHECK(outcome.code == 2);
        CHECK_FALSE(folder.has("g.svg"));
        for (const char* text : {"g.svg", "'dot'", "package graphviz", "-o g.dot"}) CHECK(contains(outcome.err, text));
        return outcome.err;
    };
    refused("/nonexistent");
    folder.write("bin/dot", "#!/bin/sh\necho broken >&2\nexit 3\n");
    REQUIRE(run_shell(folder, "chmod +x bin/dot").code == 0);
    CHECK(contains(refused("bin"), "exit code 3: broken"));
}

TEST_CASE("every lpe subcommand has help") {
    const Folder folder;
    for (const char* command : {"explain", "equal", "contains", "empty", "words", "complement", "intersection", "union",
                                "difference", "graph", "truth"}) {
        CAPTURE(command);
        const Outcome help = run_raylex(folder, std::string("lpe ") + command + " --help");
        CHECK(help.code == 0);
        CHECK(help.out.find("Exit codes:") != std::string::npos);
    }
}
