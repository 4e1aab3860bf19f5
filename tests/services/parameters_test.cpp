#include "display/services/parameters.h"

#include <catch2/catch.hpp>

#include "display/services/registry.h"

namespace raylex {
namespace {

Parameter number(std::string name, ParameterType type, std::vector<double> values, int line) {
    Parameter parameter;
    parameter.name = std::move(name);
    parameter.type = type;
    parameter.numbers = std::move(values);
    parameter.location = {"scene.pbrt", line, 5};
    return parameter;
}

ParameterSet sample_set() {
    ParameterSet set;
    set.location = {"scene.pbrt", 3, 1};
    set.parameters.push_back(number("sigma", ParameterType::real, {0.25}, 4));
    set.parameters.push_back(number("maxdepth", ParameterType::integer, {7}, 5));
    set.parameters.push_back(number("scale", ParameterType::real, {1, 2}, 6));
    Parameter flag;
    flag.name = "regularize";
    flag.type = ParameterType::boolean;
    flag.booleans = {1};
    set.parameters.push_back(flag);
    Parameter text;
    text.name = "lightsampler";
    text.type = ParameterType::string;
    text.strings = {"power"};
    set.parameters.push_back(text);
    return set;
}

TEST_CASE("look-ups return the written value, or else the default", "[parameters]") {
    const ParameterSet set = sample_set();
    CHECK(*set.real_or("sigma", 1) == 0.25);
    CHECK(*set.real_or("maxdepth", 1) == 7.0);  // an integer is accepted as a real
    CHECK(*set.integer_or("maxdepth", 1) == 7);
    CHECK(*set.boolean_or("regularize", false));
    CHECK(*set.string_or("lightsampler", "bvh") == "power");
    CHECK(*set.real_or("absent", 2.5) == 2.5);
    CHECK(*set.string_or("absent", "bvh") == "bvh");
    REQUIRE(set.unused().size() == 1);
    CHECK(set.unused()[0]->name == "scale");
}

TEST_CASE("a wrong type or count is an error that names both, at the parameter", "[parameters][law7]") {
    const ParameterSet set = sample_set();
    const auto wrong_type = set.integer_or("sigma", 1);
    REQUIRE_FALSE(wrong_type);
    CHECK(wrong_type.error().message == "parameter 'sigma' has type float; expected one integer");
    CHECK(wrong_type.error().file == "scene.pbrt");
    CHECK(wrong_type.error().line == 4);
    CHECK(wrong_type.error().column == 5);
    const auto wrong_count = set.real_or("scale", 1);
    REQUIRE_FALSE(wrong_count);
    CHECK(wrong_count.error().message == "parameter 'scale' has 2 values; expected one float");
    // An error about a parameter without a position is at its directive.
    const auto flag = set.real_or("regularize", 1);
    REQUIRE_FALSE(flag);
    CHECK(flag.error().line == 3);
}

TEST_CASE("an integer that a double cannot represent exactly is refused", "[parameters][law7]") {
    ParameterSet set;
    set.parameters.push_back(number("n", ParameterType::integer, {1e300}, 2));
    CHECK_FALSE(set.integer_or("n", 0));
}

TEST_CASE("near misses are typos, not guesses", "[parameters]") {
    const std::vector<std::string> names{"gaussian", "box", "mitchell"};
    CHECK(nearest_name("gausian", names) == "gaussian");
    CHECK(nearest_name("Mitchell", names) == "mitchell");
    CHECK(nearest_name("bxo", names) == "box");  // swapped neighbours are one typo
    CHECK(nearest_name("triangle", names).empty());
    CHECK(nearest_name("z", {"P"}).empty());  // replacing every letter gives a different word
    CHECK(nearest_name("anything", {}).empty());
}

TEST_CASE("long names are compared quickly, and quoted in part", "[parameters][law7]") {
    const std::string endless(5'000'000, 'a');
    CHECK(nearest_name(endless, {"gaussian", endless + "b"}).empty());
    CHECK(nearest_name("gaussian", {endless}).empty());
    CHECK(edit_distance(endless, endless + "b") == endless.size() + 1);
    CHECK(edit_distance(endless, endless) == 0);
    const std::string list(3900, 'x');
    CHECK(error_at({}, list, list).message == list);
    const Error error = error_at({}, "no filter is called '" + endless + "'; expected box", endless);
    CHECK(error.message.size() < 700);
    CHECK(error.hint.size() < 700);
    CHECK(error.message.starts_with("no filter is called 'aaa"));
    CHECK(error.message.ends_with("aaa'; expected box"));
    // The message is cut between characters, which have two bytes here.
    std::string accents = "'";
    for (int i = 0; i < 3000; ++i) accents += "\u00e9";
    const std::string shown = error_at({}, accents).message;
    const std::size_t cut = shown.find("...[");
    REQUIRE(cut != std::string::npos);
    CHECK(cut % 2 == 1);
    CHECK(shown.substr(shown.find("]...") + 4).size() % 2 == 0);
}

TEST_CASE("an unknown name gives an error with the known names and a similar one", "[registry][law7]") {
    Registry<int> registry("widget");
    registry.add({"cube", "", {}, 1});
    registry.add({"sphere", "", {}, 2});
    registry.add({"cube", "", {}, 3});  // a plugin overrides a built-in object
    CHECK((*registry.require("cube", {}))->factory == 3);
    const auto missing = registry.require("spere", {"job.toml", 9, 2});
    REQUIRE_FALSE(missing);
    CHECK(missing.error().message == "unknown widget 'spere'; expected one of: cube, sphere");
    CHECK(missing.error().hint == "did you mean 'sphere'?");
    CHECK(missing.error().line == 9);
}

}  // namespace
}  // namespace raylex
