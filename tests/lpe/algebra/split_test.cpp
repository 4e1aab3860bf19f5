// Generated splits: partitions by construction, proved, with names for layers, and fast.
#include <catch2/catch.hpp>

#include <algorithm>
#include <ctime>
#include <set>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/channels/split.h"
#include "lpe/match.h"

using namespace raylex;
using namespace raylex::lpe;

namespace {

SplitRequest by(const std::vector<SplitAxis>& axes) {
    SplitRequest request;
    request.by = axes;
    return request;
}

Split required(const SplitRequest& request) {
    auto split = generate_split(request);
    INFO((split ? std::string() : split.error().to_string()));
    REQUIRE(split);
    return *std::move(split);
}

std::string expression_of(const Split& split, const std::string& name) {
    for (const ChannelSource& channel : split.channels) {
        if (channel.name == name) { return channel.expression; }
    }
    return "no channel " + name;
}

/// The names of the channels that contain a path.
std::vector<std::string> channels_of(const Split& split, const std::string& path) {
    const auto events = parse_events(path);
    REQUIRE(events);
    std::vector<std::string> names;
    for (const ChannelSource& channel : split.channels) {
        const auto matched = match(channel.expression, *events, channel.dialect);
        REQUIRE(matched);
        if (*matched) { names.push_back(channel.name); }
    }
    return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("a split by light group, lobe and bounce assigns each path to the bin with its name", "[split][law1]") {
    SplitRequest request = by({SplitAxis::light_group, SplitAxis::lobe, SplitAxis::bounce});
    request.groups = {"key", "fill"};
    const Split split = required(request);
    CHECK(split.channels.size() == 3 * (1 + 5 * 3));
    CHECK(expression_of(split, "key_diffuse_bounce1") == "C<RD><L.'key'>");
    CHECK(expression_of(split, "fill_specular_bounce3plus") == "C<RS>.{2,}<L.'fill'>");
    CHECK(expression_of(split, "default_visible") == "C[<L.[^'key''fill']>O]");
    CHECK(channels_of(split, "C,- L,-,key") == Names{"key_visible"});
    CHECK(channels_of(split, "C,- R,D L,-") == Names{"default_diffuse_bounce1"});
    CHECK(channels_of(split, "C,- R,D L,-,other") == Names{"default_diffuse_bounce1"});
    CHECK(channels_of(split, "C,- R,D O,-") == Names{"default_diffuse_bounce1"});
    CHECK(channels_of(split, "C,- R,D O,-,key") == Names{"default_diffuse_bounce1"});
    CHECK(channels_of(split, "C,- T,S T,S R,D B,-,fill") == Names{"fill_transmissive_bounce3plus"});
    CHECK(channels_of(split, "C,- V,- V,- L,-,key") == Names{"key_volume_bounce2"});
    CHECK(channels_of(split, "C,- R,D R,D R,D R,D R,D R,D L,-,key") == Names{"key_diffuse_bounce3plus"});
}

TEST_CASE("every combination of axes is a partition in both dialects", "[split][law1][gate]") {
    const SplitAxis all[] = {SplitAxis::light_group, SplitAxis::lobe, SplitAxis::bounce, SplitAxis::object,
                             SplitAxis::terminal};
    for (unsigned set = 1; set < 32; ++set) {
        for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
            SplitRequest request;
            for (unsigned axis = 0; axis < 5; ++axis) {
                if ((set >> axis & 1U) != 0) { request.by.push_back(all[axis]); }
            }
            request.groups = {"key", dialect == Dialect::osl ? "fill" : "it's"};  // osl cannot write a quote
            request.objects = {"floor", "a*b"};
            request.dialect = dialect;
            request.words.unlabelled_lights = dialect == Dialect::renderman;
            INFO("axes " << set << (dialect == Dialect::osl ? ", osl" : ", renderman"));
            const auto split = generate_split(request);
            if (dialect == Dialect::osl && (set & 8U) != 0) {
                CHECK_FALSE(split);  // osl has no bin for objects without a label
                continue;
            }
            REQUIRE(split);
            // Prove it once more from the texts.
            const auto proof = check_partition(split->channels, std::nullopt, request.words);
            REQUIRE(proof);
            CHECK(proof->result == SplitProof::partition);
            std::set<std::string> names;
            for (const ChannelSource& channel : split->channels) {
                CHECK(names.insert(channel.name).second);
                CHECK(channel.name.find_first_not_of(
                          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") == std::string::npos);
                const auto word = find_path_string(channel, request.words);
                REQUIRE(word);
                CHECK(word->has_value());  // no bin is empty
            }
        }
    }
}

TEST_CASE("lobes are events, earlier ones first, or names", "[split]") {
    SplitRequest request = by({SplitAxis::lobe});
    request.lobes = {"skin=D2", "coat=S4", "D", "RS"};
    const Split events = required(request);
    CHECK(channels_of(events, "C,- R,D2 L,-") == Names{"skin"});
    CHECK(channels_of(events, "C,- R,D3 L,-") == Names{"D"});
    CHECK(channels_of(events, "C,- T,G4 L,-") == Names{"coat"});
    CHECK(channels_of(events, "C,- R,S8 L,-") == Names{"RS"});
    CHECK(channels_of(events, "C,- T,S8 L,-") == Names{"other"});
    CHECK(channels_of(events, "C,- V,- L,-") == Names{"other"});
    request.lobes = {"coat", "glass"};
    const Split names = required(request);
    CHECK(channels_of(names, "C,- R,S,floor,coat L,-") == Names{"coat"});
    CHECK(channels_of(names, "C,- R,S,coat,glass L,-") == Names{"glass"});
    CHECK(channels_of(names, "C,- R,D,coat L,-") == Names{"other"});
    request.lobes = {"'S4'"};  // in quotes it is a name, although it looks like an event
    CHECK(channels_of(required(request), "C,- R,D,x,S4 L,-") == Names{"S4"});
}

TEST_CASE("objects are split by the first hit, and media belong to `other`", "[split]") {
    SplitRequest request = by({SplitAxis::object, SplitAxis::bounce});
    request.objects = {"floor", "wall"};
    request.bounces = 2;
    const Split split = required(request);
    CHECK(channels_of(split, "C,- R,D,floor L,-") == Names{"floor_direct"});
    CHECK(channels_of(split, "C,- R,D,wall R,D,floor L,-") == Names{"wall_indirect"});
    CHECK(channels_of(split, "C,- R,D L,-") == Names{"other_direct"});
    CHECK(channels_of(split, "C,- V,- L,-") == Names{"other_direct"});
    CHECK(channels_of(split, "C,- O,-") == Names{"visible"});
}

TEST_CASE("a split of less than the beauty is restricted to it", "[split][law1]") {
    SplitRequest request = by({SplitAxis::light_group, SplitAxis::bounce});
    request.groups = {"key"};
    request.bounces = 2;
    ChannelSource of;
    of.expression = "lpe:C<RD>.*  # diffuse first";
    request.of = of;
    const Split split = required(request);
    CHECK(split.of.has_value());
    CHECK(channels_of(split, "C,- R,D L,-,key") == Names{"key_direct"});
    CHECK(channels_of(split, "C,- R,S L,-,key").empty());
    CHECK(split.notes.size() == 1);  // the two bins of light seen directly are empty
    of.expression = "C[DSV]*[<L.>O]";
    request.of = of;
    CHECK_FALSE(required(request).of.has_value());  // the beauty in a different form
    of.expression = "noclamp;C.*";
    request.of = of;
    CHECK_FALSE(generate_split(request));
}

TEST_CASE("512 channels are generated and proved within a second", "[split]") {
    SplitRequest request = by({SplitAxis::light_group, SplitAxis::lobe, SplitAxis::bounce});
    request.groups = {"a", "b", "c", "d", "e", "f", "g"};
    request.lobes = {"RD1", "RD2", "RD3", "RD4", "RS1", "RS2", "RS3", "RS4",
                     "RS5", "RS6", "RS7", "RS8", "TD",  "TS",  "V"};
    request.bounces = 4;
    const std::clock_t start = std::clock();
    const Split split = required(request);
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    CHECK(split.channels.size() == 8 * (16 * 4 + 1));  // 512, plus light seen directly for each group
    // 0.05 s on the reference machine; the bound allows for sanitizers.
    CHECK(seconds < 10);
}

TEST_CASE("requests without a valid split are refused with the reason", "[split][law7]") {
    const auto message = [](const SplitRequest& request) {
        const auto split = generate_split(request);
        return split ? std::string("no error") : split.error().message + " " + split.error().hint;
    };
    CHECK(message({}).find("no axis") != std::string::npos);
    CHECK(message(by({SplitAxis::bounce, SplitAxis::bounce})).find("bounce is named twice") != std::string::npos);
    CHECK(message(by({SplitAxis::light_group})).find("--groups") != std::string::npos);
    CHECK(message(by({SplitAxis::object})).find("--objects") != std::string::npos);
    SplitRequest request = by({SplitAxis::lobe});
    request.lobes = {"D", "D2"};
    CHECK(message(request).find("'D2' is covered") != std::string::npos);
    request.lobes = {"D2", "coat"};
    CHECK(message(request).find("different kinds") != std::string::npos);
    request.lobes = {"TRT", "R"};  // the name of hair's lobe R is also the event of reflection
    CHECK(message(request).find("a lobe whose name is 'R' must be in quotes: \"'R'\"") != std::string::npos);
    request.lobes = {"V"};
    request.words.volume = false;
    CHECK(message(request).find("cannot occur") != std::string::npos);
    request = by({SplitAxis::bounce});
    request.bounces = 65;
    CHECK(message(request).find("1 to 64") != std::string::npos);
    request = by({SplitAxis::light_group});
    request.groups = {"key"};
    request.dialect = Dialect::osl;
    CHECK(message(request).find("without a label") != std::string::npos);
    request = by({SplitAxis::light_group});
    request.groups = {std::string(200, 'x')};
    CHECK(message(request).find("200 bytes") != std::string::npos);
    CHECK_FALSE(parse_split_axis("lobes"));
    CHECK(parse_split_axis("lobes").error().hint == "did you mean 'lobe'?");
}

TEST_CASE("names of bins are valid layer names, and unique", "[split]") {
    SplitRequest request = by({SplitAxis::light_group});
    request.groups = {"R", "rim light", "rim_light", "default", "\xC3\xA9t\xC3\xA9", "7"};
    const Split split = required(request);
    Names names;
    for (const ChannelSource& channel : split.channels) { names.push_back(channel.name); }
    CHECK(names == Names{"R_", "rim_light", "rim_light_2", "t", "_7", "default"});
    CHECK(channels_of(split, "C,- L,-,default") == Names{"default"});
}
