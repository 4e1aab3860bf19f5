// Words of contributions, for a path atlas.
#include "display/services/samples/batch_path_strings.h"

#include <cmath>
#include <map>

#include <catch2/catch.hpp>

#include "display/buffer/sinks/path_atlas.h"
#include "display/services/liveness/path_suffix.h"
#include "lpe/match.h"
#include "lpe/shipped.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::build_setup;
using test::Classes;
using test::expression_channel;
using test::plain_channel;
using test::Random;

std::vector<lpe::Event> events_of(const std::string& text) {
    auto events = lpe::parse_events(text);
    REQUIRE(events);
    for (lpe::Event& event : *events) {
        const bool terminal = event.type == lpe::EventType::light || event.type == lpe::EventType::background ||
                              event.type == lpe::EventType::emission;
        event.labels.resize(terminal ? 1 : 2);
    }
    return *events;
}

/// Every event of Classes, and some with labels.
std::vector<lpe::Event> all_events() {
    return events_of("R,D R,G R,S T,D T,S V,- L,- B,- O,- R,D,floor,diffuse R,D,wall,diffuse L,-,key T,s,leaf");
}

std::vector<ChannelDefinition> shipped_channels() {
    std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb)};
    for (const lpe::NamedExpression& e : lpe::shipped_partition())
        channels.push_back(expression_channel(std::string(e.name), std::string(e.expression)));
    return channels;
}

LpeSetup setup_with_path_strings(const std::vector<ChannelDefinition>& channels, const PathStringRules& rules) {
    LpeSetup setup = build_setup(channels, 0);
    auto alphabet = PathAlphabet::build(all_events(), rules);
    REQUIRE(alphabet);
    REQUIRE(setup.keep_path_strings(*std::move(alphabet)));
    return setup;
}

/// The letters of a word, each shown as the first event with that letter: "R,D R,S L,-"; "*" is an open letter.
std::string text_of(const BatchPathStrings& words, const PathAlphabet& alphabet, std::uint32_t word) {
    std::string text;
    for (const PathStringTree::Letter letter : words.words().letters(word)) {
        text += text.empty() ? "" : " ";
        if (letter == PathAlphabet::open) {
            text += '*';
            continue;
        }
        for (std::size_t column = 1; column < alphabet.column_count(); ++column)
            if (alphabet.letter(column) == letter) {
                text += lpe::to_text(alphabet.event(column));
                break;
            }
    }
    return text;
}

std::map<std::string, RgbD> light_by_path_string(const SampleTable& table, const PathAlphabet& alphabet, int row) {
    std::map<std::string, RgbD> light;
    for (const BatchPathStrings::Entry& entry : table.words()->entries())
        if (entry.row == static_cast<std::uint32_t>(row))
            light[text_of(*table.words(), alphabet, entry.word)] += RgbD(entry.r, entry.g, entry.b);
    return light;
}

TEST_CASE("a contribution is split into words by exact shares", "[path_words][law5]") {
    const std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb)};
    const LpeSetup setup = setup_with_path_strings(channels, {});
    const Classes classes(setup);
    SampleTable table(channels, 4);
    LpeServices services(setup, table, 1);
    table.begin(test::pixel_rows(0, 0, 0, 4));
    Tracker tracker = services.begin(2);
    const LobePart parts[] = {{classes.diffuse, Rgb(1, 1, 0)}, {classes.glossy, Rgb(3, 0, 0)}};
    services.move(tracker, parts);
    services.move(tracker, classes.light);
    services.contribute(Rgb(8, 2, 1), {}, tracker);
    const auto light = light_by_path_string(table, *setup.words(), 2);
    REQUIRE(light.size() == 2);
    // A colour without a value in any lobe belongs to the first lobe.
    CHECK(light.at("R,D L,-") == RgbD(2, 2, 1));
    CHECK(light.at("R,G L,-") == RgbD(6, 0, 0));
    CHECK(light_by_path_string(table, *setup.words(), 0).empty());
}

TEST_CASE("words have no limit on pairs, but channels of the same path do", "[path_words][law5]") {
    const std::vector<ChannelDefinition> channels = test::count_diffuse(30);
    PathStringRules rules;
    rules.length = 40;
    const LpeSetup setup = setup_with_path_strings(channels, rules);
    const Classes classes(setup);
    SampleTable table(channels, 1);
    LpeServices services(setup, table, 1);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    Tracker tracker = services.begin(0);
    constexpr int bounces = 10;
    for (int i = 0; i < bounces; ++i) {
        const LobePart parts[] = {{classes.diffuse, Rgb(1)}, {classes.glossy, Rgb(1)}, {classes.singular, Rgb(2)}};
        services.move(tracker, parts);
    }
    services.move(tracker, classes.light);
    services.contribute(Rgb(1), {}, tracker);
    double sum = 0;
    for (const BatchPathStrings::Entry& entry : table.words()->entries()) sum += entry.g;
    CHECK(table.words()->entries().size() == 59049);  // 3^10, all of them
    // Shares are products of ten fractions 1/4 and 1/2: exact, like their sum.
    CHECK(sum == 1);
}

TEST_CASE("words of light subpaths are those of the whole path", "[path_words][path_suffix]") {
    const std::vector<ChannelDefinition> channels = shipped_channels();
    PathStringRules rules;
    rules.length = 3;
    const LpeSetup setup = setup_with_path_strings(channels, rules);
    const Classes classes(setup);
    const auto reversed = lpe::ReversedProgram::build(setup.program());
    REQUIRE(reversed);
    for (const lpe::ReversedProgram* language : {&*reversed, static_cast<const lpe::ReversedProgram*>(nullptr)}) {
        PathSuffixes words(language, true);
        constexpr int length = 5;
        SampleTable table(channels, length + 2);
        LpeServices services(setup, table, 1);
        table.begin(test::pixel_rows(0, 0, 0, length + 2));
        Random random(7);
        std::vector<std::vector<LobePart>> vertices;
        for (int i = 0; i < length; ++i) {
            std::vector<LobePart>& parts = vertices.emplace_back();
            for (int k = 0; k <= 1 + i % 3; ++k)
                parts.push_back({classes.scattering[static_cast<std::size_t>(random.below(5))],
                                 Rgb(random.uniform_float(), random.uniform_float(), random.uniform_float())});
        }
        for (std::size_t of_camera = 0; of_camera <= length; ++of_camera) {
            Tracker tracker = services.begin(static_cast<int>(of_camera));
            for (std::size_t k = 0; k < of_camera; ++k) services.move(tracker, vertices[k]);
            PathSuffix word = services.begin(words, classes.light);
            for (std::size_t k = length; k-- > of_camera;) word = services.prepend(words, word, vertices[k], k);
            services.connect(tracker, words, word);
            services.contribute(Rgb(1, 2, 3), {}, tracker);
        }
        const auto forward = light_by_path_string(table, *setup.words(), length);
        CHECK(forward.size() > 5);
        for (int row = 0; row < length; ++row) CHECK(light_by_path_string(table, *setup.words(), row) == forward);
    }
}

TEST_CASE("channels get the same bits whether words are kept or not", "[path_words][law2]") {
    const std::vector<ChannelDefinition> channels = shipped_channels();
    const LpeSetup with = setup_with_path_strings(channels, {}), without = build_setup(channels, 0);
    SampleTable table_with(channels, 64, 0), table_without(channels, 64, 0);
    LpeServices keeps(with, table_with, 1), keeps_not(without, table_without, 1);
    const Classes of_with(with), of_without(without);
    table_with.begin(test::pixel_rows(0, 0, 0, 64));
    table_without.begin(test::pixel_rows(0, 0, 0, 64));
    for (int row = 0; row < 64; ++row) {
        Random random(static_cast<std::uint64_t>(row));
        Tracker a = keeps.begin(row), b = keeps_not.begin(row);
        for (int bounce = 0; bounce <= row % 5; ++bounce) {
            std::vector<LobePart> parts_a, parts_b;
            for (int k = 0; k <= random.below(3); ++k) {
                const auto which = static_cast<std::size_t>(random.below(6));
                const Rgb value(random.uniform_float(), random.uniform_float(), random.uniform_float());
                parts_a.push_back({of_with.scattering[which], value});
                parts_b.push_back({of_without.scattering[which], value});
            }
            keeps.move(a, parts_a);
            keeps_not.move(b, parts_b);
        }
        keeps.move(a, of_with.light);
        keeps_not.move(b, of_without.light);
        const Rgb value(random.uniform_float(), random.uniform_float(), random.uniform_float());
        keeps.contribute(value, {}, a);
        keeps_not.contribute(value, {}, b);
    }
    for (ChannelId id = 0; id < table_with.channel_count(); ++id)
        for (int i = 0; i < 3 * 64; ++i) CHECK(table_with.values(id)[i] == table_without.values(id)[i]);
    // The words of a row sum to its beauty: at most 3^5 words, each rounded at 2^-53 of at most 1.
    for (int row = 0; row < 64; ++row) {
        double sum = 0;
        for (const auto& [word, light] : light_by_path_string(table_with, *with.words(), row)) sum += light.g;
        CHECK(std::abs(sum - table_with.values(0)[3 * row + 1]) <= 243 * 0x1p-53);
    }
}

TEST_CASE("words beyond the maximum length end in a tail, and cutouts have no letter unless requested",
          "[path_words]") {
    const std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb)};
    for (const bool straight : {false, true}) {
        PathStringRules rules;
        rules.length = 2;
        rules.straight = straight;
        const LpeSetup setup = setup_with_path_strings(channels, rules);
        const Classes classes(setup);
        const lpe::EventClass leaf = setup.classify(events_of("T,s,leaf").front());
        SampleTable table(channels, 2);
        LpeServices services(setup, table, 1);
        table.begin(test::pixel_rows(0, 0, 0, 2));
        Tracker tracker = services.begin(0);
        services.move(tracker, leaf);
        for (int bounce = 0; bounce < 4; ++bounce) services.move(tracker, classes.diffuse);
        services.move(tracker, classes.background);
        services.contribute(Rgb(1), {}, tracker);
        const auto light = light_by_path_string(table, *setup.words(), 0);
        REQUIRE(light.size() == 1);
        CHECK(light.begin()->first == (straight ? "T,s,leaf R,D * B,-" : "R,D R,D * B,-"));
        CHECK(table.words()->dropped_straight() == !straight);
    }
}

TEST_CASE("events that are not distinguished share a letter", "[path_words]") {
    const auto letters = [](const std::string& by) {
        auto rules = parse_path_string_rules(by, {"--atlas-by", 0, 0});
        REQUIRE(rules);
        auto alphabet =
            PathAlphabet::build(events_of("R,D,floor,diffuse R,D,wall,diffuse R,D2,wall,coat L,-,key L,-"), *rules);
        REQUIRE(alphabet);
        return alphabet->letter_count();
    };
    CHECK(letters("label,lobe,group") == 5);
    CHECK(letters("label,group") == 4);
    CHECK(letters("lobe,group") == 4);
    CHECK(letters("label,lobe") == 4);
    CHECK(letters("") == 2);
    const auto refused = parse_path_string_rules("label,lobes", {"--atlas-by", 0, 0});
    REQUIRE_FALSE(refused);
    CHECK(refused.error().hint == "did you mean 'lobe'?");
}

}  // namespace
}  // namespace raylex::display
