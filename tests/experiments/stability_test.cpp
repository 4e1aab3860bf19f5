// `raylex stability`: the fast half of raylex's suite holds; the format of case files, and cases that fail, are invalid
// or end their process.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/stability/suite/case_file.h"
#include "experiments/stability/suite/check_line.h"
#include "experiments/stability/suite/formula.h"
#include "support.h"
#include "tests/support/paths.h"

using namespace raylex;
using namespace raylex::experiments;
using namespace raylex::test;

namespace {

const std::string head = "title = \"Tried\"\n";

/// A case with a constant environment, which every camera ray meets.
std::string environment_case(const std::string& keys) {
    return R"([[case]]
name = "environment"
symptom = "none"
reason = "a constant"
scene = '''
Camera "perspective"
Film "rgb" "integer xresolution" 4 "integer yresolution" 2
WorldBegin
LightSource "infinite" "rgb L" [ ${L} ${2*L} ${L/2} ]
'''
spp = 4
seeds = 2
)" + keys + "\n";
}

StabilityCase case_with(const std::string& tolerance, Comparison comparison = Comparison::equal) {
    StabilityCase each;
    each.tolerance.text = tolerance;
    each.comparison = comparison;
    return each;
}

LineResult checked(const StabilityCase& what, const ProbeResult& result, const Setting& setting = {}) {
    LineResult line;
    REQUIRE(run_checks(what, setting, result, line).ok());
    return line;
}

}  // namespace

TEST_CASE("the fast half of raylex's suite holds", "[stability][release-only][gate][gate]") {
    const Folder folder;
    const Outcome outcome = run_raylex(folder, "stability --fast -o out");
    INFO(outcome.out << outcome.err);
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.out, " 0 not"));
    const Outcome page = run_shell(folder, "grep -c 'Every line holds' out/page.html");
    CHECK(page.out == "1\n");
}

TEST_CASE("formulas of cases evaluate in double and name what they do not know", "[stability]") {
    CHECK(*evaluate("2*_pi*(1 - sqrt(1 - s^2))", {{"s", 0.5}}, {}) == Approx(0.841787));
    CHECK(*evaluate("1 - 2^-24", {}, {}) == 1 - 0x1p-24);
    CHECK(*evaluate("1e-38", {}, {}) == 1e-38);
    const auto wrong = evaluate("2*q", {{"s", 1}}, {"a.toml", 3, 4});
    REQUIRE(!wrong.ok());
    CHECK(contains(wrong.error().to_string(), "a.toml:3:4"));
    CHECK(contains(wrong.error().hint, "numbers of the case: s"));
    Setting setting;
    setting.numbers["x"] = 0.1;
    setting.words["kind"] = "sphere";
    CHECK(*fill_in("${kind} ${x} ${10*x}.", setting, {}) == "sphere 0.10000000000000001 1.");
    CHECK(!fill_in("${x", setting, {}).ok());
    CHECK(terms_of("max(1, 2 + 3) se + 4 ulp") == std::vector<std::string>{"max(1, 2 + 3) se", "4 ulp"});
}

TEST_CASE("tolerances are sums of standard errors, ulps, shares and numbers", "[stability]") {
    ProbeResult result;
    result.measured = 10;
    result.expected = 10.5;
    result.standard_error = 0.1;
    // ulp(10.5) in float is 2^-20.
    CHECK(checked(case_with("4 se + 2 ulp + 0.01 rel + 0.001"), result).allowed ==
          Approx(0.4 + 2 * 0x1p-20 + 0.105 + 0.001).epsilon(1e-12));
    CHECK(checked(case_with("5 se"), result).result == LineState::holds);
    CHECK(checked(case_with("4.9 se"), result).result == LineState::fails);
    CHECK(checked(case_with("exact"), result).result == LineState::fails);
    CHECK(checked(case_with("exact", Comparison::at_most), result).result == LineState::holds);
    CHECK(checked(case_with("exact", Comparison::at_least), result).result == LineState::fails);
    // Two seeds determine their scatter badly: 4 standard errors are as rare as 1e4 of them with one degree of freedom.
    result.degrees = 1;
    CHECK(checked(case_with("4 se"), result).allowed ==
          Approx(0.1 / std::tan(0.5 * 3.14159265 * 6.334248e-5)).epsilon(1e-4));
    result.measured = NAN;
    for (const Comparison each : {Comparison::equal, Comparison::at_most, Comparison::at_least})
        CHECK(checked(case_with("1e30", each), result).result == LineState::fails);
    LineResult line;
    CHECK(!run_checks(case_with("exact"), {}, ProbeResult(), line).ok());  // no expected value
}

TEST_CASE("a case of a scene is rendered for every combination and judged", "[stability][cli]") {
    const Folder folder;
    folder.write("held.toml", head + environment_case("vary.L = [1, \"1/4\"]\nintegrators = [\"path\", \"bdpt\"]\n"
                                                      "expected = \"3.5*L/3\"\ntolerance = \"2 ulp\""));
    const Outcome held = run_raylex(folder, "stability held.toml");
    INFO(held.out << held.err);
    CHECK(held.code == 0);
    CHECK(contains(held.out, "L = 1/4, bdpt"));
    CHECK(contains(held.out, "4 lines hold, 0 not"));
    folder.write("red.toml",
                 head + environment_case("with.L = 3\ncomponent = 0\nexpected = 3.1\ntolerance = \"0.05\""));
    const Outcome red = run_raylex(folder, "stability red.toml -o out");
    CHECK(red.code == 1);
    CHECK(contains(red.out, "fails"));
    CHECK(run_shell(folder, "grep -c '1 line does not hold' out/page.html").out == "1\n");
    CHECK(contains(run_shell(folder, "cat out/results.csv").out, ",fails,"));
    folder.write("same.toml", head + environment_case("with.L = 3\nmeasure = \"same_bits\"\nagainst.L = \"L + 1\"\n"
                                                      "expected = 24\ntolerance = \"exact\""));
    CHECK(run_raylex(folder, "stability same.toml").code == 0);
}

TEST_CASE("--fast uses only the fast values, which are a subset of all values", "[stability][cli]") {
    const Folder folder;
    const auto text = [](const std::string& fast) {
        return head + environment_case("vary.L = [1, 2, 4]\n" + fast + "expected = \"3.5*L/3\"\ntolerance = \"2 ulp\"");
    };
    folder.write("c.toml", text("fast.L = [4, 1]\n"));
    CHECK(contains(run_raylex(folder, "stability c.toml").out, "3 lines hold, 0 not"));
    const Outcome fast = run_raylex(folder, "stability c.toml --fast");
    CHECK(contains(fast.out, "2 lines hold, 0 not"));
    CHECK_FALSE(contains(fast.out, "L = 2"));
    folder.write("c.toml", text("fast.L = [1, 3]\n"));
    check_refused(folder, "stability c.toml", {"c.toml:", "'fast.L' has 3, which 'vary' does not have"});
    folder.write("c.toml", text("fast.M = [1]\n"));
    check_refused(folder, "stability c.toml", {"c.toml:", "'fast.M' has no corresponding"});
}

TEST_CASE("an outcome is an image or a message, never a signal", "[stability][cli][gate]") {
    const Folder folder;
    folder.write("message.toml", head + environment_case("vary.L = [1, \"word\"]\nmeasure = \"outcome\"\n"
                                                         "expected = 0\ntolerance = \"exact\""));
    const Outcome message = run_raylex(folder, "stability message.toml");
    INFO(message.out << message.err);
    CHECK(message.code == 0);
    CHECK(contains(message.out, "an image"));
    CHECK(contains(message.out, "message: "));
    folder.write("signal.toml", "plugins = [\"" + binary_dir() + "/tests/libdeadly.so\"]\n" + head +
                                    environment_case("vary.L = [1, 2]\nmeasure = \"outcome\"\nintegrator = { type = "
                                                     "\"deadly\", way = \"segmentation\" }\nexpected = 0\n"
                                                     "tolerance = \"exact\"") +
                                    environment_case("with.L = 1\nexpected = \"3.5/3\"\ntolerance = \"2 ulp\"")
                                        .replace(9, 20, "name = \"next\""));
    const Outcome died = run_raylex(folder, "stability signal.toml");
    INFO(died.out << died.err);
    CHECK(died.code == 1);
    CHECK(count_matches(died.out, "died") == 2);
    CHECK(contains(died.out, "1 line holds, 2 not"));
}

TEST_CASE("the page compares another program's results", "[stability][cli][gate]") {
    const SceneFolder folder;
    folder.write("held.toml",
                 head + environment_case("vary.L = [1, 2]\nexpected = \"3.5*L/3\"\ntolerance = \"2 ulp\""));
    // Compares the program with itself: equal bits, so every difference would be an error of the comparison.
    const Outcome both = run_shell(
        folder, "\"$RAYLEX\" stability held.toml -o out --beside \"$RAYLEX\" --scene room.pbrt --scene-spp 4");
    INFO(both.out << both.err);
    CHECK(both.code == 0);
    const std::string page = run_shell(folder, "cat out/page.html").out;
    CHECK(contains(page, "<td>room.pbrt</td><td class=\"number\">0</td><td class=\"number\">0</td>"));
    CHECK(contains(page, "all hold too"));
    check_refused(folder, "stability held.toml --beside /bin/true", {"--beside needs -o"});
    const Outcome missing = run_raylex(folder, "stability held.toml -o out --beside ./nothing");
    CHECK(missing.code == 2);
    CHECK(contains(missing.err, "nothing"));
}

TEST_CASE("invalid case files are refused with line, column and the closest match", "[stability][cli]") {
    const Folder folder;
    const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
        folder.write("a.toml", text);
        check_refused(folder, "stability a.toml", words);
    };
    refused(head +
                "[[case]]\nname = \"a\"\nsymptom = \"s\"\nreason = \"r\"\nprobe = \"phase_mean_cosine\"\n"
                "tolerance = \"exact\"\n",
            {"a.toml:6", "'scene'"});
    refused(head + environment_case(""), {"a.toml:2", "tolerance"});
    refused(head + environment_case("tolerance = \"exact\"\nholds = \"nearly\""), {"at most", "nearly"});
    refused(head + environment_case("tolerance = \"exact\"\nmeasure = \"same_bits\""), {"against"});
    refused(head + environment_case("tolerance = \"exact\"\nintegrators = [\"pth\"]"), {"did you mean 'path'"});
    refused(head + environment_case("tolerance = \"exact\"\nwith.L = [1, 2]"), {"with.L", "several"});
    refused(head + environment_case("tolerance = \"exact\"\nexpcted = 1"), {"expcted", "expected"});
    refused(head + environment_case("tolerance = \"exact\"") + environment_case("tolerance = \"exact\""),
            {"second case 'environment'"});
    folder.write("a.toml", head + environment_case("tolerance = \"exact\"\nwith.L = 1\nexpected = \"M\""));
    const Outcome unknown = run_raylex(folder, "stability a.toml");
    CHECK(unknown.code == 1);  // found only when the line is judged; other lines are kept
    CHECK(contains(unknown.out, "numbers of the case: L"));
}
