// Expressions in English: sentences, recognised equalities, warnings.
#include <catch2/catch.hpp>

#include <algorithm>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "lpe/algebra/explanation/explain.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/match.h"
#include "lpe/shipped.h"
#include "tests/lpe/oracle.h"

using namespace raylex::lpe;

namespace {

ChannelSource source_of(const std::string& text) {
    ChannelSource channel;
    channel.expression = text.starts_with("osl:") ? text.substr(4) : text;
    channel.dialect = text.starts_with("osl:") ? Dialect::osl : Dialect::renderman;
    return channel;
}

Explanation explained(const std::string& text, const PathStrings& words = {}) {
    const auto explanation = explain(source_of(text), words);
    CAPTURE(text);
    REQUIRE(explanation);
    return *explanation;
}

bool any_has(const std::vector<std::string>& lines, const std::string& part) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

}  // namespace

TEST_CASE("expressions are described in English", "[gate]") {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"C<RD>L", "From the camera, one diffuse reflection, ending at a light."},
        {"C<RD>[DSV]+[<L.'key'>O]",
         "From the camera, one diffuse reflection, then one or more scatterings of any kind, ending at a light of "
         "group 'key' or at "
         "emission."},
        {"C<RD>[DS]*[<L.'key'>O]",
         "From the camera, one diffuse reflection, then any number of diffuse or specular scatterings, ending at a "
         "light of group "
         "'key' or at emission."},
        {"CL", "From the camera straight to a light."},
        {"C.*", "From the camera, any number of scatterings of any kind, ending at a light or at emission."},
        {"CV.*B",
         "From the camera, one volume scattering, then any number of scatterings of any kind, ending at the "
         "background."},
        {"CD{2,4}S?B",
         "From the camera, two to four diffuse scatterings, then at most one specular scattering, ending at the "
         "background."},
        {"C<RD'floor''coat'>L",
         "From the camera, one diffuse reflection off 'floor' by the lobe 'coat', ending at a light."},
        {"C<T.[^'glass']>L", "From the camera, one transmission through anything but 'glass', ending at a light."},
        {"C<R.'fl*'>L", "From the camera, one reflection off what is called 'fl*', ending at a light."},
        {"CS4L", "From the camera, one specular scattering (lobe S4), ending at a light."},
        {"C(DS)+L",
         "From the camera, once or more (one diffuse scattering, then one specular scattering), ending at a light."},
        {"C(D[DS]*[LO])|[LO]",
         "From the camera, either (a) one diffuse scattering, then any number of diffuse or specular scatterings, "
         "ending at a light or "
         "at emission; or (b) straight to a light or emission."},
        {"C[<L.>O]-CB",
         "From the camera straight to a light or emission; but not from the camera straight to the background."},
        {"C<.S'passthru'>*U2L",
         "From the camera, any number of specular scatterings at 'passthru', then one user event U2, ending at a "
         "light."},
        {"osl:C[DG]+L", "From the camera, one or more diffuse or glossy scatterings, ending at a light."},
        {"osl:C<Ts>*B", "From the camera, any number of straight passages, ending at the background."},
    };
    for (const auto& [text, sentence] : cases) {
        CAPTURE(text);
        CHECK(explained(text).sentence == sentence);
    }
}

TEST_CASE("every piece has its own byte range") {
    const Explanation explanation = explained("C <RD> ([DSV]+) # far\n <L.'key'>");
    std::vector<std::string> texts;
    for (const Piece& piece : explanation.pieces) {
        texts.push_back(explanation.expression.substr(piece.begin, piece.end - piece.begin) + " = " + piece.words);
    }
    CHECK(texts == std::vector<std::string>{"C = the camera", "<RD> = one diffuse reflection",
                                            "[DSV]+ = one or more scatterings of any kind",
                                            "<L.'key'> = the end at a light of group 'key'"});
}

TEST_CASE("the beauty, shipped channels and names are recognised by meaning", "[gate]") {
    CHECK(explained("C.*").beauty);
    CHECK(explained("C[DSV]*[<L.>O]").beauty);
    CHECK(explained("osl:C.*").beauty);
    const Explanation surfaces = explained("C[DS]*[<L.>O]");
    CHECK_FALSE(surfaces.beauty);
    CHECK(any_has(surfaces.same_as, "It is the beauty where there is no medium."));
    PathStrings no_medium;
    no_medium.volume = false;
    CHECK(explained("C[DS]*[<L.>O]", no_medium).beauty);
    CHECK_FALSE(explained("noclamp;C.*").beauty);
    CHECK(any_has(explained("noclamp;C.*").same_as, "Prefixes apart, it is the beauty."));
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        for (const NamedExpression& entry : shipped_partition(dialect)) {
            const auto explanation = explain({"", std::string(entry.expression), dialect});
            REQUIRE(explanation);
            CHECK(any_has(explanation->same_as, "the shipped channel '" + std::string(entry.name) + "'."));
        }
    }
    // The same channel in a different form.
    CHECK(any_has(explained("(C<R[D]>)(L|O)").same_as, "'directDiffuse'"));
    CHECK(any_has(explained("C<RD>[DS]+[<L.>O]").same_as, "'indirectDiffuse' where there is no medium"));
    CHECK(explained("C<RD>V<L.'x'>").same_as.empty());
}

TEST_CASE("notes list paths that people expect in a channel and that it omits") {
    CHECK(any_has(explained("C<RD>L").notes, "never ends at emission"));
    CHECK(any_has(explained("C<RD>L").notes, "including the background (infinite lights)"));
    CHECK(any_has(explained("osl:C<RD>L").notes, "never ends at the background"));
    CHECK(any_has(explained("osl:CS*L").notes, "Glossy lobes (G) do not match"));
    CHECK(any_has(explained("osl:CS*L").notes, "cutout"));
    CHECK(any_has(explained("CG+L").notes, "RenderMan itself has no G"));
    CHECK(any_has(explained("CS+L").notes, "S includes G"));
    CHECK(any_has(explained("C[DS]*L").notes, "medium"));
    CHECK(any_has(explained("CD2L").notes, "numbered lobe"));
    CHECK(any_has(explained("C<RD[^'a']>L").notes, "also matches events without a label"));
    CHECK(any_has(explained("osl:C<RD[^'a']>L").notes, "events without a label do not match"));
    CHECK(explained("C.*").notes.empty());
    const Explanation prefixes = explained("unoccluded;holdouts;C[DS]+L");
    REQUIRE(prefixes.prefixes.size() == 2);
    CHECK(prefixes.prefixes[1].first == "holdouts");
}

TEST_CASE("typos give warnings") {
    CHECK(any_has(explained("CD|SL|(DS)L").warnings, "looser than concatenation"));
    CHECK(any_has(explained("C(D|C)L").warnings, "'C' (column 5) can never match"));
    CHECK(any_has(explained("CL(D|O)?").warnings, "'D' (column 4) can never match"));
    CHECK(any_has(explained("CLD").warnings, "no path can continue at 'D' (column 3)"));
    CHECK(explained("CLD").samples.empty());
    CHECK(any_has(explained("C<RD'f\xD0\xBEor'>L").warnings, "mixes Latin letters"));
    CHECK(any_has(explained("C<RD'\xD0\xA1'>L").warnings, "looks like 'C'"));
    CHECK(any_has(explained("osl:C<R[^'coat']>.*").warnings, "excludes nothing"));
    CHECK(any_has(explained("osl:C<R'coat'>.*").warnings, "never matches"));
    CHECK(explained("osl:C<R.'coat'>.*").warnings.empty());
    CHECK(explained("C<RD>[DSV]+[<L.>O]").warnings.empty());
    // In a scene without the label, a piece that can never match.
    PathStrings scene;
    scene.alphabet =
        Alphabet{{{EventType::reflection, Scatter::diffuse, 0, {"floor"}}}, {{EventType::light, Scatter::none, 0, {}}}};
    CHECK(any_has(explained("C[<RD'flor'><RD'floor'>]L", scene).warnings, "'<RD'flor'>' (column 3) can never match"));
}

TEST_CASE("every built-in name can be explained") {
    const Explanation indirect = explained("lpe:indirectdiffuse");
    CHECK(indirect.expression.find("C<RD>") != std::string::npos);
    CHECK(any_has(indirect.same_as, "'indirectdiffuse'"));
}

TEST_CASE("samples match, and pieces reported as dead can be removed", "[gate]") {
    std::mt19937 random(20261121);  // fixed seed: the same expressions in every run
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        const auto& tokens = oracle::tokens(dialect);
        std::uniform_int_distribution<std::size_t> pick(0, tokens.size() - 1);
        std::size_t explained_count = 0;
        for (int trial = 0; trial < 4'000 && explained_count < 60; ++trial) {
            std::vector<std::size_t> sequence(3 + trial % 6);
            std::generate(sequence.begin(), sequence.end(), [&] { return pick(random); });
            if (!oracle::parse(sequence, dialect)) { continue; }
            ChannelSource channel;
            channel.expression = "C" + oracle::text_of(sequence, dialect);
            channel.dialect = dialect;
            const auto explanation = explain(channel);
            CAPTURE(channel.expression);
            if (!explanation) {
                continue;  // the preceding "C" made it a different expression, which need not parse
            }
            ++explained_count;
            CHECK(explanation->sentence.size() > 10);
            for (const Witness& sample : explanation->samples) {
                CHECK(*match(channel.expression, sample.events, dialect));
            }
            for (const std::string& warning : explanation->warnings) {
                const std::size_t column = warning.find("(column ");
                if (warning.find("can never match") == std::string::npos || dialect == Dialect::osl) { continue; }
                const std::string piece = warning.substr(1, column - 3);
                ChannelSource without = channel;
                const auto at = static_cast<std::size_t>(std::stoi(warning.substr(column + 8))) - 1;
                REQUIRE(without.expression.substr(at, piece.size()) == piece);
                without.expression.replace(at, piece.size(), "U12");  // which no word of W contains
                const auto same = check_equal(std::vector<ChannelSource>{channel, without});
                REQUIRE(same);
                CHECK(same->holds);
            }
        }
        CHECK(explained_count >= 40);
    }
}

TEST_CASE("hostile expressions are explained or refused within seconds", "[gate]") {
    const std::string nested = "C" + std::string(190, '(') + "D" + std::string(190, ')') + "L";
    std::string letters = "C";
    while (letters.size() < 4'000) { letters += "[DS]*(D|SV)?"; }
    std::string labels = "C[";
    for (int k = 0; k < 300; ++k) { labels += "<R.'a" + std::to_string(k) + "''b" + std::to_string(k) + "'>"; }
    const std::clock_t start = std::clock();
    for (const std::string& text :
         {nested, letters + "L", labels + "]*L", std::string("C(((((D*)*)*)*)*)*L"), std::string("C.*D.{24}L"),
          std::string("C(D{30}){30}L"), std::string("CD{900}L"), std::string(60'000, '.')}) {
        const auto explanation = explain(source_of(text));
        if (!explanation) {
            CHECK_FALSE(explanation.error().message.empty());
        } else {
            CHECK(explanation->sentence.size() < 100'000);
        }
    }
    // Eight limited compilations; each stops after about two seconds of work on a slow machine.
    CHECK(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC < 120);
}
