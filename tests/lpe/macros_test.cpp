// Names of expressions: built-in names, light groups, macros, and errors with the position of the definition.
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/language/names.h"
#include "lpe/language/source_map.h"

using namespace raylex;
using namespace raylex::lpe;

namespace {

ChannelSource macro_source(const std::string& expression, const std::string& name = "c") {
    ChannelSource result;
    result.name = name;
    result.expression = expression;
    return result;
}

MacroTable table(const std::vector<std::pair<std::string, std::string>>& macros) {
    MacroTable result;
    for (const auto& [name, expression] : macros) {
        ChannelSource macro = macro_source(expression, name);
        macro.origin = "rendermn.ini";
        macro.origin_line = 1 + static_cast<int>(result.list().size());
        macro.origin_column = 20;
        REQUIRE(result.add(macro));
    }
    return result;
}

std::string expanded(const std::string& expression, const MacroTable& macros = {}) {
    const auto expansion = expand_names(macro_source(expression), macros);
    return expansion ? expansion->source.expression : "error: " + expansion.error().message;
}

}  // namespace

TEST_CASE("every built-in name parses and can match", "[macros]") {
    REQUIRE(builtin_names().size() == 16);
    for (const NamedExpression& entry : builtin_names()) {
        INFO(entry.name);
        const auto word = find_path_string(macro_source(std::string(entry.name)));
        REQUIRE(word);
        CHECK(word->has_value());
        CHECK(expanded(std::string(entry.name)) == entry.expression);
    }
}

TEST_CASE("a built-in name denotes the published expression, with or without its mark", "[macros]") {
    for (const char* spelling : {"diffuse", "lpe:diffuse", "  diffuse  ", " lpe: diffuse # the direct part"}) {
        const auto difference = find_difference(macro_source(spelling), macro_source("CD<L.>"));
        INFO(spelling);
        REQUIRE(difference);
        CHECK_FALSE(difference->has_value());
    }
    CHECK(expanded("unoccluded;noclamp;diffuse") == "unoccluded;noclamp;CD<L.>");
    CHECK(*expression_prefixes(macro_source("noclamp;shadowcollector")) ==
          std::vector<std::string>{"noclamp", "shadows"});
}

TEST_CASE("a light group suffix labels every <L.> and nothing else", "[macros]") {
    CHECK(expanded("beauty_key") == "C.*[<L.'key'>O]");
    CHECK(expanded("lpe:indirectdiffuse_rim_left") == "lpe:(C<RD>[DS]+<L.'rim_left'>)|(C<RD>[DS]*O)");
    const MacroTable macros = table({{"odd", "C< L . ><L.><L.'x'>'<L.>'L"}, {"odd_key", "CDL"}});
    CHECK(expanded("odd_fill", macros) == "C<L.'fill'><L.'fill'><L.'x'>'<L.>'L");
    CHECK(expanded("odd_key", macros) == "CDL");  // a macro with the whole name takes precedence over a name with a
                                                  // group
}

TEST_CASE("a light group without effect gives a warning", "[macros]") {
    const auto expansion = expand_names(macro_source("emission_key"));
    REQUIRE(expansion);
    CHECK(expansion->source.expression == "CO");
    REQUIRE(expansion->warnings.size() == 1);
    CHECK(expansion->warnings.front().find("'key' changes nothing") != std::string::npos);
    const auto warnings = expression_warnings(macro_source("emission_key"));
    REQUIRE(warnings);
    CHECK(warnings->size() == 1);
}

TEST_CASE("macros denote channels and, after '$', expressions in parentheses", "[macros]") {
    const MacroTable macros =
        table({{"bounce", "[DS]|V"}, {"direct", "C<RD><L.>"}, {"both", "$direct|(C$bounce<L.>)"}});
    CHECK(expanded("direct", macros) == "C<RD><L.>");
    CHECK(expanded("C$bounce*L", macros) == "C([DS]|V)*L");
    CHECK(expanded("C${bounce}S", macros) == "C([DS]|V)S");
    CHECK(expanded("both_key", macros) == "(C<RD><L.'key'>)|(C([DS]|V)<L.'key'>)");
    CHECK(expanded("C'$bounce'L", macros) == "C'$bounce'L");  // in quotes it is a label
    CHECK(expanded("CDL # $nobody", macros) == "CDL # $nobody");
    CHECK(expanded("CDL", table({{"CDLx", "CO"}})) == "CDL");  // an expression is not a name
}

TEST_CASE("macros that use themselves are refused, and the error shows the circle", "[macros]") {
    const MacroTable macros = table({{"one", "C$two"}, {"two", "$three|O"}, {"three", "D$one"}, {"self", "self"}});
    for (const auto& [name, circle] : {std::pair<std::string, std::string>{"one", "one -> two -> three -> one"},
                                       {"C$two", "two -> three -> one -> two"},
                                       {"self", "self -> self"}}) {
        const auto expansion = expand_names(macro_source(name), macros);
        INFO(name);
        REQUIRE_FALSE(expansion);
        CHECK(expansion.error().message.find(circle) != std::string::npos);
        CHECK(expansion.error().file == "rendermn.ini");
    }
}

TEST_CASE("macros that grow beyond the limits are refused", "[macros]") {
    MacroTable wide, deep;
    REQUIRE(wide.add(macro_source("CDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDDL", "m0")));
    for (int k = 1; k < 40; ++k) {
        const std::string below = "$m" + std::to_string(k - 1);
        REQUIRE(wide.add(macro_source(below + below, "m" + std::to_string(k))));  // 2^39 copies
    }
    const auto grown = expand_names(macro_source("m39"), wide);
    REQUIRE_FALSE(grown);
    CHECK(grown.error().message.find("65536 bytes") != std::string::npos);
    REQUIRE(deep.add(macro_source("CDL", "d0")));
    for (int k = 1; k < 200; ++k) {
        REQUIRE(deep.add(macro_source("$d" + std::to_string(k - 1), "d" + std::to_string(k))));
    }
    CHECK(expand_names(macro_source("$d10"), deep));
    const auto sunk = expand_names(macro_source("$d199"), deep);
    REQUIRE_FALSE(sunk);
    CHECK(sunk.error().message.find("more than 64 deep") != std::string::npos);
}

TEST_CASE("unknown names give suggestions, and prefixes cannot be inside an expression", "[macros]") {
    const MacroTable macros = table({{"caustics", "C<RD>S+<L.>"}, {"raw", "noclamp;C.*"}});
    const auto near = expand_names(macro_source("lpe:caustic"), macros);
    REQUIRE_FALSE(near);
    CHECK(near.error().hint == "did you mean 'caustics'?");
    CHECK(near.error().column == 5);
    const auto inside = expand_names(macro_source("CD$nobody"), macros);
    REQUIRE_FALSE(inside);
    CHECK(inside.error().column == 4);
    CHECK(expanded("C$raw", macros).find("has the prefix 'noclamp'") != std::string::npos);
    CHECK(expanded("C$", macros).find("expected a name after '$'") != std::string::npos);
    CHECK(expanded("C${raw", macros).find("expected '}'") != std::string::npos);
    CHECK(expanded("raw", macros) == "noclamp;C.*");
}

TEST_CASE("macro names that read as expressions, are repeated or are invalid are refused", "[macros]") {
    MacroTable macros;
    CHECK_FALSE(macros.add(macro_source("CDL", "CS2O")));
    CHECK_FALSE(macros.add(macro_source("CDL", "a-b")));
    CHECK_FALSE(macros.add(macro_source("CDL", "")));
    CHECK_FALSE(macros.add(macro_source("   # nothing", "empty")));
    CHECK(macros.add(macro_source("CDL", "good")));
    const auto twice = macros.add(macro_source("CSL", "good"));
    REQUIRE_FALSE(twice);
    CHECK(twice.error().message.find("defined twice") != std::string::npos);
}

TEST_CASE("an error inside a macro gives the position in its definition", "[macros][law7]") {
    const MacroTable macros = table({{"fine", "C<RD>L"}, {"wrong", "C<RX>L"}});
    auto expansion = expand_names(macro_source("($fine)|$wrong"), macros);
    REQUIRE(expansion);
    const auto word = find_path_string(expansion->source);
    REQUIRE_FALSE(word);
    CHECK(word.error().file == "rendermn.ini");
    CHECK(word.error().line == 2);
    CHECK(word.error().column == 20 + 3);  // the X of C<RX>L, whose C is in column 20
    CHECK(word.error().hint.find("in the macro 'wrong'") != std::string::npos);
}

TEST_CASE("osl has no names", "[macros]") {
    ChannelSource osl = macro_source("diffuse");
    osl.dialect = Dialect::osl;
    const auto expansion = expand_names(osl, table({{"diffuse_x", "CDL"}}));
    REQUIRE(expansion);
    CHECK(expansion->source.expression == "diffuse");
}
