// Estimates the memory of a frame buffer before it is allocated.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/services/parameters.h"

namespace raylex::display {

struct MemoryItem {
    std::string name;  ///< name of a channel, or another use of memory: "weights", "deep"
    std::uint64_t bytes = 0;
};

/// One item per channel, in order, after "weights" for the shared planes. The sum is an upper bound. It is reached when
/// every pixel of every channel gets a contribution, because untouched pages cost no memory. `raster`: include raster
/// splats.
std::vector<MemoryItem> frame_buffer_memory(const FrameBufferLayout& layout,
                                            std::span<const ChannelDefinition> channels, bool raster = false);

/// The total in bytes.
[[nodiscard]] std::uint64_t total_bytes(std::span<const MemoryItem> items);

/// Parses "8G", "512M", "1.5G", "800k" or plain bytes; powers of 1024; "iB" or "B" can follow. Errors are at `where`.
Result<std::uint64_t> parse_memory_size(const std::string& text, const SourceLocation& where);

/// An error when the items exceed `limit` bytes (0: no limit). It names the largest items and includes `hint`.
Status check_memory(std::span<const MemoryItem> items, std::uint64_t limit, const std::string& hint = {});

/// Formats bytes: "12.3 MiB", "950 KiB".
std::string memory_text(std::uint64_t bytes);

}  // namespace raylex::display
