// Hostile input: no crash, no hang, no excessive memory. The hidden tag runs the same body longer.
#include <catch2/catch.hpp>

#include <ctime>
#include <string>

#include "lpe/algebra/proofs/check.h"
#include "lpe/match.h"
#include "lpe/program.h"
#include "oracle.h"

using namespace raylex::lpe;

namespace {

const char* const pieces[] = {"C",
                              "D",
                              "S",
                              "L",
                              ".",
                              "(",
                              ")",
                              "[",
                              "]",
                              "[^",
                              "<",
                              ">",
                              "|",
                              "*",
                              "+",
                              "?",
                              "{2}",
                              "{",
                              "}",
                              ",",
                              "!",
                              "&",
                              "-",
                              "'a'",
                              "'",
                              "'a*'",
                              "'?b*'",
                              "<RD'a'>",
                              "<.S['a''b']>",
                              "<..[^'a']>",
                              "U2",
                              "D2",
                              "V",
                              "lpe:",
                              "noclamp;",
                              "#",
                              "\n",
                              " ",
                              "{0,9}",
                              ".*",
                              "x",
                              "\xD0\xA1",
                              "\xFF",
                              "7",
                              "\\"};

std::string random_text(oracle::Random& random, std::size_t longest) {
    std::string text;
    const bool bytes = random.below(4) == 0;
    for (std::size_t k = random.below(longest); k > 0; --k) {
        if (bytes) {
            text += static_cast<char>(random.below(256));
        } else {
            text += pieces[random.below(std::size(pieces))];
        }
    }
    return text;
}

void throw_at(std::uint64_t seed, int rounds) {
    oracle::Random random(seed);
    int accepted = 0;
    for (int round = 0; round < rounds; ++round) {
        ChannelSource source;
        source.expression = random_text(random, 12);
        source.dialect = round % 2 == 0 ? Dialect::renderman : Dialect::osl;
        const auto program = Program::compile({&source, 1}, {.any_path_string = round % 3 == 0});
        if (!program) {
            REQUIRE_FALSE(program.error().message.empty());
            continue;
        }
        ++accepted;
        State state = program->starts()[0];
        for (const Event& event : oracle::random_path(random, 6)) {
            const EventClass event_class = program->classify(event);
            REQUIRE(event_class < program->class_count());
            state = program->next(state, event_class);
            REQUIRE(state < program->state_count());
        }
        const auto events = parse_events(random_text(random, 8));
        CHECK((events.ok() || events.error().column > 0));
    }
    CHECK(accepted > rounds / 50);
}

}  // namespace

TEST_CASE("random texts are compiled or refused, and nothing else", "[fuzz][law7]") {
    throw_at(31, 4000);
}
TEST_CASE("many random texts are compiled or refused", "[.full][fuzz]") {
    throw_at(32, 1'000'000);
}

TEST_CASE("expressions designed to explode are refused in bounded time", "[fuzz][law7][gate]") {
    const auto repeat = [](const std::string& text, int count) {
        std::string all;
        for (int k = 0; k < count; ++k) { all += text; }
        return all;
    };
    std::string labels;
    for (int k = 0; k < 8000; ++k) { labels += "<RD'l" + std::to_string(k) + "'>"; }
    const std::pair<std::string, bool> cases[] = {
        {"C(.{1000}){1000}L", false},
        {"C.*D.{30}L", false},
        {"C(.*D.{10}|.*S.{12})*L", false},
        {"C((((D{0}){1000}){1000}){1000})L", false},
        {"C((((D?){1000})*)*)*L", true},
        {repeat("(", 5000) + "D" + repeat(")", 5000), false},
        {repeat("!", 5000) + "D", false},
        {repeat("[", 150) + "D" + repeat("]", 150), true},
        {repeat("C", 70'000), false},
        {repeat("D", 5000), true},
        {"C[" + labels.substr(0, 65'000), false},
        {"C[" + labels.substr(0, labels.rfind('<', 60'000)) + "]L", false},
        {"C(!(.*D.{12})){1000}L", false},
        {repeat("C.*D.{11}&", 2000) + "C", false},
        {repeat("CL-", 20'000) + "CL", false},
        {repeat("CL&", 400) + "CL", true},
        {"C<RD'*a*a*a*a*a*a*a*a*a*a*b'>L", true},
        {"C<RD['*a????????????????b''*c???????????????d']>L", false},
    };
    for (const auto& [text, compiles] : cases) {
        ChannelSource source;
        source.expression = text;
        const std::clock_t begin = std::clock();
        const auto program = Program::compile({&source, 1});
        const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        UNSCOPED_INFO(text.substr(0, 60) << ": " << seconds << " s " << (program ? "" : program.error().message));
        CHECK(program.ok() == compiles);
        // The work meter stops at about 2 s on this class of machine; sanitizers and busy machines take longer.
        CHECK(seconds < 60);
    }
}
