// Refused expressions: the position of the caret and the suggestions.
#include <catch2/catch.hpp>

#include "lpe/language/parser/parser.h"
#include "lpe/match.h"
#include "lpe/program.h"

using namespace raylex;
using namespace raylex::lpe;

namespace {

struct RefusedCase {
    const char* expression;
    int column;
    const char* part;  // of the message or the hint
};

void refuses(const RefusedCase& wrong, Dialect dialect) {
    ChannelSource source;
    source.expression = wrong.expression;
    source.dialect = dialect;
    const auto program = Program::compile({&source, 1});
    INFO(wrong.expression);
    REQUIRE_FALSE(program);
    INFO(program.error().to_string());
    CHECK(program.error().column == wrong.column);
    CHECK((program.error().message + program.error().hint).find(wrong.part) != std::string::npos);
    CHECK(program.error().excerpt == wrong.expression);
}

}  // namespace

TEST_CASE("renderman errors give the position of the wrong byte", "[errors][law7]") {
    const RefusedCase cases[] = {
        {"", 1, "empty"},
        {"   ", 4, "empty"},
        {"lpe:", 5, "empty"},
        {"C(", 3, "expected an event"},
        {"C()L", 3, "'()' is empty"},
        {"C(D", 4, "expected ')' for the '(' at column 2"},
        {"C)", 2, "found ')'"},
        {"C]", 2, "found ']'"},
        {"C[DS", 5, "expected ']' for the '[' at column 2"},
        {"C[]L", 3, "expected an event"},
        {"C[^]L", 4, "expected an event"},
        {"C<RD", 5, "expected"},
        {"C<>L", 3, "'<>' is empty"},
        {"C<D>L", 3, "event type"},
        {"C<RL>L", 4, "expected a scattering"},
        {"C<RD*>L", 5, "expected a quoted label"},
        {"C<L'key'>", 4, "<L.'key'>"},
        {"C<RD'floor>L", 5, "not closed"},
        {"CD**", 4, "one repetition"},
        {"CD{2}*", 6, "one repetition"},
        {"*C", 1, "expected an event"},
        {"CD{", 4, "{n}"},
        {"CD{,2}", 4, "{n}"},
        {"CD{3,2}L", 3, "counts down"},
        {"CD{1001}L", 4, "above 1000"},
        {"CD{99999999999999999999}L", 4, "above 1000"},
        {"C|", 3, "expected an event"},
        {"|C", 1, "expected an event"},
        {"C||D", 3, "expected an event"},
        {"CD5L", 3, "expected D1 to D4"},
        {"CS9L", 3, "expected S1 to S8"},
        {"CU13L", 3, "expected U1 to U12"},
        {"CUL", 2, "needs its number"},
        {"C<Ts>L", 4, "--dialect osl"},
        {"C2L", 2, "repetition is written {n}"},
        {"CxL", 2, "labels are quoted"},
        {"difuse", 1, "did you mean 'diffuse'?"},
        {"C!DL", 2, "negates a whole expression"},
        {"C-", 3, "expected an event"},
        {"unocluded;CDL", 1, "did you mean 'unoccluded'?"},
        {"rib:CDL", 1, "lpe:"},
        {"C\xD0\xA1L", 2, "Cyrillic letter that looks like 'C'"},
        {"C<RD\xE2\x80\x98"
         "floor\xE2\x80\x99>L",
         5, "did you mean '''?"},
        {"C\xFF", 2, "the byte 0xFF"},
    };
    for (const RefusedCase& wrong : cases) { refuses(wrong, Dialect::renderman); }
}

TEST_CASE("osl errors give the position of the wrong byte", "[errors][law7]") {
    const RefusedCase cases[] = {
        {"", 1, "empty"},
        {"C D", 2, "blanks"},
        {"C()L", 3, "empty"},
        {"C|", 3, "on its right"},
        {"|C", 1, "on its left"},
        {"C||D", 3, "on its left"},
        {"C[^]L", 4, "empty"},
        {"C[^.]L", 4, "inside [^...]"},
        {"C<R<D>>", 4, "do not nest"},
        {"C<RD*>L", 5, "not allowed inside"},
        {"C<RD", 5, "expected '>' for the '<' at column 2"},
        {"CD{a}", 4, "{n}"},
        {"CD2L", 3, "renderman"},
        {"lpe:CDL", 1, "expected an event"},
        {"C'D", 2, "not closed"},
        {"CD{2000}", 4, "above 1000"},
    };
    for (const RefusedCase& wrong : cases) { refuses(wrong, Dialect::osl); }
}

TEST_CASE("an error has the file, line and column of its expression", "[errors][law7]") {
    ChannelSource source;
    source.expression = std::string("C[DS\n]*L  # a comment (\n  X");
    source.origin = std::string("job.toml");
    source.origin_line = 12;
    source.origin_column = 20;
    auto program = Program::compile({&source, 1});
    REQUIRE_FALSE(program);
    CHECK(program.error().file == "job.toml");
    CHECK(program.error().line == 14);
    CHECK(program.error().column == 3);

    source.expression = std::string("CXL");
    program = Program::compile({&source, 1});
    REQUIRE_FALSE(program);
    CHECK(program.error().line == 12);
    CHECK(program.error().column == 21);
    const std::string text = program.error().to_string();
    CHECK(text.find("job.toml:12:21: ") == 0);
    // The caret is under the X wherever the expression begins.
    const std::size_t line = text.find("\n  ") + 1;
    const std::size_t letter = text.find('X', line) - line;
    const std::size_t caret = text.find('^') - (text.rfind('\n', text.find('^')) + 1);
    CHECK(letter == caret);
}

TEST_CASE("a caret is under its column, and a character of several bytes counts once", "[errors]") {
    const Error error{"found 'X'", "f", 3, 6, "C\xC3\xA9\tDX", "a hint"};
    CHECK(error.to_string() == "f:3:6: found 'X'\n  C\xC3\xA9\tDX\n    \t ^\na hint");
}

TEST_CASE("events that do not parse are refused with a column", "[errors][law7]") {
    const std::pair<const char*, int> cases[] = {{"Q,D", 1},       {"C", 2},   {"C,", 3},         {"C,-x", 4},
                                                 {"R,D5", 4},      {"U,-", 2}, {"C,- R,D,'a", 9}, {"R,D,'a'b", 8},
                                                 {"C,- , L,-", 5}, {"U2,G", 4}};
    for (const auto& [text, column] : cases) {
        INFO(text);
        const auto events = parse_events(text);
        REQUIRE_FALSE(events);
        CHECK(events.error().column == column);
    }
}

TEST_CASE("events that are written read back unchanged", "[errors]") {
    const std::string text = "C,- R,D2,floor,'a b' T,S8,'it\\'s','' U12,- V,-,fog O,-,'x,y' B,- T,s L,-,key";
    const auto events = parse_events(text);
    REQUIRE(events);
    CHECK(events->size() == 9);
    const auto again = parse_events(to_text(*events));
    REQUIRE(again);
    CHECK(to_text(*again) == to_text(*events));
    CHECK((*again)[2].labels[0] == "it's");
    CHECK((*again)[2].lobe_number == 8);
    CHECK(to_sentence({events->data() + 1, 1}) == "diffuse reflection off 'floor' (lobe number 2, lobe 'a b')");
}

TEST_CASE("a chain of '|' of any length is one node", "[errors][law7]") {
    // Later stages walk the tree recursively: a tree as deep as the chain is long would overflow the stack.
    ChannelSource source;
    source.expression = "D";
    for (int i = 1; i < 30'000; ++i) source.expression += "|D";
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        source.dialect = dialect;
        const Expression expression = parse(source);
        const Node* node = expression.root.get();
        while (node->children.size() == 1) node = node->children.front().get();
        CHECK(node->kind == NodeKind::alternatives);
        CHECK(node->children.size() == 30'000);
    }
    // Parentheses and other items end a chain.
    source.expression = "C(D|S|G)|VD|SL";
    source.dialect = Dialect::osl;
    CHECK(parse(source).root != nullptr);
}
