// Lists of numbers: read without a token for each number, with the same results as single numbers.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "tests/transport/import_support.h"
#include "transport/import/pbrt/parser.h"

using namespace raylex;
using import_test::contains;
using transport::Directive;
using transport::parse_directive;
using transport::Tokenizer;

namespace {

Result<Directive> directive_of(const std::string& text) {
    static const std::string file = "numbers.pbrt";
    Tokenizer tokenizer(text, file);
    auto directive = parse_directive(tokenizer);
    if (!directive) return directive.error();
    REQUIRE(directive->has_value());
    return **std::move(directive);
}

Result<std::vector<double>> list_of(const std::string& numbers, const std::string& type = "float") {
    auto directive = directive_of("Shape \"x\" \"" + type + " v\" [" + numbers + "] \"float after\" 7");
    if (!directive) return directive.error();
    REQUIRE(directive->parameters.parameters.size() == 2);
    CHECK(directive->parameters.parameters[1].numbers == std::vector<double>{7});
    return directive->parameters.parameters[0].numbers;
}

Error error_in_list(const std::string& numbers, const std::string& type = "float") {
    const auto list = list_of(numbers, type);
    if (list) FAIL("accepted: " + numbers);
    return list.error();
}

struct Number {
    const char* written;
    double value;
};

}  // namespace

TEST_CASE("Numbers in lists are the doubles nearest to their text", "[import][numbers]") {
    const Number numbers[] = {
        {"0", 0},
        {"-0", -0.0},
        {"5.", 5},
        {".5", 0.5},
        {"-.5", -0.5},
        {"+.5", 0.5},
        {"+7", 7},
        {"1e3", 1000},
        {"1E+3", 1000},
        {"25e-1", 2.5},
        {"0.1", 0.1},
        {"16777217", 16777217},  // not a float
        {"0.100000001490116119384765625", 0.100000001490116119384765625},
        {"179769313486231570e-5", 179769313486231570e-5},
        {"3.4028234663852886e38", std::numeric_limits<float>::max()},
        {"4.9406564584124654e-324", 4.9406564584124654e-324},
        {"1e-400", 0},  // too small for a double
        {"00012", 12},
    };
    std::string together;
    std::vector<double> expected;
    for (const Number& number : numbers) {
        INFO(number.written);
        const auto alone = list_of(number.written);
        REQUIRE(alone);
        CHECK(*alone == std::vector<double>{number.value});
        CHECK(std::signbit(alone->front()) == std::signbit(number.value));
        const auto single = directive_of("Shape \"x\" \"float v\" " + std::string(number.written));
        REQUIRE(single);
        CHECK(single->parameters.parameters[0].numbers == *alone);
        together.append(" ").append(number.written);
        expected.push_back(number.value);
    }
    const auto all = list_of(together);
    REQUIRE(all);
    CHECK(*all == expected);
}

TEST_CASE("Text between the numbers of a list does not matter", "[import][numbers]") {
    const std::vector<double> expected{1, 2, 3};
    for (const char* text : {"1 2 3", "1\t2\r\n3\n", " 1 2 # ] 4 5\n3 ", "#\n1#2\n2#3\r3# end\n", "\v1\f2 +3",
                             "1 # a comment that holds ] and \"\n 2\n#\n#\n 3"}) {
        INFO(text);
        const auto list = list_of(text);
        REQUIRE(list);
        CHECK(*list == expected);
    }
    // Strings where numbers or strings are allowed; numbers cannot follow them.
    const auto spectrum = directive_of("Material \"x\" \"spectrum s\" [\"a]b\"]");
    REQUIRE(spectrum);
    CHECK(spectrum->parameters.parameters[0].strings == std::vector<std::string>{"a]b"});
    const auto marked = directive_of("Material \"x\" \"spectrum s\" [\"a#b\"] \"float v\" [1 2 3]");
    REQUIRE(marked);
    CHECK(marked->parameters.parameters[0].strings == std::vector<std::string>{"a#b"});
    CHECK(marked->parameters.parameters[0].numbers.capacity() == 0);  // '#' in a string does not begin a comment
    const auto pairs = directive_of("Material \"x\" \"spectrum s\" [400 .5 700 1.5]");
    REQUIRE(pairs);
    CHECK(pairs->parameters.parameters[0].numbers == std::vector<double>{400, 0.5, 700, 1.5});
}

TEST_CASE("A long list uses no more memory than its numbers", "[import][numbers]") {
    std::string text;
    for (int i = 0; i < 10'000; ++i) text += std::to_string(i) + (i % 100 == 0 ? " # a comment\n" : " ");
    const auto directive = directive_of("Shape \"x\" \"float v\" [" + text + "]");
    REQUIRE(directive);
    const std::vector<double>& numbers = directive->parameters.parameters[0].numbers;
    REQUIRE(numbers.size() == 10'000);
    CHECK(numbers[9'999] == 9'999);
    CHECK(numbers.capacity() == numbers.size());
}

TEST_CASE("A word that is not a number ends a list with line, column and what was expected", "[import][numbers]") {
    struct Slip {
        const char *list, *type;
        int line, column;
        const char* message;
    };
    const Slip slips[] = {
        {"1 2\n 1e400 3", "float", 2, 2, "found '1e400', too large for a double"},
        {"1 2\n -1e400 3", "float", 2, 2, "found '-1e400', too large for a double"},
        {"1\n\n1e39", "float", 3, 1, "found '1e39', beyond the range of float"},
        {"1 # 2\n0x10", "float", 2, 1, "found '0x10'; expected a number for 'float v'"},
        {"1 inf", "float", 1, 24, "not finite"},
        {"1 -nan", "float", 1, 24, "not finite"},
        {"1 2.5.1", "float", 1, 24, "found '2.5.1'; expected a number"},
        {"1 2,", "float", 1, 24, "found '2,'; expected a number"},
        {"1 -", "float", 1, 24, "found '-'; expected a number"},
        {"1 --2", "float", 1, 24, "found '--2'; expected a number"},
        {"1 +-2", "float", 1, 24, "found '+-2'; expected a number"},
        {"1 1e", "float", 1, 24, "found '1e'; expected a number"},
        {"1 . 2", "float", 1, 24, "found '.'; expected a number"},
        {"1 \"2\"", "float", 1, 24, "found string \"2\"; expected a number"},
        {"1 [2", "float", 1, 24, "found '['; expected a number"},
        {"1 true", "float", 1, 24, "found 'true'; expected a number"},
        {"1 2147483648", "integer", 1, 26, "found '2147483648'; expected an integer for 'integer v' of 32 bits"},
        {"1 -2147483649", "integer", 1, 26, "found '-2147483649'; expected an integer for 'integer v' of 32 bits"},
        {"1 99999999999999999999", "integer", 1, 26, "expected an integer for 'integer v' of 32 bits"},
        {"1 1.5", "integer", 1, 26, "found '1.5'; expected an integer"},
        {"1 2 3 4", "point3", 1, 11, "has 4 numbers; expected a multiple of 3"},
    };
    for (const Slip& slip : slips) {
        INFO(slip.list);
        const Error error = error_in_list(slip.list, slip.type);
        CHECK(error.file == "numbers.pbrt");
        CHECK(error.line == slip.line);
        CHECK(error.column == slip.column);
        CHECK(contains(error.message, slip.message));
    }
    const auto limits = list_of("-2147483648 2147483647 1e3 2.0", "integer");
    REQUIRE(limits);
    CHECK(*limits == std::vector<double>{-2147483648., 2147483647., 1000, 2});
}

TEST_CASE("An unclosed list is an error at its beginning, and an invalid vertex names its index", "[import][numbers]") {
    const auto open = directive_of("Shape \"x\"\n \"point3 P\" [\n 1 2 3\n 4 5 6\n");
    REQUIRE_FALSE(open);
    CHECK(open.error().line == 2);
    CHECK(open.error().column == 13);
    CHECK(contains(open.error().message, "'[' is never closed; expected ']' after the values of 'P'"));
    const auto wrong = directive_of("Shape \"x\" \"point3 P\" [\n 1 2 3\n 4 5 6\n 7 oops 9 ]");
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().line == 4);
    CHECK(wrong.error().column == 4);
    CHECK(contains(wrong.error().message, "found 'oops'"));
    CHECK(contains(wrong.error().message, ", at vertex 2"));
    // The readers of normals repair those that are not finite.
    const auto normals = directive_of("Shape \"x\" \"normal N\" [0 nan 1 inf 0 -inf 0 0 1]");
    REQUIRE(normals);
    const std::vector<double>& n = normals->parameters.parameters[0].numbers;
    REQUIRE(n.size() == 9);
    for (const std::size_t i : {1, 3, 5}) CHECK(std::isnan(n[i]));
    CHECK(n[8] == 1);
}
