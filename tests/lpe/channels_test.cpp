// Channel files: RIB, USD ASCII, rendermn.ini; lobe slots.
#include <catch2/catch.hpp>

#include <random>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/channels/channel_errors.h"
#include "lpe/channels/channel_file.h"
#include "lpe/channels/lobe_slots.h"

using namespace raylex;
using namespace raylex::lpe;

namespace {

ChannelFile read(const std::string& text, ChannelFormat format) {
    auto file = parse_channel_file(text, "file", format);
    INFO((file ? std::string() : file.error().to_string()));
    REQUIRE(file);
    return *std::move(file);
}

Error refused(const std::string& text, ChannelFormat format) {
    const auto file = parse_channel_file(text, "file", format);
    INFO(text);
    REQUIRE_FALSE(file);
    return file.error();
}

std::string written(const ChannelFile& file, ChannelFormat format) {
    std::vector<std::string> warnings;
    auto text = write_channel_file(file, format, warnings, Reader::raylex);
    INFO((text ? std::string() : text.error().to_string()));
    REQUIRE(text);
    return *std::move(text);
}

/// The error of the channel's expression.
Error expression_error(const ChannelFile& file, std::size_t channel = 0) {
    const auto word = find_path_string(file.channels.at(channel).source);
    REQUIRE_FALSE(word);
    return word.error();
}

const char* const rib_text = R"rib(##RenderMan RIB
version 3.04
Option "lpe" "string diffuse2" ["Diffuse,skin"] "string specular4" "Coat"
Display "out.exr" "openexr" "Ci,a"  # not ours
# The first layer.
# Direct only.
DisplayChannel "color directDiffuse" "string source" ["color lpe:C<RD>[<L.>O]"]
    "string filter" "gaussian" "float[2] filterwidth" [2 2] "string statistics" ["variance"]

DisplayChannel "varying color esc\141ped" "string source" "lpe:C<RD'a\\*'>\
L"
DisplayChannel "color lpe:diffuse_key"
DisplayChannel "float z"
DisplayChannel "color Ci" "string source" ["color Ci"]
WorldBegin
)rib";

const char* const usda_text = R"usda(#usda 1.0
(
    defaultPrim = "Render"  # a comment with ( and "
)
def Scope "Render" (
    kind = "group"
)
{
    rel products = [</Render/a>, </Render/b>]
    asset file = @a "path".usd@
    double x.timeSamples = { 0: -1.5e-3, 1: 2 }
    /* a block { comment */
    def Scope "Vars"
    {
        # Direct only.
        def RenderVar "directDiffuse" (
            documentation = """kept (as it is)"""
        )
        {
            uniform token dataType = "half3"
            uniform string sourceName = "C<RD>[<L.>O]"
            uniform token sourceType = "lpe"
            custom token driver:parameters:aov:format = "color3h" (
                doc = "x"
            )
        }
        variantSet "quality" = {
            "high" {
                def RenderVar "inVariant" { string sourceName = """C
D\'x\'"L"""; token sourceType = "lpe" }
            }
        }
        def RenderVar "normals" { uniform string sourceName = "N"; uniform token sourceType = "primvar" }
        def RenderVar "old" { string sourceName = "color lpe:CS[LO]" ; token driver:parameters:aov:name = "old style" }
    }
}
)usda";

}  // namespace

TEST_CASE("RIB channels are read with their other parameters", "[channels]") {
    const ChannelFile file = read(rib_text, ChannelFormat::rib);
    REQUIRE(file.channels.size() == 3);
    const FileChannel& first = file.channels[0];
    CHECK(first.source.name == "directDiffuse");
    CHECK(first.source.expression == "C<RD>[<L.>O]");
    CHECK(first.source.origin_line == 7);
    CHECK(first.comment == "The first layer.\nDirect only.");
    CHECK(first.parameters == std::vector<std::string>{"\"string filter\" \"gaussian\"",
                                                       "\"float[2] filterwidth\" [2 2]",
                                                       "\"string statistics\" [\"variance\"]"});
    CHECK(file.channels[1].source.name == "escaped");
    CHECK(file.channels[1].type == "varying color");
    CHECK(file.channels[1].source.expression == "C<RD'a\\*'>L");  // one escape is resolved, one line continued
    CHECK(file.channels[1].comment.empty());
    CHECK(file.channels[2].source.name == "lpe:diffuse_key");
    CHECK(file.channels[2].source.expression == "diffuse_key");
    REQUIRE(file.other_channels.size() == 2);
    CHECK(file.other_channels[0].source.name == "z");
    CHECK(file.other_channels[0].type == "float");
    CHECK(file.other_channels[1].source.expression == "Ci");
    REQUIRE(file.lobe_options.size() == 2);
    CHECK(file.lobe_options[0].slot == "diffuse2");
    CHECK(file.lobe_options[0].names == "Diffuse,skin");
    CHECK(file.lobe_options[1].names == "Coat");
}

TEST_CASE("any content of a RIB option's name is written so that it reads back", "[channels]") {
    const ChannelFile file = read("Option \"lpe\" \"string \\\\odd\\\"\" [\"a\\nb\"]\n", ChannelFormat::rib);
    REQUIRE(file.lobe_options.size() == 1);
    CHECK(file.lobe_options[0].slot == "\\odd\"");
    std::vector<std::string> warnings;
    const auto written = write_channel_file(file, ChannelFormat::rib, warnings);
    REQUIRE(written.ok());
    const ChannelFile again = read(*written, ChannelFormat::rib);
    REQUIRE(again.lobe_options.size() == 1);
    CHECK(again.lobe_options[0].slot == file.lobe_options[0].slot);
    CHECK(again.lobe_options[0].names == file.lobe_options[0].names);
    const auto ini = write_channel_file(file, ChannelFormat::ini, warnings);
    REQUIRE_FALSE(ini.ok());  // an option is a single line there
    CHECK(ini.error().message.find("contains a line end") != std::string::npos);
}

TEST_CASE("a text that ends in a backslash is not written where the backslash continues the line", "[channels]") {
    const ChannelFile file = read("/prman/lpe/macro/odd  \\", ChannelFormat::ini);
    REQUIRE(file.macros.size() == 1);
    CHECK(file.macros[0].expression == "\\");
    std::vector<std::string> warnings;
    const auto written = write_channel_file(file, ChannelFormat::ini, warnings);
    REQUIRE_FALSE(written.ok());
    CHECK(written.error().message.find("ends in a backslash") != std::string::npos);
}

TEST_CASE("an expression that contains a mark keeps its meaning in every format", "[channels]") {
    const ChannelFile file =
        read("DisplayChannel \"color x\" \"string source\" [\"color lpe:C lpe:D\"]\n", ChannelFormat::rib);
    REQUIRE(file.channels.size() == 1);
    REQUIRE(file.channels[0].source.expression == "C lpe:D");  // not an expression, and it must not become one
    std::vector<std::string> warnings;
    for (const ChannelFormat format : {ChannelFormat::rib, ChannelFormat::usda}) {
        const auto written = write_channel_file(file, format, warnings, Reader::raylex);
        REQUIRE(written.ok());
        const ChannelFile again = read(*written, format);
        REQUIRE(again.channels.size() == 1);
        CHECK(again.channels[0].source.expression == "C lpe:D");
    }
}

TEST_CASE("USD render variables are read wherever they are nested", "[channels]") {
    const ChannelFile file = read(usda_text, ChannelFormat::usda);
    REQUIRE(file.channels.size() == 3);
    CHECK(file.channels[0].source.name == "directDiffuse");
    CHECK(file.channels[0].type == "half3");
    CHECK(file.channels[0].comment == "Direct only.");
    CHECK(file.channels[0].prim_metadata.find("kept (as it is)") != std::string::npos);
    REQUIRE(file.channels[0].parameters.size() == 1);
    CHECK(file.channels[0].parameters[0].find("color3h") != std::string::npos);
    CHECK(file.channels[1].source.expression == "C\nD'x'\"L");
    CHECK(file.channels[2].source.name == "old style");
    CHECK(file.channels[2].source.expression == "CS[LO]");
    REQUIRE(file.other_channels.size() == 1);
    CHECK(file.other_channels[0].source.name == "normals");
    CHECK(file.other_channels[0].source.expression == "N");
}

TEST_CASE("rendermn.ini gives macros and lobe slots", "[channels]") {
    const ChannelFile file = read(
        "# comment\n/prman/rixplugin/path ./x\n/prman/lpe/macro/myDiffuse    CD<L.>   # why\n"
        "  /prman/lpe/macro/two lpe:C \\\n   D'a #b'L\n/prman/lpe/specular6  Fuzz,KPFuzz\n",
        ChannelFormat::ini);
    REQUIRE(file.macros.size() == 2);
    CHECK(file.macros[0].name == "myDiffuse");
    CHECK(file.macros[0].expression == "CD<L.>");
    CHECK(file.macros[0].origin_line == 3);
    CHECK(file.macros[1].expression == "C    D'a #b'L");
    REQUIRE(file.lobe_options.size() == 1);
    CHECK(file.lobe_options[0].slot == "specular6");
}

TEST_CASE("the written file has the content that was read, and reads back", "[channels]") {
    for (const auto& [text, format] :
         {std::pair<const char*, ChannelFormat>{rib_text, ChannelFormat::rib}, {usda_text, ChannelFormat::usda}}) {
        const ChannelFile once = read(text, format);
        const std::string first = written(once, format);
        const ChannelFile again = read(first, format);
        REQUIRE(again.channels.size() == once.channels.size());
        for (std::size_t k = 0; k < once.channels.size(); ++k) {
            INFO(once.channels[k].source.name);
            CHECK(again.channels[k].source.name == once.channels[k].source.name);
            CHECK(again.channels[k].source.expression == once.channels[k].source.expression);
            CHECK(again.channels[k].parameters == once.channels[k].parameters);
            CHECK(again.channels[k].comment == once.channels[k].comment);
            CHECK(again.channels[k].prim_metadata == once.channels[k].prim_metadata);
        }
        CHECK(written(again, format) == first);
    }
}

TEST_CASE("channels pass from format to format unchanged in meaning", "[channels]") {
    ChannelFile file = read(rib_text, ChannelFormat::rib);
    file.channels.pop_back();  // a channel named by its own expression, which neither prims nor macros can have as a
                               // name
    file.channels[1].source.name = "renamed";
    file.channels[0].parameters.pop_back();  // statistics, which rendermn.ini lacks
    for (const ChannelFormat format : {ChannelFormat::rib, ChannelFormat::usda, ChannelFormat::ini}) {
        const ChannelFile other = read(written(file, format), format);
        const std::size_t count = format == ChannelFormat::ini ? other.macros.size() : other.channels.size();
        REQUIRE(count == file.channels.size());
        for (std::size_t k = 0; k < count; ++k) {
            const ChannelSource& source = format == ChannelFormat::ini ? other.macros[k] : other.channels[k].source;
            CHECK(source.name == file.channels[k].source.name);
            const auto difference = find_difference(source, file.channels[k].source);
            REQUIRE(difference);
            CHECK_FALSE(difference->has_value());
        }
    }
    file.channels[0].source.dialect = Dialect::osl;
    std::vector<std::string> warnings;
    CHECK_FALSE(write_channel_file(file, ChannelFormat::rib, warnings));
    CHECK_FALSE(write_channel_file(file, ChannelFormat::ini, warnings));
    CHECK(write_channel_file(file, ChannelFormat::usda, warnings, Reader::raylex));
}

TEST_CASE("an error inside an expression gives the exact position in the file", "[channels][law7]") {
    Error error = expression_error(
        read("# one\nDisplayChannel \"color a\" \"string source\" [\"color lpe:C<RX>L\"]\n", ChannelFormat::rib));
    CHECK(error.file == "file");
    CHECK(error.line == 2);
    CHECK(error.column == 57);
    CHECK(error.excerpt.at(56) == 'X');
    // After an escape of two bytes and a continued line.
    error = expression_error(
        read("DisplayChannel \"color a\" \"string source\" \"lpe:C<RD\\047f\\047>\\\nDX\"\n", ChannelFormat::rib));
    CHECK(error.line == 2);
    CHECK(error.column == 2);
    error =
        expression_error(read("#usda 1.0\ndef RenderVar \"a\" {\n  string sourceName = \"\"\"C<RD\\'f\\'>\n  "
                              "DX\"\"\"\n  token sourceType = \"lpe\"\n}\n",
                              ChannelFormat::usda));
    CHECK(error.line == 4);
    CHECK(error.column == 4);
    CHECK(error.excerpt == "  DX\"\"\"");
}

TEST_CASE("broken files are refused with file, line and column", "[channels][law7]") {
    struct Case {
        const char* text;
        ChannelFormat format;
        int line, column;
        const char* part;
    };
    const Case cases[] = {
        {"DisplayChannel", ChannelFormat::rib, 1, 1, "no name"},
        {"DisplayChannel \"color a", ChannelFormat::rib, 1, 16, "not closed"},
        {"DisplayChannel \"color a\" \"string source\" [\"x\"", ChannelFormat::rib, 1, 42, "not closed"},
        {"DisplayChannel \"color a\" \"string source\"", ChannelFormat::rib, 1, 26, "no value"},
        {"DisplayChannel \"color a\" \"string source\" [1]", ChannelFormat::rib, 1, 42, "not a string"},
        {"DisplayChannel \"color a\" \"string source\" \"color lpe:\"", ChannelFormat::rib, 1, 53, "empty expression"},
        {"DisplayChannel \"color a\" \"string source\" \"float z\" \"string source\" \"color lpe:C\"",
         ChannelFormat::rib, 1, 52, "second source"},
        {"Format 1 2\n\x80\x01", ChannelFormat::rib, 2, 1, "the byte 0x80"},
        {"def RenderVar \"a\" {}", ChannelFormat::usda, 1, 1, "#usda"},
        {"#usda 1.0\ndef RenderVar \"a\" {", ChannelFormat::usda, 2, 1, "not closed"},
        {"#usda 1.0\ndef RenderVar a {}", ChannelFormat::usda, 2, 15, "name in quotes"},
        {"#usda 1.0\ndef RenderVar \"a\" { token sourceType = \"lpe\" }", ChannelFormat::usda, 2, 1, "no sourceName"},
        {"#usda 1.0\ndef RenderVar \"a\" { string sourceName = [1]; token sourceType = \"lpe\" }", ChannelFormat::usda,
         2, 41, "not a string"},
        {"#usda 1.0\n}", ChannelFormat::usda, 2, 1, "'}'"},
        {"#usda 1.0\nint a = (1]", ChannelFormat::usda, 2, 11, "expected ')'"},
        {"#usda 1.0\nstring a = \"x\n", ChannelFormat::usda, 2, 12, "not closed"},
        {"/prman/lpe/macro/a\n", ChannelFormat::ini, 1, 1, "no expression"},
        {"\n/prman/lpe/other/a b\n", ChannelFormat::ini, 2, 1, "unknown entry"},
    };
    for (const Case& wrong : cases) {
        const Error error = refused(wrong.text, wrong.format);
        INFO(error.to_string());
        CHECK(error.file == "file");
        CHECK(error.line == wrong.line);
        CHECK(error.column == wrong.column);
        CHECK(error.message.find(wrong.part) != std::string::npos);
    }
    CHECK_FALSE(channel_format("a.usdc", ""));
    CHECK_FALSE(channel_format("a.rib", "\x1f\x8b\x08"));
    CHECK_FALSE(channel_format("a.txt", "hello"));
    CHECK(*channel_format("a.txt", "#usda 1.0") == ChannelFormat::usda);
    CHECK(*channel_format("a.txt", "DisplayChannel \"color a\"") == ChannelFormat::rib);
}

TEST_CASE("errors of single channels are all reported, and the other channels are read", "[channels][law7]") {
    std::vector<Error> errors;
    auto file = parse_channels(
        "DisplayChannel \"color a\" \"string source\" [\"color lpe:C.*\"]\n"
        "DisplayChanel \"color b\" \"string source\" [\"color lpe:CD\"]\n"
        "DisplayChannel \"colour c\" \"string source\" [\"color lpe:CD\"]\n"
        "DisplayChannel \"color d\" \"string source\" [\"color lpe:\"]\n"
        "DisplayChannel \"color e\" \"string source\" [\"color lpe:CD\"] \"string statistics\" [\"msee\"]\n"
        "DisplayChannel \"color f\" \"string sorce\" [\"color lpe:CD\"]\n"
        "DisplayChannel \"varying float g\"\nDisplayChannel \"float[2] h\"\nDisplay \"a.exr\" \"openexr\" \"a\"\n"
        "Optoin \"lpe\" \"string diffuse2\" [\"Hair\"]\n",
        "file", ChannelFormat::rib, errors);
    REQUIRE(file.ok());
    CHECK(file->channels.front().source.name == "a");
    CHECK(file->other_channels.back().source.name == "h");
    std::vector<std::string> told;
    for (const Error& error : errors)
        told.push_back(std::to_string(error.line) + " " + error.message.substr(0, error.message.find(';')) + " " +
                       error.hint);
    CHECK(told == std::vector<std::string>{"2 unknown request 'DisplayChanel' did you mean 'DisplayChannel'?",
                                           "3 unknown type 'colour' did you mean 'color'?",
                                           "4 channel 'd' has an empty expression ",
                                           "5 unknown statistics 'msee' did you mean 'mse'?",
                                           "6 unknown parameter 'sorce' did you mean 'source'?",
                                           "10 unknown request 'Optoin' did you mean 'Option'?"});
    errors.clear();
    REQUIRE(
        parse_channels("#usda 1.0\ndef RenderVar \"a\" { token sourceType = \"lpe\" }\n"
                       "def RenderVar \"b\" { string sourceName = \"CD\"; token sourceType = \"lpe\"\n"
                       "  string driver:parameters:aov:statistics = \"msee\" }\n",
                       "file", ChannelFormat::usda, errors));
    REQUIRE(errors.size() == 2);
    CHECK(errors[1].line == 4);
    errors.clear();
    REQUIRE(parse_channels("/prman/lpe/macro/a\n/prman/lpe/other/b c\n", "file", ChannelFormat::ini, errors));
    CHECK(errors.size() == 2);
}

TEST_CASE("a mark in an expression is not written a second time", "[channels]") {
    ChannelFile file;
    file.channels.emplace_back().source = {"a", "lpe:CD", Dialect::renderman, "file", 1, 1, {}};
    for (const ChannelFormat format : {ChannelFormat::rib, ChannelFormat::usda, ChannelFormat::ini})
        CHECK(written(file, format).find("lpe:lpe:") == std::string::npos);
    CHECK(written(file, ChannelFormat::rib).find("[\"color lpe:CD\"]") != std::string::npos);
}

TEST_CASE("deep, long and damaged files quickly give a result or an error", "[channels][law7][gate]") {
    for (const char open : {'(', '[', '{'}) {
        CHECK(refused("#usda 1.0\nint a = " + std::string(100'000, open), ChannelFormat::usda)
                  .message.find("nested deeper") != std::string::npos);
    }
    std::string prims = "#usda 1.0\n";
    for (int k = 0; k < 1000; ++k) { prims += "def \"a\" {"; }
    CHECK(refused(prims, ChannelFormat::usda).message.find("nested deeper") != std::string::npos);
    CHECK(refused("DisplayChannel \"" + std::string(1'000'000, 'x'), ChannelFormat::rib).message.find("not closed") !=
          std::string::npos);
    CHECK(refused(std::string(20'000'000, ' '), ChannelFormat::rib).message.find("20000000 bytes") !=
          std::string::npos);
    std::mt19937 random(20261121);  // fixed: the same files every time
    for (const auto& [text, format] :
         {std::pair<std::string, ChannelFormat>{rib_text, ChannelFormat::rib},
          {usda_text, ChannelFormat::usda},
          {"/prman/lpe/macro/a C\\\nD'#'L # x\n/prman/lpe/specular2 a,b\n", ChannelFormat::ini}}) {
        for (int round = 0; round < 3000; ++round) {
            std::string damaged = text;
            for (unsigned k = 1 + random() % 4; k > 0 && !damaged.empty(); --k) {
                const std::size_t at = random() % damaged.size();
                switch (random() % 3) {
                    case 0:
                        damaged.erase(at, 1 + random() % 8);
                        break;
                    case 1:
                        damaged[at] = static_cast<char>(random() % 256);
                        break;
                    default:
                        damaged.insert(at, 1, "\"'\\{}()[]<>@#\n;="[random() % 16]);
                        break;
                }
            }
            const auto file = parse_channel_file(damaged, "file", format);
            if (!file) {
                CHECK_FALSE(file.error().message.empty());
                CHECK(file.error().line > 0);
            }
        }
    }
}

TEST_CASE("lobe slots number lobes by name; other lobes have no number", "[channels][lobes]") {
    LobeSlots slots;
    CHECK(slots.number(Scatter::diffuse, "Diffuse") == 2);
    CHECK(slots.number(Scatter::diffuse, "Subsurface") == 3);
    CHECK(slots.number(Scatter::glossy, "Clearcoat") == 4);
    CHECK(slots.number(Scatter::singular, "Glass") == 8);
    CHECK(slots.number(Scatter::glossy, "specular") == 2);    // in slots 2 and 8: the lower one
    CHECK(slots.number(Scatter::diffuse, "Clearcoat") == 0);  // in no diffuse slot
    CHECK(slots.number(Scatter::glossy, "nobody") == 0);
    CHECK(slots.user_number("Albedo") == 2);
    // raylex's own materials, by the event table of lpe/README.md.
    CHECK(slots.number(Scatter::diffuse, "diffuse") == 2);
    CHECK(slots.number(Scatter::glossy, "conductor") == 2);
    CHECK(slots.number(Scatter::singular, "mirror") == 2);
    CHECK(slots.number(Scatter::singular, "sheet") == 2);
    CHECK(slots.number(Scatter::glossy, "coat") == 4);
    CHECK(slots.number(Scatter::singular, "glass") == 8);

    const auto option = [](const char* slot, const char* names) { return LobeOption{slot, names, "job.toml", 3, 5}; };
    REQUIRE(slots.set(option("lpe:specular5", " coat , Lacquer,")));
    CHECK(slots.number(Scatter::glossy, "coat") == 5);  // a slot that was set takes precedence over a default
    CHECK(slots.number(Scatter::glossy, "Lacquer") == 5);
    CHECK(slots.number(Scatter::glossy, "Iridescence") == 0);  // the slot's defaults are gone
    REQUIRE(slots.set(option("diffuse2", "")));
    CHECK(slots.number(Scatter::diffuse, "diffuse") == 0);
    CHECK(slots.settings() ==
          std::vector<std::pair<std::string, std::string>>{{"diffuse2", ""}, {"specular5", " coat , Lacquer,"}});
    const auto twice = slots.set(option("specular6", "coat"));
    REQUIRE_FALSE(twice);
    CHECK(twice.error().line == 3);
    CHECK(twice.error().message.find("specular5 already") != std::string::npos);
    const auto unknown = slots.set(option("specular9", "x"));
    REQUIRE_FALSE(unknown);
    CHECK(unknown.error().message.find("no lobe slot 'specular9'") != std::string::npos);
    CHECK_FALSE(slots.set(option("diffuse5", "x")));
    CHECK(slots.set(option("user12", "x")));
}
