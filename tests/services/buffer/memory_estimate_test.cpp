#include "display/buffer/frame_buffer/memory_estimate.h"

#include <catch2/catch.hpp>

using namespace raylex::display;

namespace {

std::vector<ChannelDefinition> three() {
    std::vector<ChannelDefinition> list(3);
    list[0].name = "beauty";
    list[0].statistics = true;
    list[1].name = "z";
    list[1].type = ChannelType::real;
    list[1].rule = FilterRule::zmin;
    list[2].name = "diffuse";
    return list;
}

}  // namespace

TEST_CASE("each layer's bytes are those of its planes", "[memory]") {
    const auto items = frame_buffer_memory({100, 10}, three());
    REQUIRE(items.size() == 4);
    CHECK(items[0].name == "weights");
    CHECK(items[0].bytes == 1000 * (8 + 3 * 16));
    CHECK(items[1].bytes == 1000 * 144);  // as in frame_buffer.h: 48 per pixel, 144 with statistics
    CHECK(items[2].bytes == 1000 * (8 + 8 + 4));
    CHECK(items[3].bytes == 1000 * 48);
    CHECK(total_bytes(items) == 1000 * (56 + 144 + 20 + 48));
}

TEST_CASE("layers of statistics need the memory of the sums that their source keeps", "[memory][statistics]") {
    std::vector<ChannelDefinition> channels = three();
    const std::uint64_t before = total_bytes(frame_buffer_memory({100, 10}, channels));
    const auto add = [&](ChannelId source, Statistic statistic) {
        ChannelDefinition layer;
        layer.name = "layer" + std::to_string(channels.size());
        layer.source = source;
        layer.statistic = statistic;
        channels.push_back(layer);
        return total_bytes(frame_buffer_memory({100, 10}, channels));
    };
    CHECK(add(0, Statistic::mse) == before);  // beauty keeps moments in any case
    CHECK(add(2, Statistic::variance) == before + 1000 * 96);
    const std::uint64_t halves = 1000 * (96 + 2 * (8 + 16));  // two sums of three, and two weights and counts
    CHECK(add(2, Statistic::even) == before + 1000 * 96 + halves);
    CHECK(add(2, Statistic::odd) == before + 1000 * 96 + halves);
}

TEST_CASE("an image beyond the limit is refused, and the error names the largest layers first", "[memory][law7]") {
    const auto items = frame_buffer_memory({1024, 1024}, three());
    CHECK(check_memory(items, 0).ok());
    CHECK(check_memory(items, total_bytes(items)).ok());
    const auto refused = check_memory(items, total_bytes(items) - 1);
    REQUIRE(!refused.ok());
    const std::string text = refused.error().message;
    CHECK(text.find("beauty 144 MiB, weights 56.0 MiB, diffuse 48.0 MiB, z 20.0 MiB") != std::string::npos);
    CHECK(text.find("268 MiB") != std::string::npos);
}

TEST_CASE("amounts of memory are parsed with their units or refused", "[memory][law7]") {
    const auto bytes = [](const std::string& text) {
        const auto parsed = parse_memory_size(text, {"--memory-limit", 0, 0});
        return parsed.ok() ? *parsed : 0;
    };
    CHECK(bytes("4096") == 4096);
    CHECK(bytes("4096B") == 4096);
    CHECK(bytes("8G") == 8ull << 30);
    CHECK(bytes("1.5GiB") == 3ull << 29);
    CHECK(bytes("512MB") == 512ull << 20);
    CHECK(bytes("800k") == 800 * 1024);
    for (const char* wrong : {"", "G", "-1G", "0", "8X", "8 G", "nan", "inf", "1e99", "8GG", "9999999999T"}) {
        CAPTURE(wrong);
        CHECK(bytes(wrong) == 0);
    }
}
