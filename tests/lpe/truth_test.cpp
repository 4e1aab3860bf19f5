// Closed enclosures: the values of expressions against closed forms and against sums over words.
#include <catch2/catch.hpp>

#include <cmath>
#include <string>

#include "lpe/truth.h"
#include "oracle.h"

using namespace raylex::lpe;

namespace {

Enclosure enclosure(double kd, double ks, double kt = 0) {
    Enclosure result;
    result.scattering = {{{EventType::reflection, Scatter::diffuse, 0, {"wall", "diffuse"}}, kd},
                         {{EventType::reflection, Scatter::singular, 0, {"wall", "mirror"}}, ks},
                         {{EventType::transmission, Scatter::singular, 0, {"wall", "sheet"}}, kt}};
    result.terminals = {{{EventType::light, Scatter::none, 0, {"walls"}}, 1}};
    return result;
}

EnclosureTruth truth_of(const std::string& text, const Enclosure& of, Dialect dialect = Dialect::renderman) {
    ChannelSource source;
    source.expression = text;
    source.dialect = dialect;
    const auto truth = enclosure_truth(source, of);
    if (!truth) FAIL(truth.error().to_string());
    return *truth;
}

}  // namespace

TEST_CASE("expressions in an enclosure have the values of closed forms", "[truth]") {
    const Enclosure walls = enclosure(0.5, 0.3);
    const auto value = [&](const char* text) { return truth_of(text, walls, Dialect::osl).value; };
    // Geometric series, computed by hand; systems of a few states round a few times at 2^-53 of values of at most 5.
    const auto near = [](double expected) { return Approx(expected).margin(1e-14).epsilon(0); };
    CHECK(value("CL") == near(1));
    CHECK(value("C.*L") == near(5));
    CHECK(value("CDS+L") == near(0.5 * 0.3 / 0.7));
    CHECK(value("CDSDL") == near(0.075));
    CHECK(value("C<.S>*L") == near(1 / 0.7));
    CHECK(value("CD*L") == near(2));
    CHECK(value("C(<.S>*D<.S>*D)*<.S>*L") == near(1 / 0.7 / (1 - std::pow(0.5 / 0.7, 2))));  // an even number of D
    CHECK(value("C<TS>.*L") == 0);
    CHECK(value("C.{3}L") == near(std::pow(0.8, 3)));
    CHECK(value("CB") == 0);
    CHECK(truth_of("C<TS>{2}<L.'walls'>", enclosure(0.5, 0.25, 0.125)).value == near(1.0 / 64));
    CHECK(truth_of("C<TS>{2}<L.'other'>", enclosure(0.5, 0.25, 0.125)).value == 0);
    const EnclosureTruth all = truth_of("C.*L", walls);
    REQUIRE(all.by_depth.size() == 9);
    for (std::size_t k = 0; k < 9; ++k) CHECK(all.by_depth[k] == near(std::pow(0.8, static_cast<double>(k))));
}

TEST_CASE("a white enclosure has a value for paths of limited depth only", "[truth][law7]") {
    Enclosure white = enclosure(0.75, 0.25);
    const ChannelSource all{.name = {}, .expression = "C.*L"};
    const auto unbounded = enclosure_truth(all, white);
    REQUIRE_FALSE(unbounded);
    CHECK(unbounded.error().message.find("expected less than 1") != std::string::npos);
    white.max_depth = 10000;
    CHECK(truth_of("C.*L", white).value == Approx(10001).epsilon(1e-12));
    CHECK(truth_of("CD*L", white).value == Approx(4).epsilon(1e-12));
    // Albedo 1 - 1e-6 without a depth limit: the system is exact up to its condition number, 1e6 x 2^-53.
    CHECK(truth_of("C.*L", enclosure(0.999999, 0)).value == Approx(1e6).epsilon(1e-9));
    CHECK_FALSE(enclosure_truth({.name = {}, .expression = "C(L"}, white));
}

TEST_CASE("flights between the walls of a spherical enclosure cross its sheets with the right probabilities",
          "[truth][law7]") {
    Enclosure walls = enclosure(0.5, 0.3);
    walls.sheets = {{{EventType::transmission, Scatter::singular, 0, {"", "sheet"}}, 0.8}, {0.5}};
    const auto value = [&](const char* text) { return truth_of(text, walls, Dialect::osl).value; };
    const auto near = [](double expected) { return Approx(expected).margin(1e-14).epsilon(0); };
    // A quarter of the Lambert flights crosses it; a mirror's flight does if the previous one did.
    CHECK(value("CL") == 0);
    CHECK(value("C<TS>L") == near(0.8));
    CHECK(value("C<TS>DL") == near(0.8 * 0.5 * 0.75));
    CHECK(value("C<TS>D<TS>L") == 0);
    CHECK(value("C<TS>D<TS><TS>L") == near(0.8 * 0.5 * 0.25 * 0.64));
    CHECK(value("C<TS><RS>L") == 0);
    CHECK(value("C<TS><RS><TS><TS>L") == near(0.8 * 0.3 * 0.64));
    CHECK(value("C<TS>D<RS>L") == near(0.8 * 0.5 * 0.75 * 0.3));
    const double g = 0.75 / 0.7 + 0.25 * 0.64 / (1 - 0.3 * 0.64), lambert = g / (1 - 0.5 * g);
    CHECK(value("C.*L") == near(0.8 * (1 + 0.5 * lambert) / (1 - 0.3 * 0.64)));
    walls.max_depth = 3;
    CHECK(value("C.*L") == near(0.8 * (1 + 0.5 * 0.75 * (1 + 0.5 * 0.75 + 0.3))));  // crossings are events
    walls.sheets.radii = {0.5, 0.25};
    CHECK(value("C<TS><TS>DL") == near(0.64 * 0.5 * 0.75));
    walls.max_depth = {};
    CHECK(value("C<TS><TS>D<TS>{4}L") == near(0.64 * 0.5 * 0.0625 * std::pow(0.8, 4)));
    walls.sheets.radii = {1};
    const ChannelSource all{.name = {}, .expression = "C.*L"};
    CHECK(enclosure_truth(all, walls).error().message.find("less than 1") != std::string::npos);
    walls = enclosure(0.5, 0.3, 0.1);
    walls.sheets.radii = {0.5};
    CHECK(enclosure_truth(all, walls).error().message.find("only reflect") != std::string::npos);
}

TEST_CASE("random expressions have the sum over their words", "[truth][gate]") {
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        CAPTURE(dialect == Dialect::osl);
        Enclosure walls = enclosure(0.5, 0.3, 0.125);
        walls.max_depth = 6;
        // Every path of at most 6 scattering events, with its light.
        std::vector<std::pair<oracle::Path, double>> words{{{Event{}}, 1}};
        for (std::size_t i = 0; i < words.size(); ++i) {
            if (words[i].first.size() > 6) continue;
            for (const WeightedEvent& each : walls.scattering) {
                words.push_back(words[i]);
                words.back().first.push_back(each.event);
                words.back().second *= each.weight;
            }
        }
        REQUIRE(words.size() == 1093);  // (3^7 - 1) / 2
        for (auto& [word, weight] : words) word.push_back(walls.terminals[0].event);
        oracle::Random random(5);
        int compared = 0;
        double total = 0;
        while (compared < 150) {
            const auto token = [&](const char* text) {
                std::size_t at = 0;
                while (oracle::tokens(dialect)[at].text != text) ++at;
                return at;
            };
            std::vector<std::size_t> sequence{token("C"), token("(")};
            const auto inner = oracle::random_expression(random, dialect, 2 + random.below(9));
            sequence.insert(sequence.end(), inner.begin(), inner.end());
            sequence.insert(sequence.end(), {token(")"), token("L")});
            const auto tree = oracle::parse(sequence, dialect);
            REQUIRE(tree != nullptr);
            const std::string text = oracle::text_of(sequence, dialect);
            double expected = 0;
            for (const auto& [word, weight] : words)
                if (oracle::matches(*tree, word, dialect)) expected += weight;
            INFO(text);
            // The order of sums of a thousand products differs.
            const EnclosureTruth truth = truth_of(text, walls, dialect);
            REQUIRE(truth.value == Approx(expected).margin(1e-13).epsilon(0));
            // Without a depth limit, longer paths add at most the tail of the series.
            Enclosure unbounded = walls;
            unbounded.max_depth.reset();
            const double longer = truth_of(text, unbounded, dialect).value - expected;
            REQUIRE(longer >= -1e-12);
            REQUIRE(longer <= std::pow(0.925, 7) / 0.075 + 1e-12);
            total += expected;
            ++compared;
        }
        CHECK(total > 1);  // some expressions match
    }
}
