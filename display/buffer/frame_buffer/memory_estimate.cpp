#include "display/buffer/frame_buffer/memory_estimate.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "display/buffer/frame_buffer/frame_buffer_storage.h"

namespace raylex::display {
namespace {

bool of_expression(std::span<const ChannelDefinition> channels, std::size_t index) {
    const ChannelDefinition& channel = channels[index];
    const ChannelDefinition& source =
        takes_samples(channel) ? channel : channels[static_cast<std::size_t>(channel.source)];
    return source.style == ChannelStyle::expression;
}

/// Follows the layout of FrameBuffer's constructor.
std::uint64_t bytes_per_pixel(std::span<const ChannelDefinition> channels, std::size_t index, bool raster) {
    const ChannelDefinition& channel = channels[index];
    if (!keeps_pixels(channel)) return 0;
    const KeptStatistics kept = kept_statistics(channels, index);
    const auto components = static_cast<std::uint64_t>(component_count(channel.type));
    const FilterRule rule = channel.rule;
    if (rule == FilterRule::filter)
        return components * sizeof(Int128) *
               (1 + (raster && of_expression(channels, index) ? 1u : 0u) + (kept.moments ? 2u : 0u) +
                (kept.halves ? 2u : 0u));
    if (is_extremum(rule)) return components * sizeof(double) + sizeof(std::uint64_t);
    if (is_z_rule(rule)) return components * sizeof(double) + sizeof(std::uint64_t) + sizeof(float);
    return components * sizeof(Int128) + sizeof(std::uint64_t);
}

}  // namespace

std::vector<MemoryItem> frame_buffer_memory(const FrameBufferLayout& layout,
                                            std::span<const ChannelDefinition> channels, bool raster) {
    const std::uint64_t pixels = static_cast<std::uint64_t>(layout.width) * static_cast<std::uint64_t>(layout.height);
    KeptStatistics any;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const KeptStatistics kept = kept_statistics(channels, i);
        any = {any.moments || kept.moments, any.halves || kept.halves};
    }
    const std::uint64_t weights = sizeof(std::uint64_t) + sizeof(Int128) * (any.moments ? 3u : 2u) +
                                  (any.halves ? 2 * (sizeof(std::uint64_t) + sizeof(Int128)) : 0u);
    std::vector<MemoryItem> items{{"weights", pixels * weights}};
    for (std::size_t i = 0; i < channels.size(); ++i)
        items.push_back({channels[i].name, pixels * bytes_per_pixel(channels, i, raster)});
    return items;
}

std::uint64_t total_bytes(std::span<const MemoryItem> items) {
    std::uint64_t total = 0;
    for (const MemoryItem& item : items) total += item.bytes;
    return total;
}

Result<std::uint64_t> parse_memory_size(const std::string& text, const SourceLocation& where) {
    double number = 0;
    const char* last = text.data() + text.size();
    const auto [end, failed] = std::from_chars(text.data(), last, number, std::chars_format::fixed);
    std::string unit(failed == std::errc() ? end : last, last);
    for (const char* suffix : {"iB", "B"})
        if (unit.size() > 1 && unit.ends_with(suffix)) unit.erase(unit.size() - std::string(suffix).size());
    constexpr std::array<std::pair<const char*, int>, 8> units{
        {{"", 0}, {"B", 0}, {"k", 10}, {"K", 10}, {"M", 20}, {"G", 30}, {"T", 40}, {"P", 50}}};
    const auto* found = std::find_if(units.begin(), units.end(), [&](const auto& each) { return unit == each.first; });
    const double bytes = found == units.end() ? 0 : std::ldexp(number, found->second);
    if (failed != std::errc() || !(bytes >= 1) || !(bytes < 0x1p63))
        return error_at(where,
                        "'" + text + "' is not an amount of memory; expected a number with k, M, G or T, such as 8G");
    return static_cast<std::uint64_t>(bytes);
}

Status check_memory(std::span<const MemoryItem> items, std::uint64_t limit, const std::string& hint) {
    const std::uint64_t total = total_bytes(items);
    if (limit == 0 || total <= limit) return success();
    std::vector<MemoryItem> largest(items.begin(), items.end());
    std::stable_sort(largest.begin(), largest.end(),
                     [](const MemoryItem& a, const MemoryItem& b) { return a.bytes > b.bytes; });
    std::string list;
    const std::size_t shown = std::min<std::size_t>(largest.size(), 5);
    for (std::size_t i = 0; i < shown; ++i)
        list += (i == 0 ? "" : ", ") + largest[i].name + " " + memory_text(largest[i].bytes);
    if (largest.size() > shown) list += " and " + std::to_string(largest.size() - shown) + " more";
    return error_at({},
                    "the image needs " + memory_text(total) + ", more than the limit of " + memory_text(limit) +
                        "; expected fewer or smaller layers, or a lower resolution. The largest: " + list,
                    hint);
}

std::string memory_text(std::uint64_t bytes) {
    constexpr std::array<const char*, 5> units{"B", "KiB", "MiB", "GiB", "TiB"};
    auto number = static_cast<double>(bytes);
    std::size_t unit = 0;
    for (; number >= 1024 && unit + 1 < units.size(); ++unit) number /= 1024;
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), unit == 0 || number >= 100 ? "%.0f %s" : "%.1f %s", number, units[unit]);
    return text.data();
}

}  // namespace raylex::display
