// Features for other renderers: files of compiled programs, their own names, channel sets that grow.
#include <catch2/catch.hpp>

#include <cstdio>
#include <fstream>
#include <memory>
#include <set>
#include <string>

#include "lpe/adopt/channel_set.h"
#include "lpe/adopt/program_file.h"
#include "lpe/adopt/vocabulary.h"
#include "lpe/match.h"
#include "lpe/program.h"
#include "oracle.h"
#include "tests/support/paths.h"

using namespace raylex::lpe;

namespace {

std::vector<ChannelSource> adopted_channels(const std::vector<std::string>& expressions,
                                            Dialect dialect = Dialect::renderman) {
    std::vector<ChannelSource> channels;
    for (const std::string& expression : expressions) {
        channels.push_back({.name = "channel " + expression, .expression = expression, .dialect = dialect});
    }
    return channels;
}

/// Channels with labels, globs and, when `packed`, enough labels anywhere to need bit-parallel automata.
std::vector<ChannelSource> channel_set(bool packed) {
    std::vector<ChannelSource> channels =
        adopted_channels({"CD+L", "C<RD'floor'>[DS]*L", "C<R.'wall*'>.*[<L.'key'>O]", "CU2L"});
    for (int k = 0; packed && k < 40; ++k) {
        channels.push_back(
            {.name = "x", .expression = "C.*<RD'obj" + std::to_string(k) + "'>.*L", .dialect = Dialect::osl});
    }
    return channels;
}

std::set<std::size_t> accepted(const Program& program, const std::vector<Event>& path) {
    std::vector<State> words(program.starts().begin(), program.starts().end());
    for (const Event& event : path) { program.advance(words.data(), program.classify(event), words.data()); }
    std::set<std::size_t> channels;
    program.for_each_accepted(words.data(), [&](std::uint16_t channel) { channels.insert(channel); });
    return channels;
}

std::vector<Event> random_path(oracle::Random& random) {
    const char* labels[] = {"floor", "wall", "wall 2", "obj3", "obj17", "key", ""};
    std::vector<Event> word{{EventType::camera, Scatter::none, 0, {}}};
    for (std::size_t k = random.below(4); k > 0; --k) {
        word.push_back({random.below(3) != 0 ? EventType::reflection : EventType::transmission,
                        static_cast<Scatter>(1 + random.below(3)),
                        0,
                        {labels[random.below(7)], ""}});
    }
    if (random.below(6) == 0) { word.push_back({EventType::user, Scatter::none, 2, {}}); }
    word.push_back(
        {random.below(4) != 0 ? EventType::light : EventType::emission, Scatter::none, 0, {labels[random.below(7)]}});
    return word;
}

/// Uses everything that following paths can access, for files that are complete but hostile.
void exercise(const Program& program) {
    oracle::Random random(3);
    for (int round = 0; round < 50; ++round) { (void)accepted(program, random_path(random)); }
}

}  // namespace

TEST_CASE("a program read from its file behaves like the original", "[adopt][file]") {
    for (const bool packed : {false, true}) {
        const auto program = Program::compile(channel_set(packed));
        REQUIRE(program);
        REQUIRE(program->view().has_parallel() == packed);
        const auto again = program_from_bytes(to_bytes(*program), "memory");
        REQUIRE(again);
        CHECK(to_bytes(*again) == to_bytes(*program));
        CHECK(again->tables().channel_names == program->tables().channel_names);
        oracle::Random random(9);
        std::size_t matches = 0;
        for (int round = 0; round < 500; ++round) {
            const auto word = random_path(random);
            INFO(to_text(word));
            REQUIRE(accepted(*again, word) == accepted(*program, word));
            matches += accepted(*again, word).size();
        }
        CHECK(matches > 50);
    }
    const auto empty = program_from_bytes(to_bytes(Program()), "memory");
    REQUIRE(empty);
    CHECK(empty->word_count() == 0);
    CHECK(empty->classify({}) == 0);
}

TEST_CASE("the file is little-endian and contains its version", "[adopt][file]") {
    const std::string bytes = to_bytes(*Program::compile(channel_set(false)));
    CHECK(bytes.substr(0, 8) == "RAYLEXPG");
    CHECK(bytes.substr(8, 4) == std::string("\1\0\0\0", 4));
    std::string newer = bytes;
    newer[8] = 2;
    const auto refused = program_from_bytes(newer, "shot.lpeprogram");
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message.find("version 2; expected version 1") != std::string::npos);
    CHECK(refused.error().file == "shot.lpeprogram");
}

TEST_CASE("damaged and hostile files are refused or harmless", "[adopt][file][law7][gate]") {
    const std::string bytes = to_bytes(*Program::compile(channel_set(true)));
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{4}, std::size_t{11}, std::size_t{30}, bytes.size() / 2, bytes.size() - 1}) {
        CHECK_FALSE(program_from_bytes(std::string_view(bytes).substr(0, size), "cut"));
    }
    CHECK_FALSE(program_from_bytes(bytes + "x", "longer"));
    CHECK_FALSE(program_from_bytes("CDL", "text"));
    // If any byte changes, the hash does not match. If the hash is corrected, every index is checked.
    const auto hashed = [](std::string content) {
        std::uint64_t hash = 0xCBF29CE484222325ULL;
        for (const char byte : content) { hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001B3ULL; }
        for (int byte = 0; byte < 8; ++byte) { content += static_cast<char>(hash >> 8 * byte & 0xFF); }
        return content;
    };
    const std::string content = bytes.substr(0, bytes.size() - 8);
    REQUIRE(program_from_bytes(hashed(content), "same"));
    oracle::Random random(1);
    std::size_t refused = 0, read = 0;
    for (int round = 0; round < 3000; ++round) {
        std::string changed = content;
        for (std::size_t k = 1 + random.below(3); k > 0; --k) {
            // Half of the changes are near the beginning, where counts and names are.
            const std::size_t at = 12 + random.below(random.below(2) == 0 ? 600 : content.size() - 12);
            changed[at] = static_cast<char>(random.below(3) == 0 ? 0xFF : random.below(256));
        }
        if (changed != content) {
            REQUIRE_FALSE(program_from_bytes(changed + bytes.substr(bytes.size() - 8), "changed"));
        }
        const auto program = program_from_bytes(hashed(changed), "rehashed");
        if (program) {
            ++read;
            exercise(*program);  // the sanitizers check that nothing outside the arrays is read
        } else {
            ++refused;
        }
    }
    CHECK(refused > 100);
    CHECK(read > 10);
}

TEST_CASE("programs are saved and loaded by name", "[adopt][file]") {
    const std::string path = raylex::test::binary_dir() + "/adopt_test.lpeprogram";
    const auto program = Program::compile(channel_set(true));
    REQUIRE(save(*program, path));
    const auto loaded = load(path);
    REQUIRE(loaded);
    CHECK(to_bytes(*loaded) == to_bytes(*program));
    std::remove(path.c_str());
    const auto missing = load(path);
    REQUIRE_FALSE(missing);
    CHECK(missing.error().file == path);
    CHECK_FALSE(save(*program, path + "/no/such/folder"));
}

TEST_CASE("a growing channel set accepts the same paths as all its channels compiled at once", "[adopt][channel_set]") {
    for (const bool packed : {false, true}) {
        std::vector<ChannelSource> channels = channel_set(packed);
        const auto more =
            adopted_channels({"C[DS]*<L.'key'>", "C<T.'obj3'>.*L", "C.*<RD'new label'>.*L", "C<R.'wal?'>L"});
        channels.insert(channels.end(), more.begin(), more.end());
        const auto osl = adopted_channels({"C<RD'floor'>.*", "C.*<RD'obj50'>.*L"}, Dialect::osl);
        channels.insert(channels.end(), osl.begin(), osl.end());
        ChannelSet set;
        const std::size_t first = channels.size() - 6;
        auto program = set.add(std::span(channels).first(first));
        REQUIRE(program);
        for (std::size_t k = first; k < channels.size(); ++k) {
            program = set.add({&channels[k], 1});
            if (!program) { FAIL(program.error().to_string()); }
        }
        CHECK(set.channels().size() == channels.size());
        CHECK(program->channel_count() == channels.size());
        const auto at_once = Program::compile(channels);
        REQUIRE(at_once);
        CHECK(program->tables().bytes() <= 2 * at_once->tables().bytes() + 4096);
        oracle::Random random(4);
        std::size_t matches = 0;
        for (int round = 0; round < 1000; ++round) {
            auto word = random_path(random);
            if (random.below(4) == 0) {
                word.insert(word.begin() + 1, {EventType::reflection, Scatter::diffuse, 0, {"new label", ""}});
            }
            INFO(to_text(word));
            REQUIRE(accepted(*program, word) == accepted(*at_once, word));
            matches += accepted(*program, word).size();
        }
        CHECK(matches > 200);
        // A channel that does not compile leaves the set unchanged.
        const auto bad = adopted_channels({"CD("});
        CHECK_FALSE(set.add(bad));
        ChannelSource rest{.name = "rest"};
        rest.rest_of = {0};
        CHECK_FALSE(set.add({&rest, 1}));
        CHECK(set.channels().size() == channels.size());
        const auto again = set.add({});
        REQUIRE(again);
        CHECK(to_bytes(*again) == to_bytes(*program));
    }
}

TEST_CASE("channels that would multiply do not make a growing set explode", "[adopt][channel_set]") {
    ChannelSet set;
    for (int k = 0; k < 40; ++k) {
        const auto program = set.add(adopted_channels({"C.*<RD'label" + std::to_string(k) + "'>.*L"}));
        REQUIRE(program);
        CHECK(program->tables().bytes() < 300'000);
        CHECK(program->word_count() <= 8);
    }
    CHECK(set.regroupings() < 20);
}

TEST_CASE("registered names denote user events and lobes in expressions and events", "[adopt][vocabulary]") {
    Vocabulary words;
    REQUIRE(words.add_event("hair_entry"));
    REQUIRE(words.add_event("passthru", 5));
    REQUIRE(words.add_lobe("coat", Scatter::glossy, 4));
    REQUIRE(words.add_lobe("skin", Scatter::diffuse, 3));
    const auto vocabulary = std::make_shared<const Vocabulary>(words);
    const auto entry = words.event("hair_entry", {"wig"});
    const auto coat = words.scattering(EventType::reflection, "coat", {"car"});
    const auto skin = words.scattering(EventType::transmission, "skin", {"face"});
    REQUIRE((entry && coat && skin));
    CHECK(to_text(*entry) == "U1,-,wig");
    CHECK(to_text(*coat) == "R,G4,car");
    CHECK(to_text(*skin) == "T,D3,face");
    const Event camera, light{EventType::light, Scatter::none, 0, {}};
    const auto matches = [&](const std::string& expression, Dialect dialect, const Event& event) {
        const ChannelSource source{.name = {}, .expression = expression, .dialect = dialect, .vocabulary = vocabulary};
        const auto program = Program::compile({&source, 1});
        if (!program) { FAIL(program.error().to_string()); }
        return !accepted(*program, {camera, event, light}).empty();
    };
    Event other_coat = *coat;
    other_coat.lobe_number = 2;
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        CAPTURE(dialect == Dialect::osl);
        const bool osl = dialect == Dialect::osl;
        CHECK(matches("C'hair_entry'L", dialect, *entry));
        CHECK(matches(osl ? "C<'hair_entry'.'wig'>L" : "C<.'hair_entry''wig'>L", dialect, *entry));
        CHECK_FALSE(matches(osl ? "C<'hair_entry'.'hat'>L" : "C<.'hair_entry''hat'>L", dialect, *entry));
        CHECK_FALSE(matches("C'passthru'L", dialect, *entry));
        CHECK_FALSE(matches("C.L", dialect, *entry));
        CHECK(matches("C<R'coat''car'>L", dialect, *coat));
        CHECK(matches("C'coat'L", dialect, *coat));
        CHECK(matches("C<.['skin''coat']>L", dialect, *coat));
        CHECK_FALSE(matches("C<T'coat'>L", dialect, *coat));
        CHECK_FALSE(matches("C'coat'L", dialect, other_coat));
        CHECK_FALSE(matches("C'coat'L", dialect, *skin));
        CHECK(matches("C<TD'face'>L", dialect, *skin));  // a registered diffuse lobe still matches D
        CHECK(
            matches("C<R.'coat'>L", dialect, {EventType::reflection, Scatter::diffuse, 0, {"coat"}}));  // in this slot
                                                                                                        // it is a label
    }
}

TEST_CASE("invalid names and unknown names are errors", "[adopt][vocabulary][law7]") {
    Vocabulary words;
    REQUIRE(words.add_event("hair"));
    CHECK_FALSE(words.add_event("hair"));
    CHECK_FALSE(words.add_lobe("hair", Scatter::diffuse, 1));
    CHECK_FALSE(words.add_event(""));
    CHECK_FALSE(words.add_event("it's"));
    CHECK_FALSE(words.add_event("a*"));
    CHECK_FALSE(words.add_event("too far", 13));
    CHECK_FALSE(words.add_lobe("fifth", Scatter::diffuse, 5));
    CHECK_FALSE(words.add_lobe("through", Scatter::straight, 1));
    for (int k = 2; k <= 12; ++k) {
        const auto number = words.add_event("event" + std::to_string(k));
        REQUIRE(number);
        CHECK(*number == k);
    }
    CHECK_FALSE(words.add_event("one more"));
    const auto near = words.event("hairs");
    REQUIRE_FALSE(near);
    CHECK(near.error().hint.find("'hair'") != std::string::npos);
    CHECK_FALSE(words.scattering(EventType::reflection, "hair"));
    // Without a vocabulary, a quoted text in a slot is an error in renderman.
    const ChannelSource source{.name = {}, .expression = "C<R'coat'>L"};
    CHECK_FALSE(Program::compile({&source, 1}));
}
