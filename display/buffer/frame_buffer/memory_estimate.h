// What a frame buffer will take, before any of it is taken.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/services/parameters.h"

namespace raylex::display {

struct MemoryItem {
    std::string name;  ///< a channel's, or what else takes memory: "weights", "deep"
    std::uint64_t bytes = 0;
};

/// One item per channel, in order, after "weights" for what they share. The sum is an upper bound that is reached when
/// every pixel of every channel gets something: pages that nothing touches are never taken from the system.
/// `raster`: with room for raster splats.
std::vector<MemoryItem> frame_buffer_memory(const FrameBufferLayout& layout,
                                            std::span<const ChannelDefinition> channels, bool raster = false);

/// Bytes in all.
[[nodiscard]] std::uint64_t total_bytes(std::span<const MemoryItem> items);

/// "8G", "512M", "1.5G", "800k" or plain bytes, powers of 1024 (an "iB" or "B" may follow). Errors at `where`.
Result<std::uint64_t> parse_memory_size(const std::string& text, const SourceLocation& where);

/// An error when the items exceed `limit` bytes (0 = no limit), naming the largest of them, and with that hint.
Status check_memory(std::span<const MemoryItem> items, std::uint64_t limit, const std::string& hint = {});

/// "12.3 MiB", "950 KiB".
std::string memory_text(std::uint64_t bytes);

}  // namespace raylex::display
