// The packets of the tev image viewer (github.com/Tom94/tev), from the Python description of its protocol that the
// viewer's authors publish (package "tevclient", formerly src/python/ipc.py in its repository):
//
// TCP, by default port 14158. A packet is its own length in bytes as uint32, the type as one byte, and its fields;
// numbers are little-endian, text is UTF-8 and ends with a zero byte.
//
//   4 create image    grab focus (byte), name, width, height (int32), number of channels (int32), their names
//   6 update image    grab focus (byte), name, number of channels (int32), their names, x, y, width, height (int32),
//                     per channel an offset and then per channel a stride (int64, in floats) into the pixels, pixels
//                     (float32)
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"

namespace raylex::display::tev {

inline constexpr int default_port = 14158;

/// A packet ready to be sent.
using Packet = std::vector<unsigned char>;

/// Creates a black image with that name; it replaces an earlier one.
[[nodiscard]] Packet create_image(const std::string& name, int width, int height,
                                  const std::vector<std::string>& channels);
/// The pixels of a region in row order with interleaved channels.
[[nodiscard]] Packet update_image(const std::string& name, const std::vector<std::string>& channels,
                                  const PixelRegion& region, std::span<const float> values);

}  // namespace raylex::display::tev
